"""A sphere turned into views by FFmpeg's v360, and by a numpy remap, matches perspective renders of the same place.

v360 maps pixel centres to [0, W-1], so it is up to half a pixel off: it decides orientation; the remap decides the
subpixel. usage: orientation_test.py BIN_DIR FAILURE_DIR
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

FAILURES = pathlib.Path(sys.argv.pop(2))
PROGRAMS = Programs(sys.argv.pop(1))
SIDE = 240
SPHERE = (960, 480)
VIEWS = {"yaw 0": (0, 0), "yaw 90": (90, 0), "yaw 180": (180, 0), "pitch 60": (0, 60)}


def orientation(yaw, pitch):
    """Yaw to the right about +Y, then pitch up about the turned +X."""
    y, p = np.radians(yaw) / 2, np.radians(pitch) / 2
    cy, sy, cp, sp = np.cos(y), -np.sin(y), np.cos(p), np.sin(p)
    return np.array([cy * cp, cy * sp, sy * cp, -sy * sp])


def turned_and_flipped(image):
    """The eight symmetries of a square; the first is the image itself."""
    for flip in (False, True):
        for quarter_turns in range(4):
            yield (flip, quarter_turns), np.rot90(image[:, ::-1] if flip else image, quarter_turns)


def changed_spheres(sphere):
    yield "mirrored", sphere[:, ::-1]
    yield "upside down", sphere[::-1]
    yield "turned upside down", sphere[::-1, ::-1]
    for degrees in (90, 180, 270):
        yield f"turned {degrees}", np.roll(sphere, sphere.shape[1] * degrees // 360, axis=1)


def v360(sphere, yaw, pitch):
    height, width = sphere.shape[:2]
    view = f"v360=input=e:output=flat:h_fov=90:v_fov=90:w={SIDE}:h={SIDE}:yaw={yaw}:pitch={pitch}:interp=linear"
    raw = subprocess.run(["ffmpeg", "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-i",
                          "-", "-vf", f"format=gbrp,{view}", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                         input=bytes_of(sphere).tobytes(), capture_output=True, check=True).stdout
    return np.frombuffer(raw, np.uint8).reshape(SIDE, SIDE, 3) / 255


def remap(sphere, yaw, pitch, columns_off=0.0, rows_off=0.0):
    u, v = pixel_centres(SIDE, SIDE)
    direction = perspective_direction(u, v, SIDE, SIDE, np.pi / 2) @ rotation(orientation(yaw, pitch)).T
    x, y = equirect_pixel(direction, sphere.shape[1], sphere.shape[0])
    return sample(sphere, x + columns_off, y + rows_off)


class Orientation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_orientation_"))
        scene = PROGRAMS.scene("orientation", cls.root / "scene")
        centre = (0.4, -0.3, 0.5)
        path = cls.root / "views.csv"
        path.write_text("".join(
            ",".join(str(value) for value in (index / 30, *centre, *orientation(yaw, pitch))) + "\n"
            for index, (yaw, pitch) in enumerate(VIEWS.values())))
        same = ["--path", path, "--fps", 30, "--eye", "centre", "--spp", 8, "--seed", 1, "--aovs", "none"]
        PROGRAMS.run("render", scene, "--camera", "perspective", "--fov", 90, "--size", f"{SIDE}x{SIDE}", "--frames", "0-3",
                     *same, "--out", cls.root / "views")
        PROGRAMS.run("render", scene, "--size", "{}x{}".format(*SPHERE), "--frames", "1", *same, "--out", cls.root / "sphere")
        cls.views = [srgb(colour_of(read_frame(cls.root / f"views/centre/frame.{i:04d}.exr"))) for i in range(4)]
        cls.sphere = srgb(colour_of(read_frame(cls.root / "sphere/centre/frame.0001.exr")))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def test_v360_sees_the_rendered_views_and_no_other_turn_or_mirror_image(self):
        for (name, (yaw, pitch)), rendered in zip(VIEWS.items(), self.views):
            with self.subTest(name):
                scores = {}
                upright = v360(self.sphere, yaw, pitch)
                for how, candidate in turned_and_flipped(upright):
                    scores[f"view flipped {how[0]}, quarter turns {how[1]}"] = psnr_db(candidate, rendered)
                right = next(iter(scores))
                for how, sphere in changed_spheres(self.sphere):
                    scores[f"sphere {how}"] = psnr_db(v360(sphere, yaw, pitch), rendered)
                wrong = max((score, how) for how, score in scores.items() if how != right)
                print(f"{name}: v360 {scores[right]:.2f} dB, best wrong candidate {wrong[0]:.2f} dB ({wrong[1]})")
                if scores[right] < wrong[0] + 6 or scores[right] < 22:
                    left = leave_behind(FAILURES, f"v360 {name}", upright, rendered)
                    self.fail(f"expected v360 within 22 dB and 6 dB ahead of all others, found {scores}; see {left}")

    def test_remap_is_right_to_a_fraction_of_a_pixel(self):
        for (name, (yaw, pitch)), rendered in zip(VIEWS.items(), self.views):
            with self.subTest(name):
                view = remap(self.sphere, yaw, pitch)
                # How far off the mapping is, in sphere pixels: least squares on the view's change with an offset.
                slopes = [remap(self.sphere, yaw, pitch, columns_off=0.5) - remap(self.sphere, yaw, pitch, columns_off=-0.5),
                          remap(self.sphere, yaw, pitch, rows_off=0.5) - remap(self.sphere, yaw, pitch, rows_off=-0.5)]
                off, *_ = np.linalg.lstsq(np.stack([slope.ravel() for slope in slopes], 1), (rendered - view).ravel(), rcond=None)
                best = psnr_db(view, rendered)
                print(f"{name}: remap {best:.2f} dB, off by {off[0]:+.3f} columns, {off[1]:+.3f} rows")
                if np.max(np.abs(off)) > 0.03 or best < 26:
                    left = leave_behind(FAILURES, f"remap {name}", view, rendered)
                    self.fail(f"expected within 0.03 pixels and 26 dB, found {off} and {best:.2f} dB; see {left}")


if __name__ == "__main__":
    unittest.main(verbosity=1)
