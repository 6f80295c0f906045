"""`equistream import` of files that Mitsuba's own `aov` integrator wrote: a wall seen from behind, in closed form. Runs the built program and the real wheel."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import mitsuba as mi
from conftest import choose, diffuse, film, pose
from independent import colour_of, equirect_direction, perspective_direction, read_frame, rotation, unit

EQUISTREAM = pathlib.Path(os.environ["EQUISTREAM_BUILD"]) / "bin/equistream"
EYE_M, TURNED = np.array([0.3, 1.5, 0.2]), np.array([0.9, -0.1, 0.25, 0.1])
WALL_Z_M, WALL_HALF_M, NEAR_M, FOV_DEG, ALBEDO = -3, 2, 0.25, 80, (0.2, 0.5, 0.8)
FLAT, SPHERE = (48, 32), (64, 32)


def write_by_mitsuba(kind, file):
    camera = {"type": "equirect"} if kind == "sphere" else {"type": "perspective", "fov": FOV_DEG, "near_clip": NEAR_M}
    # A rectangle's normal is +Z; this one's back is seen.
    wall = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, WALL_Z_M]).rotate([0, 1, 0], 180).scale(WALL_HALF_M),
            "bsdf": {"type": "twosided", "of": diffuse(*ALBEDO)}}
    scene = mi.load_dict({"type": "scene", "sky": {"type": "constant"}, "wall": wall,
                          "integrator": {"type": "aov", "aovs": "depth:depth,normal:sh_normal,albedo:albedo,object_id:shape_index",
                                         "nested": {"type": "path", "max_depth": 3}},
                          "sensor": {**camera, "to_world": pose(EYE_M, rotation(TURNED)), "film": film(*(SPHERE if kind == "sphere" else FLAT)),
                                     "sampler": {"type": "independent", "sample_count": 4}}})
    mi.render(scene, seed=1)
    scene.sensors()[0].film().write(str(file))


def wall_depth(kind):
    """Along the rays through the middles of the nine pixels around each: +inf where they miss."""
    width, height = SPHERE if kind == "sphere" else FLAT
    found = []
    for x, y in np.ndindex(3, 3):
        u, v = np.meshgrid(np.arange(width) + x - 0.5, np.arange(height) + y - 0.5)
        direction = equirect_direction(u, v, width, height) if kind == "sphere" else perspective_direction(u, v, width, height, np.radians(FOV_DEG))
        direction = unit(direction) @ rotation(TURNED).T
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (WALL_Z_M - EYE_M[2]) / direction[..., 2]
            at = EYE_M + depth[..., None] * direction
            found.append(np.where((depth > 0) & (np.abs(at[..., :2]) < WALL_HALF_M).all(axis=-1), depth, np.inf))
    return np.stack(found)


@pytest.mark.parametrize("kind", ["flat", "sphere"])
def test_mitsubas_own_aov_file(kind, tmp_path):
    choose("scalar_rgb")
    write_by_mitsuba(kind, tmp_path / "room.exr")
    (tmp_path / "head.csv").write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + ",".join(map(str, [0, *EYE_M, *unit(TURNED)])) + "\n")
    lens = [] if kind == "sphere" else ["--fov", str(FOV_DEG), "--near", str(NEAR_M)]
    done = subprocess.run([EQUISTREAM, "import", tmp_path / "room.exr", "--path", tmp_path / "head.csv", *lens, "--out", tmp_path / "shot"],
                          capture_output=True, text=True)
    assert done.returncode == 0 and "conventions: mitsuba" in done.stdout, done.stdout + done.stderr
    frame, written = read_frame(tmp_path / "shot/centre/frame.0000.exr"), read_frame(tmp_path / "room.exr")

    expected = wall_depth(kind)
    hit, miss = np.isfinite(expected).all(axis=0), np.isinf(expected).all(axis=0)
    assert hit.sum() > 50 and miss.sum() > 50
    # The film averages samples that lie anywhere in a pixel. The wall is nearest between the rays.
    depth = frame["depth.Z"]
    assert np.isinf(depth[miss]).all()
    assert (depth[hit] >= 0.999 * expected.min(axis=0)[hit]).all() and (depth[hit] <= expected.max(axis=0)[hit]).all()
    assert np.abs(np.mean(depth[hit] / expected[4][hit]) - 1) < 0.003
    normal = np.stack([frame[f"normal.{c}"] for c in "XYZ"], axis=-1)
    assert np.abs(normal[hit] - [0, 0, 1]).max() < 1e-3
    assert np.abs(np.stack([frame[f"albedo.{c}"] for c in "RGB"], axis=-1)[hit] - ALBEDO).max() < 1e-3
    assert len(np.unique(frame["object_id"][hit])) == 1 and frame["object_id"][hit].min() > 0 and (frame["object_id"][miss] == 0).all()
    # Our frames' colour is of halves.
    assert (colour_of(frame) == colour_of(written).astype(np.float16)).all() and (colour_of(frame)[miss] == 1).all() and np.ptp(colour_of(frame)[hit]) > 0.1
