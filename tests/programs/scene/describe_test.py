"""`equistream scene describe`: a model of one's own can be rendered at once, and nothing of its owner's is replaced.

usage: describe_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))

# A cube of 120 units a side, corners counted from 1, faces outwards.
CUBE = "".join(f"v {120 * x} {120 * y} {120 * z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
CUBE += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"


def run(*words):
    return subprocess.run([PROGRAMS.folder / "equistream", *map(str, words)], capture_output=True, text=True)


class Describe(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_describe_"))
        PROGRAMS.scene("orientation", cls.root / "made")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        self.room = self.folder / "room.glb"
        shutil.copy(self.root / "made/orientation.glb", self.room)

    def assert_refused(self, result, *mentions):
        self.assertEqual(result.returncode, 2, result.stderr + result.stdout)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), result.stderr)

    def render(self, scene):
        PROGRAMS.run("render", scene, "--size", "64x32", "--spp", 1, "--aovs", "depth", "--out", self.folder / "frames")
        return read_frame(self.folder / "frames/centre/frame.0000.exr")

    def test_a_room_is_rendered_from_inside(self):
        done = run("scene", "describe", self.room)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("room.json: describes", done.stdout)
        self.assertIn("1 m (glTF's)", done.stdout)
        self.assertIn("the model's own, 12 emissive triangles", done.stdout)
        info = json.loads(PROGRAMS.run("scene", "info", self.folder / "room.json", "--json"))
        self.assertEqual((info["scene"], info["sun"], info["sky"], info["lean_m"]), ("room", False, False, 0.1))
        self.assertGreater(info["nearest_m"], 0.3)
        frame = self.render(self.folder / "room.json")
        self.assertGreater(np.isfinite(frame["depth.Z"]).mean(), 0.99)
        # The floor is 2.5 m below the origin.
        self.assertAlmostEqual(frame["depth.Z"][-1].min(), 1.6, delta=0.02)
        self.assertGreater(np.quantile(colour_of(frame).max(-1), 0.1), 0.02)

    def test_an_object_is_seen_from_outside_by_daylight(self):
        model = self.folder / "cube.obj"
        model.write_text(CUBE)
        told = json.loads(PROGRAMS.run("scene", "describe", model, "--json"))
        self.assertEqual((told["inside"], told["sun"], told["model_unit_m"]), (False, True, 1))
        self.assertEqual(told["command"].split()[:3], ["equistream", "scene", "describe"])
        frame = self.render(told["scene"])
        hit = np.isfinite(frame["depth.Z"])
        self.assertTrue(hit[:, 24:40].any() and not hit[:, [0, -1]].any(), "ahead, and nothing behind")
        self.assertGreater(np.median(colour_of(frame)[hit].max(-1)), 0.02)

    def test_units(self):
        model = self.folder / "cube.obj"
        for size, unit in ((1, 1), (30, 0.01), (300, 0.001)):
            scaled = [" ".join(["v", *(str(size * float(x)) for x in line.split()[1:])]) if line[0] == "v" else line for line in CUBE.splitlines()]
            model.write_text("\n".join(scaled) + "\n")
            told = json.loads(PROGRAMS.run("scene", "describe", model, "--overwrite", "--json"))
            self.assertEqual((told["model_unit_m"], json.loads(pathlib.Path(told["scene"]).read_text()).get("model_unit_m", 1)), (unit, unit))
        told = json.loads(PROGRAMS.run("scene", "describe", model, "--unit", 0.5, "--overwrite", "--json"))
        self.assertEqual((told["model_unit_m"], told["unit_from"]), (0.5, "--unit"))
        low, high = json.loads(PROGRAMS.run("scene", "info", told["scene"], "--json"))["bounding_box_m"]
        self.assertTrue(np.allclose([low, high], told["bounding_box_m"], rtol=1e-5))
        self.assertAlmostEqual(high[0], 18000, delta=0.1)

    def test_a_description_elsewhere_finds_its_model(self):
        (self.folder / "scenes").mkdir()
        PROGRAMS.run("scene", "describe", self.room, "--out", self.folder / "scenes/mine.json")
        self.assertEqual(json.loads((self.folder / "scenes/mine.json").read_text())["model"], "../room.glb")
        self.assertIn("mine", PROGRAMS.run("scene", "info", self.folder / "scenes/mine.json"))

    def test_what_is_not_its_own_is_not_replaced(self):
        out = self.folder / "room.json"
        describe = ("scene", "describe", self.room)
        for foreign in ("[1, 2]", '{"a": 1}', "notes"):
            out.write_text(foreign)
            for words in (describe, (*describe, "--overwrite")):
                self.assert_refused(run(*words), f"--out {out}: expected a new name, or a scene description to replace, found another file")
            self.assertEqual(out.read_text(), foreign)
        out.unlink()
        PROGRAMS.run(*describe)
        made = out.read_text()
        self.assertEqual(run(*describe).returncode, 0, "the same again")
        changed = made.replace('"lean_m":0.1', '"lean_m":0.2')
        self.assertNotEqual(changed, made)
        out.write_text(changed)
        self.assert_refused(run(*describe), f"--out {out}: expected a new name, or --overwrite, found another scene description")
        self.assertEqual(out.read_text(), changed)
        self.assertEqual(run(*describe, "--overwrite").returncode, 0)
        self.assertEqual(out.read_text(), made)
        self.assert_refused(run(*describe, "--out", self.folder / "room.txt"), "--out: expected a name that ends in .json")
        self.assert_refused(run(*describe, "--out", self.folder / "none/room.json"), "expected a folder that can be written to")

    def test_what_is_no_model_is_told_in_a_line(self):
        bad = self.folder / "bad.glb"
        bad.write_bytes(b"glTF" + bytes(20))
        self.assert_refused(run("scene", "describe", bad), bad)
        self.assert_refused(run("scene", "describe", self.folder / "none.glb"), "none.glb", "no such file")
        scene = self.root / "made/orientation.json"
        self.assert_refused(run("scene", "describe", scene), f"{scene}: expected a model (.glb, .gltf or .obj), found a scene description")
        self.assertFalse((self.folder / "bad.json").exists())

    def test_frames_of_a_camera_that_stands_still(self):
        PROGRAMS.run("scene", "describe", self.room)
        words = ["render", self.folder / "room.json", "--frames", "0-1", "--dry-run", "--out", self.folder / "frames"]
        self.assert_refused(run(*words), "--frames: expected 0, the only frame of the camera's path (--path CSV gives it a longer one), found 0-1")
        path = self.folder / "path.csv"
        path.write_text("0,0,0,0,1,0,0,0\n")
        self.assert_refused(run(*words, "--path", path), "--frames: expected frames within the path's 0-0, found 0-1")


if __name__ == "__main__":
    unittest.main(verbosity=1)
