"""A user's own XML, z up, with every kind of shape: frames, exported geometry, and playing it back.

usage: own_xml_test.py BIN_DIR
"""

import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
ROOM = pathlib.Path(__file__).resolve().parent / "room.xml"
SIZE = ["--size", "512x256"]


def decibels(a, b):
    return -10 * np.log10(np.mean((a - b) ** 2))


def picture(file):
    return np.asarray(Image.open(file).convert("RGB"), float) / 255


class OwnXml(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_xml_"))
        PROGRAMS.run("render", ROOM, "--host", "mitsuba", *SIZE, "--spp", 4, "--out", cls.root / "out")
        cls.frame = read_frame(cls.root / "out/centre/frame.0000.exr")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def test_the_xmls_z_is_our_y(self):
        """Straight down there is the floor at z = 0, and the lamp hangs above: the head stands 1.5 up."""
        down, up = self.frame["depth.Z"][-1].mean(), self.frame["depth.Z"][0].mean()
        self.assertAlmostEqual(down, 1.5, delta=1e-3)
        self.assertAlmostEqual(up, 2.5, delta=1e-3)  # the ceiling at z = 4
        self.assertGreater(self.frame["normal.Y"][-1].min(), 0.999)

    def test_exported_geometry_gives_the_same_depth(self):
        """A ray cast of the GLB by the embedded host: another tracer, another Embree, triangles for curved shapes."""
        PROGRAMS.run("render", self.root / "out/scene.json", *SIZE, "--spp", 1, "--aovs", "depth,ids", "--out", self.root / "glb")
        cast = read_frame(self.root / "glb/centre/frame.0000.exr")
        a, b = self.frame["depth.Z"], cast["depth.Z"]
        same = self.frame["object_id"] == cast["object_id"]  # objects are written in the order of Mitsuba's shapes
        self.assertGreater(same.mean(), 0.995)
        self.assertEqual(len(np.unique(cast["object_id"])), 10)
        self.assertGreater((np.abs(a - b)[same] <= 1e-4 * a[same]).mean(), 0.999)

    def test_holes_of_a_mask_are_holes_in_the_export(self):
        """The grid is seen, and through it what is behind it."""
        grid = self.frame["object_id"] == 7
        rows, columns = np.nonzero(grid)
        box = self.frame["object_id"][rows.min():rows.max() + 1, columns.min():columns.max() + 1]
        self.assertTrue(0.3 < (box == 7).mean() < 0.7)

    def test_playing_it_back_with_its_own_geometry(self):
        """Against what Mitsuba renders from the eye itself; a view turned and no more is much farther off."""
        video = self.root / "room.mkv"
        PROGRAMS.run("render", ROOM, "--host", "mitsuba", "--size", "1024x512", "--spp", 16, "--aovs", "none", "--out",
                     self.root / "clean")
        PROGRAMS.run("encode", self.root / "clean", "--out", video, "--crf", 12)
        flat = ["--size", "320x240"]
        PROGRAMS.run("render", ROOM, "--host", "mitsuba", "--camera", "perspective", "--eye", "both", "--ipd", "0.3", *flat,
                     "--spp", 64, "--aovs", "none", "--out", self.root / "truth")
        PROGRAMS.run("info", self.root / "truth/left", "--pictures", self.root / "look")
        # A wide head is the test's: nothing about a 30 cm one is coded in the stream.
        (self.root / "head.csv").write_text(self.head(-0.15))
        scores = {}
        for method in ("eye-depth", "rotation"):
            PROGRAMS.run("play", video, "--scene", self.root / "out/scene.json", "--method", method, "--head", self.root / "head.csv",
                         *flat, "--out", self.root / method)
            view = next((self.root / method / "left").glob("*.png"))
            truth = picture(next((self.root / "look").glob("*colour.png")))
            scores[method] = decibels(picture(view)[8:-8, 8:-8], truth[8:-8, 8:-8])
        print("played back:", scores, file=sys.stderr)
        self.assertGreater(scores["eye-depth"], scores["rotation"] + 4)
        self.assertGreater(scores["eye-depth"], 20)

    def head(self, aside):
        """The XML's head, moved so that play's left eye is where the truth's is."""
        import json
        key = json.loads((self.root / "out/scene.json").read_text())["camera"]["keys"][0]
        q = key["orientation_wxyz"]
        right = rotation(q) @ np.array([1, 0, 0])
        p = np.array(key["position_m"]) + right * (aside + 0.0315)
        return f"0,{p[0]},{p[1]},{p[2]},{q[0]},{q[1]},{q[2]},{q[3]}\n"

    def test_the_process_holds_none_of_the_systems_clashing_libraries(self):
        process = subprocess.Popen([PROGRAMS.folder / "equistream", "render", ROOM, "--host", "mitsuba", *SIZE, "--spp", "4096",
                                    "--out", self.root / "long"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        maps = ""
        deadline = time.time() + 120
        while "libembree" not in maps and time.time() < deadline and process.poll() is None:
            time.sleep(0.2)
            maps = pathlib.Path(f"/proc/{process.pid}/maps").read_text()
        time.sleep(1)
        maps = pathlib.Path(f"/proc/{process.pid}/maps").read_text()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=300)
        files = {line.split()[-1] for line in maps.splitlines() if "/" in line}
        wheel = next(file for file in files if file.endswith("/libmitsuba.so")).rsplit("/", 1)[0]
        for clashing in ("libembree", "libpugixml", "libOpenImageIO"):
            for file in files:
                self.assertFalse(clashing in file and not file.startswith(wheel), file)
        self.assertEqual(process.returncode, -signal.SIGINT, said)
        self.assertIn("interrupted: 0 of 1 frames", said)
        self.assertEqual(list((self.root / "long/centre").glob("*.exr")), [])

    def test_resuming_keeps_what_is_there_and_refuses_what_is_not_the_same(self):
        options = ["--host", "mitsuba", "--size", "64x32", "--spp", "1", "--aovs", "depth", "--out", self.root / "again"]
        PROGRAMS.run("render", ROOM, *options)
        self.assertIn("0 frames rendered, 1 kept", PROGRAMS.run("render", ROOM, *options))
        with self.assertRaisesRegex(RuntimeError, "(?s)exit 2.*fingerprint"):
            PROGRAMS.run("render", ROOM, *options, "-D", "power=20")
        with self.assertRaisesRegex(RuntimeError, "(?s)exit 2.*equistream-mitsuba"):
            PROGRAMS.run("render", ROOM, *options, "--variant", "scalar_rgb")

    def rendered(self, name, *options):
        PROGRAMS.run("render", ROOM, "--host", "mitsuba", "--size", "128x64", *options, "--out", self.root / name)
        return read_frame(self.root / name / "centre/frame.0000.exr")

    def test_every_variant_that_this_build_has_sees_the_same(self):
        """Spectral ones too: their film is linear Rec.709. Those for GPUs have no GPU here."""
        with self.assertRaisesRegex(RuntimeError, "expected one of ") as refused:
            self.rendered("none", "--variant", "none")
        known = str(refused.exception).split("expected one of ")[1].split(", found")[0].split(", ")
        self.assertIn("scalar_rgb", known)
        expected = self.rendered("expected", "--spp", 64)
        for variant in known:
            if variant.startswith("cuda"):
                continue
            frame = self.rendered(variant, "--variant", variant, "--spp", 64)
            # On an edge between two shapes either may be met.
            same = np.abs(frame["depth.Z"] - expected["depth.Z"]) < 1e-5 * expected["depth.Z"]
            self.assertGreater(same.mean(), 0.995, variant)
            for channel in "RGB":
                a, b = np.clip(frame[channel], 0, 2).mean(), np.clip(expected[channel], 0, 2).mean()
                self.assertLess(abs(a - b), 0.05 * b, f"{variant}: {channel}")

    def test_other_seeds_are_independent_and_the_same_one_repeats(self):
        scalar = ["--variant", "scalar_rgb", "--spp", 4]
        one, again, other = (self.rendered(f"seed{i}", *scalar, "--seed", seed) for i, seed in enumerate((1, 1, 2)))
        self.assertTrue(all((one[name] == again[name]).all() for name in one))
        self.assertTrue((one["depth.Z"] == other["depth.Z"]).all())
        self.assertLess((one["R"] == other["R"]).mean(), 0.2)

    def test_a_walk_and_both_eyes(self):
        """The head goes 0.2 a frame towards the far wall at y = 4 of the XML; eyes stand aside of it."""
        path = self.root / "walk.csv"
        path.write_text("0,0,1.5,2,1,0,0,0\n1,0,1.5,-0.4,1,0,0,0\n")
        PROGRAMS.run("render", ROOM, "--host", "mitsuba", "--size", "256x128", "--spp", 1, "--path", path, "--fps", 12, "--frames", "0-2",
                     "--eye", "both", "--aovs", "depth,motion", "--out", self.root / "walk")
        ahead = [read_frame(self.root / f"walk/left/frame.{n:04d}.exr") for n in range(3)]
        for before, after in zip(ahead, ahead[1:]):
            down = [frame["depth.Z"][-1].mean() for frame in (before, after)]
            self.assertAlmostEqual(down[0], down[1], delta=1e-4)
            back = [frame["depth.Z"][64, 0] for frame in (before, after)]  # behind: the wall that the head leaves
            self.assertAlmostEqual(back[1] - back[0], 0.2, delta=2e-3)
        self.assertGreater(np.abs(ahead[1]["backward.u"]).max(), 1)
        middle = [read_frame(self.root / f"walk/{eye}/frame.0001.exr")["depth.Z"][64, 0] for eye in ("left", "right")]
        self.assertAlmostEqual(middle[0], middle[1], delta=1e-3)


if __name__ == "__main__":
    unittest.main()
