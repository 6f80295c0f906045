"""What tests of the viewer have in common: a stream of the bundled scene, a display, and viewers on it."""

import json
import pathlib
import shutil
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from display import Display, ViewerProcess, psnr, wait_for  # noqa: E402,F401
from independent import *  # noqa: E402,F403

PROGRAMS = Programs(sys.argv.pop(1))
WIDTH, HEIGHT = 320, 180


class Viewing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_viewer_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        description = json.loads(cls.scene.read_text())
        description["head_box"] = {"lean_m": 0.4}  # room for heads that are moved by keys held for about so long
        cls.scene.write_text(json.dumps(description))
        folder = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-3", "--fps", 5, "--size", "512x256", "--spp", 1, "--aovs", "depth", "--out", folder)
        cls.stream = cls.root / "walk.mkv"
        PROGRAMS.run("encode", folder, "--out", cls.stream, "--depth", "none", "--crf", "8", "--preset", "ultrafast", "--progress", "none")
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()
        shutil.rmtree(cls.root, ignore_errors=True)

    def view(self, *words, source=None, size=f"{WIDTH}x{HEIGHT}", paused=True, config=None):
        shown = [self.stream] if source is None else [source] if source else []
        still = (["--paused"] if paused else []) + (["--size", size] if size else [])
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.root))  # of each viewer: what another wrote is not waited for
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", self.out, *shown, *still, *words, config=config)
        self.addCleanup(viewer.close)
        return viewer

    def by_geometry(self, *words, **more):
        return self.view("--scene", self.scene, *words, **more)

    def played(self, *words, eye="left", size=f"{WIDTH}x{HEIGHT}"):
        """Frame 0 as `play` shows it."""
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        PROGRAMS.run("play", self.stream, "--scene", self.scene, "--depth", "gl", "--size", size, "--frames", "0", *words, "--progress", "none", "--out", out)
        return np.asarray(Image.open(out / eye / "frame.0000.png").convert("RGB")).astype(float)

    def report_of(self, viewer):
        """Ends a viewer that was started with --json."""
        viewer.press("Escape")
        status, said = viewer.end()
        self.assertEqual((status, said), (0, ""))
        return json.loads(viewer.printed)
