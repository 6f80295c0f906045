"""Commands as a person runs them: what is there already is kept, options that could do nothing are refused, paths that cannot be
looked at are bad input, and reports say whose they are.

usage: commands_test.py BIN_DIR   (the folder of the built programs)
"""

import json
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PLAY = ["--method", "rotation", "--size", "64x64"]
QUICK = ["--rays", 20000, "--visibility-rays", 20000, "--quantile", 0.9]
BIN = pathlib.Path(sys.argv.pop(1))


def run(*words):
    return subprocess.run([BIN / "equistream", *map(str, words)], capture_output=True, text=True, timeout=120)


def contents(folder):
    """Bytes of every file below a folder."""
    return {path: path.read_bytes() for path in pathlib.Path(folder).rglob("*") if path.is_file()}


class Commands(unittest.TestCase):
    """`scene` is a scene's description, `frames` are six small frames of it, and `out` is each test's own folder."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_commands_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.scene, cls.frames = cls.root / "scene" / "motion.json", cls.root / "frames"
        cls.done("scene", "generate", "motion", "--out", cls.scene.parent)
        cls.done("render", cls.scene, "--frames", "0-5", "--size", "128x64", "--spp", 2, "--aovs", "depth", "--out", cls.frames)

    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    @staticmethod
    def done(*words):
        result = run(*words)
        assert result.returncode == 0, result.stderr
        return result.stdout

    def refused(self, words, *mentions, code=2):
        result = run(*words)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (code, 1), result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), result.stderr)
        return result.stdout


class Models(Commands):
    def setUp(self):
        super().setUp()
        self.scenes = self.out / "scenes"
        shutil.copytree(self.scene.parent, self.scenes)
        self.description = self.scenes / "motion.json"

    def assert_kept(self, out, *mentions):
        before = contents(self.scenes)
        self.refused(["model", self.description, *QUICK, "--out", out], f"--out {out}", *mentions)
        self.assertEqual(contents(self.scenes), before)

    def test_a_scene_is_not_replaced_by_its_model(self):
        self.assert_kept(self.description, "expected an output that is not the input, found", self.description)
        link = self.out / "link.json"
        link.symlink_to(self.description)
        self.assert_kept(link, "expected an output that is not the input")

    def test_geometry_is_not_replaced_under_another_name(self):
        (self.scenes / "again.glb").hardlink_to(self.scenes / "motion.glb")
        before = contents(self.scenes)
        self.refused(["model", self.description, *QUICK, "--out", self.scenes / "again.json"], "expected an output that is not the input", "motion.glb")
        self.assertEqual(contents(self.scenes), before)

    def test_a_path_too_long_for_boxes_all_along_it_is_told(self):
        description = json.loads(self.description.read_text())
        description["camera"] = {"keys": [{"time_s": 60 * i, "position_m": [0, 1.6, 200 * i]} for i in range(2)]}
        description["head_box"] = {"lean_m": 0.1}
        self.description.write_text(json.dumps(description))
        path = json.loads(self.done("model", self.description, *QUICK, "--json", "--out", self.out / "m.json"))["path"]
        self.assertLessEqual(path["centres"], 512)
        self.assertGreaterEqual(path["centres"] * path["cell_m"], 200)
        self.assertGreater(path["added_m"], 0.4 * path["cell_m"])

    def test_another_scene_is_not_replaced(self):
        self.done("scene", "generate", "orientation", "--out", self.scenes)
        self.assert_kept(self.scenes / "orientation.json", "a client's model to replace", "orientation.json")

    def test_a_scene_that_its_user_changed_is_generated_anew_only_where_asked(self):
        generate = ["scene", "generate", "orientation", "--out", self.scenes]
        self.done(*generate)
        self.done(*generate)
        file = self.scenes / "orientation.json"
        made = file.read_text()
        file.write_text(made.replace("{", "{ ", 1))
        before = contents(self.scenes)
        self.refused(generate, file, "--overwrite")
        self.assertEqual(contents(self.scenes), before)
        self.done(*generate, "--overwrite")
        self.assertEqual(file.read_text(), made)

    def test_a_model_that_was_made_with_other_options_is_replaced_only_where_asked(self):
        """A description says nothing of some; the model does."""
        self.done("scene", "generate", "--option", "n=16", "sphere", "--out", self.scenes)
        file = self.scenes / "sphere.glb"
        for options in (["--option", "n=8"], ["--knob", "8"]):
            before = contents(self.scenes)
            self.refused(["scene", "generate", "sphere", *options, "--out", self.scenes], file, "--overwrite")
            self.assertEqual(contents(self.scenes), before)
        (self.scenes / "sphere.json").unlink()
        self.refused(["scene", "generate", "sphere", "--option", "n=8", "--out", self.scenes], file, "--overwrite")

    def test_a_path_on_another_clock_than_what_moves_is_refused(self):
        scene = json.loads(self.description.read_text())
        for path in (scene["camera"], *scene["moving"]):
            for key in path["keys"]:
                key["time_s"] += 1e6
        self.description.write_text(json.dumps(scene))
        head = self.out / "head.csv"
        render = ["render", self.description, "--path", head, "--dry-run", "--out", self.out / "frames"]
        for begin in (1000005, 1000000):
            head.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "".join(f"{begin + i},0,1.6,0,1,0,0,0\n" for i in range(2)))
            if begin == 1000005:
                self.refused(render, f"--path {head}: expected a path that begins at 1000000.000000 s", "found 1000005.000000 s")
            else:
                self.done(*render)

    def test_a_host_in_a_settings_file_must_be_the_one_that_runs(self):
        settings = self.out / "host.ini"
        settings.write_text("[render]\nhost = mitsuba\n")
        self.refused(["render", self.description, "--settings", settings, "--out", self.out / "frames"], "--host: expected embree", "on the command line only")
        settings.write_text("[render]\nhost = embree\n")
        self.done("render", self.description, "--settings", settings, "--dry-run", "--out", self.out / "frames")

    def test_geometry_that_no_model_names_is_not_replaced(self):
        (self.scenes / "alone.glb").write_bytes(b"somebody's")
        self.assert_kept(self.scenes / "alone.json", "a client's model to replace", "alone.glb")

    def test_an_earlier_model_is_replaced(self):
        for _ in range(2):
            self.done("model", self.description, *QUICK, "--out", self.out / "model.json")


class Encodings(Commands):
    def test_a_hidden_layer_of_another_eye_is_refused(self):
        render = ["render", self.scene, "--frames", 0, "--size", "128x64", "--aovs", "depth", "--out", self.out / "eyes"]
        self.done(*render, "--eye", "left", "--layers")
        self.done(*render, "--eye", "right")
        encode = ["encode", self.out / "eyes", "--out", self.out / "a.mkv", "--preset", "ultrafast", "--depth", "w10"]
        self.refused([*encode, "--eye", "right"], "hidden, frame 0: expected the eye of")
        self.done(*encode, "--eye", "left")

    def test_depth_that_cannot_be_halved_is_not(self):
        self.done("render", self.scene, "--frames", 0, "--size", "130x66", "--aovs", "depth", "--out", self.out / "odd")
        for code in (("w10", "--depth-crf", 20), ("lossless",)):
            self.refused(["encode", self.out / "odd", "--out", self.out / "a.mkv", "--depth", *code, "--depth-scale", 2], "--depth-scale: expected 1", "2 for 130x66")
        self.done("render", self.scene, "--frames", 0, "--size", "512x256", "--aovs", "depth", "--spp", 1, "--out", self.out / "even")
        self.refused(["encode", self.out / "even", "--out", self.out / "a.mkv", "--tiles", "4x4", "--base", 128, "--depth", "w10", "--depth-crf", 20, "--depth-scale", 2],
                     "--depth-scale: expected 1", "2 for 128x64")


class Views(Commands):
    def play(self, out, *options, source=None):
        return ["play", source or self.frames, *PLAY, *options, "--out", out]

    def encoded(self, name, *options):
        stream = self.out / name
        stream.parent.mkdir(exist_ok=True)
        self.done("encode", self.frames, "--preset", "ultrafast", *options, "--out", stream)
        return stream

    def test_a_stream_is_not_replaced_by_its_views(self):
        walk = self.encoded("walk.mkv")
        part = walk.rename(self.out / "cut.mkv.part")
        shutil.copyfile(part, walk)
        both = self.encoded("eyes/both.mp4")
        before = contents(self.out)
        for words in (self.play(walk, source=walk), self.play(self.out / "cut.mkv", source=part),
                      self.play(both.parent, "--format", "mp4", "--layout", "sbs", source=both)):
            self.refused(words, "expected an output that is not the input, found")
            self.assertEqual(contents(self.out), before)

    def test_a_view_that_nothing_could_read_is_refused(self):
        self.refused(["play", self.frames, "--method", "rotation", "--size", "64x64", "--fov", 0.05, "--format", "exr", "--out", self.out / "views"],
                     "--fov: expected degrees above 0.1 and below 179, found 0.05")

    def test_frames_without_a_manifest_are_not_replaced_by_their_views(self):
        frames = self.out / "frames"
        shutil.copytree(self.frames / "centre", frames / "left", ignore=shutil.ignore_patterns("manifest.json"))
        before = contents(frames)
        for source in (frames, frames / "left"):
            self.refused(self.play(frames, "--overwrite", source=source), "expected an output that is not the input")
            self.assertEqual(contents(frames), before)

    def assert_kept(self, views, other, *mentions):
        before = contents(views)
        self.refused(other, *mentions, "choose another folder or --overwrite")
        self.assertEqual(contents(views), before)
        self.done(*other, "--overwrite")

    def test_views_of_other_frames_stay(self):
        views = self.out / "views"
        self.done(*self.play(views, "--frames", "0-1"))
        self.assert_kept(views, self.play(views, "--frames", "2-3"), "expected frames [0,1] as of the views there, found [2,3]")
        self.assert_kept(views, self.play(views), "expected frames [2,3] as of the views there, found the default")

    def test_views_for_other_glasses_stay(self):
        views = self.out / "views"
        self.done(*self.play(views, "--layout", "anaglyph", "--anaglyph", "grey"))
        self.assert_kept(views, self.play(views, "--layout", "anaglyph"), 'expected anaglyph "grey" as of the views there')

    def test_views_of_another_exposure_stay(self):
        stream, views = self.encoded("hdr.mp4", "--transfer", "pq", "--fill", "none"), self.out / "views"
        self.done(*self.play(views, source=stream))
        self.assert_kept(views, self.play(views, "--exposure", "-1", source=stream), "expected the default hdr_display as of the views there")
        self.assert_kept(views, self.play(views, "--exposure", "-2", source=stream), '"exposure":-1.0')

    def test_views_of_another_choice_by_time_stay(self):
        views = self.out / "views"
        auto = ["play", self.frames, "--method", "auto", "--size", "32x32", "--frames", "0-1", "--out", views]
        self.done(*auto, "--budget-ms", 1000)
        self.assert_kept(views, [*auto, "--budget-ms", 2000], "expected budget_ms 1000.0 as of the views there")
        self.assert_kept(views, [*auto, "--budget-ms", 2000, "--rechoose", "off"], "expected rechoose true as of the views there")

    def test_views_without_a_report_stay(self):
        views = self.out / "views"
        self.done(*self.play(views))
        (views / "report.json").unlink()
        self.assert_kept(views, self.play(views), f"{views}: expected a report.json with the settings of its views")

    def kill_while_playing(self, views):
        process = subprocess.Popen([BIN / "equistream", *map(str, self.play(views, "--repeat", 3000))], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while not list(views.glob("left/frame.*.png")):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()

    def test_a_killed_run_is_made_anew_by_the_same_command_alone(self):
        views = self.out / "views"
        self.kill_while_playing(views)
        self.assert_kept(views, self.play(views, "--fill", "none"), 'found "none"')
        shutil.rmtree(views)
        self.kill_while_playing(views)
        self.done(*self.play(views))
        self.assertEqual(len(list(views.glob("left/frame.*.png"))), 6)

    def test_a_first_frame_is_played_although_the_second_is_damaged(self):
        frames = self.out / "frames"
        shutil.copytree(self.frames, frames)
        second = frames / "centre" / "frame.0001.exr"
        second.write_bytes(second.read_bytes()[: second.stat().st_size // 2])
        self.refused(["play", frames, "--method", "auto", "--budget-ms", 1000, "--size", "32x32", "--out", self.out / "views"], second, code=1)
        self.assertEqual([path.name for path in (self.out / "views/left").iterdir()], ["frame.0000.png"])


    def test_missing_frames_are_told_and_not_exported(self):
        frames = self.out / "frames"
        shutil.copytree(self.frames, frames)
        (frames / "centre" / "frame.0002.exr").unlink()
        views = self.out / "views"
        self.done("play", frames, *PLAY, "--frames", "0-4", "--out", views)
        self.assertIn(f"{frames}: frames missing in between: 1, the first is 2", json.loads((views / "report.json").read_text())["notes"])
        for asked in ("1-3", "3-100"):
            self.refused(["export", frames, "--frames", asked, "--out", self.out / "comp"], f"expected frames {asked}, found no frame.")
        self.done("export", frames, "--frames", "3-4", "--out", self.out / "comp")

    def test_a_settings_file_has_values_with_any_characters(self):
        settings = self.out / "own.ini"
        settings.write_text(f'\ufeffframes = 0 # the first\nout = "{self.out}/take #2, again"\n')
        self.done("play", self.frames, *PLAY, "--settings", settings)
        self.assertEqual(sorted(path.name for path in self.out.iterdir()), ["own.ini", "take #2, again"])


class Scores(Commands):
    def setUp(self):
        super().setUp()
        self.views = self.out / "views"
        self.done("play", self.frames, *PLAY, "--frames", "0-1", "--out", self.views)

    def test_difference_pictures_take_no_compared_ones_places(self):
        truth = self.out / "truth"
        shutil.copytree(self.views, truth)
        before = contents(self.out)
        for folder in (self.views, truth, self.views / "gaps"):
            self.refused(["compare", self.views, truth, "--gaps", self.views / "gaps", "--difference", folder],
                         f"--difference {folder}: expected a folder apart from what is compared")
            self.assertEqual(contents(self.out), before)
        self.done("compare", self.views, truth, "--difference", self.out / "difference")

    def test_scores_do_not_take_the_place_of_what_play_says(self):
        before = contents(self.out)
        self.refused(["compare", self.views, self.views, "--metrics", "psnr", "--out", self.views / "report.json"],
                     "report.json: expected an output that is not the input")
        self.assertEqual(contents(self.out), before)

    def test_scores_replace_earlier_scores_alone(self):
        words, scene = ["compare", self.views, self.views, "--metrics", "psnr", "--out"], self.out / "scene.json"
        for _ in range(2):
            self.done(*words, self.out / "score.json")
        shutil.copy(self.scene, scene)
        before = contents(self.out)
        self.refused([*words, scene], f"--out {scene}: expected a new name, or an earlier report of compare to replace, found another file; choose another name, or remove that file")
        self.assertEqual(contents(self.out), before)

    def test_scores_that_cannot_be_written_are_told(self):
        picture = self.views / "left" / "frame.0000.png"
        words = ["compare", picture, picture, "--metrics", "psnr", "--out"]
        self.refused([*words, self.out / "none" / "score.json"], "expected a folder that can be written to")
        self.refused([*words, self.out], "expected the name of a file, found a folder of this name")
        longest = self.out / ("x" * 255)  # there is no room for a name while it is written
        self.assertIn("identical", self.refused([*words, longest], longest.name[:50], code=1))


class Options(Commands):
    def test_pictures_of_a_display_have_no_exposure_and_no_view(self):
        self.done("play", self.frames, *PLAY, "--frames", 0, "--out", self.out / "views")
        picture, frame = self.out / "views/left/frame.0000.png", self.frames / "centre/frame.0000.exr"
        for option, value in (("--exposure", 4), ("--view", "Un-tone-mapped")):
            self.refused(["compare", picture, picture, option, value], f"{option}: expected an EXR among the pictures, found PNG alone")
            self.done("compare", frame, frame, "--metrics", "psnr", option, value)

    def test_errors_without_the_truths_noise_need_truths_of_their_own(self):
        picture, truths = self.frames / "centre", []
        for seed in (21, 22):
            truths.append(self.out / f"truth-{seed}" / "centre")
            self.done("render", self.scene, "--frames", "0-1", "--size", "128x64", "--spp", 2, "--seed", seed, "--aovs", "motion", "--out", truths[-1].parent)
        words = ["compare", picture, truths[0], "--frames", "0-1", "--metrics", "flicker", "--json"]
        self.refused(words, "--metrics flicker: expected --truth2 or --second, found neither")
        self.refused([*words, "--truth2", truths[0]], f"--truth2: {truths[0]}/frame.000", ": expected noise of its own, found the file ")
        self.refused([*words, "--truth2", picture], "--truth2: ", ": expected noise of its own, found the file ")
        self.refused([*words, "--second", picture, truths[1], "--truth2", picture], f"--truth2: expected the TRUTH2 of --second, found {picture}")
        found = json.loads(self.done(*words, "--truth2", truths[1]))
        eye = found["eyes"]["view"]
        self.assertEqual((found["second_truth"], eye["flicker"]["motion"]), (str(truths[1]), "exact"))
        self.assertLess(eye["whole"]["linear"]["mean_square_low"], eye["whole"]["linear"]["mean_square"])

    def test_nothing_is_extrapolated_without_refreshes(self):
        for value in (0, 7):
            self.refused(["play", self.frames, *PLAY, "--frames", 0, "--extrapolate", value, "--out", self.out / "views"],
                         "--extrapolate: expected --refresh or --network as well, found neither")

    def test_pixels_are_square_by_default_and_where_they_are_not_that_is_told(self):
        render = ["render", self.scene, "--dry-run", "--out", self.out / "frames"]
        for spans, size in (("360,180", "1920x960"), ("180,180", "1920x1920"), ("360,90", "1920x480")):
            made = run(*render, "--range", spans)
            self.assertIn(f" of {size} pixels ", made.stdout)
            self.assertEqual(made.stderr, "")
        self.refused([*render, "--range", "20,170"], "--range: expected at most 4 times as high as wide, or --size as well", "16320 high")
        self.done(*render, "--range", "20,170", "--size", "64x544")
        for words, rows in ((["--range", "180,180", "--size", "128x64"], 128), (["--size", "64x33"], 32), (["--range", "180,90", "--size", "128x64"], None)):
            told = run(*render, *words).stderr
            self.assertEqual("are not square" in told, rows is not None, told)
            self.assertIn(f"those of {rows} rows are\n" if rows else "", told)

    def test_a_dry_run_leaves_what_is_there_alone(self):
        before = contents(self.frames)
        self.done("render", self.scene, "--frames", "0-5", "--size", "128x64", "--seed", 9, "--dry-run", "--out", self.frames)
        self.assertEqual(contents(self.frames), before)

    def test_a_dry_run_knows_its_options(self):
        self.refused(["import", self.frames / "centre", "--dry-run", "--progress", "bogus"], "--progress", "bogus")

    def test_paths_that_cannot_be_looked_at(self):
        circle, long = self.out / "circle", self.out / ("x" * 300)
        circle.symlink_to(circle)
        for path, why in ((circle, "symbolic links"), (long, "name too long")):
            for words in (["info", path], ["import", path, "--dry-run"], ["play", self.frames, *PLAY, "--frames", 0, "--out", path / "a.mp4"],
                          ["play", path, *PLAY, "--frames", 0, "--out", self.out / "views"], ["encode", path, "--out", self.out / "a.mkv"]):
                self.refused(words, "expected ", why)


class Reports(Commands):
    def assert_names_its_making(self, *words):
        report = json.loads(self.done(*words))
        self.assertTrue(report["command"].startswith("equistream " + " ".join(words[:1])), report["command"])
        self.assertTrue(report["version"] and report["machine"]["cpu"] and report["machine"]["threads"] >= 1, words)
        return report

    def test_what_info_says(self):
        for source, kind in ((self.frames, "render"), (self.frames / "centre/frame.0000.exr", "exr")):
            self.assertEqual(self.assert_names_its_making("info", source, "--json")["kind"], kind)

    def test_what_scene_says(self):
        self.assertEqual(self.assert_names_its_making("scene", "info", self.scene, "--json")["scene"], "motion")
        xml = self.out / "motion.xml"
        self.assertGreater(self.assert_names_its_making("scene", "convert", self.scene, xml, "--json")["triangles"], 0)
        self.assertEqual(self.assert_names_its_making("scene", "info", xml, "--json")["must_change"], [])


class Windows(Commands):
    def test_those_that_cannot_be(self):
        size = "--window: expected a width above 0 and below 360 degrees, a height of at most 180, found "
        density = "--density: expected a multiple of 32, more than the 32 columns of a sphere of --size 32x16, up to 32768, found "
        whole = "--window: expected a whole sphere of one eye, without --layers and --patches, found "
        gaze = ["--window", "gaze,60x45"]
        for words, line in [
            (["--window", "1"], "--window: expected AZ,EL,WxH or gaze,WxH in degrees, found '1'"),
            (["--window", "1,2,60"], "--window: expected AZ,EL,WxH or gaze,WxH in degrees, found '1,2,60'"),
            (["--window", "1,2,60xa"], "--window: expected AZ,EL,WxH or gaze,WxH in degrees, found 'a'"),
            (["--window", "gaze,0x45"], size + "'gaze,0x45'"),
            (["--window", "gaze,360x45"], size + "'gaze,360x45'"),
            (["--window", "gaze,60x181"], size + "'gaze,60x181'"),
            (["--window", "1,91,60x45"], "--window: expected AZ from -360 to 360 and EL from -90 to 90 degrees, found '1,91,60x45'"),
            (["--window", "gaze,359x45"], "--window: expected less than the sphere's 128x64, found 128x16"),
            ([*gaze, "--density", 100], density + "100"),
            ([*gaze, "--density", 32], density + "32"),
            (["--density", 128], "--density: expected --window as well, found none"),
            ([*gaze, "--camera", "perspective"], whole + "--camera perspective; leave one of the two out"),
            ([*gaze, "--eye", "both"], whole + "--eye both; leave one of the two out"),
            ([*gaze, "--range", "180,90"], whole + "--range; leave one of the two out"),
            ([*gaze, "--layers"], whole + "--layers; leave one of the two out"),
            ([*gaze, "--patches"], whole + "--patches; leave one of the two out"),
            (["--samples", "angle", "--camera", "perspective"], "--samples angle: expected spheres of independent frames, found --camera perspective"),
            (["--samples", "angle", "--accumulate", 4], "--samples angle: expected spheres of independent frames, found --accumulate"),
        ]:
            self.refused(["render", self.scene, "--size", "32x16", "--out", self.out / "w", *words], line)
        self.assertFalse((self.out / "w").exists())


class Tiles(Commands):
    def refused_of(self, render, *cases):
        frames = self.out / "frames"
        self.done("render", self.scene, "--frames", "0-0", "--spp", 1, "--out", frames, *render)
        for words, line in cases:
            self.refused(["encode", frames, "--out", self.out / "a.mkv", *words], line)
        self.assertEqual([path.name for path in self.out.iterdir()], ["frames"])

    def test_those_that_cannot_be(self):
        few = "--tiles: expected at least 2 across and 1 down, found "
        divide = "--tiles: expected numbers that divide 256x128 pixels into multiples of 16, found "
        small = "--tiles: expected tiles of at least 64x64 pixels, found "
        base = "--base: expected a multiple of 4 from 128 on, below the sphere's 256, found "
        tiles = ["--tiles", "4x2"]
        self.refused_of(
            ["--size", "256x128", "--aovs", "depth", "--layers"],
            (["--tiles", "1x1"], few + "1x1"),
            (["--tiles", "7x3"], divide + "7x3"),
            (["--tiles", "32x1"], divide + "32x1"),
            (["--tiles", "4x4"], small + "64x32"),
            (["--tiles", "0x2"], "--tiles"),
            (["--tiles", "8"], "--tiles"),
            (["--tiles", "99999999999x1"], "--tiles"),
            (["--base", 128], "--base: expected --tiles as well, found no tiles"),
            (["--fill", "none", "--fill-crf", 30], "--fill-crf: expected tracks that fill gaps (--fill), found none"),
            (["--fill", "none", "--depth-share", 0.5], "--depth-share: expected depth that is coded (--depth), found none"),
            (["--fill", "none", "--depth-scale", 2], "--depth-scale: expected depth that is coded (--depth), found none"),
            (["--depth-share", 0.5], "--depth-share: expected depth that is coded (--depth), found depth of the hidden layer only"),
            (["--depth-scale", 2], "--depth-scale: expected depth that is coded (--depth), found depth of the hidden layer only"),
            (["--depth-crf", 30, "--depth-scale", 2], "--depth-scale: expected depth that is coded (--depth), found depth of the hidden layer only"),
            ([*tiles, "--base", 5], base + "5"),
            ([*tiles, "--base", -128], "--base"),
            ([*tiles, "--base", 256], base + "256"),
            ([*tiles, "--base", 130], base + "130"),
            ([*tiles, "--motion", "auto"], "--tiles 4x2: expected --motion none, as motion is coded for whole spheres only, found auto"),
            ([*tiles, "--fill", "hidden"], "--tiles 4x2: expected a whole sphere with a small stream at most (--fill none or small), found hidden in "),
        )

    def test_of_two_eyes(self):
        self.refused_of(["--size", "256x128", "--eye", "both"],
                        (["--tiles", "4x2", "--stereo", "top-bottom"], "--tiles 4x2: expected --stereo tracks, found top-bottom"))

    def test_of_windows(self):
        self.refused_of(["--size", "128x64", "--window", "gaze,90x90", "--density", 256],
                        (["--tiles", "2x1"], "--tiles 2x1: expected a whole sphere with a small stream at most"))

    def test_both_eyes_of_flat_views(self):
        self.refused_of(["--size", "128x64", "--camera", "perspective", "--eye", "both"],
                        (["--stereo", "top-bottom"], "expected a sphere, for --stereo, found a perspective view"))

    def test_of_flat_views(self):
        self.refused_of(["--size", "256x128", "--camera", "perspective"], (["--tiles", "4x2"], "expected whole spheres, twice as wide as high, found 256x128"))

    def test_of_parts_of_spheres(self):
        self.refused_of(["--size", "256x128", "--range", "180,90"], (["--tiles", "4x2"], "expected whole spheres, twice as wide as high, found 256x128"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
