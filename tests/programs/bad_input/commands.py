"""Commands as a person runs them, what they refuse, and small frames to run them on."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1))


def run(*words):
    return subprocess.run([BIN / "equistream", *map(str, words)], capture_output=True, text=True, timeout=120)


def contents(folder):
    """Bytes of every file below a folder."""
    return {path: path.read_bytes() for path in pathlib.Path(folder).rglob("*") if path.is_file()}


class Commands(unittest.TestCase):
    """`scene` is a scene's description, `frames` are six small frames of it, and `out` is each test's own folder."""

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_commands_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.scene, cls.frames = cls.root / "scene" / "motion.json", cls.root / "frames"
        cls.done("scene", "generate", "motion", "--out", cls.scene.parent)
        cls.done("render", cls.scene, "--frames", "0-5", "--size", "128x64", "--spp", 2, "--aovs", "depth", "--out", cls.frames)

    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    @staticmethod
    def done(*words):
        result = run(*words)
        assert result.returncode == 0, result.stderr
        return result.stdout

    def refused(self, words, *mentions, code=2):
        result = run(*words)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (code, 1), result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), result.stderr)
        return result.stdout
