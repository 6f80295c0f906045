"""As a new user: a clean virtual environment, `pip install .`, Mitsuba, a sphere saved and reprojected. Slow: it compiles."""

import os
import pathlib
import subprocess
import sys
import zipfile

SOURCE = pathlib.Path(os.environ["EQUISTREAM_SOURCE"])
PYTHON = os.environ.get("EQUISTREAM_TEST_PYTHON", sys.executable)
USE = """
import equistream.mitsuba as em, equistream as es, mitsuba as mi, numpy as np
mi.set_variant('scalar_rgb')
scene = mi.load_dict(mi.cornell_box())
camera = es.EquirectCamera(128, 64)
em.render_sequence(scene, es.PosePath([(0, es.Pose((0, 0, 0.5)))]), 'out/centre', camera, frames=[0, 1], spp=4)
frame = es.Sequence('out/centre')[1]
eye = es.PerspectiveCamera(64, 48)
view = es.reproject(frame, eye, es.Pose((0.03, 0, 0.5)), depth=em.depth_source(scene))
assert view.rgb.mean() > 10 and (view.origin > 0).all()
maps = open('/proc/self/maps').read()
embrees = {line.split()[-1] for line in maps.splitlines() if 'libembree' in line}
assert len(embrees) <= 1 and 'OpenImageIO' not in maps, embrees
print('done')
"""


def run(*words, **options):
    result = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=1500, **options)
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
    return result.stdout


def test_installed_as_a_new_user_would(tmp_path):
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "EQUISTREAM"))}
    run(PYTHON, "-m", "venv", tmp_path / "venv")
    python = tmp_path / "venv" / "bin" / "python"
    run(python, "-m", "pip", "wheel", "--no-deps", "-w", tmp_path / "wheels", "-C", "cmake.define.EQUISTREAM_MITSUBA_VARIANTS=scalar_rgb",
        SOURCE, cwd=tmp_path, env=environment)
    (wheel,) = (tmp_path / "wheels").glob("equistream-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    contents = {name.split("/", 1)[1] for name in names if name.startswith("equistream/")}
    modules = {name for name in contents if name.startswith("_core.") and name.endswith(".so")}
    assert len(modules) == 1 and contents - modules == {
        "__init__.py", "_core.pyi", "arrays.py", "build_facts.py", "cameras.py", "colour.py", "depth.py", "frames.py", "mitsuba.py", "plugins/equirect.so",
        "plugins/equirect_aov.so", "py.typed", "reprojection.py", "streams.py"}
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert all(name.startswith(("equistream/", "equistream-")) for name in names)
    run(python, "-m", "pip", "install", f"{wheel}[mitsuba]", env=environment)
    assert run(python, "-c", USE, cwd=tmp_path, env=environment).strip().endswith("done")
