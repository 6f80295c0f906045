"""The sensor's rays against tests/programs/independent.py and closed forms."""

import mitsuba as mi
import numpy as np
import pytest
from conftest import diffuse, planes, pose, scene, sensor, sphere
from independent import angle_between, equirect_direction, pixel_centres, rotation

WIDTH, HEIGHT = 64, 32
TURNED = rotation([0.9, 0.1, -0.3, 0.2])


def rays(loaded, u, v, differentials=False):
    """Origins, unit directions and lengths for crop-relative pixel coordinates; each an (n, 3) or (n,) array."""
    size = loaded.film().crop_size()
    u, v = np.ravel(u) / size[0], np.ravel(v) / size[1]
    call = loaded.sample_ray_differential if differentials else loaded.sample_ray
    if mi.variant().startswith("scalar"):
        found = [call(0, 0.5, [a, b], [0.5, 0.5])[0] for a, b in zip(u, v)]
        return found
    ray = call(mi.Float(0), mi.Float(0.5), mi.Point2f(mi.Float(u), mi.Float(v)), mi.Point2f(0.5))[0]
    return ray


def values(found, name):
    if isinstance(found, list):
        return np.array([np.array(getattr(ray, name)) for ray in found], float)
    value = np.array(getattr(found, name), float)
    return value.T if value.ndim == 2 else value


def test_every_pixels_direction_is_the_formula(variant):
    loaded = mi.load_dict(sensor(WIDTH, HEIGHT, to_world=pose((1, 2, 3), TURNED)))
    u, v = pixel_centres(WIDTH, HEIGHT)
    found = rays(loaded, u, v)
    expected = equirect_direction(u.ravel(), v.ravel(), WIDTH, HEIGHT) @ TURNED.T
    assert angle_between(values(found, "d"), expected).max() < 1e-6
    assert np.abs(np.linalg.norm(values(found, "d"), axis=-1) - 1).max() < 1e-6
    assert np.abs(np.broadcast_to(values(found, "o"), expected.shape) - [1, 2, 3]).max() == 0


def test_seam_and_poles(variant):
    loaded = mi.load_dict(sensor(WIDTH, HEIGHT))
    v = np.linspace(0, HEIGHT, 9)
    left, right = (values(rays(loaded, np.full(9, edge), v), "d") for edge in (0.0, WIDTH))
    assert angle_between(left, right).max() < 1e-6
    assert left[4] == pytest.approx([0, 0, 1], abs=1e-6), "the seam is straight behind"
    for row, up in ((0.0, 1), (float(HEIGHT), -1)):
        d = values(rays(loaded, np.linspace(0, WIDTH, 7), np.full(7, row)), "d")
        assert d == pytest.approx(np.tile([0, up, 0], (7, 1)), abs=1e-6)


def test_a_crop_sees_what_the_whole_film_sees(variant):
    crop = {"crop_width": 8, "crop_height": 4, "crop_offset_x": 40, "crop_offset_y": 20}
    loaded = mi.load_dict(sensor(WIDTH, HEIGHT, film_options=crop))
    u, v = pixel_centres(8, 4)
    expected = equirect_direction(u.ravel() + 40, v.ravel() + 20, WIDTH, HEIGHT)
    assert angle_between(values(rays(loaded, u, v), "d"), expected).max() < 1e-6


def test_vr180(variant):
    loaded = mi.load_dict(sensor(32, 32, longitude_min=-90.0, longitude_max=90.0))
    u, v = pixel_centres(32, 32)
    expected = equirect_direction(u.ravel() + 16, v.ravel(), 64, 32)
    assert angle_between(values(rays(loaded, u, v), "d"), expected).max() < 1e-6


def test_differentials_are_a_step_of_one_pixel(variant):
    width, height = 2048, 1024
    loaded = mi.load_dict(sensor(width, height, to_world=pose((0, 0, 0), TURNED)))
    u, v = np.array([3.5, 700.5, 1800.5]), np.array([200.5, 512.5, 900.5])
    found = rays(loaded, u, v, differentials=True)
    pixel = 2 * np.pi / width
    for name, du, dv in (("d_x", 1, 0), ("d_y", 0, 1)):
        expected = equirect_direction(u + du, v + dv, width, height) @ TURNED.T
        assert angle_between(values(found, name), expected).max() < 0.6 * pixel**2 + 1e-6


@pytest.mark.parametrize("eye, side", [("centre", 0), ("left", -1), ("right", 1)])
def test_eyes_stand_beside_the_head(variant, eye, side):
    loaded = mi.load_dict(sensor(8, 4, eye=eye, ipd=0.07, to_world=pose((1, 2, 3), TURNED)))
    o = values(rays(loaded, [3.3], [1.2]), "o").reshape(3)
    assert o == pytest.approx(np.array([1, 2, 3]) + TURNED @ [side * 0.035, 0, 0], abs=1e-6)


