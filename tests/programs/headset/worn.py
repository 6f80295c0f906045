"""The viewer with a headset on: its stream, its runtime's script, and what came of it."""

import copy
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / name) for name in (".", "live", "viewer")]
from display import PATIENCE_S, Display, ViewerProcess, psnr, wait_for  # noqa: E402,F401
from independent import *  # noqa: E402,F403

RUNTIME = sys.argv.pop(2)
PROGRAMS = Programs(sys.argv.pop(1))
STILL = (0, 0, 0, 1, 0, 0, 0)
IPD_M = 0.064  # the runtime's, unless it is told otherwise


def turn(degrees, axis):
    half = np.radians(degrees) / 2
    return np.array([np.cos(half), *(np.sin(half) * np.array(axis))])


def lines_of(script):
    """Heads, and other lines as they are."""
    return "".join((line if isinstance(line, str) else " ".join(f"{x:.9g}" for x in line)) + "\n" for line in script)


class Log:
    """What the runtime wrote of frames that were seen, and at its end."""

    def __init__(self, folder):
        # Of whole lines alone: it may be writing still.
        lines = [json.loads(line) for line in (folder / "log.jsonl").read_text().rpartition("\n")[0].splitlines()]
        self.broken = [line["broken"] for line in lines if "broken" in line]
        self.frames = [line for line in lines if "frame" in line]
        self.end = lines[-1] if lines and "end" in lines[-1] else None


class WornViewer(ViewerProcess):
    """On a script that waits for it."""

    def __init__(self, test, script, *words, source=None):
        self.folder = test.scripted(script)
        worn = copy.copy(test.display)
        worn.environment = {**test.display.environment, **test.runtime_of(self.folder)}
        super().__init__(worn, PROGRAMS.folder / "equistream", self.folder, source or test.stream, "--headset", *words)
        test.addCleanup(self.close)

    def log(self):
        return Log(self.folder)

    def wait_for_frame(self, number):
        wait_for(lambda: (self.folder / "log.jsonl").exists() and any(f["frame"] >= number for f in self.log().frames), f"frame {number}")

    def go_on(self, name):
        (self.folder / name).touch()


class Worn(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Once for all that have these tests in common."""
        if hasattr(Worn, "root"):
            return
        Worn.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_headset_"))
        unittest.addModuleCleanup(shutil.rmtree, Worn.root, ignore_errors=True)
        Worn.scene = PROGRAMS.scene("pavilion", Worn.root)
        description = json.loads(Worn.scene.read_text())
        description["head_box"] = {"lean_m": 0.4}
        Worn.scene.write_text(json.dumps(description))
        folder = Worn.root / "frames"
        PROGRAMS.run("render", Worn.scene, "--frames", "0", "--size", "512x256", "--spp", 1, "--aovs", "depth", "--out", folder)
        Worn.stream = Worn.root / "walk.mkv"
        PROGRAMS.run("encode", folder, "--out", Worn.stream, "--depth", "none", "--crf", "8", "--preset", "ultrafast", "--progress", "none")
        Worn.manifest = Worn.root / "runtime.json"
        Worn.manifest.write_text(json.dumps({"file_format_version": "1.0.0", "runtime": {"library_path": RUNTIME}}))
        Worn.display = Display()
        unittest.addModuleCleanup(Worn.display.close)

    def scripted(self, script):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        (folder / "script.txt").write_text(lines_of(script))
        return folder

    def runtime_of(self, folder):
        return {"XR_RUNTIME_JSON": str(self.manifest), "EQUISTREAM_FAKE_XR": str(folder)}

    def worn(self, script, *words, status=0):
        """The viewer on a script from beginning to end; frames by their number, with pictures, its log, and the process."""
        folder = self.scripted(script)
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", self.stream, "--headset", "--paused", "--scene", self.scene, "--out",
                                                  folder, *words]], env={**self.display.environment, **self.runtime_of(folder)}, capture_output=True, text=True,
                                timeout=PATIENCE_S)
        self.assertEqual(result.returncode, status, result.stderr)
        log = Log(folder)
        self.assertEqual(log.broken, [])
        frames = {frame["frame"]: frame for frame in log.frames}
        for number, frame in frames.items():
            for eye, view in enumerate(frame["views"]):
                view["picture"] = np.asarray(Image.open(folder / f"frame.{number:04}.{eye}.ppm")).astype(float)
        return frames, log, result
