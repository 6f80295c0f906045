"""PSNR equals FFmpeg's psnr filter within 0.01 dB and SSIM equals scikit-image within 0.001, on photographs. What options choose equals numpy.

usage: parity_test.py BIN_DIR   (the folder of the built programs)
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy
    import OpenEXR
    import skimage.data
    from PIL import Image
    from skimage.metrics import structural_similarity
except ImportError as missing:
    sys.exit(f"parity_test.py: expected the packages of tests/requirements.txt, found no {missing.name}")
if not shutil.which("ffmpeg"):
    sys.exit("parity_test.py: expected ffmpeg on the PATH, found none")

BIN = pathlib.Path(sys.argv.pop(1)).resolve()


def coded(picture, crf, folder):
    """The picture after H.264 at this CRF, in its own 8 bits."""
    height, width = (side // 2 * 2 for side in picture.shape[:2])
    raw = numpy.ascontiguousarray(picture[:height, :width]).tobytes()
    pipe = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"]
    video = folder / "coded.mkv"
    subprocess.run(["ffmpeg", "-v", "error", "-y", *pipe, "-i", "-", "-c:v", "libx264", "-crf", str(crf), video],
                   input=raw, check=True)
    back = subprocess.run(["ffmpeg", "-v", "error", "-i", video, *pipe[:4], "-"], capture_output=True, check=True).stdout
    return picture[:height, :width], numpy.frombuffer(back, numpy.uint8).reshape(height, width, 3)


def cases(folder):
    """Name, picture, truth: what happens to pictures here, and extremes."""
    random = numpy.random.default_rng(1)
    astronaut, cat, coffee = skimage.data.astronaut(), skimage.data.chelsea(), skimage.data.coffee()
    noisy = numpy.clip(cat + random.normal(0, 9, cat.shape), 0, 255).astype(numpy.uint8)
    motorcycle = numpy.asarray(Image.open(pathlib.Path(skimage.data.__file__).parent / "motorcycle_left.png").convert("RGB"))
    truth, blocky = coded(coffee, 34, folder)
    fine_truth, fine = coded(motorcycle, 16, folder)
    dark = (cat // 12).astype(numpy.uint8)
    dark_noisy = numpy.clip(dark + random.integers(-1, 2, dark.shape), 0, 255).astype(numpy.uint8)
    return [("noise", noisy, cat), ("codec, crf 34", blocky, truth), ("codec, crf 16", fine, fine_truth),
            ("a column off", numpy.roll(astronaut, 1, axis=1), astronaut), ("dark", dark_noisy, dark),
            ("black against white", numpy.zeros((40, 60, 3), numpy.uint8), numpy.full((40, 60, 3), 255, numpy.uint8)),
            ("negative", 255 - astronaut, astronaut)]


def ffmpeg_psnr(picture, truth, pixel_format):
    text = subprocess.run(["ffmpeg", "-hide_banner", "-i", picture, "-i", truth, "-filter_complex",
                           f"[0]format={pixel_format}[a];[1]format={pixel_format}[b];[a][b]psnr=stats_file=-",
                           "-f", "null", "-"], capture_output=True, text=True, check=True).stdout
    return float(re.search(r"psnr_avg:([0-9.]+)", text)[1])


class Compared(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="equistream_parity_"))

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def compare(self, picture, truth, *options):
        result = subprocess.run([BIN / "equistream-compare", picture, truth, "--json", *options], capture_output=True,
                                text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)["eyes"]


class Parity(Compared):
    def test_one_picture(self):
        for name, picture, truth in cases(self.folder):
            with self.subTest(name):
                Image.fromarray(picture).save(self.folder / "a.png")
                Image.fromarray(truth).save(self.folder / "t.png")
                ours = self.compare(self.folder / "a.png", self.folder / "t.png")["view"]
                for pixel_format in ("rgb24", "gbrp"):
                    theirs = ffmpeg_psnr(self.folder / "a.png", self.folder / "t.png", pixel_format)
                    self.assertAlmostEqual(ours["psnr_db"], theirs, delta=0.01)
                theirs = structural_similarity(picture, truth, channel_axis=2, gaussian_weights=True, sigma=1.5,
                                               use_sample_covariance=False, data_range=255)
                self.assertAlmostEqual(ours["ssim"], theirs, delta=0.001)
                print(f"{name}: PSNR {ours['psnr_db']:.3f} dB, SSIM {ours['ssim']:.5f} (scikit-image {theirs:.5f})")

    def test_sequence_pools_squared_errors(self):
        """FFmpeg's summary of a sequence is the PSNR of the mean square error, as ours is."""
        random = numpy.random.default_rng(2)
        truth = skimage.data.chelsea()
        for index, sigma in enumerate((2, 20, 5)):
            noisy = numpy.clip(truth + random.normal(0, sigma, truth.shape), 0, 255).astype(numpy.uint8)
            for eye in ("left", "right"):
                for side, pixels in (("a", noisy if eye == "left" else truth), ("t", truth)):
                    place = self.folder / side / eye
                    place.mkdir(parents=True, exist_ok=True)
                    Image.fromarray(pixels).save(place / f"frame.{index:04d}.png")
        eyes = self.compare(self.folder / "a", self.folder / "t", "--metrics", "psnr")
        text = subprocess.run(["ffmpeg", "-hide_banner", "-i", self.folder / "a/left/frame.%04d.png", "-i",
                               self.folder / "t/left/frame.%04d.png", "-filter_complex",
                               "[0]format=gbrp[a];[1]format=gbrp[b];[a][b]psnr", "-f", "null", "-"],
                              capture_output=True, text=True, check=True).stderr
        theirs = float(re.search(r"average:([0-9.]+)", text)[1])
        self.assertAlmostEqual(eyes["left"]["psnr_db"], theirs, delta=0.01)
        self.assertGreater(eyes["left"]["psnr_mean_of_frames_db"], eyes["left"]["psnr_db"] + 2)
        self.assertIsNone(eyes["right"]["psnr_db"])
        self.assertTrue(eyes["right"]["identical"])


