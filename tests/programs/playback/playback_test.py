"""What `equistream play` takes for depth, method and fill, of every kind of source, and what it says of it.

usage: playback_test.py BIN_DIR
"""

import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
VIEW = ["--size", "96x64", "--progress", "none"]


class Playback(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_playback_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        cls.folder = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-2", "--size", "256x128", "--spp", 1, "--aovs", "depth", "--out", cls.folder)
        cls.plain, cls.coded, cls.lossless = (cls.root / f"{name}.mkv" for name in ("plain", "coded", "lossless"))
        for stream, depth in ((cls.plain, "none"), (cls.coded, "w10"), (cls.lossless, "lossless")):
            PROGRAMS.run("encode", cls.folder, "--out", stream, "--depth", depth, "--preset", "ultrafast", "--progress", "none")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    def play(self, source, *options, out="eyes"):
        table = PROGRAMS.run("play", source, *VIEW, *options, "--overwrite", "--out", self.out / out)
        report = json.loads((self.out / out / "report.json").read_text())
        self.assertIn(f"method {report['method']}, depth {report['depth']}", table)
        return report

    def assert_way(self, report, method, depth):
        self.assertEqual((report["method"], report["depth"]), (method, depth))

    def assert_refused(self, source, options, *mentions):
        words = [str(word) for word in ["play", source, *VIEW, *options, "--out", self.out / "none"]]
        result = subprocess.run([PROGRAMS.folder / "equistream", *words], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), result.stderr)
        self.assertFalse((self.out / "none").exists())

    def test_depth_is_refused_by_the_kind_of_source(self):
        self.assert_refused(self.coded, ["--depth", "exact", "--method", "mesh"], "--depth exact: expected a folder of rendered frames", self.coded,
                            "depth coded w10", "--depth stream")
        self.assert_refused(self.coded, ["--depth", "exact", "--scene", self.scene], "--depth exact", "w10")
        self.assert_refused(self.plain, ["--depth", "exact"], "--depth exact", self.plain, "a stream without depth")
        self.assert_refused(self.plain, ["--depth", "stream"], "--depth stream: expected a stream with a depth track", self.plain)
        self.assert_refused(self.folder, ["--depth", "stream", "--method", "mesh"], "--depth stream: expected a stream", self.folder,
                            "a folder of rendered frames", "--depth exact")
        self.assert_refused(self.folder, ["--depth", "stream", "--scene", self.scene], "--depth stream", self.folder)
        self.assert_refused(self.folder, ["--depth", "ray", "--method", "mesh"], "--depth ray", "--scene S")
        self.assert_refused(self.coded, ["--method", "eye-depth"], "--method eye-depth", "--scene S")

    def test_a_lossless_stream_has_exact_depth(self):
        """Its planes are the folder's bit for bit: so is the depth that is found in them."""
        found = {}
        for source, name in ((self.lossless, "stream"), (self.folder, "folder")):
            self.assert_way(self.play(source, "--depth", "exact", "--method", "mesh", "--reliability", "--format", "exr", out=name), "mesh", "exact")
            found[name] = [read_frame(self.out / name / eye / "frame.0001.exr")["depth.Z"] for eye in ("left", "right")]
        np.testing.assert_array_equal(found["stream"], found["folder"])

    def test_depth_and_method_are_by_what_there_is(self):
        self.assert_way(self.play(self.plain, "--scene", self.scene), "eye-depth", "ray")
        self.assert_way(self.play(self.coded, "--scene", self.scene), "eye-depth", "ray")
        for source, depth, whose in ((self.coded, "stream", "the stream's own"), (self.lossless, "stream", "the stream's own"),
                                     (self.folder, "exact", "the render's own")):
            report = self.play(source)
            self.assert_way(report, "mesh", depth)
            self.assertTrue([note for note in report["notes"] if whose in note and "method mesh" in note], report["notes"])
        report = self.play(self.plain)
        self.assert_way(report, "rotation", "none")
        self.assertTrue([note for note in report["notes"] if str(self.plain) in note and "rotation (the eye only turns)" in note], report["notes"])
        # What was asked for is taken as it was, and not remarked on.
        self.assert_way(self.play(self.coded, "--depth", "stream"), "mesh", "stream")
        self.assert_way(self.play(self.coded, "--method", "splat"), "splat", "stream")
        report = self.play(self.coded, "--method", "rotation")
        self.assert_way(report, "rotation", "none")
        self.assertEqual(report["notes"], [])

    def test_the_default_shows_what_the_same_by_name_does(self):
        self.play(self.coded, out="default")
        self.play(self.coded, "--depth", "stream", "--method", "mesh", out="named")
        for eye in ("left", "right"):
            for name in ("frame.0000.png", "frame.0002.png"):
                self.assertEqual((self.out / "default" / eye / name).read_bytes(), (self.out / "named" / eye / name).read_bytes())

    def test_a_model_has_no_colours_to_fill_with(self):
        model = self.out / "model.json"
        PROGRAMS.run("model", self.scene, "--rays", 20000, "--visibility-rays", 20000, "--quantile", 0.5, "--rounds", 1, "--out", model)
        report = self.play(self.plain, "--model", model, "--fill", "geometry,pushpull", "--ipd", 0.5)
        self.assertTrue([note for note in report["notes"] if "--fill geometry is ignored" in note and str(model) in note], report["notes"])
        for eye in ("left", "right"):
            self.assertEqual(report["eyes"][eye]["filled"]["geometry"], 0)
            self.assertGreater(report["eyes"][eye]["filled"]["pushpull"], 0)
        of_scene = self.play(self.plain, "--scene", self.scene, "--fill", "geometry,pushpull", "--ipd", 0.5)
        self.assertFalse([note for note in of_scene["notes"] if "geometry" in note], of_scene["notes"])
        self.assertGreater(of_scene["eyes"]["left"]["filled"]["geometry"], 0)

    def test_methods_are_listed_with_auto(self):
        self.assert_refused(self.plain, ["--method", "speher"], "--method: expected rotation, ", "or auto, found 'speher'")

    def test_an_option_that_is_gone_says_so(self):
        words = ["play", self.folder, *VIEW, "--scene", self.scene, "--depth-reuse", "on", "--out", self.out / "gone"]
        result = subprocess.run([PROGRAMS.folder / "equistream", *map(str, words)], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("--depth-reuse has no effect any more", result.stderr)

    def test_repetitions_time_the_same_frame_again(self):
        for repeat in (1, 3):
            self.play(self.folder, "--scene", self.scene, "--repeat", repeat, out=f"repeat{repeat}")
        for eye in ("left", "right"):
            for index in range(3):
                name = f"{eye}/frame.{index:04}.png"
                self.assertEqual((self.out / "repeat1" / name).read_bytes(), (self.out / "repeat3" / name).read_bytes(), name)

    # -- depth that OpenGL draws

    def view(self, out, eye):
        return np.asarray(Image.open(self.out / out / eye / "frame.0000.png").convert("RGB"), dtype=np.float64)

    def test_drawn_depth_shows_what_cast_depth_does(self):
        """They differ at outlines, which lie within a sample, and by as much as the picture is noisy there."""
        clean = self.root / "clean"
        PROGRAMS.run("render", self.scene, "--frames", 0, "--size", "768x384", "--spp", 8, "--aovs", "none", "--out", clean)
        reports = {}
        for depth in ("ray", "gl", "gl-cube"):
            PROGRAMS.run("play", clean, "--scene", self.scene, "--depth", depth, "--size", "240x136", "--progress", "none", "--out", self.out / depth)
            reports[depth] = json.loads((self.out / depth / "report.json").read_text())
            self.assert_way(reports[depth], "eye-depth", depth)
        self.assertNotIn("gl_driver", reports["ray"])
        for depth in ("gl", "gl-cube"):
            self.assertTrue(reports[depth]["gl_driver"])
            for eye in ("left", "right"):
                found = 10 * np.log10(255**2 / np.mean((self.view(depth, eye) - self.view("ray", eye)) ** 2))
                print(f"{depth}, {eye}: {found:.1f} dB")
                self.assertGreater(found, 28)

    def test_drawn_depth_needs_a_scene_and_leaves_the_streams_undecoded(self):
        for depth in ("gl", "gl-cube"):
            self.assert_refused(self.coded, ["--depth", depth], f"--depth {depth}", "--scene S")
            self.assertEqual(self.tracks(self.coded, "--scene", self.scene, "--depth", depth), {"main"})

    def test_drawn_depth_may_be_chosen_by_time(self):
        report = self.auto(self.coded, 1e6, "--scene", self.scene, "--depth", "gl", "--fill", "pushpull")
        self.assert_way(report, "eye-depth", "gl")
        self.assertTrue(report["gl_driver"])
        choice = report["choice"]
        self.assertEqual({plan["depth"] for plan in choice["tried"]}, {"gl"})
        cheapest = self.auto(self.coded, 1e-3, "--scene", self.scene, "--depth", "gl", "--fill", "none", out="cheapest")
        # Turning and a sphere take about as long: of these, whichever was measured to be faster is taken.
        choice = cheapest["choice"]
        self.assertEqual(choice["tried"][choice["chosen"]]["milliseconds"], min(plan["milliseconds"] for plan in choice["tried"]))
        self.assertIn(cheapest["method"], ("rotation", "proxy-sphere"))
        self.assertEqual(cheapest["depth"], "none")
        self.assertNotIn("gl_driver", cheapest)

    # -- choosing by time

    def auto(self, source, budget_ms, *options, out="auto"):
        return self.play(source, "--method", "auto", "--budget-ms", budget_ms, *options, out=out)

    def test_a_frame_with_one_before_it_is_timed(self):
        report = self.auto(self.folder, 1e6, "--scene", self.scene, "--fill", "earlier,pushpull", "--ipd", 0.3)
        choice = report["choice"]
        self.assertEqual(choice["frame"], 1)
        self.assertGreater(choice["tried"][0]["filled"]["earlier"], 0)
        self.assertEqual([frame["index"] for frame in report["frames"]], [0, 1, 2])
        alone = self.auto(self.folder, 1e6, "--scene", self.scene, "--fill", "earlier,pushpull", "--ipd", 0.3, "--frames", 0)
        self.assertEqual((alone["choice"]["frame"], alone["choice"]["tried"][0]["filled"]["earlier"]), (0, 0))

    def test_trials_leave_nothing_behind(self):
        """What is chosen shows what it does when asked for by name, from the first frame on."""
        words = ["--scene", self.scene, "--fill", "earlier,pushpull"]
        chosen = self.auto(self.folder, 1e6, *words)
        self.play(self.folder, "--method", chosen["method"], *words, out="named")
        for index in range(3):
            name = f"left/frame.{index:04}.png"
            self.assertEqual((self.out / "auto" / name).read_bytes(), (self.out / "named" / name).read_bytes(), name)

    def test_rechoosing_belongs_to_choosing(self):
        self.assert_refused(self.folder, ["--rechoose", "off"], "--rechoose", "--method auto")
        self.assert_refused(self.folder, ["--method", "auto", "--budget-ms", 5, "--rechoose", "maybe"], "--rechoose", "on or off", "'maybe'")
        self.assertNotIn("changes", self.play(self.folder, "--scene", self.scene))

    def test_what_fills_nothing_is_no_way_of_its_own(self):
        """Neither stream has hidden layers or patches: what is left to leave out is earlier."""
        choice = self.auto(self.coded, 1e-3, "--fill", "hidden,patches,earlier,pushpull")["choice"]
        fills = {plan["fill"] for plan in choice["tried"] + choice["passed_over"] if plan["depth"] == "stream"}
        self.assertEqual(fills, {"hidden,patches,earlier,pushpull", "pushpull"})

    def test_partial_spheres_without_depth_keep_no_black_gaps(self):
        part = self.root / "part"
        PROGRAMS.run("render", self.scene, "--frames", "0-1", "--size", "128x64", "--range", "180,90", "--spp", 1, "--aovs", "none", "--out", part)
        report = self.auto(part, 1e6, "--fov", 120)
        self.assertEqual((report["method"], report["depth"], report["fill"]), ("proxy-sphere", "none", "pushpull"))
        for eye in report["eyes"].values():
            self.assertGreater(eye["filled"]["pushpull"], 0)
            self.assertEqual(eye["gap_fraction_after"]["pushpull"], 0)
        # The same for what only turns.
        choice = self.auto(part, 1e-3, "--fov", 120)["choice"]
        ways = [(plan["method"], plan["fill"]) for plan in choice["tried"] + choice["passed_over"]]
        self.assertEqual(sorted(ways), [("proxy-sphere", "pushpull"), ("rotation", "none"), ("rotation", "pushpull")])
        self.assertEqual(ways[0], ("proxy-sphere", "pushpull"))

    # -- a window within a sphere

    def window(self, *words):
        folder = self.root / "window"
        if not folder.exists():
            PROGRAMS.run("render", self.scene, "--frames", "0-2", "--size", "128x64", "--window", "gaze,120x90", "--density", 512, "--spp", 4, "--aovs", "depth", "--out", folder)
        return folder

    def test_a_window_shows_what_its_whole_sphere_does(self):
        whole = self.root / "dense"
        PROGRAMS.run("render", self.scene, "--frames", "0-2", "--size", "512x256", "--spp", 4, "--aovs", "depth", "--out", whole)
        for method, depth in (("mesh", ["--depth", "exact"]), ("rotation", [])):
            with self.subTest(method):
                report = self.play(self.window(), "--method", method, *depth, out="window")
                self.play(whole, "--method", method, *depth, out="whole")
                for eye in ("left", "right"):
                    self.assertLess(report["eyes"][eye]["gap_fraction"], 0.02)
                    found, wanted = (np.asarray(Image.open(self.out / name / eye / "frame.0001.png"), float)[8:-8, 8:-8] for name in ("window", "whole"))
                    self.assertLess(np.mean(np.abs(found - wanted) > 2), 0.02)

    def test_around_a_window_is_its_base(self):
        """A head turned by half of what the window covers."""
        head = self.root / "turned.csv"
        first = json.loads(PROGRAMS.run("info", "--json", self.window() / "centre/frame.0000.exr"))["frame"]["head"]
        w, x, y, z = first["orientation_wxyz"]
        c, s = math.cos(-math.pi / 6), math.sin(-math.pi / 6)
        turn = (w * c - y * s, x * c - z * s, y * c + w * s, z * c + x * s)  # about the head's own up
        rows = [",".join(map(repr, map(float, (time_s, *first["position_m"], *turn)))) for time_s in (0, 9)]
        head.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "\n".join(rows) + "\n")
        base = self.root / "base"
        base.mkdir(exist_ok=True)
        if not (base / "centre").exists():
            (base / "centre").symlink_to(self.window() / "centre")
        stream = self.out / "window.mkv"
        said = json.loads(PROGRAMS.run("encode", self.window(), "--out", stream, "--depth", "w10", "--crf", 8, "--preset", "ultrafast", "--progress", "none", "--json"))
        self.assertEqual([track["name"] for track in said["tracks"]], ["main", "depth", "window", "window-depth"])
        for source in (self.window(), stream):
            words = ["--scene", self.scene, "--head", head, "--frames", "0"]
            report = self.play(source, *words, out="window")
            self.play(base, *words, out="base")
            for eye in ("left", "right"):
                self.assertGreater(report["eyes"][eye]["filled"]["base"], 0.2 * report["eyes"][eye]["pixels"])
                self.assertEqual(report["eyes"][eye]["gap_fraction_after"]["pushpull"], 0)
                found, wanted = (np.asarray(Image.open(self.out / name / eye / "frame.0000.png"), float)[:, 70:] for name in ("window", "base"))
                off = np.abs(found - wanted)
                if source == stream:
                    self.assertLess(np.mean(off), 10, "what coding takes from noise")
                else:
                    self.assertLess(np.mean(off > 12), 0.03, "what lies well beyond the window is the base's alone")

    def test_short_of_time_a_window_keeps_its_base(self):
        choice = self.auto(self.window(), 1e-3)["choice"]
        for plan in choice["tried"] + choice["passed_over"]:
            self.assertIn("base", plan["fill"])

    # -- mirrors and glass

    def test_mirrors_are_images_gaps_or_on_their_surface(self):
        mirrors = self.root / "mirrors"
        PROGRAMS.run("render", self.scene, "--frames", "0-1", "--size", "512x256", "--spp", 1, "--aovs", "depth,specular,virtual", "--out", mirrors)
        words = {"default": [], **{word: ["--mirrors", word] for word in ("images", "gaps", "surface")}}
        reports = {name: self.play(mirrors, *options, "--scene", self.scene, "--fill", "none", out=name) for name, options in words.items()}
        self.assertEqual({name: report["mirrors"] for name, report in reports.items()},
                         {"default": "images", "images": "images", "gaps": "gaps", "surface": "surface"})
        for eye in ("left", "right"):
            images, gaps, surface = (reports[name]["eyes"][eye] for name in ("images", "gaps", "surface"))
            self.assertNotIn("specular", surface)
            counts, opened = images["specular"], gaps["specular"]
            self.assertGreater(counts["by_virtual_depth"], 10)
            self.assertEqual((opened["by_virtual_depth"], opened["displaced"], opened["kept"]), (0, 0, counts["kept"]))
            self.assertEqual(opened["gaps"], sum(counts.values()) - counts["kept"])
            self.assertEqual((images["gaps"] - surface["gaps"], gaps["gaps"] - surface["gaps"]), (counts["gaps"], opened["gaps"]))
            views = {name: (self.out / name / eye / "frame.0001.png").read_bytes() for name in words}
            self.assertEqual(views["default"], views["images"])
            self.assertEqual(len(set(views.values())), 3)
        self.assert_refused(mirrors, ["--scene", self.scene, "--mirrors", "always"], "--mirrors: expected images, gaps or surface, found 'always'")

    # -- what is decoded

    def tracks(self, source, *options, out="eyes"):
        """Those of which pictures were given."""
        found = self.play(source, *options, out=out)["bytes"]["input"]
        return {name for name, track in found.items() if track["pictures"] > 0}

    def test_only_what_is_used_is_decoded(self):
        everything, stream = self.root / "everything", self.root / "everything.mkv"
        PROGRAMS.run("render", self.scene, "--frames", "0-1", "--size", "512x256", "--spp", 1, "--aovs", "depth,specular,virtual", "--small", "right",
                     "--layers", "--patches", "--patch-budget", 20, "--out", everything)
        PROGRAMS.run("encode", everything, "--out", stream, "--depth", "w10", "--fill", "small,hidden,patches", "--mirrors", "always", "--preset",
                     "ultrafast", "--progress", "none")
        hidden, patches = {"hidden", "hidden-depth"}, {"patches", "patches-depth"}
        with_depth = {"main", "depth", "images"}
        for options, used in ((["--method", "rotation", "--fill", "none"], {"main"}),
                              (["--method", "rotation"], {"main"}),
                              (["--method", "proxy-sphere", "--fill", "small,pushpull"], {"main", "small"}),
                              (["--fill", "none"], with_depth),
                              (["--fill", "hidden,pushpull"], with_depth | hidden),
                              (["--fill", "patches,small"], with_depth | patches | {"small"}),
                              (["--scene", self.scene, "--fill", "earlier,pushpull"], with_depth - {"depth"}),
                              (["--scene", self.scene, "--depth", "gl", "--fill", "earlier,pushpull"], with_depth - {"depth"}),
                              (["--method", "auto", "--budget-ms", 1e6, "--fill", "hidden,pushpull"], with_depth | hidden),
                              (["--mirrors", "gaps", "--fill", "pushpull"], with_depth),
                              (["--mirrors", "surface", "--fill", "pushpull"], with_depth - {"images"}),
                              (["--mirrors", "surface", "--fill", "hidden,pushpull"], with_depth | hidden),
                              (["--mirrors", "surface", "--scene", self.scene, "--fill", "earlier,pushpull"], with_depth - {"depth"}),
                              (["--mirrors", "surface", "--method", "auto", "--budget-ms", 1e6, "--fill", "pushpull"], with_depth - {"images"})):
            with self.subTest(options=options):
                self.assertEqual(self.tracks(stream, *options), used)
        # How far pixels can be trusted depends on mirrors, the pictures do not: they are the same without the track.
        on_surface = ["--mirrors", "surface", "--fill", "pushpull"]
        self.assertEqual(self.tracks(stream, *on_surface, "--reliability", out="judged"), with_depth)
        self.assertEqual(self.tracks(stream, *on_surface, out="unjudged"), with_depth - {"images"})
        for eye in ("left", "right"):
            for name in ("frame.0000.png", "frame.0001.png"):
                self.assertEqual((self.out / "judged" / eye / name).read_bytes(), (self.out / "unjudged" / eye / name).read_bytes())
        self.assertEqual(self.tracks(everything, "--method", "rotation", "--fill", "none"), {"centre"})
        self.assertEqual(self.tracks(everything, "--fill", "hidden"), {"centre", "hidden"})
        # That it turns spheres is known once the first frame has come, which has all.
        flat = self.root / "flat.mkv"
        PROGRAMS.run("encode", everything, "--out", flat, "--fill", "hidden", "--preset", "ultrafast", "--progress", "none")
        self.assertEqual(self.tracks(flat), {"main"})

    def test_what_the_choice_does_not_use_is_left_out_from_then_on(self):
        """Frames that were under way when it was made still have it: how many differs from run to run, so that none are told."""
        long, stream = self.root / "long", self.root / "long.mkv"
        PROGRAMS.run("render", self.scene, "--frames", "0-23", "--size", "128x64", "--spp", 1, "--aovs", "depth", "--out", long)
        PROGRAMS.run("encode", long, "--out", stream, "--depth", "w10", "--preset", "ultrafast", "--gop", 4, "--progress", "none")
        report = self.auto(stream, 1e6, "--scene", self.scene)
        self.assert_way(report, "eye-depth", "ray")
        tracks = report["bytes"]["input"]
        self.assertEqual(tracks["main"]["pictures"], 24)
        self.assertNotIn("depth", tracks)
        self.assertEqual(len(report["frames"]), 24)


if __name__ == "__main__":
    unittest.main(verbosity=1)
