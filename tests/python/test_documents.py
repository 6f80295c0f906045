"""What docs/python.md shows runs, in its order; so does the example."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

SOURCE = pathlib.Path(os.environ["EQUISTREAM_SOURCE"])
HAS_MITSUBA = importlib.util.find_spec("mitsuba") is not None and (pathlib.Path(importlib.util.find_spec("equistream").origin).parent / "plugins").exists()


def test_python_md(root, scene, run, tmp_path, monkeypatch, capsys):
    run("render", scene, "--frames", "0-2", "--size", "256x128", "--spp", 2, "--aovs", "all", "--out", tmp_path / "render")
    run("encode", tmp_path / "render", "--out", tmp_path / "walk.mp4")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (SOURCE / "docs" / "python.md").read_text(), re.S)
    assert len(blocks) == 5
    names = {}
    for block in blocks:
        if "mitsuba" in block and not HAS_MITSUBA:
            continue
        exec(compile(block, "docs/python.md", "exec"), names)
    assert len(list((tmp_path / "brighter" / "centre").glob("*.exr"))) == 3
    if HAS_MITSUBA:
        assert len(list((tmp_path / "cornell" / "centre").glob("*.exr"))) == 2


@pytest.mark.skipif(not HAS_MITSUBA, reason="no mitsuba")
def test_example(tmp_path):
    result = subprocess.run([sys.executable, SOURCE / "client/python/examples/reproject.py", tmp_path / "eyes.png"],
                            capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    decibels = float(re.search(r"render of it: ([0-9.]+) dB", result.stdout).group(1))
    assert decibels > 28, result.stdout
    picture = np.asarray(Image.open(tmp_path / "eyes.png"))
    assert picture.shape == (544, 1536, 3) and picture[300:, :768].mean() > 20