class Options(Compared):
    """Of small pictures at random, whose errors are larger from row to row."""

    height, width = 16, 32

    def codes(self, name, seed):
        random = numpy.random.default_rng(seed)
        noise = random.normal(0, numpy.linspace(2, 20, self.height)[:, None, None], (self.height, self.width, 3))
        pixels = numpy.clip(numpy.full(noise.shape, 120) + noise, 0, 255).astype(numpy.uint8)
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(pixels).save(file)
        return file, pixels.astype(float)

    def light(self, name, seed, exposure):
        pixels = numpy.random.default_rng(seed).uniform(0, 0.3, (self.height, self.width, 3)).astype(numpy.float16)
        file = self.folder / f"{name}.0000.exr"
        OpenEXR.File({"type": OpenEXR.scanlineimage}, {c: numpy.ascontiguousarray(pixels[..., k]) for k, c in enumerate("RGB")}).write(str(file))
        subprocess.run([BIN / "equistream-import", file, "--exposure", str(exposure), "--out", self.folder / name], check=True, capture_output=True)
        return self.folder / name, pixels.astype(float)

    def psnr(self, errors, weights=1.0):
        """Of errors in 8-bit codes."""
        return -10 * numpy.log10(numpy.average(errors ** 2, weights=numpy.broadcast_to(weights, errors.shape)) / 255 ** 2)

    def test_ws_psnr_weighs_pixels_by_their_solid_angle(self):
        (a, picture), (t, truth) = self.codes("a.png", 1), self.codes("t.png", 2)
        edges = numpy.sin(numpy.linspace(numpy.pi / 2, -numpy.pi / 2, self.height + 1))
        plain, weighed = self.psnr(picture - truth), self.psnr(picture - truth, (edges[:-1] - edges[1:])[:, None, None])
        self.assertGreater(abs(plain - weighed), 0.2)
        both = self.compare(a, t, "--metrics", "psnr,ws-psnr")["view"]
        self.assertAlmostEqual(both["psnr_db"], plain, 4)
        self.assertAlmostEqual(both["ws_psnr_db"], weighed, 4)
        self.assertNotIn("psnr_db", self.compare(a, t, "--metrics", "ws-psnr")["view"])
        self.assertNotIn("ws_psnr_db", self.compare(a, t)["view"])

    def test_gaps_are_scored_apart(self):
        (a, picture), (t, truth) = self.codes("a.png", 1), self.codes("t.png", 2)
        gaps = numpy.zeros((self.height, self.width), bool)
        gaps[10:, 20:] = True
        Image.fromarray(gaps).save(self.folder / "gaps.png")
        found = self.compare(a, t, "--metrics", "psnr", "--gaps", self.folder / "gaps.png")["view"]
        self.assertAlmostEqual(found["psnr_db"], self.psnr(picture - truth), 4)
        self.assertAlmostEqual(found["gaps"]["psnr_db"], self.psnr((picture - truth)[gaps]), 4)
        self.assertAlmostEqual(found["gaps"]["fraction"], gaps.mean(), 9)

    def test_eyes_that_were_told_are_scored_alone(self):
        expected = {}
        for seed, eye in enumerate(("left", "right", "centre")):
            (_, picture), (_, truth) = (self.codes(f"{side}/{eye}/frame.0000.png", 2 * seed + k) for k, side in enumerate("at"))
            expected[eye] = self.psnr(picture - truth)
        for told, eyes in (([], ["left", "right"]), (["--eyes", "right"], ["right"]), (["--eyes", "centre,left"], ["centre", "left"])):
            found = self.compare(self.folder / "a", self.folder / "t", "--metrics", "psnr", *told)
            self.assertEqual(list(found), eyes)
            for eye in eyes:
                self.assertAlmostEqual(found[eye]["psnr_db"], expected[eye], 4)

    def test_exposure_and_view_make_light_what_is_compared(self):
        (a, picture), (t, truth) = self.light("a", 1, 2), self.light("t", 2, 2)

        def srgb(x):
            return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)

        def raw(x):
            return x

        figures = []
        for told, exposure, curve in (([], 2, srgb), (["--exposure", 0.5], 0.5, srgb), (["--exposure", 4], 4, srgb), (["--view", "Raw"], 2, raw)):
            shown = [numpy.floor(255 * curve(numpy.clip(exposure * light, 0, 1)) + 0.5) for light in (picture, truth)]
            figures.append(self.psnr(shown[0] - shown[1]))
            self.assertAlmostEqual(self.compare(a, t, "--metrics", "psnr", *map(str, told))["centre"]["psnr_db"], figures[-1], delta=0.01)
        self.assertGreater(numpy.diff(sorted(figures)).min(), 0.1)

    def test_second_runs_make_the_noise_free_error_a_mean_of_products(self):
        names = ("a.png", "t.png", "a2.png", "t2.png")
        (a, t, a2, t2), codes = zip(*(self.codes(name, seed) for seed, name in enumerate(names)))
        picture, truth, picture2, truth2 = (pixels / 255 for pixels in codes)
        found = self.compare(a, t, "--metrics", "none", "--second", a2, t2)["view"]
        self.assertAlmostEqual(found["noise_free"]["display"]["mean_square"], numpy.mean((picture - truth) * (picture2 - truth2)), 8)
        self.assertNotIn("whole", found)
        found = self.compare(a, t, "--metrics", "none", "--truth2", t2)["view"]
        self.assertAlmostEqual(found["whole"]["display"]["mean_square"], numpy.mean((picture - truth) * (picture - truth2)), 8)
        self.assertNotIn("noise_free", found)
        self.assertEqual({"whole", "noise_free"} & set(self.compare(a, t)["view"]), set())


if __name__ == "__main__":
    unittest.main(verbosity=1)
