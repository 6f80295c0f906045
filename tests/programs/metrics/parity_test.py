"""PSNR equals FFmpeg's psnr filter within 0.01 dB and SSIM equals scikit-image within 0.001, on photographs.

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


class Parity(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="equistream_parity_"))

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def compare(self, picture, truth, *options):
        result = subprocess.run([BIN / "equistream-compare", picture, truth, "--json", *options], capture_output=True,
                                text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)["eyes"]

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


if __name__ == "__main__":
    unittest.main(verbosity=1)
