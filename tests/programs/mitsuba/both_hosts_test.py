"""The same scenes in both hosts: depth, motion, ids and normals agree where both see the same object.

usage: both_hosts_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import struct
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
WIDTH, HEIGHT = 512, 256
ACCURATE = 1e-4
SHARE = 0.999


def directions_at(u, v):
    return equirect_direction(u, v, WIDTH, HEIGHT)


class BothHosts:
    """What the scenes share."""

    scene_name, frame = None, 0
    options = ()
    brightness = 0.02
    """How far the mean of a channel may be apart, relatively: of 10^5 pixels at two samples its noise is 0.1 % in these scenes."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_hosts_"))
        scene = PROGRAMS.scene(cls.scene_name, cls.root / "scene")
        cls.change(scene)
        cls.frames = {}
        for host in ("embree", "mitsuba"):
            PROGRAMS.run("render", scene, "--host", host, "--frames", cls.frame, "--size", f"{WIDTH}x{HEIGHT}", "--spp", 2,
                         *cls.options, "--out", cls.root / host)
            cls.frames[host] = read_frame(cls.root / host / f"centre/frame.{cls.frame:04d}.exr")
        ours, theirs = cls.frames["embree"], cls.frames["mitsuba"]
        cls.same = np.logical_and.reduce([ours[name] == theirs[name] for name in ("object_id", "material_id", "instance_id")])
        cls.same_surface = cls.same & (ours["object_id"] > 0)

    @classmethod
    def change(cls, scene):
        """What one of them does to its scene before it is rendered."""

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def test_almost_all_pixels_see_the_same_object(self):
        self.assertGreater(self.same.mean(), 0.99)
        self.assertGreater(self.same_surface.mean(), 0.2)

    def test_depth(self):
        a, b = (self.frames[host]["depth.Z"][self.same_surface] for host in ("embree", "mitsuba"))
        self.assertGreater((np.abs(a - b) <= ACCURATE * a).mean(), SHARE)
        missed = self.same & (self.frames["embree"]["object_id"] == 0)
        for host in self.frames:
            self.assertTrue(np.isinf(self.frames[host]["depth.Z"][missed]).all(), host)

    def test_motion(self):
        """Apart by less than a hundredth of a pixel, measured along the great circle."""
        u, v = pixel_centres(WIDTH, HEIGHT)
        for way in ("backward", "forward"):
            ends = [directions_at(u + self.frames[host][f"{way}.u"], v + self.frames[host][f"{way}.v"]) for host in self.frames]
            apart = np.linalg.norm(ends[0] - ends[1], axis=-1) * WIDTH / (2 * np.pi)
            self.assertGreater((apart[self.same] < 0.01).mean(), SHARE, way)
            longest = np.hypot(self.frames["embree"][f"{way}.u"], self.frames["embree"][f"{way}.v"])[self.same].max()
            self.assertGreater(longest, 0.3, f"{way}: nothing moves, so nothing is tested")

    def test_normals_and_ids(self):
        normals = [np.stack([self.frames[host][f"normal.{c}"] for c in "XYZ"], axis=-1)[self.same_surface] for host in self.frames]
        self.assertGreater(((normals[0] * normals[1]).sum(axis=-1) > 0.999).mean(), 0.99)
        ids = self.frames["mitsuba"]["object_id"]
        self.assertLess(ids.max(), 0xfffffe, "the sun's disc is no object")

    def test_colour_is_as_bright(self):
        """Two samples a pixel: only the mean over the image can be compared."""
        for channel in "RGB":
            a, b = (self.frames[host][channel][self.same].mean() for host in ("embree", "mitsuba"))
            self.assertLess(abs(a - b), self.brightness * a, channel)

    def test_alpha_says_what_was_hit(self):
        a, b = (self.frames[host]["A"] for host in ("embree", "mitsuba"))
        inside = self.same & (np.roll(self.frames["embree"]["object_id"], 1, 1) == self.frames["embree"]["object_id"])
        self.assertGreater((np.abs(a - b)[inside] < 0.6).mean(), 0.995)
        hit = self.frames["embree"]["object_id"] > 0
        for low, high, mask in ((0.97, 1, self.same & hit), (0, 0.06, self.same & ~hit)):
            if mask.any():  # some scenes are closed
                means = a[mask].mean(), b[mask].mean()
                self.assertTrue(low <= min(means) and max(means) <= high, means)
                self.assertAlmostEqual(*means, delta=0.005)


class Pavilion(BothHosts, unittest.TestCase):
    scene_name, frame = "pavilion", 30
    brightness = 0.15  # Mitsuba's `principled` reflects more than our metal-rough materials (docs/results/mitsuba.md)


class MovingObjects(BothHosts, unittest.TestCase):
    scene_name, frame = "motion", 14


class MovingLamps(BothHosts, unittest.TestCase):
    """What shines is no instance in Mitsuba: its vertices move."""

    scene_name, frame = "motion", 14

    @classmethod
    def change(cls, scene):
        model = scene.with_suffix(".glb")
        data = model.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        gltf = json.loads(data[20:20 + length])
        moving = {entry["object"] for entry in json.loads(scene.read_text())["moving"]}
        for node in gltf["nodes"]:
            if node["name"] in moving:
                for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
                    gltf["materials"][primitive["material"]]["emissiveFactor"] = [0.5, 0.4, 0.3]
        text = json.dumps(gltf).encode()
        text += b" " * (-len(text) % 4)
        rest = data[20 + length:]
        model.write_bytes(data[:8] + struct.pack("<II", 20 + len(text) + len(rest), len(text)) + b"JSON" + text + rest)


