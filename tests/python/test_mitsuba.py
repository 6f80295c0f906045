"""Beside Mitsuba: plugins found in either order and for all compiled variants, renders as frames, one Embree, clear refusals."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import equistream as es
import numpy as np
import pytest

from conftest import BIN, SOURCE, python_md
from notebook import run as run_notebook

PACKAGE = pathlib.Path(es.__file__).parent
CASE = """
import equistream as es
{first}
{second}
scene = mi.load_dict({{'type': 'scene', 'ball': {{'type': 'sphere', 'center': [1, 0, -4], 'radius': 1}}, 'sky': {{'type': 'constant'}}}})
frame = em.render_frame(scene, es.Pose((0.5, 0, 0)), es.EquirectCamera(64, 32), spp=2, aovs='depth,ids')
d = frame.info.camera.directions() @ [0.5, 0, -4]
"""


def python(code, **environment):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, env={**os.environ, **environment})


def ball(camera, pose, centre, radius):
    """Closed form: distance to a sphere along each pixel-centre ray."""
    d = pose.to_world(camera.directions())
    b = d @ (np.asarray(centre) - pose.position_m)
    square = b * b - np.sum((np.asarray(centre) - pose.position_m) ** 2) + radius**2
    return np.where((square > 0) & (b > 0), b - np.sqrt(np.maximum(square, 0)), np.inf)


@pytest.mark.parametrize("variant", ["scalar_rgb", "llvm_ad_rgb"])
@pytest.mark.parametrize("order", ["before", "after"])
def test_either_order(variant, order):
    imports = [f"import mitsuba as mi; mi.set_variant('{variant}')", "import equistream.mitsuba as em"]
    if order == "before":
        imports.reverse()
    code = CASE.format(first=imports[0], second=imports[1]) + """
