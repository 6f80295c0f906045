"""What `equistream play --refresh` shows of frames that come late: the right frame, for the head as it is by then.

usage: late_server_test.py BIN_DIR
"""

import collections
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
VIEW = ["--size", "96x64", "--progress", "none", "--method", "mesh", "--depth", "exact", "--fill", "pushpull"]
LAST, PHOTON_S = 29, 0.02


class LateServer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_late_server_"))
        scene = PROGRAMS.scene("pavilion", cls.root)
        cls.place = json.loads(scene.read_text())["camera"]["keys"][0]["position_m"]
        cls.frames = cls.root / "frames"
        PROGRAMS.run("render", scene, "--frames", f"0-{LAST}", "--size", "192x96", "--spp", 1, "--aovs", "depth", "--out", cls.frames)
        cls.still = cls.head("still", lambda t: 0)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    @classmethod
    def head(cls, name, yaw_rad):
        """A path that turns in place; beyond both ends of the frames, where heads are known before and foretold after."""
        file = cls.root / f"{name}.csv"
        rows = [[t, *cls.place, math.cos(yaw_rad(t) / 2), 0, math.sin(yaw_rad(t) / 2), 0] for t in (k / 500 for k in range(-300, 1500))]
        file.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
        return file

    def play(self, out, *options):
        PROGRAMS.run("play", self.frames, *VIEW, *options, "--overwrite", "--out", self.root / out)
        return json.loads((self.root / out / "report.json").read_text())

    def picture(self, out, index, eye="left"):
        return (self.root / out / eye / f"frame.{index:04}.png").read_bytes()

    def pixels(self, out, index):
        return np.asarray(Image.open(self.root / out / "left" / f"frame.{index:04}.png"), float)

    def test_each_refresh_shows_its_frame_as_play_does(self):
        """A head at rest sees of a frame what it sees of it without any network."""
        self.play("plain", "--head", self.still)
        report = self.play("late", "--head", self.still, "--refresh", 45, "--network", "delay=60,jitter=40,seed=4")
        viewing = report["viewing"]
        shown = {each["number"]: each["frame"] for each in viewing["each"] if "frame" in each}
        self.assertEqual([path.name for path in sorted((self.root / "late/left").iterdir())], [f"frame.{k:04}.png" for k in sorted(shown)])
        self.assertEqual([frame["index"] for frame in report["frames"]], sorted(shown))
        self.assertEqual(viewing["blank"], viewing["refreshes"] - len(shown))
        self.assertGreater(len(set(shown.values())), 20)
        for refresh, frame in shown.items():
            for eye in ("left", "right"):
                self.assertEqual(self.picture("late", refresh, eye), self.picture("plain", frame, eye), (refresh, frame))

    def test_the_head_is_where_it_is_at_the_refresh(self):
        """A head that turns steadily sees frame f at refresh k as a path that is so much ahead shows it."""
        turn = lambda t: 0.8 * t
        report = self.play("turning", "--head", self.head("turning", turn), "--refresh", 30, "--network", "delay=60")
        each = [each for each in report["viewing"]["each"] if "frame" in each]
        self.assertLess(report["viewing"]["error_deg"]["max"], 0.01)
        for one in each:
            self.assertAlmostEqual(one["unreprojected_error_deg"], math.degrees(0.8) * one["age_ms"] / 1e3, places=2)
        lag = collections.Counter(one["number"] - one["frame"] for one in each).most_common(1)[0][0]
        self.assertGreaterEqual(lag, 3)  # 60 ms and 20 ms
        self.play("ahead", "--head", self.head("ahead", lambda t: turn(t + lag / 30)))
        self.play("behind", "--head", self.root / "turning.csv")
        alike = [one for one in each if one["number"] - one["frame"] == lag]
        for one in alike:
            seen = self.pixels("turning", one["number"])
            off = {name: np.abs(seen - self.pixels(name, one["frame"])).mean() for name in ("ahead", "behind")}
            self.assertLess(off["ahead"], 0.2, one)
            self.assertGreater(off["behind"], 20 * off["ahead"] + 1, one)

    def test_a_stall_holds_frames_back_and_the_report_says_so(self):
        spec = "delay=50,stall=0.4:0.5"
        report = self.play("stalled", "--head", self.still, "--refresh", 60, "--network", spec)
        self.assertEqual((report["settings"]["network"], report["settings"]["refresh_hz"]), (spec, 60))
        viewing = report["viewing"]
        numbers = [each["frame"] for each in viewing["each"] if "frame" in each]
        self.assertEqual(numbers, sorted(numbers))
        self.assertEqual(numbers[-1], LAST)
        for each in viewing["each"]:
            if "frame" in each:
                sent_s = each["frame"] / 30
                arrival_s = (0.9 if 0.4 - 1e-9 <= sent_s < 0.9 else sent_s) + 0.05
                self.assertLessEqual(arrival_s, each["display_s"] - PHOTON_S + 1e-9)
                self.assertAlmostEqual(each["age_ms"], 1e3 * (each["display_s"] - sent_s), places=6)
        held = [each for each in viewing["each"] if 0.65 < each["display_s"] < 0.9]
        self.assertEqual({each["frame"] for each in held}, {11})
        self.assertIn("late", {each["state"] for each in held})
        self.assertAlmostEqual(sum(viewing["state_s"].values()), viewing["refreshes"] / 60, places=6)
        self.assertEqual((viewing["frames_sent"], viewing["frames_lost"]), (LAST + 1, 0))

    def test_what_cannot_be_simulated_is_one_line(self):
        for options, mention in ((["--refresh", 90], "--refresh: expected --head CSV as well"), (["--network", "delay=9"], "--network: expected --head"),
                                 (["--refresh", 0, "--head", self.still], "--refresh: expected 1 to 1000 Hz, found 0"),
                                 (["--network", "delay=soon", "--head", self.still], "--network delay: expected milliseconds from 0 to 60000, found 'soon'"),
                                 (["--network", "lag=9", "--head", self.still], "--network: expected delay=MS, ")):
            words = [str(word) for word in ["play", self.frames, *VIEW, *options, "--out", self.root / "none"]]
            result = subprocess.run([PROGRAMS.folder / "equistream", *words], capture_output=True, text=True)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn(mention, result.stderr)
            self.assertFalse((self.root / "none").exists())


if __name__ == "__main__":
    unittest.main()
