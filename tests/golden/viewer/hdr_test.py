"""HDR streams from `encode --transfer pq`: `play` and `view` show them alike, and as their display is chosen.

usage: hdr_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from display import Display, ViewerProcess, psnr, wait_for  # noqa: E402
from independent import *  # noqa: E402,F403

PROGRAMS = Programs(sys.argv.pop(1))
SIZE = (320, 180)
FILMIC = "ACES 1.0 - SDR Video"


class Hdr(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_hdr_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        description = json.loads(cls.scene.read_text())
        description["exposure"] *= 3  # for the sky to be brighter than white
        cls.scene.write_text(json.dumps(description))
        cls.folder = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-1", "--size", "512x256", "--spp", 4, "--aovs", "depth", "--out", cls.folder)
        cls.streams = {}
        for transfer in ("srgb", "pq"):
            cls.streams[transfer] = cls.root / f"{transfer}.mkv"
            PROGRAMS.run("encode", cls.folder, "--out", cls.streams[transfer], "--transfer", transfer, "--depth", "none", "--crf", "4", "--preset", "ultrafast",
                         "--progress", "none")
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()
        shutil.rmtree(cls.root, ignore_errors=True)

    def played(self, *words, transfer="pq"):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        PROGRAMS.run("play", self.streams[transfer], "--method", "sphere", "--fill", "none", "--size", "{}x{}".format(*SIZE), "--frames", "0", *words,
                     "--progress", "none", "--out", out)
        return np.asarray(Image.open(out / "left" / "frame.0000.png").convert("RGB")).astype(float)

    def view(self, *words):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", out, self.streams["pq"], "--method", "sphere", "--fill", "off", "--paused",
                               "--size", "{}x{}".format(*SIZE), *words)
        self.addCleanup(viewer.close)
        return viewer

    def test_an_hdr_stream_is_shown_as_an_srgb_one_unless_told_otherwise(self):
        self.assertGreater(psnr(self.played(), self.played(transfer="srgb")), 34)  # two codings of noise

    def test_view_shows_what_play_shows(self):
        for words in ((), ("--view-transform", FILMIC), ("--exposure", "-2")):
            with self.subTest(words=words):
                played, viewer = self.played(*words), self.view(*words)
                seen = viewer.picture()
                viewer.close()
                self.assertGreaterEqual(psnr(seen, played), 50)
        self.assertLess(psnr(self.played(), self.played("--view-transform", FILMIC)), 30)

    def test_a_key_changes_the_exposure(self):
        viewer = self.view()
        viewer.picture()
        viewer.press(*["minus"] * 4)
        darker = self.played("--exposure", "-1")
        wait_for(lambda: psnr(viewer.picture(), darker) >= 50 or None, "a picture one stop darker")

    def test_what_is_brighter_than_white_is_kept(self):
        # Two stops down, what was clipped at white has shades again; an sRGB stream has none.
        white = (self.played(transfer="srgb") >= 255).all(axis=2)
        self.assertGreater(white.sum(), 50)
        self.assertGreater(self.played("--exposure", "-5")[white].std(), 2)

    def refused(self, program, *words):
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", program, *words]], env=self.display.environment, capture_output=True, text=True)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
        return result.stderr

    def test_what_cannot_be_is_said_in_one_line(self):
        out = ("--out", self.root / "nothing")
        self.assertIn("expected an HDR stream", self.refused("play", self.streams["srgb"], "--exposure", "1", *out))
        self.assertIn("expected an HDR stream", self.refused("view", self.streams["srgb"], "--exposure", "1", *out))
        self.assertIn("expected an HDR stream", self.refused("play", self.folder, "--exposure", "1", *out))
        self.assertIn("view: expected one of", self.refused("view", self.streams["pq"], "--view-transform", "Filmic", *out))
        self.assertIn("display: expected one of", self.refused("play", self.streams["pq"], "--display", "TV", *out))
        self.assertIn("--format exr", self.refused("play", self.streams["pq"], "--format", "exr", "--exposure", "1", *out))
        self.assertIn("--transfer pq", self.refused("encode", self.folder, "--transfer", "pq", "--stereo", "top-bottom", *out))
        nothing = self.root / "nothing.ocio"
        nothing.write_text("colours: none\n")
        self.assertIn("nothing.ocio: expected an OpenColorIO config", self.refused("play", self.streams["pq"], "--ocio", nothing, *out))


if __name__ == "__main__":
    unittest.main()