import numpy as np
print(frame['depth'].shape, int(np.isfinite(frame['depth']).sum()), frame.info.host)
maps = [line.split()[-1] for line in open('/proc/self/maps') if 'r-xp' in line]
print(sorted({m.rsplit('/', 1)[-1].split('.so')[0] for m in maps if 'embree' in m or 'OpenImageIO' in m or 'pugixml' in m}))
print([m for m in maps if ('embree' in m or 'pugixml' in m) and '/mitsuba/' not in m])
"""
    result = python(code)
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert lines[0].startswith("(32, 64) ") and variant in lines[0]
    assert lines[1] in ("['libembree3', 'libpugixml']", "['libembree3']", "['libpugixml']", "[]") and lines[2] == "[]"


@pytest.fixture(scope="module")
def em():
    import equistream.mitsuba
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    return equistream.mitsuba


@pytest.fixture(scope="module")
def scene(em):
    import mitsuba as mi
    return mi.load_dict({"type": "scene", "ball": {"type": "sphere", "center": [1, 0, -4], "radius": 1},
                         "sky": {"type": "constant"}, "sensor": {"type": "perspective", "to_world": em.to_world(es.Pose((0, 1, 2)))}})


@pytest.mark.parametrize("camera", [es.EquirectCamera(128, 64), es.EquirectCamera(64, 64, (-np.pi / 2, np.pi / 2)), es.PerspectiveCamera(80, 60, 1.2)])
def test_depth_is_the_closed_form(em, scene, camera):
    pose = es.Pose.look_at((0.3, 0.2, 0.1), (0.8, 0, -4))
    frame = em.render_frame(scene, pose, camera, spp=1, aovs="depth,normal")
    expected = ball(camera, pose, (1, 0, -4), 1)
    hit = np.isfinite(expected) & np.isfinite(frame["depth"])
    assert (np.isfinite(expected) != np.isfinite(frame["depth"])).mean() < 2e-3 and hit.sum() > 10
    np.testing.assert_allclose(frame["depth"][hit], expected[hit], rtol=1e-4)
    points = pose.position_m + pose.to_world(camera.directions())[hit] * expected[hit][:, None]
    np.testing.assert_allclose(frame["normal"][hit], points - [1, 0, -4], atol=2e-3)


def test_poses_go_there_and_back(em, scene):
    pose = es.Pose.look_at((1, 2, 3), (-1, 0.5, 0))
    assert np.allclose(em.pose_of(em.to_world(pose)).matrix, pose.matrix, atol=1e-6)
    assert np.allclose(em.pose_of(scene.sensors()[0].world_transform()).position_m, [0, 1, 2], atol=1e-6)


def test_sequences_encode_and_reproject(em, scene, run, tmp_path):
    path = es.PosePath([(0, es.Pose()), (1, es.Pose((0.3, 0, 0)))])
    camera = es.EquirectCamera(256, 128)
    sequence = em.render_sequence(scene, path, tmp_path / "centre", camera, frames=range(3), spp=2, name="ball")
    assert sequence.indices == [0, 1, 2] and sequence.info(1).scene == "ball"
    stamp = (tmp_path / "centre" / "frame.0000.exr").stat().st_mtime_ns
    em.render_sequence(scene, path, tmp_path / "centre", camera, frames=range(4), spp=2, name="ball")
    assert (tmp_path / "centre" / "frame.0000.exr").stat().st_mtime_ns == stamp
    run("encode", tmp_path, "--out", tmp_path / "ball.mp4")
    frame = next(es.open_feed(tmp_path / "ball.mp4"))
    eye = es.PerspectiveCamera(64, 64)
    pose = es.eye_pose(eye, frame.main.info.head, "right")
    view = es.reproject(frame, eye, pose, depth=em.depth_source(scene))
    assert view.gaps.sum() < 64 * 64 / 10 and (view.origin > 0).all()
    np.testing.assert_allclose(view.depth_m, ball(eye, pose, (1, 0, -4), 1), rtol=1e-4)


def test_depth_of_patches_is_the_closed_form(em, run, tmp_path):
    """From within a ball, whose centre is not the sphere's: patches anywhere hit it."""
    import mitsuba as mi
    run("scene", "generate", "leaf", "--out", tmp_path)
    run("render", tmp_path / "leaf.json", "--frames", "0", "--size", "64x32", "--spp", 1, "--aovs", "depth", "--patches", "--out", tmp_path / "frames")
    info = es.read_frame_info(tmp_path / "frames" / "patches" / "frame.0000.exr")
    centre = info.camera_pose.position_m + [0.3, 0.1, 0.2]
    around = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "center": centre.tolist(), "radius": 2}})
    cast = em.depth_source(around).cast_patches(info)
    rays = es.patch_rays(info)
    b = np.sum(rays.directions * (centre - rays.origins_m), axis=-1)
    expected = b + np.sqrt(b * b - np.sum((centre - rays.origins_m) ** 2, axis=-1) + 2**2)
    assert rays.used.sum() > 50 and np.ptp(expected[rays.used]) > 0.3
    np.testing.assert_allclose(cast[rays.used], expected[rays.used], rtol=1e-4)


def small_sequence(em, scene, folder, **changes):
    path = es.PosePath([(0, es.Pose()), (0.3, es.Pose((0.3, 0, 0)))])
    settings = dict(path=path, frames=range(2), fps=10, spp=2, aovs="depth,motion", camera=es.EquirectCamera(32, 16)) | changes
    return em.render_sequence(scene, settings.pop("path"), folder, settings.pop("camera"), **settings)


