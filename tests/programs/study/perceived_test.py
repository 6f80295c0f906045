"""Flicker beside closed forms, with noise that it must not count; FLIP of what is the same."""

import math
import pathlib
import shutil
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import perceived  # noqa: E402

SIZE, FRAMES = (96, 64), 6
GREY = 128


class Perceived(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_perceived_"))
        self.addCleanup(shutil.rmtree, self.root, ignore_errors=True)
        self.random = np.random.default_rng(7)

    def sequence(self, name, offsets, noise=0):
        """Grey frames, each brighter by its offset."""
        folder = self.root / name
        folder.mkdir()
        for number, offset in enumerate(offsets):
            values = GREY + offset + noise * self.random.standard_normal((*SIZE[::-1], 3))
            Image.fromarray(np.clip(np.round(values), 0, 255).astype(np.uint8)).save(folder / f"frame.{number:04}.png")
        return folder

    def flicker(self, offsets, noise=0):
        runs = [(self.sequence(f"view-{seed}", offsets, noise), self.sequence(f"truth-{seed}", [0] * FRAMES, noise)) for seed in (1, 2)]
        return perceived.flicker(runs)

    def test_an_error_that_stays_does_not_flicker(self):
        self.assertEqual(self.flicker([20] * FRAMES)["mean_square"], 0)
        self.assertIsNone(perceived.decibels(0))

    def test_one_that_comes_and_goes_counts_by_its_steps(self):
        found = self.flicker([0, 10] * (FRAMES // 2))
        self.assertAlmostEqual(found["mean_square"], (10 / 255) ** 2, places=6)
        self.assertAlmostEqual(found["db"], -20 * np.log10(10 / 255), places=2)

    def test_noise_counts_nothing(self):
        noise = 12
        found = self.flicker([0, 10] * (FRAMES // 2), noise)
        deviation = 4 * (noise / 255) ** 2 / np.sqrt((FRAMES - 1) * 3 * SIZE[0] * SIZE[1])
        self.assertLess(abs(found["mean_square"] - (10 / 255) ** 2), 5 * deviation)

    def test_of_a_single_frame_there_is_none(self):
        one = self.sequence("one", [0])
        self.assertIsNone(perceived.flicker([(one, one), (one, one)]))

    def test_flip_is_of_what_differs(self):
        plain, bright = self.sequence("plain", [0, 0]), self.sequence("bright", [30, 30])
        self.assertEqual(perceived.flip(plain, plain, 20), 0)
        self.assertGreater(perceived.flip(bright, plain, 20), 0.05)
        self.assertAlmostEqual(perceived.pixels_a_degree(180 / math.pi), 1)


if __name__ == "__main__":
    unittest.main()
