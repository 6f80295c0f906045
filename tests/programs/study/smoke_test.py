"""The study at preset smoke, as users start it: it ends, goes on where it was interrupted, measures what must be so, draws, tabulates and plans.

usage: smoke_test.py BIN_DIR
"""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SCENE = "pavilion"
CHARTS = ("accuracy-time", "accuracy-bytes", "paper-quality", "paper-times", "paper-bytes", "parity", "parsimony", "stability", "latency")
PATIENCE_S = 120


class Smoke(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_study_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.out = cls.root / "out"
        cls.interrupted = cls.interrupt_after("steps/render-perspective-1.json")
        cls.kept = cls.record("render-perspective-1").stat().st_mtime_ns
        began = time.monotonic()
        cls.whole = cls.study()
        cls.took_s = time.monotonic() - began

    @classmethod
    def command(cls, *words):
        return [str(word) for word in (BIN / "equistream", "study", "--preset", "smoke", "--out", cls.out, *words)]

    @classmethod
    def study(cls, *words):
        return subprocess.run(cls.command(*words), capture_output=True, text=True)

    @classmethod
    def record(cls, step):
        return cls.out / f"work/{SCENE}/steps/{step}.json"

    @classmethod
    def interrupt_after(cls, file):
        """What a study that is interrupted once it has made `file` ends with."""
        process = subprocess.Popen(cls.command(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
        deadline = time.monotonic() + PATIENCE_S
        while not (cls.out / "work" / SCENE / file).exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE_S)
        return process.returncode, errors

    def result(self, experiment, scene=SCENE):
        return json.loads((self.out / experiment / f"{scene}.json").read_text())

    def db(self, system, coded, kind="noise_free"):
        entry = next(e for e in self.result("systems")["systems"] if e["system"] == system and (e["codec"] is not None) == coded)
        return min(entry[kind][eye][kind]["linear"]["db"] for eye in ("left", "right"))

    def test_goes_on_where_it_was_interrupted(self):
        self.assertEqual(self.interrupted[0], -signal.SIGINT)
        self.assertIn("interrupted; run it again to go on", self.interrupted[1])
        self.assertEqual(self.whole.returncode, 0, self.whole.stderr)
        self.assertEqual(self.record("render-perspective-1").stat().st_mtime_ns, self.kept, "what was done was done again")
        again = self.study()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("there already", again.stdout)
        self.assertNotIn("equistream play", again.stderr)

    def test_says_how_many_steps_there_are_and_what_is_left(self):
        steps = [tuple(map(int, found)) for found in re.findall(r"^step (\d+) of (\d+)", self.whole.stderr, re.M)]
        told, done = steps[0][1], steps[-1][0]
        self.assertLess(abs(done - told), 0.1 * told, f"told of {told} steps and ran {done}: presets.SMOKE_STEPS")
        self.assertRegex(self.whole.stderr, r"step \d+ of \d+, about \d+ (seconds|minutes) left: equistream ")

    def test_measures_what_must_be_so(self):
        systems = self.result("systems")
        self.assertTrue(all(entry["n"] == {"frames": 2, "seeds": 2} for entry in systems["systems"]))
        self.assertGreater(self.db("pair", False), self.db("centre", False), "what is rendered for the eye itself errs by its bias alone")
        self.assertGreater(self.db("default", False), self.db("centre-turned", False), "what programs do by default knows of parallax")
        self.assertGreater(self.db("pair", True), self.db("centre", True), "what is not reprojected is nearer")
        self.assertGreater(self.db("centre", False), self.db("centre-turned", False) + 0.5, "parallax counts")
        self.assertGreater(self.db("centre", False), self.db("centre", True), "coding costs")
        for system in ("pair", "centre", "centre-turned"):
            self.assertLess(self.db(system, False, "whole"), self.db(system, False), "the whole error has the noise of what is seen")
        self.assertGreater(self.db("pair", False), self.db("pair", True) + 3, "coding is an error of the method")
        self.assertLess(abs(self.db("pair", False, "whole") - self.db("pair", True, "whole")), 1, "which a viewer of so noisy views hardly sees")
        for entry in systems["systems"]:
            for kind in ("whole", "noise_free"):
                self.assertEqual(entry[kind]["left"]["flicker"]["motion"], "exact")
        fewest, *_, most = (point["whole"]["left"]["whole"]["linear"]["db"] for point in self.result("parsimony")["samples"])
        self.assertGreater(most, fewest + 0.5, "samples count")
        parity = self.result("parity")["entries"]
        for entry in parity:
            self.assertEqual("bytes_a_frame" in entry, entry["codec"] is not None)
        by_width = {entry["width"]: entry["whole"]["left"]["whole"]["display"]["db"] for entry in parity if entry["system"] == "centre" and entry["codec"] is None}
        self.assertGreater(by_width[1024], by_width[640], "width counts")
        by_crf = {entry["crf"]: sum(entry["bytes_a_frame"].values()) for entry in parity if entry["system"] == "perspective" and entry["codec"]}
        self.assertEqual(sorted(by_crf, key=by_crf.get, reverse=True), sorted(by_crf))
        falls = self.result("stability", "generated")["breakers"]["near"]["falls"]
        self.assertEqual(falls["rotation"]["3"], "0.1", "the hardest value, which is the only one")
        delays = self.result("latency", "generated")["sweeps"]["delay, ms"]
        turned = {value: next(run["psnr_db"] for run in runs if run["method"] == "sphere") for value, runs in delays.items()}
        self.assertLess(turned["400"], turned["0"] - 3)
        views = {value: next(run["psnr_db"] for run in runs if run["method"] == "wide-views") for value, runs in delays.items()}
        self.assertGreater(views["0"], turned["0"], "nothing is nearer than what was rendered for the eye")
        self.assertLess(views["400"], views["0"] - 3)

    def test_draws_tabulates_and_says_what_it_took(self):
        for name in CHARTS:
            self.assertGreater((self.out / f"{name}.svg").stat().st_size, 4_000, name)
        page = (self.out / f"{SCENE}.html").read_text()
        self.assertNotIn("@DATA@", page)
        self.assertIn(f'src="pictures/{SCENE}.js"', page)
        self.assertGreater((self.out / f"pictures/{SCENE}.js").read_text().count("data:image/"), 20)
        tables = (self.out / "tables.md").read_text()
        for section in ("Scenes", "Systems in pavilion", "Bytes", "Parity", "The knee"):
            self.assertIn(f"## {section}", tables)
        row = next(line.split(" | ") for line in tables.splitlines() if line.startswith("| both eyes rendered and coded | uncoded"))
        self.assertRegex(row[7], r"^\d+\.\d\d \[\d+\.\d\d, \d+\.\d\d\]$", "the whole error comes first")
        self.assertRegex(row[-1], r"^\d+\.\d / ", "flicker of what is seen")
        points = json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)[1])["points"]
        self.assertTrue(all(point["whole"]["db"] < 60 for point in points))
        known = re.search(r"systems/pavilion.json: whole errors known within (\S+) dB \(the median of (\d+)\), (\S+) dB at most", self.whole.stdout)
        self.assertEqual(int(known[2]), 2 * len(points))
        warned = [line for line in self.whole.stderr.splitlines() if "systems/pavilion.json: warning: expected whole errors known within 0.3 dB" in line]
        self.assertEqual(len(warned), 1 if float(known[3]) > 0.3 else 0)
        print(f"{self.took_s:.0f} s")

    def test_wrong_input_has_the_status_of_other_commands(self):
        for words, said in ((("--scenes", "nope", "--out", self.root / "none"), "found 'nope'"), (("--out", REPOSITORY / "study-out"), "expected a folder outside the repository")):
            refused = subprocess.run([BIN / "equistream", "study", *words], capture_output=True, text=True)
            self.assertEqual((refused.returncode, said in refused.stderr.splitlines()[-1]), (2, True), refused.stderr)
        self.assertFalse((REPOSITORY / "study-out").exists())

    def test_plans_a_farm(self):
        farm = self.out / "farm"
        plan = subprocess.run([BIN / "equistream", "farm", "--out", farm, "--measured", self.out, "study", "--preset", "smoke", "--out", self.out], capture_output=True, text=True)
        self.assertEqual(plan.returncode, 0, plan.stderr)
        self.assertRegex(plan.stdout, r"measure +1 +\d+ +\d+\.\d+ +render\n")
        template = json.loads((farm / "template.json").read_text())
        last = int(template["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"].split("-")[1])
        self.assertIn(f"--array=0-{last}", (farm / "submit.sh").read_text())
        self.assertEqual([step["name"] for step in template["steps"]], ["render", "measure", "generated", "draw"])
        refused = self.study("--job", last + 1)
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (2, 1))
        self.assertIn(f"--job: expected 0 to {last}", refused.stderr)
        done = self.study("--job", 0)
        self.assertEqual(done.returncode, 0, done.stderr)
        job = json.loads((self.out / "study-smoke.jobs.json").read_text())[0]
        part = self.out / f"work/{SCENE}/parts/{job['render']}/{job['first']:06}-{job['last']:06}/left"
        self.assertEqual(len(list(part.glob("frame.*.exr"))), job["last"] - job["first"] + 1)


if __name__ == "__main__":
    unittest.main()
