#!/usr/bin/env python3
"""A recorded stream over an emulated line that loses packets: every sphere arrives, by each transport that holds there.

usage: lossy_test.py BIN_DIR      (with the Python package on PYTHONPATH)

Exit status 77 where no network namespace can be made: that takes root and /dev/net/tun.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[3] / "programs/study")]
from conditions import LINES  # noqa: E402
from emulated import new_network  # noqa: E402
from ends import in_a_child  # noqa: E402
from live_streams import lossy  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1))
SPHERES = 60


def run(*words):
    subprocess.run([BIN / "equistream", *map(str, words)], check=True, stdout=subprocess.DEVNULL)


class Lossy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="equistream_lossy_")
        cls.addClassCleanup(cls.folder.cleanup)
        work = pathlib.Path(cls.folder.name)
        run("scene", "generate", "pavilion", "--out", work)
        run("render", work / "pavilion.json", "--frames", f"0-{SPHERES - 1}", "--size", "256x128", "--spp", 1, "--aovs", "depth", "--out", work / "frames", "--progress", "none")
        cls.stream = work / "pavilion.mkv"
        run("encode", work / "frames", "--out", cls.stream, "--crf", 12, "--depth", "auto", "--progress", "none")

    def packets_lost(self, way, line):
        """All spheres arrive."""
        found = in_a_child(lambda: lossy(BIN, self.stream, (), LINES[line], way, 1))
        self.assertIsNone(found["problem"])
        self.assertEqual(found["spheres"], SPHERES)
        return found["packets_lost"]

    def test_one_in_a_hundred_lost(self):
        for way in ("tcp", "tls"):
            with self.subTest(way):
                self.assertGreater(self.packets_lost(way, "1 % lost"), 0)

    def test_one_in_twenty_lost(self):
        self.assertGreaterEqual(self.packets_lost("srt", "5 % lost"), 20)

    def test_one_in_five_lost(self):
        self.assertGreaterEqual(self.packets_lost("srt", "20 % lost"), 100)

    def test_packets_that_overtake(self):
        self.packets_lost("srt", "200 ms of jitter, packets overtake")


def is_possible():
    child = os.fork()
    if child == 0:
        try:
            new_network()
            os.close(os.open("/dev/net/tun", os.O_RDWR))
        except OSError as error:
            print(f"skipped: {error}", flush=True)
            os._exit(77)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


if __name__ == "__main__":
    if not is_possible():
        sys.exit(77)
    unittest.main(warnings="ignore")
