"""Motion against rigid transforms in numpy: positions of the same points in two images, written out once more."""

import mitsuba as mi
import numpy as np
import pytest
from conftest import diffuse, film, hit_sphere, planes, pose, scene, sensor, sphere
from independent import (angle_between, equirect_direction, equirect_pixel, perspective_direction, pixel_centres, rotation,
                         unit)

WIDTH, HEIGHT = 128, 64
TURN = rotation([0.97, 0.05, 0.2, -0.1])


def rows(matrix):
    return list(np.asarray(matrix, float)[:3].ravel())


def camera(previous, here, following, **others):
    named = {"to_world_previous": previous, "to_world": here, "to_world_next": following}
    return sensor(WIDTH, HEIGHT, **{name: pose(*placed) for name, placed in named.items() if placed}, **others)


def shortest(u):
    return u - WIDTH * np.floor(u / WIDTH + 0.5)


def expected_motion(points, there):
    """Of world points (or directions, if `there` has no place) from the pixels of an image to another one's."""
    place, turn = there
    local = (points - place if place is not None else points) @ turn
    u, v = equirect_pixel(local, WIDTH, HEIGHT)
    u0, v0 = pixel_centres(WIDTH, HEIGHT)
    return np.stack([shortest(u - u0), v - v0], -1)


def motion(found, name):
    return np.stack([found[f"{name}.u"], found[f"{name}.v"]], -1)


def assert_close(found, expected):
    """Within 2e-3 pixels of great circle, and in columns and rows too, where a pole is not within a pixel."""
    u, v = pixel_centres(WIDTH, HEIGHT)
    a, b = (equirect_direction(u + m[..., 0], v + m[..., 1], WIDTH, HEIGHT) for m in (found, expected))
    assert np.isfinite(found).all()
    assert angle_between(a, b).max() < 2e-3 * 2 * np.pi / WIDTH
    away = np.abs(v + expected[..., 1] - HEIGHT / 2) < HEIGHT / 2 - 1
    off = found - expected
    off[..., 0] = shortest(off[..., 0])
    assert np.abs(off[away]).max() < 5e-3


def directions(turn=np.eye(3)):
    return equirect_direction(*pixel_centres(WIDTH, HEIGHT), WIDTH, HEIGHT) @ turn.T


def test_a_turning_and_moving_camera(variant):
    here, previous, following = ((0.2, 0.1, 0), TURN), ((0, 0, 0.3), np.eye(3)), ((0.5, -0.2, 0.1), TURN @ TURN)
    found = planes(scene({"room": sphere((0.3, 0, 0), 3.0)}, camera(previous, here, following), aovs="motion"))
    d = directions(TURN)
    points = np.array(here[0]) + hit_sphere(here[0], d, [0.3, 0, 0], 3.0)[..., None] * d
    assert_close(motion(found, "backward"), expected_motion(points, previous))
    assert_close(motion(found, "forward"), expected_motion(points, following))
    assert -WIDTH / 2 <= found["backward.u"].min() and found["backward.u"].max() < WIDTH / 2


def test_what_is_infinitely_far_moves_by_turning_only(variant):
    moving = camera(((9, 9, 9), np.eye(3)), ((0, 0, 0), TURN), ((5, 0, 0), TURN))
    found = planes(scene({"sky": {"type": "constant"}}, moving, aovs="motion"))
    assert_close(motion(found, "backward"), expected_motion(directions(TURN), (None, np.eye(3))))
    assert np.abs(motion(found, "forward")).max() < 2e-4


def test_nothing_moves_by_default(variant):
    still = sensor(WIDTH, HEIGHT, to_world=pose((0.1, 0, 0), TURN))
    found = planes(scene({"room": sphere((0.3, 0, 0), 3.0)}, still, aovs="motion"))
    assert np.abs(motion(found, "backward")).max() < 2e-4 and np.abs(motion(found, "forward")).max() < 2e-4