class FlatView(BothHosts, unittest.TestCase):
    scene_name, frame = "motion", 14
    options = ("--camera", "perspective", "--fov", "80")

    def test_motion(self):
        for way in ("backward", "forward"):
            apart = np.hypot(*(self.frames["embree"][f"{way}.{c}"] - self.frames["mitsuba"][f"{way}.{c}"] for c in "uv"))
            self.assertGreater((apart[self.same] < 0.01).mean(), SHARE, way)


class MirrorsGlassAndWhatIsBehind(BothHosts, unittest.TestCase):
    """Virtual depth and motion of mirrors and panes, and the hidden layer."""

    scene_name, frame = "materials", 14
    options = ("--layers", "--patches")

    def test_what_mirrors_and_panes_show(self):
        ours, theirs = (self.frames[host] for host in ("embree", "mitsuba"))
        sharp = self.same & (ours["specular"] == 1) & (theirs["specular"] == 1)
        self.assertGreater(sharp.sum(), 1000)
        a, b = ours["virtual_depth.Z"][sharp], theirs["virtual_depth.Z"][sharp]
        self.assertGreater((np.isinf(a) == np.isinf(b)).mean(), 0.995)
        ends = np.isfinite(a) & np.isfinite(b)
        self.assertGreater(ends.sum(), 500)
        # In the bound's w, with the box that both frames carry: an eighth of the budget of a quarter of a pixel.
        w_a, w_b = (0.0315 / (z[ends] - 0.0315) for z in (a, b))
        self.assertGreater((np.abs(w_a - w_b) < 1 / 3840 / 8).mean(), 0.99)
        for way in ("backward", "forward"):
            apart = [np.hypot(*(ours[f"virtual_{way}.{c}"] - theirs[f"virtual_{way}.{c}"] for c in "uv"))[sharp]]
            self.assertGreater((apart[0] < 0.01).mean(), 0.99, way)
            moved = np.abs(ours[f"virtual_{way}.u"] - ours[f"{way}.u"])[sharp]
            self.assertGreater(moved.max(), 0.05, f"{way}: what a mirror shows moves as the mirror does")

    def test_hidden_layer(self):
        hidden = {host: read_frame(self.root / host / f"hidden/frame.{self.frame:04d}.exr") for host in self.frames}
        there = {host: ~np.isnan(frame["depth.Z"]) for host, frame in hidden.items()}
        both, either = there["embree"] & there["mitsuba"], there["embree"] | there["mitsuba"]
        self.assertGreater(both.sum(), 500)
        self.assertLess(either.mean(), 0.1)
        self.assertGreater(both.sum() / either.sum(), 0.98)
        a, b = (hidden[host]["depth.Z"][both] for host in ("embree", "mitsuba"))
        self.assertGreater((np.isinf(a) == np.isinf(b)).mean(), 0.99)
        ends = np.isfinite(a) & np.isfinite(b)
        self.assertGreater((np.abs(a[ends] - b[ends]) <= ACCURATE * a[ends]).mean(), 0.99)
        for host, frame in hidden.items():
            self.assertEqual(frame["A"][~there[host]].max(), 0)
            first = self.frames[host]["depth.Z"]
            self.assertTrue((frame["depth.Z"] > first)[there[host]].all(), host)
        for channel in "RGB":
            a, b = (hidden[host][channel][both].mean() for host in ("embree", "mitsuba"))
            self.assertLess(abs(a - b), self.brightness * a, channel)

    def test_patches(self):
        """Each host plans with its own rays, which differ in the last bits."""
        chosen, depth = {}, {}
        for host in self.frames:
            file = self.root / host / f"patches/frame.{self.frame:04d}.exr"
            attributes = OpenEXR.File(str(file)).header()
            side = attributes["equistream:patchSide"]
            slots = attributes["equistream:patchSlots"].split(",")
            plane = read_frame(file)["depth.Z"]
            columns = plane.shape[1] // side
            self.assertLessEqual(plane.size, 0.1 * WIDTH * HEIGHT)
            depth[host] = {slot: plane[i // columns * side:(i // columns + 1) * side, i % columns * side:(i % columns + 1) * side]
                           for i, slot in enumerate(slots) if slot != "-"}
            chosen[host] = set(depth[host])
            self.assertGreater(len(chosen[host]), 100)
        common = chosen["embree"] & chosen["mitsuba"]
        self.assertGreater(len(common), 0.95 * max(len(blocks) for blocks in chosen.values()))
        a, b = (np.concatenate([depth[host][block].ravel() for block in sorted(common)]) for host in ("embree", "mitsuba"))
        self.assertFalse(np.isnan(a).any() or np.isnan(b).any())
        ends = np.isfinite(a) & np.isfinite(b)
        self.assertGreater((np.abs(a - b)[ends] <= ACCURATE * a[ends]).mean(), 0.99)


if __name__ == "__main__":
    unittest.main()
