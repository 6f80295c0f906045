"""Filtered spheres beside closed forms; narrowed_rendered_test.py has them beside rendered ones."""

import unittest

import narrowed
import numpy as np


class Narrowed(unittest.TestCase):
    def test_each_pixel_is_the_mean_of_those_it_covers(self):
        colour = np.arange(4 * 8 * 3, dtype=float).reshape(4, 8, 3)
        np.testing.assert_allclose(narrowed.narrowed(colour, (4, 2))[1, 3], colour[2:4, 6:8].mean(axis=(0, 1)))

    def test_light_is_kept(self):
        random = np.random.default_rng(2).random((9, 18, 3))
        np.testing.assert_allclose(narrowed.narrowed(random, (6, 3)).mean(axis=(0, 1)), random.mean(axis=(0, 1)), atol=1e-12)

    def test_other_sizes_are_refused(self):
        for size in ((8, 4), (3, 2), (4, 1)):
            with self.assertRaisesRegex(ValueError, f"a whole fraction of 4x2, found {size[0]}x{size[1]}"):
                narrowed.narrowed(np.zeros((2, 4, 3)), size)


if __name__ == "__main__":
    unittest.main()