def test_shapes_move_by_their_tables(variant):
    loaded = scene({"room": sphere((0, 0, 0), 5.0), "ball": sphere((0, 0.4, -3), 1.0)}, sensor(WIDTH, HEIGHT), aovs="motion,ids")
    step = np.eye(4)
    step[:3, :3], step[:3, 3] = TURN, [0.3, -0.1, 0.2]
    still = np.eye(4)
    order = [shape.id() for shape in loaded.shapes()]
    params = mi.traverse(loaded)
    for name, matrix in (("moved_previous", np.linalg.inv(step)), ("moved_next", step)):
        params[f"integrator.{name}"] = sum((rows({"ball": matrix}.get(shape, still)) for shape in order), [])
    params.update()
    found = planes(loaded)
    d = directions()
    ball = hit_sphere([0, 0, 0], d, [0, 0.4, -3], 1.0)
    hit = np.isfinite(ball)
    assert (found["object_id"][hit] == order.index("ball") + 1).all()
    points = np.where(hit, ball, 5.0)[..., None] * d
    for name, matrix in (("backward", np.linalg.inv(step)), ("forward", step)):
        moved = np.where(hit[..., None], points @ matrix[:3, :3].T + matrix[:3, 3], points)
        assert_close(motion(found, name), expected_motion(moved, (np.zeros(3), np.eye(3))))
    assert np.abs(motion(found, "forward")[hit]).max() > 2


def test_ods_motion_is_between_the_columns_own_eyes(variant):
    """A point that does not move has none; one that moves lands where a search over all columns finds it again."""
    eye = {"eye": "ods_right", "ipd": 0.2}
    still = planes(scene({"room": sphere((0.3, 0, 0), 3.0)}, sensor(WIDTH, HEIGHT, **eye), aovs="motion"))
    assert np.abs(motion(still, "backward")).max() < 1e-3
    previous = (np.array([0.1, 0.05, -0.2]), TURN)
    loaded = scene({"room": sphere((0.3, 0, 0), 3.0)}, camera(previous, ((0, 0, 0), np.eye(3)), None, **eye), aovs="motion,depth")
    found = planes(loaded)

    def eye_of(longitude, latitude):
        fade = (1 + np.cos(np.pi * np.clip((np.degrees(np.abs(latitude)) - 60) / 15, 0, 1))) / 2
        return (0.1 * fade)[..., None] * np.stack([np.cos(longitude), 0 * longitude, np.sin(longitude)], -1)

    u, v = pixel_centres(WIDTH, HEIGHT)
    longitude, latitude = 2 * np.pi * (u / WIDTH - 0.5), np.pi * (0.5 - v / HEIGHT)
    points = eye_of(longitude, latitude) + found["depth.Z"][..., None] * directions()
    # Where motion says the point was, the ray of that very column must pass through it.
    u1, v1 = u + found["backward.u"], v + found["backward.v"]
    longitude1, latitude1 = 2 * np.pi * (u1 / WIDTH - 0.5), np.pi * (0.5 - v1 / HEIGHT)
    local = (points - previous[0]) @ previous[1]
    off = angle_between(local - eye_of(longitude1, latitude1), equirect_direction(u1, v1, WIDTH, HEIGHT))
    assert off.max() < 2e-3 * 2 * np.pi / WIDTH


def test_perspective_motion_and_what_is_behind(variant):
    width, height, fov = 60, 40, np.radians(80)
    view = {"type": "perspective", "fov": 80.0, "to_world": pose((0, 0, 0)), "film": film(width, height)}
    previous, following = ((0.2, 0.1, 0.4), TURN), ((0, 0, 0), rotation([0, 0, 1, 0]))
    loaded = scene({"room": sphere((0, 0, 0), 3.0)}, view, aovs="motion",
                   to_world_previous=pose(*previous), to_world_next=pose(*following))
    found = planes(loaded)
    u, v = pixel_centres(width, height)
    points = 3 * unit(perspective_direction(u, v, width, height, fov))
    x, y, z = np.moveaxis((points - previous[0]) @ previous[1], -1, 0)
    focal = 0.5 * width / np.tan(0.5 * fov)
    expected = np.stack([width / 2 + focal * x / -z - u, height / 2 + focal * y / z - v], -1)
    assert (z < 0).all()
    assert motion(found, "backward") == pytest.approx(expected, abs=2e-3)
    # The next view looks the other way: everything is behind it, eight diagonals from the middle, in its own direction.
    there = motion(found, "forward") + np.stack([u, v], -1) - [width / 2, height / 2]
    assert np.linalg.norm(there, axis=-1) == pytest.approx(8 * np.hypot(width, height), rel=1e-5)
    x, y, _ = np.moveaxis(points @ following[1], -1, 0)
    assert (there[..., 0] * x >= 0).all() and (there[..., 1] * y <= 0).all()
