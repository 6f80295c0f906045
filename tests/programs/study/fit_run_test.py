"""`equistream fit` of the bundled scene in miniature, and what every program makes of the file that it writes.

usage: fit_run_test.py BIN_DIR
"""

import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS / "programs"), str(TESTS / "programs/viewer")]
from display import Display  # noqa: E402
from fitting.choice import Chosen  # noqa: E402
from fitting.report import sections_of, write_settings  # noqa: E402
from fitting.trial import SEEDS  # noqa: E402
from fitting.work import Asked, Fill, Light, Point, by_scene, by_streamed_depth, windowed  # noqa: E402
from independent import Programs  # noqa: E402

PROGRAMS = Programs(sys.argv.pop(1))
SMALL = ("--eye-size", "160x90", "--frames", "30-31", "--truth-spp", 16, "--most-spp", 8, "--widest", 1)
WANTED_DB = 16
ROOM = """mtllib room.mtl
usemtl grey
v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4
v -1 0 -3\nv 1 0 -3\nv 1 2 -3\nv -1 2 -3
f 4 3 2 1\nf 5 6 7 8
"""
"""A floor and a wall on it."""
GREY = "newmtl grey\nKd {0} {0} {0}\n"
STILL = {"model": "room.obj", "sky": {"radiance": 1}, "camera": {"keys": [{"time_s": 0, "position_m": [0, 1.6, 1]}]}}
LEAST = ("--eye-size", "64x64", "--truth-spp", 4, "--most-spp", 1, "--widest", 0.5)


