"""render, import and serve with --denoise: what is written, what is said, and what happens without the library.

usage: denoise_test.py BIN_DIR OTHER_DENOISER   (a library of another major version)
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import OpenEXR

OTHER = sys.argv.pop(2)
BIN = pathlib.Path(sys.argv.pop(1))
SIZE = ["--size", "192x96", "--frames", "0", "--progress", "none"]


def run(*words, **environment):
    return subprocess.run([BIN / "equistream", *map(str, words)], capture_output=True, text=True, timeout=300, env={**os.environ, **environment})


def planes_of(file):
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        return {name: np.asarray(channel.pixels, np.float32) for part in exr.parts for name, channel in part.channels.items()}


def colour(file):
    planes = planes_of(file)
    return np.stack([planes[c] for c in "RGB"], -1)


def error(picture, truth):
    """Of display-like values, so that lamps do not decide."""
    return float(np.mean((np.clip(picture, 0, 1) - np.clip(truth, 0, 1)) ** 2))


class Denoise(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="equistream_denoise_")
        cls.root = pathlib.Path(cls.folder.name)
        made = run("scene", "generate", "pavilion", "--out", cls.root / "scene")
        assert made.returncode == 0, made.stderr
        cls.scene = cls.root / "scene/pavilion.json"
        truth = run("render", cls.scene, *SIZE, "--spp", "64", "--seed", "9", "--aovs", "none", "--out", cls.root / "truth")
        assert truth.returncode == 0, truth.stderr
        cls.truth = colour(cls.root / "truth/centre/frame.0000.exr")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def render(self, name, *words, **environment):
        ended = run("render", self.scene, *SIZE, "--spp", "4", *words, "--out", self.root / name, **environment)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return self.root / name

    def refused(self, *words, **environment):
        ended = run(*words, **environment)
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertEqual(len(ended.stderr.strip().splitlines()), 1, ended.stderr)
        return ended.stderr

    def test_colour_is_cleaner_and_says_by_what(self):
        out = self.render("clean", "--denoise", "balanced", "--aovs", "depth,raw,guides")
        file = out / "centre/frame.0000.exr"
        planes = planes_of(file)
        raw = np.stack([planes[f"raw.{c}"] for c in "RGB"], -1)
        self.assertLess(error(colour(file), self.truth), error(raw, self.truth) / 2)
        plain = self.render("plain", "--aovs", "depth")
        np.testing.assert_array_equal(raw, colour(plain / "centre/frame.0000.exr"))
        np.testing.assert_array_equal(planes["depth.Z"], planes_of(plain / "centre/frame.0000.exr")["depth.Z"])
        normal = np.stack([planes[f"guide_normal.{c}"] for c in "XYZ"], -1)
        self.assertLessEqual(np.linalg.norm(normal, axis=-1).max(), 1.001)
        for said in (json.loads((out / "centre/manifest.json").read_text())["denoiser"], run("info", file).stdout):
            self.assertRegex(said, r"Open Image Denoise 2\.\d+\.\d+.*, balanced")
        self.assertNotIn("guide_albedo.R", planes_of(self.render("bare", "--denoise", "fast", "--aovs", "depth") / "centre/frame.0000.exr"))

    def test_guides_look_through_mirrors_and_follow_the_surface(self):
        planes = planes_of(self.render("guides", "--aovs", "all,guides") / "centre/frame.0000.exr")
        plain = (planes["specular"] == 0) & np.isfinite(planes["depth.Z"])
        normal, guide = (np.stack([planes[f"{name}.{c}"] for c in "XYZ"], -1)[plain] for name in ("normal", "guide_normal"))
        self.assertGreater(np.mean(np.sum(normal * guide, -1) > 0.9), 0.7)
        albedo, guide = (np.stack([planes[f"{name}.{c}"] for c in "RGB"], -1)[plain] for name in ("albedo", "guide_albedo"))
        self.assertLess(np.mean(np.abs(albedo - guide)), 0.06)

    def test_every_stream_of_a_render(self):
        out = self.render("all", "--denoise", "fast", "--layers", "--patches", "--small", "left")
        for stream in ("centre", "hidden", "patches", "small"):
            self.assertIn("fast", json.loads((out / stream / "manifest.json").read_text())["denoiser"], stream)
        hidden = planes_of(out / "hidden/frame.0000.exr")
        self.assertTrue((hidden["A"] == 0).any() and np.isfinite(hidden["R"]).all())

    def test_the_same_whatever_the_threads(self):
        one, two = (colour(self.render(f"threads-{n}", "--denoise", "fast", "--threads", n) / "centre/frame.0000.exr") for n in (1, 2))
        np.testing.assert_array_equal(one, two)

    def test_other_settings_are_not_mixed(self):
        out = self.render("mixed", "--denoise", "fast")
        said = self.refused("render", self.scene, *SIZE, "--spp", "4", "--out", out)
        self.assertRegex(said, r'expected denoise "Open Image Denoise .*, fast".*found off')

    def test_a_stream_says_so_too(self):
        out = self.render("coded", "--denoise", "fast")
        coded = run("encode", out, "--out", self.root / "coded.mp4", "--progress", "none")
        self.assertEqual(coded.returncode, 0, coded.stderr)
        self.assertRegex(run("info", self.root / "coded.mp4").stdout, r"denoised +by Open Image Denoise 2.*, fast")

    def test_import(self):
        out = self.render("foreign", "--aovs", "depth,normal,albedo,guides")
        ended = run("import", out / "centre", "--out", self.root / "imported", "--denoise", "balanced", "--lock", "world", "--progress", "none")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        file = self.root / "imported/centre/frame.0000.exr"
        self.assertLess(error(colour(file), self.truth), error(colour(out / "centre/frame.0000.exr"), self.truth) / 2)
        self.assertNotIn("guide_albedo.R", planes_of(file))
        self.assertIn("Denoise", run("info", file).stdout)

    @unittest.skipUnless((BIN / "equistream-render-mitsuba").exists(), "built without Mitsuba")
    def test_mitsuba(self):
        words = ["render", self.scene, "--host", "mitsuba", "--spp", "4", "--aovs", "depth,raw,guides", "--denoise", "balanced", "--frames", "0", "--progress", "none"]
        ended = run(*words, "--size", "64x32", "--layers", "--out", self.root / "mitsuba-layers")  # ray by ray
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertTrue(np.isfinite(colour(self.root / "mitsuba-layers/hidden/frame.0000.exr")).all())
        ended = run(*words, "--size", "192x96", "--out", self.root / "mitsuba")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        planes = planes_of(self.root / "mitsuba/centre/frame.0000.exr")
        raw = np.stack([planes[f"raw.{c}"] for c in "RGB"], -1)
        self.assertLess(error(colour(self.root / "mitsuba/centre/frame.0000.exr"), self.truth), error(raw, self.truth) / 2)
        ours = planes_of(self.render("ours", "--aovs", "guides") / "centre/frame.0000.exr")
        for channel in ("guide_normal.X", "guide_normal.Y", "guide_normal.Z", "guide_albedo.G"):
            self.assertLess(np.median(np.abs(planes[channel] - ours[channel])), 0.05, channel)

    def test_without_the_library(self):
        words = ["render", self.scene, *SIZE, "--out", self.root / "none"]
        self.assertIn("EQUISTREAM_OIDN", self.refused(*words, "--denoise", "fast", EQUISTREAM_OIDN=str(self.root)))
        self.assertIn("version 3.1.2", self.refused(*words, "--denoise", "fast", EQUISTREAM_OIDN=OTHER))
        self.assertIn("without oidn", self.refused(*words, "--denoise", "fast", EQUISTREAM_OIDN="libm.so.6"))
        self.assertIn("device", self.refused(*words, "--denoise", "fast", OIDN_DEFAULT_DEVICE="hip"))
        self.assertIn("--denoise", self.refused(*words, "--denoise", "best"))
        self.assertIn("raw", self.refused(*words, "--aovs", "raw"))
        self.assertFalse((self.root / "none").exists())


if __name__ == "__main__":
    unittest.main()
