"""What --method auto chooses: the best where time does not matter, and something that keeps to a short time.

usage: budget_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))


class Budget(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_budget_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        cls.frames = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-1", "--size", "512x256", "--spp", 1, "--aovs", "depth", "--out", cls.frames)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def play(self, budget_ms, *options):
        PROGRAMS.run("play", self.frames, "--method", "auto", "--budget-ms", budget_ms, "--size", "640x360", "--out", self.root / "eyes", *options)
        return json.loads((self.root / "eyes/report.json").read_text())

    @staticmethod
    def way(plan):
        return plan["method"], plan["depth"], plan["fill"]

    def chosen(self, report):
        """The way that the report says was taken, of those that it says were tried."""
        choice = report["choice"]
        taken = choice["tried"][choice["chosen"]]
        self.assertEqual(self.way(taken), self.way(report))
        self.assertIn(taken["method"], choice["line"])
        return taken

    def test_the_first_that_fits_is_taken(self):
        # Nothing fits no time at all: so all ways are tried, and the fastest is taken.
        tiny = self.play(0.001, "--scene", self.scene)
        tried = tiny["choice"]["tried"]
        self.assertFalse(tiny["choice"]["fits"])
        self.assertEqual(self.chosen(tiny)["milliseconds"], min(plan["milliseconds"] for plan in tried))
        self.assertIn("nothing fits", tiny["choice"]["line"])

        # Where time does not matter it is the first of them, and no other is tried.
        generous = self.play(1e6, "--scene", self.scene)
        self.assertTrue(generous["choice"]["fits"])
        self.assertEqual(len(generous["choice"]["tried"]), 1)
        self.assertEqual(self.way(self.chosen(generous)), self.way(tried[0]))
        self.assertEqual(generous["fill"], generous["settings"]["fill"])

        # Halfway between the best and the fastest, the first that fits or, where the machine has slowed down, the fastest.
        best, fastest = tried[0]["milliseconds"], min(plan["milliseconds"] for plan in tried)
        budget = (best * fastest) ** 0.5
        middle = self.play(budget, "--scene", self.scene)
        choice, taken = middle["choice"], self.chosen(middle)
        self.assertTrue(all(plan["milliseconds"] > budget for plan in choice["tried"][:choice["chosen"]]))
        self.assertEqual(choice["fits"], taken["milliseconds"] <= budget)
        second = sum(ms for stage, ms in middle["frames"][1]["milliseconds"].items() if stage != "write")
        print(f"best {best:.1f} ms, fastest {fastest:.1f} ms, budget {budget:.1f} ms: {choice['line']}; the second frame took {second:.1f} ms")
        self.assertLess(second, best)

    def test_depth_that_came_with_the_frames_is_used(self):
        report = self.play(1e6)
        self.assertEqual(self.chosen(report)["depth"], "stream")
        # The scene, which would give any other, is not there.
        self.assertTrue(all(plan["depth"] in ("stream", "none") for plan in self.play(0.001)["choice"]["tried"]))


if __name__ == "__main__":
    unittest.main(verbosity=1)