class Fit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_fit_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root / "scenes")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def fit(self, *words, code=0):
        done = subprocess.run([PROGRAMS.folder / "equistream-fit", *map(str, words)], cwd=self.root, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_what_it_writes_is_what_programs_take(self):
        said = self.fit(self.scene, "--db", WANTED_DB, *SMALL, "--out", "mini.ini").stdout
        settings = self.root / "mini.ini"
        chosen = re.search(r"chosen: (\d+)x(\d+), .*, h264 CRF (\d+), .*: (\d+\.\d+) \[.*\] dB, ([\d,]+) bytes", said)
        self.assertIsNotNone(chosen, said)
        self.assertGreaterEqual(float(chosen[4]), WANTED_DB)
        self.assertRegex(settings.read_text(), rf"^# equistream fit .* --db {WANTED_DB} --eye-size 160x90 .*, measured \d{{4}}-\d\d-\d\d\n")

        squares, wanted = [], (float(chosen[3]), int(chosen[1]), int(chosen[2]))
        seeds = int(re.search(r"with (\d+) seeds that the search did not use", said)[1])
        for seed in SEEDS[:seeds]:
            rendered, stream, eyes = self.root / f"frames-{seed}", self.root / f"mini-{seed}.mp4", self.root / f"eyes-{seed}"
            PROGRAMS.run("render", self.scene, "--settings", settings, "--frames", "30-31", "--seed", seed, "--out", rendered)
            report = json.loads(PROGRAMS.run("encode", rendered, "--settings", settings, "--out", stream, "--json", "--progress", "none"))
            self.assertEqual((report["crf"], report["tracks"][0]["width"], report["tracks"][0]["height"]), wanted)
            PROGRAMS.run("play", stream, "--settings", settings, "--out", eyes, "--progress", "none")
            squares.append(self.whole_square(eyes))
        played = json.loads((eyes / "report.json").read_text())
        section = settings.read_text().split("[play]")[1].split("[")[0]
        self.assertEqual(played["settings"]["size"], [160, 90])
        self.assertIn(f"method = {played['method']}\n", section)
        self.assertIn(f'fill = "{played["fill"]}"\n', section)
        self.assertEqual(played["notes"], [])
        self.assertAlmostEqual(-10 * math.log10(sum(squares) / len(squares)), float(chosen[4]), delta=0.006)
        self.look_around(stream, settings)

        again = self.fit(self.scene, "--db", WANTED_DB, *SMALL, "--out", "again.ini")
        self.assertIn("everything was there already", again.stdout)
        before, after = (file.read_text().split("[play]")[0].split("\n", 1) for file in (settings, self.root / "again.ini"))
        self.assertEqual(after[0], before[0].replace("mini.ini", "again.ini"))
        self.assertEqual(after[1], before[1])

        self.assertIn("--kb", self.fit(self.scene, "--db", WANTED_DB, "--kb", 3, code=2).stderr)
        short = self.fit(self.scene, "--db", 70, *SMALL, "--out", "never.ini", code=1)
        self.assertRegex(short.stderr.splitlines()[-1], r"--db 70: not to be had; the most found is \d+\.\d+ \[")
        self.assertFalse((self.root / "never.ini").exists())

    def whole_square(self, eyes):
        """Beside the truths that `fit` has rendered."""
        first, second = sorted(self.root.glob("pavilion-fit/*/renders/truth-*"))
        scores = self.root / "scores.json"
        PROGRAMS.run("compare", eyes, first, "--truth2", second, "--metrics", "none", "--out", scores, "--progress", "none")
        squares = [eye["whole"]["linear"]["mean_square"] for eye in json.loads(scores.read_text())["eyes"].values()]
        return sum(squares) / len(squares)

    def test_programs_take_what_tells_of_mirrors(self):
        asked, settings = Asked((160, 90), 90.0, 30, 30, 1, 1, 1), self.root / "told.ini"
        chosen = Chosen(Point(by_scene(Fill(), True, Light(1)), 512, 30, 0, 0, 0, 0), Fill(), 0, depth_share=0.1, told=True)
        write_settings(settings, ["told"], sections_of(chosen, asked, "h264"))
        PROGRAMS.run("render", self.scene, "--settings", settings, "--frames", "30-30", "--out", self.root / "told")
        report = json.loads(PROGRAMS.run("encode", self.root / "told", "--settings", settings, "--out", self.root / "told.mp4", "--json", "--progress", "none"))
        self.assertIn("images", {track["name"] for track in report["tracks"]})
        PROGRAMS.run("play", self.root / "told.mp4", "--settings", settings, "--out", self.root / "told-eyes", "--progress", "none")
        self.assertEqual(json.loads((self.root / "told-eyes/report.json").read_text())["method"], "mesh")

    def test_programs_take_a_window(self):
        asked, settings = Asked((160, 90), 90.0, 30, 30, 1, 1, 1, (110, 70)), self.root / "window.ini"
        way = windowed(by_streamed_depth(Fill(), False, Light(1), 0.1), asked.window)
        chosen = Chosen(Point(way, 1024, 30, 0, 0, 0, 0), way.fill, 0, depth_share=0.1)
        write_settings(settings, ["window"], sections_of(chosen, asked, "h264"))
        PROGRAMS.run("render", self.scene, "--settings", settings, "--frames", "30-30", "--out", self.root / "looked-at")
        report = json.loads(PROGRAMS.run("encode", self.root / "looked-at", "--settings", settings, "--out", self.root / "window.mp4", "--json", "--progress", "none"))
        sizes = {track["name"]: (track["width"], track["height"]) for track in report["tracks"]}
        self.assertEqual((sizes["main"], sizes["window"]), ((256, 128), (320, 208)))
        PROGRAMS.run("play", self.root / "window.mp4", "--settings", settings, "--out", self.root / "window-eyes", "--progress", "none")
        played = json.loads((self.root / "window-eyes/report.json").read_text())
        self.assertEqual(played["notes"], [])
        self.assertGreater(played["bytes"]["input"]["window"]["pictures"], 0, "it is looked at")
        PROGRAMS.run("play", self.root / "window.mp4", "--size", "160x90", "--fill", "pushpull", "--out", self.root / "base-alone", "--progress", "none")
        self.assertIn("--fill lacks base", json.loads((self.root / "base-alone/report.json").read_text())["notes"][-1])

    def room(self, folder):
        """Its description and its materials."""
        files = [self.root / folder / f"room.{end}" for end in ("json", "mtl", "obj")]
        files[0].parent.mkdir()
        for file, text in zip(files, (json.dumps(STILL), GREY.format(0.5), ROOM)):
            file.write_text(text)
        return files[:2]

    def test_another_material_is_another_scene(self):
        scene, materials = self.room("room")
        for grey, is_new in ((0.5, True), (0.5, False), (0.9, True), (0.5, False)):
            materials.write_text(GREY.format(grey))
            said = self.fit(scene, "--db", 70, *LEAST, code=1).stderr  # not to be had, which is soon known
            self.assertEqual("step 1" in said, is_new, said)
            self.assertIn("not to be had", said)
        self.assertEqual(len(list((self.root / "room-fit").iterdir())), 2)

    def look_around(self, stream, settings):
        display = Display()
        self.addCleanup(display.close)
        words = ["view", stream, "--settings", settings, "--seconds", "1", "--json"]
        done = subprocess.run([PROGRAMS.folder / "equistream", *words], env=display.environment, capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertGreater(json.loads(done.stdout)["refreshes"], 0)

    def test_bad_words_are_one_line_and_two(self):
        named = PROGRAMS.scene("pavilion", self.root / "named").rename(self.root / "named/mini-model.json")
        (self.root / "it's \"mine\"").mkdir()
        for words, what in (((self.root / "none.json", "--db", 30), "found no such file"), ((self.scene, "--db", "loud"), "found 'loud'"),
                            ((self.scene, "--db", 30, "--frames", "9-1"), "found '9-1'"),
                            ((self.scene, "--db", 30, "--window", "400x90"), "found '400x90'"), ((self.scene, "--db", 30, "--frames", "0-9999"), "found 9999"),
                            ((self.scene, "--db", 30, "--out", "none/here.ini"), "found none/here.ini"),
                            ((named, "--db", 30, "--out", self.root / "named/mini.ini"), "expected names that are not the scene's, found"),
                            ((self.scene, "--db", 30, "--out", self.scene), "expected names that are not the scene's, found"),
                            ((self.scene, "--db", 30, "--out", self.scene.with_suffix(".glb")), "expected names that are not the scene's, found"),
                            ((self.scene, "--db", 30, "--out", "it's \"mine\"/a.ini"), "expected a path without line ends and without both kinds of quotes"),
                            ((self.scene, "--db", 30, "--out", "a\nb.ini"), "expected a path without line ends")):
            said = self.fit(*words, code=2).stderr
            self.assertIn(what, said)
            self.assertEqual(len(said.splitlines()), 1, said)
        self.assertEqual([path.name for path in self.root.iterdir()].count("pavilion-fit"), 0)


if __name__ == "__main__":
    unittest.main()
