"""Filtered spheres beside closed forms, and beside spheres that were rendered as narrow."""

import unittest

import narrowed
import numpy as np


class Narrowed(unittest.TestCase):
    def test_each_narrow_pixel_weighs_one(self):
        for wide, narrow in ((12, 4), (12, 8), (7, 5), (1920, 1280)):
            weights = narrowed.area_weights(wide, narrow).toarray()
            np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-12)
            np.testing.assert_allclose(weights.sum(axis=0), narrow / wide, atol=1e-12)

    def test_two_thirds_is_by_area(self):
        np.testing.assert_allclose(narrowed.area_weights(3, 2).toarray(), [[2 / 3, 1 / 3, 0], [0, 1 / 3, 2 / 3]], atol=1e-15)

    def test_whole_and_broken_ratios_agree(self):
        random = np.random.default_rng(1).random((12, 24, 3))
        by_weights = np.einsum("yr,xc,rck->yxk", narrowed.area_weights(12, 4).toarray(), narrowed.area_weights(24, 8).toarray(), random)
        np.testing.assert_allclose(narrowed.narrowed(random, (8, 4)), by_weights, atol=1e-12)

    def test_light_is_kept(self):
        random = np.random.default_rng(2).random((9, 18, 3))
        np.testing.assert_allclose(narrowed.narrowed(random, (12, 6)).mean(axis=(0, 1)), random.mean(axis=(0, 1)), atol=1e-12)

    def test_wider_is_refused(self):
        with self.assertRaisesRegex(ValueError, "at most 4x2, found 8x4"):
            narrowed.narrowed(np.zeros((2, 4, 3)), (8, 4))

    def test_samples_grow_with_the_area(self):
        self.assertEqual(narrowed.samples_of(16, (1920, 960), (960, 480)), 64)
        self.assertEqual(narrowed.samples_of(16, (1920, 960), (1280, 640)), 36)


if __name__ == "__main__":
    unittest.main()
