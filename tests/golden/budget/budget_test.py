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

    def test_generous_and_tiny_differ(self):
        generous = self.play(1e6, "--scene", self.scene)
        self.assertEqual((generous["method"], generous["depth"]), ("surface", "ray"))
        self.assertEqual(generous["fill"], generous["settings"]["fill"])
        self.assertTrue(generous["choice"]["fits"])
        self.assertEqual(len(generous["choice"]["tried"]), 1)
        tiny = self.play(0.001, "--scene", self.scene)
        self.assertNotEqual(tiny["method"], "surface")
        self.assertFalse(tiny["choice"]["fits"])
        tried = tiny["choice"]["tried"]
        self.assertGreaterEqual({plan["method"] for plan in tried}, {"surface", "mesh", "splat", "lean", "sphere"})
        self.assertIn("nothing fits", tiny["choice"]["line"])

        # Halfway between the best and the fastest, something in between or the fastest: and the second frame keeps to it.
        best, fastest = tried[0]["milliseconds"], min(plan["milliseconds"] for plan in tried)
        budget = (best * fastest) ** 0.5
        middle = self.play(budget, "--scene", self.scene)
        chosen = middle["choice"]["tried"][middle["choice"]["chosen"]]
        self.assertNotEqual((chosen["method"], chosen["fill"]), (tried[0]["method"], tried[0]["fill"]))
        second = sum(ms for stage, ms in middle["frames"][1]["milliseconds"].items() if stage != "write")
        print(f"best {best:.1f} ms, fastest {fastest:.1f} ms, budget {budget:.1f} ms: {middle['choice']['line']}; the second frame took {second:.1f} ms")
        self.assertLess(second, best)

    def test_depth_that_came_with_the_frames_is_used(self):
        report = self.play(1e6)
        self.assertEqual((report["method"], report["depth"]), ("mesh", "stream"))


if __name__ == "__main__":
    unittest.main(verbosity=1)
