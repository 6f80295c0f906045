"""Depth and light where they are known: depth inside a sphere mesh is its radius within the facets' sag, and a miss is +inf; in furnaces every radiance is 1,
within the error bar of the estimate.

usage: closed_form_test.py BIN_DIR Depth|Furnace
"""

import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
# Rays and vertices are float: a few units in the last place of coordinates up to R.
ROUNDING = 4e-6


class Depth(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_depth_"))

    def tearDown(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def render(self, scene, *options):
        PROGRAMS.run("render", scene, "--frames", 0, "--spp", 1, "--seed", 1, "--aovs", "depth,normal,ids", *options, "--out",
                     self.root / "out")
        return read_frame(self.root / "out/centre/frame.0000.exr")

    def test_centre_of_a_sphere_mesh(self):
        for radius, n in ((3.0, 64), (0.5, 256), (100.0, 17)):
            for camera in (["--size", "360x180"], ["--camera", "perspective", "--fov", 90, "--size", "160x120"]):
                with self.subTest(radius=radius, n=n, camera=camera[0]):
                    scene = PROGRAMS.scene("sphere", self.root / "scene", "--option", f"radius={radius}", "--option", f"n={n}")
                    depth = self.render(scene, *camera)["depth.Z"]
                    sag = radius * (1 - np.cos(np.pi / n))
                    print(f"R {radius}, n {n}: depth {depth.min():.6f} to {depth.max():.6f}, "
                          f"allowed {radius - sag:.6f} to {radius:.6f}")
                    self.assertTrue(np.all(np.isfinite(depth)))
                    self.assertLessEqual(depth.max(), radius * (1 + ROUNDING))
                    self.assertGreaterEqual(depth.min(), (radius - sag) * (1 - ROUNDING))
                    shutil.rmtree(self.root / "out")

    def test_off_centre_depth_is_the_distance_along_each_ray(self):
        """Direction matters: the camera stands halfway to +X, so depth there is least."""
        radius, n, offset = 2.0, 256, 0.5
        scene = PROGRAMS.scene("sphere", self.root / "scene", "--option", f"radius={radius}", "--option", f"n={n}", "--option",
                               f"offset={offset}")
        depth = self.render(scene, "--size", "360x180")["depth.Z"]
        direction = equirect_direction(*pixel_centres(360, 180), 360, 180)
        along = direction[..., 0] * offset * radius
        exact = -along + np.sqrt(along ** 2 + radius ** 2 * (1 - offset ** 2))
        # A facet lies at most the sag inside; seen obliquely that is longer, by 1 / cos of the angle to its normal.
        cosine = (along + exact) / radius
        sag = radius * (1 - np.cos(np.pi / n)) / cosine
        self.assertLessEqual(np.max(depth - exact), radius * ROUNDING)
        self.assertLessEqual(np.max(exact - depth - 1.5 * sag), radius * ROUNDING)

    def test_a_miss_is_infinite_and_has_no_ids(self):
        scene = PROGRAMS.scene("furnace", self.root / "scene")
        frame = self.render(scene, "--size", "256x128")
        miss = frame["object_id"] == 0
        self.assertTrue(0.5 < np.mean(miss) < 0.99)
        self.assertTrue(np.all(np.isposinf(frame["depth.Z"][miss])))
        self.assertTrue(np.all(np.isfinite(frame["depth.Z"][~miss])))
        for axis in "XYZ":
            self.assertTrue(np.all(frame[f"normal.{axis}"][miss] == 0))


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
