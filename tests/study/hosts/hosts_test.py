"""The same scene in both hosts, small: geometry, ids, motion and colour. usage: hosts_test.py BIN_DIR FAILURE_DIR

A failing picture (embedded, Mitsuba, difference; how unlikely each block is) is left in FAILURE_DIR.
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

FAILURES = pathlib.Path(sys.argv.pop(2))
BIN = pathlib.Path(sys.argv.pop(1))
COMPARE = pathlib.Path(__file__).with_name("compare.py")


class Hosts(unittest.TestCase):
    def agree(self, scene, require, *options, generate=()):
        with tempfile.TemporaryDirectory(prefix="equistream_hosts_test_") as folder:
            subprocess.run([BIN / "equistream", "scene", "generate", scene, *generate, "--out", folder], check=True, stdout=subprocess.DEVNULL)
            result = subprocess.run([sys.executable, COMPARE, f"{folder}/{scene}.json", "--out", FAILURES, "--bin", BIN, "--require", require, *options],
                                    capture_output=True, text=True)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_materials_that_mean_the_same(self):
        self.agree("materials", "depth,motion,ids,colour", "--size", "256x128", "--spp", "16", "--seeds", "4", "--frame", "10")

    def test_a_furnace_keeps_its_light_in_both(self):
        self.agree("furnace", "depth,motion,ids,colour", "--size", "128x64", "--spp", "16", "--seeds", "3")

    def test_motion_over_the_seam_and_the_pole(self):
        self.agree("motion", "depth,motion,ids", "--size", "256x128", "--spp", "2", "--seeds", "2", "--frame", "14")

    def test_depth_inside_a_sphere(self):
        self.agree("sphere", "depth,motion,ids", "--size", "256x128", "--spp", "2", "--seeds", "2", generate=("--option", "offset=0.5"))


if __name__ == "__main__":
    unittest.main()
