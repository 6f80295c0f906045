import os
import pathlib
import re
import subprocess
import sys
import threading

import equistream
import pytest

BIN = pathlib.Path(os.environ["EQUISTREAM_BIN"])
SOURCE = pathlib.Path(os.environ["EQUISTREAM_SOURCE"])
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "programs"))  # independent.py


def program(*words):
    """Runs `equistream ...` to its end."""
    result = subprocess.run([BIN / "equistream", *(str(w) for w in words)], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    return result.stdout


def refusals_of_four_threads(call):
    """What threads that make one call at once were told, each that was refused."""
    problems = []

    def look():
        try:
            call()
        except equistream.InputError as problem:
            problems.append(str(problem))

    threads = [threading.Thread(target=look) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return problems


def python_md(section):
    """The blocks of code below a heading of docs/python.md."""
    sections = re.split(r"^## ", (SOURCE / "docs/python.md").read_text(), flags=re.M)
    found = [text for text in sections if text.startswith(section + "\n")]
    assert len(found) == 1, section
    return re.findall(r"```python\n(.*?)```", found[0], re.S)


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
