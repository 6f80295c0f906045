"""HDR streams from `encode --transfer pq`: `play` and `view` show them alike, and as their display is chosen.

usage: hdr_test.py BIN_DIR
"""

import copy
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from display import Display, ViewerProcess, psnr, wait_for  # noqa: E402
from independent import *  # noqa: E402,F403

PROGRAMS = Programs(sys.argv.pop(1))
SIZE = (320, 180)
FILMIC = "ACES 1.0 - SDR Video"


class Hdr(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_hdr_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        description = json.loads(cls.scene.read_text())
        description["exposure"] *= 3  # for the sky to be brighter than white
        cls.scene.write_text(json.dumps(description))
        cls.folder = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-1", "--size", "512x256", "--spp", 4, "--aovs", "depth", "--out", cls.folder)
        cls.streams = {}
        for transfer in ("srgb", "pq"):
            cls.streams[transfer] = cls.root / f"{transfer}.mkv"
            PROGRAMS.run("encode", cls.folder, "--out", cls.streams[transfer], "--transfer", transfer, "--depth", "none", "--crf", "4", "--preset", "ultrafast",
                         "--progress", "none")
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()
        shutil.rmtree(cls.root, ignore_errors=True)

    def played(self, *words, transfer="pq"):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        PROGRAMS.run("play", self.streams[transfer], "--method", "rotation", "--fill", "none", "--size", "{}x{}".format(*SIZE), "--frames", "0", *words,
                     "--progress", "none", "--out", out)
        return np.asarray(Image.open(out / "left" / "frame.0000.png").convert("RGB")).astype(float)

    def view(self, *words):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", out, self.streams["pq"], "--method", "rotation", "--fill", "off", "--paused",
                               "--size", "{}x{}".format(*SIZE), *words)
        self.addCleanup(viewer.close)
        return viewer

    def test_an_hdr_stream_is_shown_as_an_srgb_one_unless_told_otherwise(self):
        self.assertGreater(psnr(self.played(), self.played(transfer="srgb")), 34)  # two codings of noise

    def test_view_shows_what_play_shows(self):
        for words in ((), ("--view-transform", FILMIC), ("--exposure", "-2")):
            with self.subTest(words=words):
                played, viewer = self.played(*words), self.view(*words)
                seen = viewer.picture()
                viewer.close()
                self.assertGreaterEqual(psnr(seen, played), 50)
        self.assertLess(psnr(self.played(), self.played("--view-transform", FILMIC)), 30)

    def test_a_key_changes_the_exposure(self):
        viewer = self.view()
        viewer.picture()
        viewer.press(*["minus"] * 4)
        darker = self.played("--exposure", "-1")
        wait_for(lambda: psnr(viewer.picture(), darker) >= 50 or None, "a picture one stop darker")

    def light_ahead(self):
        """What was rendered of frame 0, exposed, as an eye that turns only looks into it."""
        light = json.loads(self.scene.read_text())["exposure"] * colour_of(read_frame(self.folder / "centre" / "frame.0000.exr"))
        tags = json.loads(PROGRAMS.run("info", self.streams["pq"], "--json"))["tracks"][0]["first_frame"]
        (width, height), (rows, columns) = SIZE, light.shape[:2]
        ahead = perspective_direction(*pixel_centres(width, height), width, height, np.pi / 2) @ rotation(tags["head"]["orientation_wxyz"]).T
        u, v = equirect_pixel(ahead @ rotation(tags["camera_pose"]["orientation_wxyz"]), columns, rows)
        return lambda exposed: sample(exposed(light), u, v)

    def test_what_is_brighter_than_white_is_kept(self):
        # Five stops down, what was clipped at white has shades again, and those of the light that was rendered.
        white = (self.played(transfer="srgb") >= 255).all(axis=2)
        self.assertGreater(white.sum(), 50)
        ahead = self.light_ahead()
        shown, light = self.played("--exposure", "-5")[white], ahead(lambda light: 255 * srgb(light / 32))[white]
        clipped = ahead(lambda light: 255 * srgb(np.minimum(light, 1) / 32))[white]
        self.assertGreater(light.std(), 2)
        self.assertGreater(psnr(shown, light), 40)
        self.assertLess(psnr(clipped, light), 25)

    def coded_otherwise(self, name, pixels, *words):
        """The HDR stream once more with its samples in other places; its frame data stays."""
        stream = self.root / f"{name}.mkv"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", self.streams["pq"], "-map", "0:v:0", *words, "-c:v", "libx264", "-preset", "ultrafast", "-qp", "4",
                        "-udu_sei", "1", "-pix_fmt", pixels, "-color_primaries", "bt2020", "-color_trc", "smpte2084", "-colorspace", "bt2020nc", stream], check=True)
        self.streams[name] = stream
        return name

    def test_hdr_whose_samples_lie_otherwise(self):
        top_left = self.coded_otherwise("top-left", "yuv420p10le", "-vf", "scale=out_h_chr_pos=0:out_v_chr_pos=0", "-x264-params", "chromaloc=2")
        for name in (top_left, self.coded_otherwise("whole", "yuv444p10le")):
            with self.subTest(name):
                self.assertGreater(psnr(self.played("--exposure", "-2", transfer=name), self.played("--exposure", "-2")), 40)

    def mixed(self):
        """A small stream in HDR, which has no first picture, beside a main one of 8 bits."""
        folder = self.root / "with_small"
        PROGRAMS.run("render", self.scene, "--frames", "0-2", "--fps", 5, "--size", "512x256", "--spp", 1, "--aovs", "none", "--small", "right", "--out", folder)
        coded = {}
        for transfer in ("srgb", "pq"):
            coded[transfer] = self.root / f"with_small.{transfer}.mkv"
            PROGRAMS.run("encode", folder, "--out", coded[transfer], "--transfer", transfer, "--depth", "none", "--fill", "small", "--gop", "1", "--preset", "ultrafast",
                         "--progress", "none")
        mixed = self.root / "mixed.mkv"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", coded["srgb"], "-i", coded["pq"], "-map", "0:v:0", "-map", "1:v:1", "-c", "copy", "-bsf:v:1",
                        "noise=drop=not(n)", mixed], check=True)
        tracks = json.loads(PROGRAMS.run("info", "--frames", "--json", mixed))["tracks"]
        self.assertEqual([len(track["frames"]) for track in tracks], [3, 2])
        return mixed

    def test_a_shader_is_made_before_its_first_picture_comes(self):
        shaders = self.root / "shaders"
        shaders.mkdir()
        display = copy.copy(self.display)
        display.environment = {**self.display.environment, "MESA_SHADER_DUMP_PATH": str(shaders)}
        viewer = ViewerProcess(display, PROGRAMS.folder / "equistream", pathlib.Path(tempfile.mkdtemp(dir=self.root)), self.mixed(), "--scene", self.scene, "--fill",
                               "small", "--paused", "--size", "{}x{}".format(*SIZE))
        self.addCleanup(viewer.close)
        first = viewer.picture()
        made = len(list(shaders.iterdir()))
        self.assertGreater(made, 10)
        viewer.press("period")
        wait_for(lambda: psnr(viewer.picture(), first) < 60, "the next frame, whose small picture is HDR")
        self.assertEqual(len(list(shaders.iterdir())), made)
        viewer.press("Escape")
        self.assertEqual(viewer.end(), (0, ""))

    def foreign(self, transfer):
        """Somebody else's video of 10 bits, by how it says that its samples stand for light."""
        video = self.root / f"{transfer}.mp4"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "lavfi", "-i", "color=0x406080:size=256x128:rate=5:duration=1", "-c:v", "libx264", "-pix_fmt", "yuv420p10le",
                        "-color_primaries", "bt2020", "-color_trc", transfer, "-colorspace", "bt2020nc", video], check=True)
        return video

    def test_hdr_that_is_not_pq_is_said_to_be_dull(self):
        seen, said = {}, {}
        for transfer in ("arib-std-b67", "bt2020-10"):
            viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", pathlib.Path(tempfile.mkdtemp(dir=self.root)), self.foreign(transfer), "--paused",
                                   "--size", "760x100")
            self.addCleanup(viewer.close)
            seen[transfer] = viewer.picture()
            time.sleep(4.5)  # until what was written has gone
            red, green, blue = np.moveaxis(viewer.screen()[:100, :760], -1, 0)
            orange = (red > 180) & (green > 100) & (green < 180) & (blue > 40) & (blue < 110)  # the bar of progress has no blue
            said[transfer] = np.flatnonzero(orange.any(axis=0))
            viewer.press("Escape")
            self.assertEqual(viewer.end(), (0, ""))
        # Shown alike; the one line is that of ordinary video, the other is more than twice as long.
        self.assertEqual(psnr(*seen.values()), float("inf"))
        self.assertGreater(len(said["bt2020-10"]), 40)
        self.assertGreater(said["arib-std-b67"].max(), 2 * said["bt2020-10"].max())
        self.assertIn("expected an HDR stream (PQ", self.refused("play", self.foreign("arib-std-b67"), "--exposure", "1", "--out", self.root / "nothing"))

    def refused(self, program, *words):
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", program, *words]], env=self.display.environment, capture_output=True, text=True)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
        return result.stderr

    def test_what_cannot_be_is_said_in_one_line(self):
        out = ("--out", self.root / "nothing")
        self.assertIn("expected an HDR stream", self.refused("play", self.streams["srgb"], "--exposure", "1", *out))
        self.assertIn("expected an HDR stream", self.refused("view", self.streams["srgb"], "--exposure", "1", *out))
        self.assertIn("expected an HDR stream", self.refused("play", self.folder, "--exposure", "1", *out))
        self.assertIn("equistream view: --view-transform: expected one of", self.refused("view", self.streams["pq"], "--view-transform", "Filmic", *out))
        self.assertIn("equistream play: --display: expected one of", self.refused("play", self.streams["pq"], "--display", "TV", *out))
        self.assertIn("--format exr", self.refused("play", self.streams["pq"], "--format", "exr", "--exposure", "1", *out))
        self.assertIn("--transfer pq", self.refused("encode", self.folder, "--transfer", "pq", "--stereo", "top-bottom", *out))
        nothing = self.root / "nothing.ocio"
        nothing.write_text("colours: none\n")
        self.assertIn("nothing.ocio: expected an OpenColorIO config", self.refused("play", self.streams["pq"], "--ocio", nothing, *out))


if __name__ == "__main__":
    unittest.main()
