"""As users come to it: two lines of Python, Mitsuba's own command line, the example, a clash of releases."""

import os
import pathlib
import subprocess
import sys

import mitsuba as mi
import numpy as np
import pytest
from conftest import BUILD, choose

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLE = ROOT / "host-adapters/mitsuba3/examples/sphere.py"

XML = """<scene version="3.0.0">
    <integrator type="equirect_aov">
        <string name="aovs" value="depth, motion, ids"/>
        <integrator type="path"><integer name="max_depth" value="3"/></integrator>
    </integrator>
    <sensor type="equirect">
        <float name="near_clip" value="1"/>
        <string name="eye" value="left"/>
        <float name="longitude_min" value="-90"/>
        <float name="longitude_max" value="90"/>
        <transform name="to_world"><lookat origin="0, 0, 0" target="0, 0, -1" up="0, 1, 0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="32"/><integer name="height" value="32"/>
            <string name="component_format" value="float32"/>
            <rfilter type="gaussian"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
    </sensor>
    <shape type="sphere"><float name="radius" value="2"/><boolean name="flip_normals" value="true"/><bsdf type="diffuse"/></shape>
    <emitter type="point"><point name="position" value="0, 1, 0"/><rgb name="intensity" value="1"/></emitter>
</scene>
"""


def command_line(*words, **options):
    program = pathlib.Path(mi.__file__).parent / "mitsuba"
    return subprocess.run([program, *map(str, words)], capture_output=True, text=True, **options)


@pytest.mark.parametrize("name", ["scalar_rgb", "llvm_ad_rgb"])
def test_mitsubas_command_line_renders_both_plugins(name, tmp_path):
    choose("scalar_rgb")
    (tmp_path / "scene.xml").write_text(XML)
    done = command_line("-m", name, "-a", BUILD, "-o", tmp_path / "out.exr", tmp_path / "scene.xml")
    assert done.returncode == 0, done.stdout + done.stderr
    written = mi.Bitmap(str(tmp_path / "out.exr"))
    names = [field.name for field in written.struct_()]
    values = np.array(written)
    depth = values[..., names.index("depth.Z")]
    # The left eye is 31.5 mm off the middle of the ball.
    assert np.abs(depth - 2).max() == pytest.approx(0.0315, abs=0.001)
    assert (values[..., names.index("object_id")] == 1).all() and np.abs(values[..., names.index("forward.u")]).max() < 1e-4


def test_mitsubas_command_line_says_what_is_wrong(tmp_path):
    choose("scalar_rgb")
    (tmp_path / "scene.xml").write_text(XML.replace("depth, motion, ids", "depht"))
    done = command_line("-m", "scalar_rgb", "-a", BUILD, tmp_path / "scene.xml")
    assert done.returncode != 0
    assert 'expected albedo, depth, motion, normal, ids, specular, virtual, all or none, found "depht"' in done.stdout + done.stderr


@pytest.mark.parametrize("name", ["scalar_rgb", "llvm_ad_rgb"])
def test_the_example(name, tmp_path):
    environment = {**os.environ, "VARIANT": name}
    words = [sys.executable, EXAMPLE, BUILD, "sphere.exr"]
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "256x128 pixels, 11 planes beside colour: depth.Z, backward.u" in done.stdout
    assert (tmp_path / "sphere.exr").stat().st_size > 256 * 128 * 11


def test_without_the_plugins_folder_mitsuba_says_so():
    code = "import mitsuba as mi; mi.set_variant('scalar_rgb'); mi.load_dict({'type': 'equirect'})"
    done = subprocess.run([sys.executable, "-c", code], cwd="/", capture_output=True, text=True)
    assert done.returncode != 0 and 'Plugin "equirect" not found' in done.stderr