def test_frames_of_anything_else_are_refused_even_where_all_are_there(em, scene, tmp_path):
    import mitsuba as mi
    folder = tmp_path / "centre"
    small_sequence(em, scene, folder)
    stamps = [(folder / f"frame.000{i}.exr").stat().st_mtime_ns for i in range(2)]
    small_sequence(em, scene, folder)
    aside = es.PosePath([(0, es.Pose((0, 1, 0))), (0.3, es.Pose((0.3, 0, 0)))])
    other = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "center": [1, 0, -5], "radius": 1}, "sky": {"type": "constant"}})
    for changes in (dict(path=aside), dict(spp=4), dict(seed=1), dict(integrator={"type": "direct"}), dict(integrator={"type": "path", "hide_emitters": True}), dict(scene=other), dict(path=aside, frames=range(3))):
        with pytest.raises(es.InputError, match="choose another folder or overwrite"):
            small_sequence(em, changes.pop("scene", scene), folder, **changes)
    assert [(folder / f"frame.000{i}.exr").stat().st_mtime_ns for i in range(2)] == stamps
    assert small_sequence(em, other, folder, overwrite=True).indices == [0, 1]


def test_the_same_scene_is_known_again_by_another_process(em):
    code = '''
import mitsuba as mi; mi.set_variant('llvm_ad_rgb')
import equistream as es, equistream.mitsuba as em
renderer = em.Renderer(mi.load_dict(mi.cornell_box()), es.EquirectCamera(32, 16))
import hashlib
frame = renderer.frame(es.Pose((0, 0, 0.5)), spp=1)
print(em._fingerprint(renderer, es.PosePath([(0, es.Pose())])), hashlib.md5(b''.join(frame[p].tobytes() for p in ('object_id', 'material_id', 'instance_id'))).hexdigest(),
      frame['object_id'].max())
'''
    runs = [python(code) for _ in range(6)]  # Mitsuba lists shapes in one of a few orders
    assert {run.stdout for run in runs} == {runs[0].stdout} and len(runs[0].stdout.split()[0]) == 32, runs[0].stderr
    assert int(runs[0].stdout.split()[2]) > 3


def test_motion_does_not_depend_on_which_frames_are_asked_for(em, scene, tmp_path):
    whole = small_sequence(em, scene, tmp_path / "whole", frames=range(4))
    part = small_sequence(em, scene, tmp_path / "part", frames=[1, 2])
    for index in (1, 2):
        for plane in ("backward", "forward"):
            np.testing.assert_allclose(part.read(index)[plane], whole.read(index)[plane], atol=1e-4)
            assert np.abs(part.read(index)[plane]).max() > 0.1
    assert np.abs(whole.read(0)["backward"]).max() < 1e-3 and np.abs(whole.read(3)["forward"]).max() < 1e-3


def test_every_frame_and_eye_has_noise_of_its_own(em, tmp_path):
    import mitsuba as mi
    lit = mi.load_dict(mi.cornell_box())
    still = es.PosePath([(0, es.Pose((0, 0, 0.5)))])
    left, right = (small_sequence(em, lit, tmp_path / eye, path=still, eye=eye, ipd_m=0.0) for eye in ("left", "right"))
    np.testing.assert_allclose(left[0]["depth"], right[1]["depth"])
    lit_up = np.isfinite(left[0]["depth"]) & (left[0]["colour"][..., :3].max(-1) > 0)
    assert lit_up.mean() > 0.5
    for other in (left[1], right[0]):
        assert (left[0]["colour"][..., :3] == other["colour"][..., :3]).all(-1)[lit_up].mean() < 0.1


def test_a_scene_that_has_our_integrator(em):
    import mitsuba as mi
    described = mi.cornell_box()
    described["integrator"] = {"type": "equirect_aov", "aovs": "depth", "nested": {"type": "path", "max_depth": 1}}
    frame = em.render_frame(mi.load_dict(described), es.Pose((0, 0, 0.5)), es.EquirectCamera(32, 16), spp=2, aovs="depth,ids")
    assert (np.isfinite(frame["depth"]) == (frame["object_id"] > 0)).all() and frame["object_id"].max() > 3
    # One bounce at most, as its own nested integrator says: light is seen and nothing that it falls on.
    assert (frame["colour"][..., :3].max(-1) > 0).mean() < 0.1


