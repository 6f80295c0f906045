"""Bad input gets one clear line and the right exit code, and nothing finished is lost. Runs the real programs.

usage: bad_input_test.py BIN_DIR   (the folder of the built programs)
"""

import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

BIN = pathlib.Path(sys.argv.pop(1))
SMALL = ["--size", "128x64", "--spp", "2", "--aovs", "depth"]


def run(*words, **options):
    words = [str(word) for word in words]
    return subprocess.run([BIN / "equistream", *words], capture_output=True, text=True, timeout=120, **options)


def frames_of(folder):
    return sorted(path.name for path in pathlib.Path(folder).glob("frame.*.exr"))


def leftovers(folder):
    """Files that are neither frames nor the manifest: parts of something unfinished."""
    names = [path.name for path in pathlib.Path(folder).iterdir()]
    return [name for name in names if not (name.startswith("frame.") and name.endswith(".exr")) and name != "manifest.json"]


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_bad_input_"))
        made = run("scene", "generate", "motion", "--out", cls.root / "scene")
        assert made.returncode == 0, made.stderr
        cls.scene = cls.root / "scene" / "motion.json"
        rendered = run("render", cls.scene, "--frames", "0-5", *SMALL, "--out", cls.root / "good")
        assert rendered.returncode == 0, rendered.stderr

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    def assert_refused(self, result, code, *mentions):
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        self.assertEqual(result.returncode, code, result.stderr + result.stdout)
        self.assertEqual(len(lines), 1, result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), lines[0])

    def scene_with(self, change, name="changed.json"):
        """A copy of the scene's folder with its description's text changed."""
        folder = self.out / "scene"
        shutil.copytree(self.root / "scene", folder)
        file = folder / name
        file.write_text(change((folder / "motion.json").read_text()))
        return file

    def test_unknown_commands_and_options(self):
        commands = re.findall(r"^  (\w+)", run("--help").stdout, re.MULTILINE)
        self.assertGreater(len(commands), 8)
        self.assert_refused(run("paint"), 2, "'paint'", f"({', '.join(commands)})")
        self.assert_refused(run("rendr"), 2, "found 'rendr'; did you mean render?")
        self.assert_refused(run("render", self.scene, "--frame", "0-3", "--out", self.out), 2, "--frame: no such option; did you mean --frames?")
        self.assert_refused(run("scene", "generate", "pavilion", "--outt", self.out), 2, "--outt: no such option; did you mean --out?")
        self.assert_refused(run("render", self.scene, "-o", self.out), 2, "-o: no such option; did you mean --out?")
        self.assert_refused(run("scene", "inf", self.scene), 2, "equistream scene: expected generate, info, describe, convert or placements, found 'inf'; did you mean info?")
        self.assert_refused(run("scene", "generate", "pavillion", "--out", self.out), 2, "equistream scene: NAME: expected one of pavilion, ", "found 'pavillion'; did you mean pavilion?")
        self.assert_refused(run("render", self.scene, "--sise", "64x32", "--out", self.out), 2, "--sise")
        self.assert_refused(run("render", self.scene, "--host", "cycles", "--out", self.out), 2, "cycles", "embree")

    def test_shared_options_mean_the_same_in_every_command(self):
        commands = re.findall(r"^  (\w+)", run("--help").stdout, re.MULTILINE)
        for command in commands:
            words = " ".join(run(command, "--help").stdout.split())
            self.assertIn("--settings FILE", words, command)
            if command != "scene":  # whose own commands have it
                self.assertRegex(words, "--json [Rr]eport as JSON on standard output", command)
            if command not in ("scene", "view", "doctor"):  # which have no steps
                self.assertRegex(words, r"--progress \S+( \[auto\])? .*auto: [^;]*; json: [^;]*; none: nothing", command)
            self.assert_refused(run(command, "--settings", self.out / "none.ini"), 2, "none.ini")

    def test_generated_scenes_are_reported_in_json(self):
        made = json.loads(run("scene", "generate", "motion", "--out", self.out, "--json").stdout)
        self.assertEqual((made["scene"], made["command"].split()[:3]), (f"{self.out}/motion.json", ["equistream", "scene", "generate"]))
        self.assertEqual(made["triangles"], json.loads(run("scene", "info", self.out / "motion.json", "--json").stdout)["triangles"])
        scenes = {scene["name"]: scene for scene in json.loads(run("scene", "generate", "--list", "--json").stdout)["scenes"]}
        self.assertEqual([option["name"] for option in scenes["sphere"]["options"]][:2], ["radius", "n"])

    def test_progress_and_reports_in_json(self):
        frames, stream, model = self.root / "good", self.out / "a.mkv", self.out / "m.json"
        told = {"what", "done", "total", "note", "seconds", "seconds_left"}
        for words in (["render", self.scene, "--frames", "0-1", *SMALL, "--out", self.out / "r"], ["encode", frames, "--out", stream], ["info", stream], ["info", frames, "--frames"],
                      ["play", frames, "--method", "rotation", "--size", "32x32", "--frames", "0", "--out", self.out / "eyes"],
                      ["compare", self.out / "eyes", self.out / "eyes", "--metrics", "psnr"],
                      ["import", frames / "centre", "--out", self.out / "i", "--frames", "0"], ["model", self.scene, "--out", model, "--rays", "10000", "--error-px", "8"]):
            result = run(*words, "--json", "--progress", "json")
            self.assertEqual(result.returncode, 0, result.stderr)
            steps = [json.loads(line) for line in result.stderr.splitlines() if line.startswith("{")]
            self.assertTrue(steps, words[0])
            for step in steps:
                self.assertEqual(step.keys(), told, words[0])
            report = json.loads(result.stdout)
            self.assertTrue(report["command"].startswith(f"equistream {words[0]}"), report["command"])
            self.assertTrue(report["version"] and report["machine"]["cpu"] and report["machine"]["threads"] >= 1, words[0])

    def test_a_render_has_as_many_threads_as_told(self):
        """33 threads are at least 24 more than one."""
        def most(threads, spp, enough=1000):
            """Until it ends or has enough of them."""
            words = ["render", self.scene, "--frames", "0", "--size", "512x256", "--spp", spp, "--threads", threads, "--out", self.out / f"{threads}"]
            process, found = subprocess.Popen([BIN / "equistream", *map(str, words)], stdout=subprocess.DEVNULL), 0
            while process.poll() is None and found < enough:
                found = max(found, len(os.listdir(f"/proc/{process.pid}/task")))
                time.sleep(0.002)
            process.kill()
            process.wait()
            return found

        few = most(1, 8)
        self.assertGreaterEqual(most(33, 256, few + 24), few + 24)

    def test_frame_ranges(self):
        for bad in ("5-4", "-3-2", "a-b", "7-", "9999"):
            self.assert_refused(run("render", self.scene, f"--frames={bad}", "--out", self.out / "x"), 2, "--frames")
        self.assert_refused(run("render", self.scene, "--frames", "", "--out", self.out / "x"), 2, "--frames")

    def test_sizes_and_aovs(self):
        self.assert_refused(run("render", self.scene, "--size", "0x32", "--out", self.out / "x"), 2, "--size")
        self.assert_refused(run("render", self.scene, "--frames", "0", "--aovs", "depth,smell", "--out", self.out / "x"), 2, "smell", "motion")

    def test_missing_scene(self):
        self.assert_refused(run("render", self.out / "none.json", "--out", self.out / "x"), 2, "none.json")

    def test_unknown_key_names_file_line_and_accepted_names(self):
        def change(text):
            at = text.index("{") + 1
            return text[:at] + '\n "sunn": 1,' + text[at:]

        scene = self.scene_with(change)
        self.assert_refused(run("render", scene, "--frames", "0", *SMALL, "--out", self.out / "x"), 2, f"{scene}:2", "sunn", "model")

    def test_broken_json_names_the_line(self):
        scene = self.scene_with(lambda text: text[: len(text) // 2])
        self.assert_refused(run("render", scene, "--frames", "0", *SMALL, "--out", self.out / "x"), 2, f"{scene}:")

    def test_missing_and_truncated_model(self):
        scene = self.scene_with(lambda text: text)
        model = next(scene.parent.glob("*.glb"))
        whole = model.read_bytes()
        for share in (0, 0.001, 0.3, 0.99):
            model.write_bytes(whole[: int(len(whole) * share)])
            self.assert_refused(run("render", scene, "--frames", "0", *SMALL, "--out", self.out / "x"), 2, model.name)
        model.unlink()
        self.assert_refused(run("render", scene, "--frames", "0", *SMALL, "--out", self.out / "x"), 2, model.name)

    def test_damaged_texture(self):
        scene = self.scene_with(lambda text: text)
        model = next(scene.parent.glob("*.glb"))
        data = bytearray(model.read_bytes())
        at = max(data.find(magic) for magic in (b"\x89PNG\r\n", b"\xff\xd8\xff"))
        self.assertGreater(at, 0, "the scene should have a texture")
        data[at : at + 8] = b"notapic!"
        model.write_bytes(data)
        self.assert_refused(run("render", scene, "--frames", "0", *SMALL, "--out", self.out / "x"), 2, model.name, "texture")

    def test_sky_images(self):
        def change(text):
            return json.dumps(json.loads(text) | {"sky": {"image": "sky.exr"}})

        scene = self.scene_with(change)
        sky = scene.parent / "sky.exr"
        words = ["render", scene, "--frames", "0", *SMALL, "--out", self.out / "x"]
        self.assert_refused(run(*words), 2, f"{scene}:1", "sky.exr", "found none")
        whole = next((self.root / "good").rglob("frame.0000.exr")).read_bytes()
        for content in (b"", b"no image", whole[: len(whole) // 2]):
            sky.write_bytes(content)
            self.assert_refused(run(*words), 2, sky, "sky image")
        sky.write_bytes(whole)  # a sphere of ours is a sky as it is
        result = run(*words)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_nothing_in_the_scene(self):
        made = run("scene", "generate", "empty", "--out", self.out / "scene")
        self.assertEqual(made.returncode, 0, made.stderr)
        scene = next((self.out / "scene").glob("*.json"))
        result = run("render", scene, "--frames", "0", *SMALL, "--out", self.out / "x")
        self.assert_refused(result, 2, scene.with_suffix(".glb"), "expected at least one triangle, found none")

    def test_client_models(self):
        out = self.out / "model.json"
        quick = ["--rays", "20000", "--visibility-rays", "20000"]
        self.assert_refused(run("model", self.scene, "--error-px", "0", "--out", out), 2, "--error-px", "found 0")
        self.assert_refused(run("model", self.scene, "--share", "1.5", "--out", out), 2, "--share")
        self.assert_refused(run("model", self.scene, "--out", self.out / "model"), 2, "--out", "NAME.json")
        self.assert_refused(run("model", self.scene, "--out", self.out / "none" / "model.json"), 2, self.out / "none")
        self.assert_refused(run("model", self.scene, *quick, "--quantile", "0.9", "--out", "/proc/model.json"), 1, "/proc/model.json")
        pathless = self.scene_with(lambda text: json.dumps({**json.loads(text), "camera": {"keys": []}}))
        self.assert_refused(run("model", pathless, "--out", out), 2, pathless, "at least one key")
        made = run("model", self.scene, *quick, "--quantile", "0.9", "--out", out)
        self.assertEqual(made.returncode, 0, made.stderr)
        play = ["play", self.root / "good", "--size", "64x36", "--out", self.out / "eyes"]
        self.assertEqual(run(*play, "--model", out).returncode, 0)
        self.assert_refused(run(*play, "--model", self.scene), 2, self.scene, "client's model")
        self.assert_refused(run("model", out, "--out", self.out / "again.json"), 2, out, "client's model")
        text = out.read_text()
        out.write_text(re.sub(r'"stands_for": "[0-9a-f]{4}', '"stands_for": "0000', text))
        self.assert_refused(run(*play, "--model", out), 2, out, "geometry")
        out.write_text(re.sub(r'"stands_for": "[0-9a-f]{4}', '"stands_for": "', text))
        self.assert_refused(run(*play, "--model", out), 2, out, "16 hexadecimal digits")

    def test_nan_in_a_path(self):
        path = self.out / "path.csv"
        path.write_text("time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,nan,0,0,1,0,0,0\n")
        self.assert_refused(run("render", self.scene, "--path", path, *SMALL, "--out", self.out / "x"), 2, f"{path}:3", "nan")

    def test_unwritable_folders(self):
        (self.out / "file").write_text("")
        for folder in (self.out / "file" / "x", "/proc/equistream"):
            self.assert_refused(run("scene", "generate", "motion", "--out", folder), 2, folder)
            self.assert_refused(run("render", self.scene, "--frames", "0", *SMALL, "--out", folder), 2, folder)
            result = run("encode", self.root / "good", "--out", f"{folder}/a.mp4")
            self.assertIn(result.returncode, (1, 2))
            self.assert_refused(result, result.returncode, folder)
            self.assert_refused(run("play", self.root / "good", "--method", "rotation", "--out", folder), 2, folder)

    def test_truncated_frame(self):
        folder = self.out / "frames"
        shutil.copytree(self.root / "good", folder)
        frame = sorted((folder / "centre").glob("frame.*.exr"))[3]
        frame.write_bytes(frame.read_bytes()[: frame.stat().st_size // 2])
        self.assert_refused(run("encode", folder, "--out", self.out / "a.mp4"), 1, frame.name)
        self.assert_refused(run("info", frame), 2, frame.name)

    def test_missing_and_foreign_streams(self):
        self.assert_refused(run("play", self.out / "none.mp4", "--out", self.out / "x"), 2, "none.mp4")
        (self.out / "text.mp4").write_text("this is no video\n" * 100)
        self.assert_refused(run("play", self.out / "text.mp4", "--out", self.out / "x"), 2, "text.mp4")
        self.assert_refused(run("info", self.out / "text.mp4"), 2, "text.mp4")
        picture = next((self.root / "good").rglob("frame.*.exr"))
        still = self.out / "still.mp4"
        still.write_bytes(picture.read_bytes())
        self.assert_refused(run("play", still, "--out", self.out / "x"), 2, "still.mp4: expected a video in MP4, Matroska", "found an EXR file (info explains it")

    def test_a_stream_of_a_version_to_come_is_no_damage(self):
        stream = self.out / "later.mkv"
        self.assertEqual(run("encode", self.root / "good", "--out", stream).returncode, 0)
        uuid = bytes.fromhex("69c4803651334784" "8093ec66a7475119")
        data = stream.read_bytes()
        self.assertEqual(data.count(uuid + b"\x01\x00"), 6)
        stream.write_bytes(data.replace(uuid + b"\x01", uuid + b"\x09"))
        for words in (["info", stream], ["play", stream, "--method", "rotation", "--out", self.out / "x"]):
            self.assert_refused(run(*words), 2, stream, "version 1", "version 9")

    def test_cut_streams_play_up_to_the_cut_and_say_so(self):
        for extension in ("mp4", "mkv", "ts"):
            stream = self.out / f"whole.{extension}"
            made = run("encode", self.root / "good", "--gop", "1", "--crf", "1", "--out", stream)
            self.assertEqual(made.returncode, 0, made.stderr)
            cut = self.out / f"cut.{extension}"
            cut.write_bytes(stream.read_bytes()[: int(stream.stat().st_size * 0.6)])
            views = self.out / f"views_{extension}"
            result = run("play", cut, "--method", "rotation", "--size", "64x36", "--out", views)
            self.assert_refused(result, 1, cut.name)
            played = len(list((views / "left").glob("frame.*.png")))
            self.assertGreaterEqual(played, 2, extension)
            self.assertLess(played, 6, extension)
            self.assertTrue((views / "report.json").exists())

    def test_a_full_device_takes_no_stream(self):
        for extension in ("mp4", "mkv", "ts"):
            full = self.out / f"full.{extension}"
            full.symlink_to("/dev/full")
            self.assert_refused(run("encode", self.root / "good", "--out", full), 1, full, "No space left on device")

    def test_another_scene_of_the_same_name_is_refused(self):
        scene = self.scene_with(lambda text: text, "motion.json")
        words = ["play", self.root / "good", "--frames", "0", "--size", "64x36", "--out"]
        self.assertEqual(run(*words, self.out / "same", "--scene", scene).returncode, 0)
        model = next(scene.parent.glob("*.glb"))
        data = model.read_bytes()
        self.assertIn(b"generator", data)
        model.write_bytes(data.replace(b"generator", b"Generator", 1))
        self.assert_refused(run(*words, self.out / "views", "--scene", scene), 2, scene, "geometry")
        self.assertFalse((self.out / "views").exists())

    def test_frames_that_name_no_geometry_are_played_with_a_note(self):
        name = b"equistream:geometry"
        folder = self.out / "frames"
        shutil.copytree(self.root / "good", folder)
        for frame in (folder / "centre").glob("frame.*.exr"):
            frame.write_bytes(frame.read_bytes().replace(name, b"equistream:otherone"))
        result = run("play", folder, "--frames", "0", "--size", "64x36", "--scene", self.scene, "--out", self.out / "views")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("carries no geometry fingerprint", result.stdout)

    def test_a_damaged_picture_is_one_line(self):
        views = self.out / "views"
        self.assertEqual(run("play", self.root / "good", "--method", "rotation", "--frames", "0", "--size", "64x64", "--out", views).returncode, 0)
        whole = views / "left" / "frame.0000.png"
        data = bytearray(whole.read_bytes())
        data[data.index(b"IDAT") + 20] ^= 0x55
        damaged = self.out / "damaged.png"
        damaged.write_bytes(data)
        self.assert_refused(run("compare", damaged, whole), 2, damaged, "IDAT")
        self.assert_refused(run("compare", whole, whole, "--frames", "0"), 2, "--frames", whole)

    def test_a_large_picture_in_a_small_file_takes_little_more_than_its_pixels(self):
        side, file = 8192, self.out / "black.png"

        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        packer = zlib.compressobj(9)
        rows = b"".join(packer.compress(bytes(side + 1)) for _ in range(side)) + packer.flush()
        file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))
        self.assertLess(file.stat().st_size, 100_000)
        words = [str(word) for word in (BIN / "equistream", "compare", file, file, "--metrics", "psnr", "--progress", "none")]
        child = os.posix_spawn(words[0], words, os.environ, file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)])
        _, status, usage = os.wait4(child, 0)
        self.assertEqual(status, 0)
        # Both pictures in 8 bits, an error a pixel and a copy on the way; floats of both would be 1.6 GB more.
        self.assertLess(usage.ru_maxrss * 1024, 1.3e9)

    def test_a_killed_render_resumes_and_ends_in_the_same_frames(self):
        words = ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", "16", "--seed", "3"]
        straight = run(*words, "--out", self.out / "straight")
        self.assertEqual(straight.returncode, 0, straight.stderr)
        killed = self.out / "killed"
        process = subprocess.Popen([BIN / "equistream", *map(str, words), "--out", killed], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while not (killed / "centre").is_dir() or len(frames_of(killed / "centre")) < 1:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)
        process.wait()
        first = killed / "centre" / frames_of(killed / "centre")[0]
        stamp = first.stat().st_mtime_ns
        self.assertEqual(run(*words, "--out", killed).returncode, 0)
        self.assertEqual(first.stat().st_mtime_ns, stamp, "a finished frame was rendered again")
        self.assertEqual(leftovers(killed / "centre"), [])
        for name in frames_of(self.out / "straight" / "centre"):
            self.assertEqual((self.out / "straight" / "centre" / name).read_bytes(), (killed / "centre" / name).read_bytes(), name)

    def test_resuming_with_other_settings_is_refused(self):
        folder = self.out / "frames"
        shutil.copytree(self.root / "good", folder)
        self.assert_refused(run("render", self.scene, "--frames", "0-5", *SMALL, "--seed", "9", "--out", folder), 2, "seed")

    def test_layouts_that_cannot_be(self):
        play = ["play", self.root / "good", "--size", "64x36", "--out", self.out]
        self.assert_refused(run(*play, "--layout", "stack"), 2, "--layout", "files, sbs or anaglyph")
        self.assert_refused(run(*play, "--layout", "sbs", "--format", "exr"), 2, "--layout", "exr")
        self.assert_refused(run(*play, "--anaglyph", "grey"), 2, "--anaglyph", "--layout anaglyph")
        self.assert_refused(run(*play, "--layout", "anaglyph", "--anaglyph", "purple"), 2, "--anaglyph", "half-colour")

    def test_play_never_touches_rendered_frames_and_leaves_no_mixture(self):
        flat = self.out / "flat"
        made = run("render", self.scene, "--camera", "perspective", "--eye", "both", "--frames", "0-2", "--size", "64x64", "--spp", "1",
                   "--aovs", "none", "--out", flat)
        self.assertEqual(made.returncode, 0, made.stderr)
        before = {path: path.read_bytes() for path in flat.rglob("*.exr")}
        self.assert_refused(run("play", flat, "--method", "rotation", "--format", "exr", "--out", flat), 2, flat)
        self.assertEqual(before, {path: path.read_bytes() for path in flat.rglob("*.exr")})
        views = self.out / "views"
        self.assertEqual(run("play", flat, "--method", "rotation", "--out", views).returncode, 0)
        other = ["play", flat, "--method", "rotation", "--frames", "1", "--size", "32x32", "--out", views]
        pictures = {path: path.read_bytes() for path in views.rglob("*") if path.is_file()}
        self.assert_refused(run(*other), 2, f"{views}/report.json: expected the default size as of the views there, found [32,32]",
                            "choose another folder or --overwrite")
        self.assert_refused(run("play", flat, "--method", "rotation", "--fill", "none", "--out", views), 2, 'expected fill "', 'found "none"')
        self.assertEqual(pictures, {path: path.read_bytes() for path in views.rglob("*") if path.is_file()})
        self.assertEqual(run(*other, "--overwrite").returncode, 0)
        self.assertEqual(sorted(path.name for path in (views / "left").iterdir()), ["frame.0001.png"])
        again = run(*other)
        self.assertEqual(again.returncode, 0, again.stderr)
        (views / "report.json").write_text("[]")
        self.assert_refused(run(*other), 2, "expected the report of play, found another file")

    def test_a_video_that_is_named_is_that_file(self):
        out = self.out / "eyes.mp4"
        play = ["play", self.root / "good", "--method", "rotation", "--size", "64x64", "--frames", "0-1"]
        done = run(*play, "--out", out, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([path.name for path in self.out.iterdir()], ["eyes.mp4"])
        self.assertEqual(json.loads(done.stdout)["settings"]["layout"], "sbs")
        tracks = json.loads(run("info", out, "--json").stdout)["tracks"]
        self.assertEqual([(track["width"], track["height"], track["pictures"], track["stereo"]) for track in tracks], [(128, 64, 2, "sbs")])
        before = out.read_bytes()
        self.assert_refused(run(*play, "--layout", "anaglyph", "--out", out), 2, f"--out {out}: expected the name of a new video, or --overwrite, found a file of this name")
        self.assertEqual(out.read_bytes(), before)
        self.assertEqual(run(*play, "--out", out, "--overwrite").returncode, 0)
        red_cyan = self.out / "red-cyan.mkv"
        self.assertEqual(run(*play, "--layout", "anaglyph", "--out", red_cyan).returncode, 0)
        self.assertEqual(json.loads(run("info", red_cyan, "--json").stdout)["tracks"][0]["width"], 64)
        self.assert_refused(run(*play, "--layout", "files", "--out", out), 2, f"--out {out}: expected --layout sbs or anaglyph")
        self.assert_refused(run(*play, "--format", "png", "--out", out), 2, f"--out {out}: expected --format mp4, or the name of a folder")
        self.assert_refused(run(*play, "--reliability", "--out", out), 2, "the name of a folder for --reliability")
        for name in ("view.mov", "view.webm", "view.GIF", "view.png"):
            self.assert_refused(run(*play, "--out", self.out / name), 2, f"--out {self.out / name}: expected a folder, or NAME.mp4 or NAME.mkv, found")
            self.assertFalse((self.out / name).exists())
        (self.out / "folder.mp4").mkdir()
        self.assert_refused(run(*play, "--out", self.out / "folder.mp4"), 2, "expected the name of a video, found a folder of this name")

    def test_names_that_are_not_utf_8_end_nothing(self):
        folder = self.out / os.fsdecode(b"frames\xff")
        shutil.copytree(self.root / "good", folder)
        views = self.out / "views"
        for _ in range(2):  # the second time over its own views
            done = run("play", folder, "--method", "rotation", "--size", "32x32", "--frames", "0", "--json", "--out", views)
            self.assertEqual(done.returncode, 0, done.stderr)
            for report in (done.stdout, (views / "report.json").read_text()):
                self.assertTrue(json.loads(report)["settings"]["source"].endswith("frames\ufffd"))

    def test_a_file_of_another_kind_is_told_who_takes_it(self):
        xml, glb = self.out / "cbox.xml", next((self.root / "scene").glob("*.glb"))
        xml.write_text('<?xml version="1.0"?>\n<scene version="3.0.0"/>\n')
        frame = self.root / "good" / "centre" / "frame.0000.exr"
        stream = self.out / "a.mkv"
        self.assertEqual(run("encode", self.root / "good", "--preset", "ultrafast", "--out", stream).returncode, 0)
        alone = self.out / "alone.glb"
        alone.write_bytes(glb.read_bytes())
        out = ["--out", self.out / "x"]
        for words, said in (
                (["render", xml, *out], "expected a scene description (JSON), found a scene in XML (render --host mitsuba renders Mitsuba's)"),
                (["render", glb, *out], f"found a model ({self.scene} beside it describes it)"),
                (["render", alone, *out], "found a model (scene describe writes a scene description of it; render and scene info take that)"),
                (["scene", "info", alone], "expected a scene description (JSON), found a model (scene describe writes"),
                (["scene", "info", stream], "found a video (play, view, serve and info take it)"),
                (["info", self.scene], "expected a video, found a scene description or other JSON (render renders a scene, scene info explains it)"),
                (["info", glb], "found a model"),
                (["info", xml], "render --host mitsuba"),
                (["play", self.scene, *out], "found a scene description"),
                (["play", frame, *out], "found an EXR file (info explains it; encode, play and view take its folder)"),
                (["encode", stream, "--out", self.out / "b.mkv"], "expected a folder of frames, found a video")):
            self.assert_refused(run(*words), 2, said)

    def test_what_is_read_is_not_written_over(self):
        render = self.out / "render"
        shutil.copytree(self.root / "good", render)
        before = {file: file.read_bytes() for file in render.rglob("*") if file.is_file()}
        frame = render / "centre/frame.0000.exr"
        self.assert_refused(run("compare", frame, render / "centre/frame.0001.exr", "--metrics", "psnr", "--out", frame), 2, f"--out {frame}: expected an output that is not the input")
        self.assert_refused(run("export", render / "centre", "--out", render / "centre", "--layout", "parts", "--overwrite"), 2, "expected an output outside the input")
        self.assert_refused(run("export", render, "--out", render, "--layout", "parts"), 2, "expected an output outside the input")
        self.assert_refused(run("import", render / "centre", "--out", render, "--overwrite"), 2, "expected another folder than what is imported lies in")
        self.assert_refused(run("import", render / "centre", "--out", render / "centre"), 2, f"--out {render / 'centre'}: expected an output that is not the input")
        self.assertEqual({file: file.read_bytes() for file in render.rglob("*") if file.is_file()}, before)

    def test_a_stream_that_is_closed_is_no_file_that_is_written(self):
        video = self.out / "a.mkv"
        for closed in ("2>&-", "<&- 2>&-"):
            done = subprocess.run(["sh", "-c", f'"$0" "$@" {closed}', BIN / "equistream", "encode", self.root / "good", "--out", video, "--preset", "ultrafast", "--progress", "json"],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0)
            self.assertNotIn(b'"done"', video.read_bytes())
            read = run("info", video)
            self.assertEqual((read.returncode, read.stderr), (0, ""))
        self.assertEqual(subprocess.run(["sh", "-c", '"$0" info "$1" >&-', BIN / "equistream", video], capture_output=True).returncode, 1)

    def test_numbers_with_leading_zeros_are_no_octal_ones(self):
        for words in (("encode", self.root / "good", "--out", self.out / "a.mkv", "--gop", "010"), ("render", self.scene, "--out", self.out / "r", "--spp", "-08")):
            self.assert_refused(run(*words), 2, "expected a number without leading zeros, found")

    def test_a_server_waits_for_no_named_pipe(self):
        os.mkfifo(self.out / "pipe")
        self.assert_refused(run("serve", self.out / "pipe", "--listen", "tcp://:0"), 2, f"{self.out / 'pipe'}: expected a file or a folder, found something else")

    def test_play_writes_into_no_folder_of_a_render(self):
        render = self.out / "render"
        made = run("render", self.scene, "--small", "right", "--frames", "0", *SMALL, "--out", render)
        self.assertEqual(made.returncode, 0, made.stderr)
        before = sorted(render.rglob("*"))
        for folder in (render, render / "centre", render / "small"):
            self.assert_refused(run("play", self.root / "good", "--method", "rotation", "--out", folder), 2,
                                f"--out {folder}: expected a folder without rendered frames, found", "manifest.json")
        self.assertEqual(sorted(render.rglob("*")), before)
        shutil.rmtree(render / "centre")
        self.assert_refused(run("play", self.root / "good", "--method", "rotation", "--out", render), 2,
                            f"found {render}/small/manifest.json")

    def test_frames_asked_for_end_a_stream_early(self):
        stream = self.out / "whole.mkv"
        self.assertEqual(run("encode", self.root / "good", "--gop", "1", "--out", stream).returncode, 0)
        cut = self.out / "cut.mkv"
        cut.write_bytes(stream.read_bytes()[: int(stream.stat().st_size * 0.8)])
        result = run("play", cut, "--method", "rotation", "--size", "64x64", "--frames", "0-1", "--out", self.out / "views")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_nothing_to_play_is_told_with_the_range_only_where_one_was_asked_for(self):
        empty = self.out / "empty" / "centre"
        empty.mkdir(parents=True)
        words = ["play", "--method", "rotation", "--out", self.out / "views"]
        self.assert_refused(run(*words, empty.parent), 2, f"{empty}: expected rendered frames, found none")
        self.assert_refused(run(*words, self.root / "good", "--frames", "90-91"), 2, "expected rendered frames in the range asked for")

    def test_a_head_outside_its_box_is_counted_and_the_source_is_named(self):
        head = self.out / "head.csv"
        views = self.out / "views"
        words = ["play", self.root / "good", "--scene", self.scene, "--size", "64x36", "--out", views]
        self.assertEqual(run(*words).returncode, 0)
        report = json.loads((views / "report.json").read_text())
        self.assertFalse([note for note in report["notes"] if "head box" in note], report["notes"])
        self.assertEqual(report["source"], {"seed": 1, "samples_per_pixel": 2})
        head.write_text("0,1000,0,0,1,0,0,0\n")
        result = run(*words, "--head", head, "--overwrite")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("in 6 of 6 frames an eye is outside the head box", result.stdout)

    def test_help_shows_the_subcommands_own_example(self):
        for word, example in (("info", "equistream scene info scenes/"), ("generate", "equistream scene generate pavilion")):
            text = run("scene", word, "--help").stdout
            self.assertEqual(text.count("  equistream scene"), 1, text)
            self.assertIn("  " + example, text)

    def test_a_slip_in_a_path_is_no_header(self):
        path = self.out / "path.csv"
        path.write_text("O.0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n")
        self.assert_refused(run("render", self.scene, "--path", path, *SMALL, "--out", self.out / "x"), 2, f"{path}:1", "O.0")

    def test_manifests_are_json(self):
        manifest = json.loads((self.root / "good" / "centre" / "manifest.json").read_text())
        self.assertIn("planes", manifest)


if __name__ == "__main__":
    unittest.main(verbosity=2)