def test_clip_distances_bound_the_ray(variant):
    loaded = mi.load_dict(sensor(8, 4, near_clip=0.5, far_clip=3.0))
    found = rays(loaded, [3.5], [1.5])
    assert values(found, "o").reshape(3) == pytest.approx(0.5 * values(found, "d").reshape(3), abs=1e-6)
    assert values(found, "maxt").reshape(-1)[0] == pytest.approx(2.5)


def ods_offsets(eye, longitude, latitude, **options):
    loaded = mi.load_dict(sensor(WIDTH, HEIGHT, eye=eye, ipd=0.07, **options))
    longitude, latitude = np.broadcast_arrays(longitude, latitude)
    found = rays(loaded, (longitude / (2 * np.pi) + 0.5) * WIDTH, (0.5 - latitude / np.pi) * HEIGHT)
    return values(found, "o"), values(found, "d")


def test_ods_eyes_look_tangentially_from_the_viewing_circle(variant):
    longitude = np.linspace(-np.pi, np.pi, 33)
    for eye, side in (("ods_left", -1), ("ods_right", 1)):
        o, d = ods_offsets(eye, longitude, 0.3)
        assert np.linalg.norm(o, axis=-1) == pytest.approx(0.035, abs=1e-7)
        assert np.abs((o * d).sum(-1)).max() < 1e-7, "tangential"
        right_hand = np.cross(d, [0, 1, 0])
        assert ((o * right_hand).sum(-1) * side).min() > 0


def test_ods_disparity_is_the_ipd_at_the_equator_and_nothing_at_the_poles(variant):
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 721)
    left, _ = ods_offsets("ods_left", 0.7, latitude)
    right, _ = ods_offsets("ods_right", 0.7, latitude)
    apart = np.linalg.norm(right - left, axis=-1)
    degrees = np.abs(np.degrees(latitude))
    assert apart[360] == pytest.approx(0.07, abs=1e-7)
    assert apart[degrees < 60] == pytest.approx(0.07, abs=1e-7)
    assert apart[degrees > 75.01] == pytest.approx(0, abs=1e-7)
    t = np.clip((degrees - 60) / 15, 0, 1)
    assert apart == pytest.approx(0.07 * (1 + np.cos(np.pi * t)) / 2, abs=2e-7)
    # Nowhere steeper than its formula at the middle of the fade.
    assert np.abs(np.diff(apart)).max() < 0.07 * (np.pi / 2) * 0.25 / 15 + 1e-6
    never, _ = ods_offsets("ods_right", 0.7, np.radians(89.0), ods_pole="none")
    assert np.linalg.norm(never) == pytest.approx(0.035, abs=1e-7)


def test_solid_angles(variant):
    """A ball's share of the sphere, pixel by pixel, is its closed form 2 pi (1 - cos)."""
    radius, away = 1.0, 2.5
    for direction in ([0.3, 0.2, -0.9], [0.1, 0.99, 0.0], [0.02, -0.3, 0.95]):
        centre = away * np.array(direction) / np.linalg.norm(direction)
        found = planes(scene({"ball": sphere(centre, radius)}, sensor(512, 256), aovs="depth"))
        edges = np.sin(np.pi * (0.5 - np.arange(257) / 256))
        solid = (2 * np.pi / 512) * (edges[:-1] - edges[1:])
        seen = (np.isfinite(found["depth.Z"]) * solid[:, None]).sum()
        assert seen == pytest.approx(2 * np.pi * (1 - np.sqrt(1 - (radius / away) ** 2)), rel=2e-3)


def test_new_parameters_are_taken_up(variant):
    loaded = mi.load_dict(sensor(8, 4))
    params = mi.traverse(loaded)
    params["to_world"] = pose((5, 0, 0))
    params["near_clip"] = 0.25
    params["eye"] = 2
    params.update()
    assert np.array(params["to_world_previous"].matrix).reshape(4, 4)[0, 3] == 5, "a neighbour never given goes along"
    found = rays(loaded, [4.0], [2.0])
    assert values(found, "o").reshape(3) == pytest.approx([5.0315, 0, -0.25], abs=1e-5)
    params["to_world_previous"] = pose((4, 0, 0))
    params.update()
    params["to_world"] = pose((6, 0, 0))
    params.update()
    assert np.array(params["to_world_previous"].matrix).reshape(4, 4)[0, 3] == 4


def test_the_box_around_it_holds_every_origin(variant):
    loaded = mi.load_dict(sensor(8, 4, eye="ods_left", ipd=0.2, to_world=pose((1, 2, 3))))
    box = loaded.bbox()
    assert np.array(box.min) == pytest.approx([0.9, 1.9, 2.9]) and np.array(box.max) == pytest.approx([1.1, 2.1, 3.1])
