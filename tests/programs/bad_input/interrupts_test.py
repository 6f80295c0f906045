"""Programs that are interrupted end in order, keep what is finished, and say in a line what there is.

usage: interrupts_test.py BIN_DIR   (the folder of the built programs)
"""

import fcntl
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1))
FRAMES = 400


def command(*words):
    return [str(word) for word in (BIN / "equistream", *words)]


def done(*words):
    result = subprocess.run(command(*words), capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    return result.stdout


class Interrupts(unittest.TestCase):
    """`frames` are many, six of them over and over."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_interrupts_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.scene, cls.frames = cls.root / "scene" / "motion.json", cls.root / "frames"
        done("scene", "generate", "motion", "--out", cls.scene.parent)
        done("render", cls.scene, "--frames", "0-5", "--size", "128x64", "--spp", 1, "--aovs", "depth", "--out", cls.root / "six")
        cls.frames.mkdir()
        for index in range(FRAMES):
            (cls.frames / f"frame.{index:04}.exr").symlink_to(cls.root / f"six/centre/frame.{index % 6:04}.exr")

    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    def interrupted(self, *words):
        """Status and last line of a program that is told to end after its first step. It waits for us to read of the others."""
        read_end, write_end = os.pipe()
        fcntl.fcntl(write_end, fcntl.F_SETPIPE_SZ, 4096)
        with open(read_end) as told:
            process = subprocess.Popen(command(*words, "--progress", "json"), stdout=subprocess.DEVNULL, stderr=write_end)
            os.close(write_end)
            while (line := told.readline()) and not line.startswith("{"):
                pass
            process.send_signal(signal.SIGTERM)
            lines = [line, *told.read().splitlines()]
        return process.wait(timeout=60), [said for said in lines if said.startswith("equistream")][-1:]

    def count(self, ended, expected):
        """Frames that were finished, as the line says, which is `expected` with (N) for them."""
        status, (line,) = ended
        self.assertEqual(status, 1, line)
        pattern = re.escape(expected).replace(r"\(N\)", r"(\d+)")
        self.assertRegex(line, f"^{pattern}$")
        finished = int(re.match(pattern, line)[1])
        self.assertGreater(finished, 0)
        self.assertLess(finished, FRAMES)
        return finished

    def test_encode(self):
        stream = self.out / "a.mkv"
        finished = self.count(self.interrupted("encode", self.frames, "--preset", "ultrafast", "--out", stream),
                              f"equistream encode: interrupted: (N) of {FRAMES} frames are coded; what was coded so far is kept in {stream}.part")
        self.assertEqual([path.name for path in self.out.iterdir()], ["a.mkv.part"])
        self.assertEqual(json.loads(done("info", f"{stream}.part", "--json"))["tracks"][0]["pictures"], finished)

    def test_export(self):
        comp = self.out / "comp"
        status, (line,) = self.interrupted("export", self.frames, "--out", comp)
        begin = re.search(r"--frames (\d+)-", line)
        self.assertTrue(begin, line)
        finished = self.count((status, [line]), f"equistream export: interrupted: (N) of {FRAMES} frames are exported; to export the others, add --frames {begin[1]}-{FRAMES - 1}")
        self.assertEqual(finished, int(begin[1]))
        self.assertEqual(sorted(path.name for path in comp.iterdir()), [f"frame.{index:04}.exr" for index in range(finished)])
        done("export", self.frames, "--frames", f"{finished}-{finished + 1}", "--out", comp)

    def test_play(self):
        play = ["play", self.frames, "--method", "rotation", "--size", "64x64", "--out"]
        line = "equistream play: interrupted: (N) frames played and kept; to start over, add --overwrite to the same command"
        finished = self.count(self.interrupted(*play, self.out / "views"), line)
        report = json.loads((self.out / "views/report.json").read_text())
        self.assertEqual((report["played"], report["truncation"]), (finished, f"interrupted: {finished} frames played and kept"))
        self.assertEqual(len(list(self.out.glob("views/left/frame.*.png"))), finished)
        video = self.out / "a.mp4"
        finished = self.count(self.interrupted(*play, video), line)
        self.assertEqual(json.loads(done("info", video, "--json"))["tracks"][0]["pictures"], finished)

    def test_play_through_a_stall(self):
        """Nothing is read until it is over."""
        head = self.out / "head.csv"
        head.write_text("0,0,0,0,1,0,0,0\n")
        play = ["play", self.frames, "--method", "rotation", "--size", "64x64", "--head", head, "--network", "stall=0.01:20", "--out"]
        self.count(self.interrupted(*play, self.out / "views"),
                   "equistream play: interrupted: (N) refreshes played and kept; to start over, add --overwrite to the same command")

    def test_model(self):
        model = self.out / "model.json"
        status, line = self.interrupted("model", self.scene, "--visibility-rays", 2**34, "--out", model)
        self.assertEqual((status, line), (-signal.SIGTERM, [f"equistream model: interrupted: {model} is not finished; the same command starts over"]))
        self.assertEqual(list(self.out.iterdir()), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
