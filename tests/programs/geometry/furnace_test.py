"""Furnaces: scenes whose every radiance is 1, within the error bar of the estimate.

usage: furnace_test.py BIN_DIR
"""

import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
SEEDS = 6


class Furnace(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_furnace_"))

    def tearDown(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def test_radiance_is_one(self):
        for kind in ("open", "closed"):
            with self.subTest(kind):
                scene = PROGRAMS.scene("furnace", self.root / kind, "--option", f"kind={kind}")
                renders = []
                for seed in range(1, SEEDS + 1):
                    out = self.root / f"{kind}{seed}"
                    PROGRAMS.run("render", scene, "--frames", 0, "--size", "128x64", "--spp", 64, "--seed", seed, "--max-bounces", 64, "--aovs", "ids",
                                 "--out", out)
                    renders.append(read_frame(out / "centre/frame.0000.exr"))
                colour = np.array([colour_of(frame) for frame in renders])
                self.assertTrue(np.all(np.isfinite(colour)))
                for object_id in np.unique(renders[0]["object_id"]):
                    means = colour[:, renders[0]["object_id"] == object_id].mean(axis=(1, 2))
                    mean, error = means.mean(), means.std(ddof=1) / np.sqrt(SEEDS)
                    pixels = int(np.sum(renders[0]["object_id"] == object_id))
                    print(f"{kind}, object {object_id}, {pixels} pixels: {mean:.5f} +- {error:.5f}")
                    # Student's t with 5 degrees of freedom: 6.9 is one in a thousand; 5e-4 is half a unit of the half
                    # floats that colour is stored in.
                    self.assertLessEqual(abs(mean - 1), 6.9 * error + 5e-4)
                    self.assertLess(error, 0.01)


if __name__ == "__main__":
    unittest.main(verbosity=1)
