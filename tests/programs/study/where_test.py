"""Kinds of pixels: each pixel is of exactly one, edges begin where closed form says, and whose gaps a system's are."""

import unittest

import numpy as np

from experiments import where
from experiments.systems import SYSTEMS
from figures.where import parts, shares

FOCAL_PX, IPD_M = 320, 0.063
BY_NAME = {system.name: system for system in SYSTEMS}


def step(near_m, far_m, columns=8):
    return np.where(np.arange(columns) < columns // 2, near_m, far_m) * np.ones((5, 1))


class Kinds(unittest.TestCase):
    def test_each_pixel_is_of_exactly_one(self):
        random = np.random.default_rng(1)
        hidden, specular = random.random((2, 40, 60)) < 0.05
        kinds = where.kinds_of(hidden, specular, random.choice([1.0, 1.01, 3.0, np.inf], (40, 60), p=[0.5, 0.45, 0.03, 0.02]), FOCAL_PX, IPD_M)
        self.assertEqual(list(kinds), list(where.KINDS))
        np.testing.assert_array_equal(sum(mask.astype(int) for mask in kinds.values()), 1)
        np.testing.assert_array_equal(kinds["hidden"], hidden)
        self.assertTrue(all(mask.any() for mask in kinds.values()))

    def test_a_mirror_reaches_a_pixel_further(self):
        specular = np.zeros((5, 8), bool)
        specular[2, 4] = True
        kinds = where.kinds_of(np.zeros_like(specular), specular, np.ones(specular.shape), FOCAL_PX, IPD_M)
        self.assertEqual(kinds["mirrors"].sum(), 9)
        self.assertEqual(kinds["edges"].sum(), 0)

    def test_an_edge_begins_at_a_pixel_of_shift(self):
        near_m = 2.0
        at_one_pixel_m = 1 / (1 / near_m - where.EDGE_PX / (FOCAL_PX * IPD_M))
        found = where.edges(step(near_m, 1.01 * at_one_pixel_m), FOCAL_PX, IPD_M)
        np.testing.assert_array_equal(np.flatnonzero(found[2]), [3, 4])
        self.assertFalse(where.edges(step(near_m, 0.99 * at_one_pixel_m), FOCAL_PX, IPD_M).any())

    def test_the_sky_lies_still(self):
        near, far = (where.edges(step(FOCAL_PX * IPD_M / px, np.inf), FOCAL_PX, IPD_M).any() for px in (1.1, 0.9))
        self.assertEqual((near, far), (True, False))


def entry(**kinds):
    """Of both eyes alike: {kind: (share of the pixels, mean square over these)}; a share of 0 has no error."""
    figures = {kind: {"fraction": share, **({"noise_free": {"linear": {"mean_square": square}}} if share else {})} for kind, (share, square) in kinds.items()}
    return {"kinds": {kind: {"left": figure, "right": figure} for kind, figure in figures.items()}}


class Shares(unittest.TestCase):
    def test_they_are_of_all_of_the_error(self):
        found = entry(hidden=(0.1, 0.02), mirrors=(0, 0), edges=(0.3, 0.01), elsewhere=(0.6, 0.005))
        self.assertAlmostEqual(sum(square for _, square in parts(found).values()), 0.1 * 0.02 + 0.3 * 0.01 + 0.6 * 0.005)
        for kind, share in {"hidden": 0.25, "mirrors": 0, "edges": 0.375, "elsewhere": 0.375}.items():
            self.assertAlmostEqual(shares(found)[kind], share)

    def test_what_noise_made_negative_is_none(self):
        self.assertEqual(shares(entry(hidden=(0.1, -0.001), elsewhere=(0.9, 0.01))), {"hidden": 0, "elsewhere": 1})


class Places(unittest.TestCase):
    def test_all_from_one_place_miss_what_its_geometry_says(self):
        self.assertEqual({name: getattr(where.that_knows_gaps(system), "name", None) for name, system in BY_NAME.items()}, {
            "perspective": "perspective", "pair": None, "sphere-left": "sphere-left", "two-spheres": None,
            **{name: "centre" for name in BY_NAME if name.startswith("centre") or name == "default"}})


if __name__ == "__main__":
    unittest.main()