WRAPPERS = {"aov": {"type": "aov", "aovs": "dd:depth,albedo:albedo"}, "moment": {"type": "moment"},
            "ours": {"type": "equirect_aov", "aovs": "all"}}


@pytest.mark.parametrize("kind", list(WRAPPERS))
def test_wrappers_give_way_to_what_renders_colour(em, kind):
    import mitsuba as mi
    content = {"type": "scene", "ball": {"type": "sphere", "center": [0, 0, -3]}, "sky": {"type": "constant"}}
    path = {"type": "path", "max_depth": 3}
    plain, wrapped = (em.render_frame(mi.load_dict(content | {"integrator": integrator}), es.Pose(), es.EquirectCamera(64, 32), spp=2)
                      for integrator in (path, WRAPPERS[kind] | {"nested": path}))
    for plane in ("colour", "depth", "albedo"):
        np.testing.assert_array_equal(wrapped[plane], plain[plane], err_msg=plane)


def test_clipping_distances(em, scene, tmp_path):
    """What is nearer or farther is not there, and makes another sequence."""
    import mitsuba as mi
    balls = mi.load_dict({"type": "scene", "near": {"type": "sphere", "center": [0, 0, -3]}, "far": {"type": "sphere", "center": [0, 0, -9], "radius": 4}})
    camera = es.EquirectCamera(64, 32)
    ahead = {name: em.render_frame(balls, es.Pose(), camera, spp=1, aovs="depth", **clips)["depth"][15, 31]
             for name, clips in (("all", {}), ("near", {"near_clip": 4.5}), ("both", {"near_clip": 4.5, "far_clip": 4.9}))}
    assert abs(ahead["all"] - 2) < 0.05 and abs(ahead["near"] - 5) < 0.05 and np.isinf(ahead["both"])
    assert abs(em.depth_source(balls, near_clip=4.5)(camera, es.Pose())[15, 31] - 5) < 0.05
    path = es.PosePath([(0, es.Pose()), (1, es.Pose((0.1, 0, 0)))])
    em.render_sequence(balls, path, tmp_path, camera, frames=[0], spp=1, near_clip=4.5)
    for fps in (0, float("nan")):
        with pytest.raises(es.InputError, match="frames_per_second: expected a number from 0.001 to 1000"):
            em.render_sequence(balls, path, tmp_path, camera, frames=[0], spp=1, fps=fps)
    with pytest.raises(es.InputError, match="fingerprint"):
        em.render_sequence(balls, path, tmp_path, camera, frames=[0], spp=1, near_clip=4)


def test_rays_begin_in_the_sensors_medium(em):
    import mitsuba as mi
    fog = {"type": "homogeneous", "albedo": 0.0, "sigma_t": 1.0}
    content = {"type": "scene", "integrator": {"type": "volpath"}, "lamp": {"type": "sphere", "radius": 2, "flip_normals": True, "bsdf": {"type": "diffuse"},
               "emitter": {"type": "area", "radiance": 1.0}, "interior": fog}}
    seen = [em.render_frame(mi.load_dict(content | {"sensor": {"type": "perspective"} | medium}), es.Pose(), es.EquirectCamera(16, 8), spp=16)["colour"][..., 1].mean()
            for medium in ({}, {"medium": fog})]
    assert abs(seen[0] - 2) < 0.3 and seen[1] < 0.4 * seen[0]  # walls that give 1 and reflect a half


def test_variants_that_were_not_compiled_are_refused(em, monkeypatch):
    import mitsuba as mi
    assert mi.variant() in em.MITSUBA_VARIANTS
    monkeypatch.setattr(em, "MITSUBA_VARIANTS", ("another", "a_third"))
    with pytest.raises(es.InputError, match=f"of another, a_third, found {mi.variant()}"):
        em.to_world(es.Pose())


