"""Motion of a moving camera among still and moving objects: against rigid motion computed here, and by pictures.

Sampling frame N-1 at x + backward(x) must give frame N where the point was visible: over the seam, near the poles, on
the objects. usage: motion_test.py BIN_DIR FAILURE_DIR
"""

import json
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

FAILURES = pathlib.Path(sys.argv.pop(2))
PROGRAMS = Programs(sys.argv.pop(1))
WIDTH, HEIGHT = 512, 256
NOW = 14
FPS = 30


def slerp(a, b, t):
    a, b = np.asarray(a, float), np.asarray(b, float)
    b = -b if np.dot(a, b) < 0 else b
    angle = np.arccos(np.clip(np.dot(a, b), -1, 1))
    if angle < 1e-9:
        return a
    return (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)


def pose_at(keys, time):
    """Rotation and position of a path at a time: held at its ends, linear and slerp between."""
    times = [key["time_s"] for key in keys]
    i = int(np.clip(np.searchsorted(times, time) - 1, 0, len(keys) - 2))
    t = np.clip((time - times[i]) / (times[i + 1] - times[i]), 0, 1)
    a, b = keys[i], keys[i + 1]
    identity = [1, 0, 0, 0]
    turn = slerp(a.get("orientation_wxyz", identity), b.get("orientation_wxyz", identity), t)
    return rotation(turn), (1 - t) * np.array(a["position_m"]) + t * np.array(b["position_m"])


