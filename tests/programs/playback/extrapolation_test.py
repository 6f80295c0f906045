"""Moving objects while frames are late: extrapolated, they are nearer to where they are than where the newest frame shows them.

usage: extrapolation_test.py BIN_DIR
"""

import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
SIZE, FOV_DEG, HZ = "160x160", 100, 90
VIEW = ["--method", "mesh", "--depth", "stream", "--size", SIZE, "--fov", FOV_DEG, "--refresh", HZ, "--progress", "none"]
TRUTH_HZ, TRUTH = 15, range(10, 14)  # each the sixth refresh of the display


class Extrapolation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_extrapolation_"))
        cls.scene = PROGRAMS.scene("motion", cls.root)
        cls.frames = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-30", "--size", "320x160", "--spp", 1, "--aovs", "depth,motion,ids", "--out", cls.frames)
        cls.report = json.loads(PROGRAMS.run("encode", cls.frames, "--out", cls.root / "motion.mkv", "--depth", "auto", "--motion", "auto", "--json"))
        keys = json.loads(cls.scene.read_text())["camera"]["keys"]
        cls.head = cls.root / "head.csv"
        half = math.radians(35) / 2  # backwards and up: the ball is there, and the block above
        rows = [[key["time_s"], *key["position_m"], 0, 0, math.cos(half), -math.sin(half)] for key in keys]
        cls.head.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in rows))
        PROGRAMS.run("render", cls.scene, "--camera", "perspective", "--eye", "both", "--path", cls.head, "--fps", TRUTH_HZ, "--frames", f"{TRUTH[0]}-{TRUTH[-1]}",
                     "--size", SIZE, "--fov", FOV_DEG, "--spp", 4, "--seed", 2, "--aovs", "ids", "--out", cls.root / "truth")
        cls.movers = np.unique(read_frame(cls.frames / "centre/frame.0000.exr")["object_id"])[-2:]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def play(self, out, source, *options):
        PROGRAMS.run("play", self.root / source, *VIEW, "--head", self.head, *options, "--overwrite", "--out", self.root / out)
        return json.loads((self.root / out / "report.json").read_text())

    def seen(self, out, refresh, eye="left"):
        return np.asarray(Image.open(self.root / out / eye / f"frame.{refresh:04}.png"), float) / 255

    def coarse_db(self, out):
        """Of means over blocks of 5x5 pixels: of where things are, which a small sphere's textures do not tell."""
        errors = []
        blocks = lambda image: image.reshape(32, 5, 32, 5, 3).mean((1, 3))
        for index in TRUTH:
            for eye in ("left", "right"):
                truth = read_frame(self.root / f"truth/{eye}/frame.{index:04}.exr")
                moves = np.isin(truth["object_id"], self.movers)
                self.assertGreater(moves.sum(), 500)
                moving_blocks = moves.reshape(32, 5, 32, 5).any((1, 3))
                errors.append(((blocks(self.seen(out, index * HZ // TRUTH_HZ, eye)) - blocks(srgb(colour_of(truth)))) ** 2)[moving_blocks])
        return -10 * np.log10(np.mean(np.concatenate(errors)))

    def max_step(self, out, refreshes):
        pictures = [self.seen(out, refresh) for refresh in refreshes]
        return max(float(np.abs(b - a).mean()) for a, b in zip(pictures, pictures[1:]))

    def test_encode_says_what_moves_and_how_well(self):
        motion = self.report["motion"]
        self.assertEqual((motion["frames"], motion["most_regions"]), (31, 2))
        self.assertLess(motion["bytes"] / 31, 500)
        self.assertGreater(motion["mean_motion_px"], 50)
        self.assertLess(motion["mean_error_px"], 0.25)
        track = json.loads(PROGRAMS.run("info", self.root / "motion.mkv", "--json"))["tracks"][0]
        self.assertEqual(track["motion"], {"pictures": 31, "most_regions": 2, "bytes": motion["bytes"]})
        self.assertEqual(len(track["first_frame"]["moving"]), 2)

    def test_extrapolated_is_nearer_the_truth(self):
        held = self.play("held", "motion.mkv", "--network", "delay=50", "--extrapolate", 0)
        extrapolated = self.play("extrapolated", "motion.mkv", "--network", "delay=50")
        # Half the error at least; 9 dB were measured.
        self.assertGreater(self.coarse_db("extrapolated"), self.coarse_db("held") + 6)
        self.assertFalse([frame for frame in held["frames"] if "moved_on" in frame])
        each = {one["number"]: one for one in extrapolated["viewing"]["each"]}
        for frame in [frame for frame in extrapolated["frames"] if frame["index"] in range(60, 79)]:
            one = each[frame["index"]]
            self.assertAlmostEqual(frame["moved_on"]["ms"], one["extrapolated_ms"] + one["ahead_ms"], places=6)
            self.assertAlmostEqual(frame["moved_on"]["ms"], one["age_ms"], places=6)  # where they are by now
            self.assertGreater(frame["moved_on"]["pixels"], 1000)

    def test_a_stall_is_calm_and_so_is_what_follows(self):
        calm = self.play("calm", "motion.mkv", "--network", "delay=60")
        stall = self.play("stall", "motion.mkv", "--network", "delay=60,stall=0.4:0.3")
        moved = [(frame["index"], frame["moved_on"]["ms"]) for frame in stall["frames"] if "moved_on" in frame]
        self.assertGreater(max(ms for _, ms in moved), 250)
        self.assertLess(max(ms for _, ms in moved), 1e3 * (0.2 + 0.2 + 1 / 30) + 1)
        # Where things are shown goes on: by no more in a refresh than four of display time, and never back.
        times = {frame["index"]: next(one["frame"] for one in stall["viewing"]["each"] if one["number"] == frame["index"]) / 30 + frame["moved_on"]["ms"] / 1e3
                 for frame in stall["frames"] if "moved_on" in frame}
        steps = [times[k + 1] - times[k] for k in sorted(times) if k + 1 in times]
        self.assertGreaterEqual(min(steps), -1e-9)
        self.assertLess(max(steps), 4.1 / HZ)
        shown = sorted(frame["index"] for frame in calm["frames"])
        usual = self.max_step("calm", [k for k in shown if 30 <= k <= 84])
        self.assertLess(self.max_step("stall", [k for k in sorted(times) if 30 <= k <= 84]), 4 * usual)

    def test_without_motion_nothing_is_different(self):
        """Frames in which nothing moves, and streams that say nothing, cost nothing and look the same."""
        PROGRAMS.run("encode", self.frames, "--out", self.root / "silent.mkv", "--depth", "auto", "--frames", "0-20")
        for out, options in (("silent", []), ("silent-held", ["--extrapolate", 0])):
            report = self.play(out, "silent.mkv", "--network", "delay=50", *options)
            self.assertFalse([frame for frame in report["frames"] if "moved_on" in frame])
        pictures = sorted(path.name for path in (self.root / "silent/left").iterdir())
        self.assertGreater(len(pictures), 20)
        for name in pictures:
            self.assertEqual((self.root / "silent/left" / name).read_bytes(), (self.root / "silent-held/left" / name).read_bytes())
        still = PROGRAMS.scene("pavilion", self.root)
        PROGRAMS.run("render", still, "--frames", "0-2", "--size", "192x96", "--spp", 1, "--aovs", "depth,motion", "--out", self.root / "still")
        for name, options in (("with", ["--motion", "auto"]), ("without", [])):
            PROGRAMS.run("encode", self.root / "still", "--out", self.root / f"{name}.mkv", *options)
        self.assertEqual((self.root / "with.mkv").read_bytes(), (self.root / "without.mkv").read_bytes())

    def test_the_name_of_earlier_versions_does_the_same_and_says_so(self):
        words = ["play", self.root / "motion.mkv", *VIEW, "--head", self.head, "--carry", 0.125, "--out", self.root / "former"]
        result = subprocess.run([PROGRAMS.folder / "equistream", *map(str, words)], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("equistream play: note: --carry is now called --extrapolate\n", result.stderr)
        self.assertEqual(json.loads((self.root / "former/report.json").read_text())["settings"]["extrapolation_limit_s"], 0.125)

    def test_what_cannot_be_done_is_one_line(self):
        PROGRAMS.run("render", self.scene, "--frames", 0, "--size", "128x64", "--spp", 1, "--aovs", "depth", "--out", self.root / "plain")
        for words, mention in ((["encode", self.root / "plain", "--motion", "auto", "--out", self.root / "no.mkv"], "plane 'backward' for --motion (render --aovs depth,motion)"),
                               (["play", self.root / "motion.mkv", *VIEW, "--head", self.head, "--extrapolate", 2, "--out", self.root / "no"], "--extrapolate: expected 0 to 1 s, found 2")):
            result = subprocess.run([PROGRAMS.folder / "equistream", *map(str, words)], capture_output=True, text=True)
            self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
            self.assertIn(mention, result.stderr)


if __name__ == "__main__":
    unittest.main()