def test_motion_of_the_camera(em, scene):
    camera = es.EquirectCamera(128, 64)
    here, before = es.Pose((0.1, 0, 0)), es.Pose((0, 0, 0))
    frame = em.render_frame(scene, here, camera, spp=1, previous=before, aovs="depth,motion")
    depth = frame["depth"]
    hit = np.isfinite(depth)
    centres = np.stack(np.meshgrid(np.arange(128) + 0.5, np.arange(64) + 0.5), -1)
    points = here.position_m + camera.directions() * np.where(hit, depth, 1)[..., None]
    expected = camera.pixels(points - before.position_m) - centres
    np.testing.assert_allclose(frame["backward"][hit], expected[hit], atol=5e-3)
    np.testing.assert_allclose(frame["forward"], 0, atol=1e-3)


def test_bad_arguments(em, scene):
    import mitsuba as mi
    for call in (lambda: em.Renderer("scene", es.EquirectCamera(4, 2)), lambda: em.Renderer(scene, (4, 2)),
                 lambda: em.Renderer(scene, es.EquirectCamera(4, 2), aovs="deep"),
                 lambda: em.render_frame(scene, spp=0), lambda: em.frame_from_tensor(np.zeros((3, 3, 3)), [], es.frame_info(es.EquirectCamera(4, 2))),
                 lambda: em.render_sequence(scene, es.PosePath([(0, es.Pose())]), "x", es.EquirectCamera(4, 2), frames=[])):
        with pytest.raises(es.InputError) as caught:
            call()
        assert "expected" in str(caught.value) and "\n" not in str(caught.value)


def test_missing_and_wrong_mitsuba_are_told(tmp_path):
    """Without the plugins, without mitsuba, and with another version of it."""
    copy = tmp_path / "a" / "equistream"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("plugins"))
    result = python("import equistream.mitsuba", PYTHONPATH=str(copy.parent))
    assert "expected the plugins" in result.stderr.splitlines()[-1]
    fake = tmp_path / "b"
    (fake / "mitsuba").mkdir(parents=True)
    (fake / "mitsuba" / "__init__.py").write_text("__version__ = '3.5.2'")
    result = python("import equistream.mitsuba", PYTHONPATH=f"{fake}:{PACKAGE.parent}")
    assert "expected mitsuba 3.9.1" in result.stderr.splitlines()[-1] and "3.5.2" in result.stderr
    (fake / "mitsuba" / "__init__.py").write_text("raise ImportError('gone')")
    result = python("import equistream.mitsuba", PYTHONPATH=f"{fake}:{PACKAGE.parent}")
    assert "found none (gone)" in result.stderr.splitlines()[-1]
    result = python("import equistream.mitsuba as em; import equistream as es; em.to_world(es.Pose())")
    assert "expected a variant" in result.stderr.splitlines()[-1]


def test_python_md(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = python_md("Mitsuba")
    assert len(blocks) == 1
    exec(compile(blocks[0], "docs/python.md", "exec"), {"es": es, "np": np})
    assert len(list((tmp_path / "cornell" / "centre").glob("*.exr"))) == 2


def test_notebook(tmp_path, monkeypatch):
    file = SOURCE / "client/python/examples/reproject.ipynb"
    assert file.stat().st_size < 150_000
    notebook = json.loads(file.read_text())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{BIN}{os.pathsep}{os.environ['PATH']}")
    outputs, names = run_notebook(notebook)
    assert names["source"] == "cornell.mp4" and (tmp_path / "cornell.mp4").stat().st_size > 10_000
    turned, by_depth = names["found"].values()
    assert abs(turned[0] - by_depth[0]) < 1 and by_depth[0] > 30, names["found"]
    assert min(by_depth) > 25 and turned[-1] < by_depth[-1] - 5, names["found"]
    # What is kept in the file is what a run leaves: as many pictures and lines.
    kept = [cell["outputs"] for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert [[output["output_type"] for output in cell] for cell in kept] == [[output["output_type"] for output in cell] for cell in outputs]
