"""What the pages on Python show without Mitsuba runs, in its order; test_mitsuba.py runs the rest."""

import re

import equistream as es
import numpy as np

from conftest import SOURCE, python_md

HERE = ("Frames", "Streams", "Reprojection", "Mirrors, glass and patches", "Directions, poses, colour")
BESIDE_MITSUBA = ("Mitsuba",)


def test_python_md(scene, run, tmp_path, monkeypatch):
    run("render", scene, "--frames", "0-2", "--size", "256x128", "--spp", 2, "--aovs", "all", "--patches", "--patch-budget", 20,
        "--out", tmp_path / "render")
    run("encode", tmp_path / "render", "--depth", "auto", "--out", tmp_path / "walk.mp4")
    run("encode", tmp_path / "render", "--out", tmp_path / "bare.mp4")
    monkeypatch.chdir(tmp_path)
    assert {picture.role for picture in es.open_stream("walk.mp4") if picture.rgb is None} >= {"depth"}
    names = {}
    for section in HERE:
        blocks = python_md(section)
        assert len(blocks) == 1, section
        exec(compile(blocks[0], "docs/python.md", "exec"), names)
    patches = names["frame"].patches
    assert patches.depth_m is None
    cast, by_rays = (names[who].cast_patches(patches.info) for who in ("everywhere", "caster"))
    used = es.patch_rays(patches.info).used
    assert np.isfinite(cast[used]).any() and used.any()
    np.testing.assert_allclose(cast[used], by_rays[used], rtol=1e-4)
    assert len(list((tmp_path / "brighter" / "centre").glob("*.exr"))) == 3
    (tmp_path / "frames").symlink_to("render")
    blocks = re.findall(r"```python\n(.*?)```", (SOURCE / "docs/guide/python.md").read_text(), re.S)
    assert len(blocks) == 1
    exec(compile(blocks[0], "docs/guide/python.md", "exec"), {})


def test_every_block_is_run_by_some_test():
    assert (SOURCE / "docs/python.md").read_text().count("```python") == len(HERE + BESIDE_MITSUBA)