class Motion(unittest.TestCase):
    lock = "world"

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_motion_"))
        scene = PROGRAMS.scene("motion", cls.root / "scene")
        cls.description = json.loads(scene.read_text())
        PROGRAMS.run("render", scene, "--frames", f"{NOW - 1}-{NOW + 1}", "--fps", FPS, "--size", f"{WIDTH}x{HEIGHT}", "--spp", 6,
                     "--seed", 1, "--lock", cls.lock, "--aovs", "depth,motion,ids", "--out", cls.root / "out")
        cls.frames = {n: read_frame(cls.root / f"out/centre/frame.{n:04d}.exr") for n in (NOW - 1, NOW, NOW + 1)}

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def camera_at(self, frame):
        turn, position = pose_at(self.description["camera"]["keys"], frame / FPS)
        return (turn if self.lock == "path" else np.eye(3)), position

    def world_points(self, frame):
        """Where every pixel's point is, from depth."""
        turn, position = self.camera_at(frame)
        direction = equirect_direction(*pixel_centres(WIDTH, HEIGHT), WIDTH, HEIGHT) @ turn.T
        return position + self.frames[frame]["depth.Z"][..., None] * direction

    def moving_masks(self, points):
        """Which pixels show a moving object: those whose point lies in its bounds where it is now."""
        ids = self.frames[NOW]["object_id"]
        masks = {}
        for moving in self.description["moving"]:
            turn, position = pose_at(moving["keys"], NOW / FPS)
            near = np.linalg.norm(points - position, axis=-1) < 0.36 if moving["object"] == "ball" else \
                np.all(np.abs((points - position) @ turn) < (0.46, 0.16, 0.31), axis=-1)
            found, counts = np.unique(ids[near], return_counts=True)
            masks[moving["object"]] = ids == found[np.argmax(counts)]
        return masks

    def expected_direction(self, points, masks, other):
        """Camera-frame direction of every point at frame `other`, each moved with its object."""
        moved = points.copy()
        for moving in self.description["moving"]:
            turn, position = pose_at(moving["keys"], NOW / FPS)
            turn_other, position_other = pose_at(moving["keys"], other / FPS)
            mask = masks[moving["object"]]
            moved[mask] = ((points[mask] - position) @ turn) @ turn_other.T + position_other
        turn, position = self.camera_at(other)
        return (moved - position) @ turn

    def places(self, masks, u_other):
        """Named sets of pixels that the claim is made for, each large enough to mean something."""
        u, v = pixel_centres(WIDTH, HEIGHT)
        still = ~(masks["ball"] | masks["block"])
        seam = (u_other < 0) | (u_other >= WIDTH)
        places = {"still": still, "ball": masks["ball"], "block": masks["block"], "over the seam": seam, "upper pole": v < 12,
                  "lower pole": v > HEIGHT - 12}
        if self.lock == "world":
            places["ball at the seam"] = masks["ball"] & ((u < 12) | (u > WIDTH - 12))
        for name, mask in places.items():
            self.assertGreater(np.sum(mask), 20, name)
        return places

    def test_against_rigid_motion(self):
        points = self.world_points(NOW)
        masks = self.moving_masks(points)
        u, v = pixel_centres(WIDTH, HEIGHT)
        for channel, other in (("backward", NOW - 1), ("forward", NOW + 1)):
            du, dv = (self.frames[NOW][f"{channel}.{c}"] for c in "uv")
            self.assertTrue(np.all(np.isfinite(du)) and np.all(np.isfinite(dv)))
            self.assertLessEqual(np.max(np.abs(du)), WIDTH / 2)
            expected = self.expected_direction(points, masks, other)
            found = equirect_direction(u + du, v + dv, WIDTH, HEIGHT)
            off = angle_between(found, expected) * WIDTH / (2 * np.pi)
            for name, mask in self.places(masks, u + du).items():
                print(f"{channel}, {name}: {np.sum(mask)} pixels, at most {off[mask].max():.5f} px off")
                # Depth and hit points are float32: 1e-6 of metres at metres, times 81 px a radian, and the motion's own.
                self.assertLess(off[mask].max(), 0.005, name)
            moved = angle_between(equirect_direction(u, v, WIDTH, HEIGHT), expected) * WIDTH / (2 * np.pi)
            self.assertGreater(np.median(moved), 0.2)  # there is motion to find

    def test_previous_frame_sampled_by_motion_gives_this_one(self):
        now, before = self.frames[NOW], self.frames[NOW - 1]
        points = self.world_points(NOW)
        masks = self.moving_masks(points)
        u, v = pixel_centres(WIDTH, HEIGHT)
        x, y = u + now["backward.u"], v + now["backward.v"]
        # Visible: the four samples around show the same object, none nearer or further than the point then was.
        turn, position = self.camera_at(NOW - 1)
        distance = np.linalg.norm(self.expected_direction(points, masks, NOW - 1), axis=-1)
        visible = np.ones((HEIGHT, WIDTH), bool)
        for right in (0, 1):
            for down in (0, 1):
                column = (np.floor(x - 0.5).astype(int) + right) % WIDTH
                row = np.clip(np.floor(y - 0.5).astype(int) + down, 0, HEIGHT - 1)
                visible &= before["object_id"][row, column] == now["object_id"]
                visible &= np.abs(before["depth.Z"][row, column] / distance - 1) < 0.05
        # Colour is filtered over the pixel: stay a pixel away from other objects.
        same = now["object_id"]
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            visible &= np.roll(same, step, axis) == same
        picture = srgb(sample(colour_of(before), x, y))
        truth = srgb(colour_of(now))
        error = np.abs(picture - truth).max(axis=-1)
        unmoved = np.abs(srgb(colour_of(before)) - truth).max(axis=-1)
        for name, mask in self.places(masks, x).items():
            mask = mask & visible
            self.assertGreater(np.sum(mask), 20, name)
            rms, rms_unmoved = (np.sqrt(np.mean(e[mask] ** 2)) for e in (error, unmoved))
            print(f"{name}: {np.sum(mask)} visible pixels, rms {rms:.5f} by motion, {rms_unmoved:.5f} unmoved")
            # Resampling softens texture and antialiased texture differs by its own filter; a wrong sign doubles "unmoved".
            if rms > 0.02 or rms > 0.5 * rms_unmoved:
                left = leave_behind(FAILURES, f"motion {self.lock} {name}", picture * visible[..., None],
                                    truth * visible[..., None])
                self.fail(f"{name}: expected rms below 0.02 and half of unmoved, found {rms:.5f} and {rms_unmoved:.5f}; see {left}")
        self.assertGreater(np.mean(visible), 0.8)


class MotionOfATurningSphere(Motion):
    """The sphere's axes turn with the path, so every pixel moves."""

    lock = "path"


if __name__ == "__main__":
    unittest.main(verbosity=1)
