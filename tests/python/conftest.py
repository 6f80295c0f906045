import os
import pathlib
import subprocess
import sys

import pytest

BIN = pathlib.Path(os.environ["EQUISTREAM_BIN"])
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "golden"))  # independent.py


def program(*words):
    """Runs `equistream ...` to its end."""
    result = subprocess.run([BIN / "equistream", *(str(w) for w in words)], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.fixture(scope="session")
def run():
    return program


@pytest.fixture(scope="session")
def root(tmp_path_factory):
    return tmp_path_factory.mktemp("equistream_python")


@pytest.fixture(scope="session")
def scene(root):
    program("scene", "generate", "motion", "--out", root / "scene")
    return root / "scene" / "motion.json"


@pytest.fixture(scope="session")
def sphere(root, scene):
    """A left sphere with a small right view, and both eyes' own views, whose depth makes reprojection exact."""
    out = root / "sphere"
    program("render", scene, "--frames", "0-2", "--size", "512x256", "--spp", 2, "--aovs", "all", "--eye", "left", "--small", "right",
            "--out", out)
    return out


@pytest.fixture(scope="session")
def stream(root, sphere):
    file = root / "walk.mp4"
    program("encode", sphere, "--out", file)
    return file
