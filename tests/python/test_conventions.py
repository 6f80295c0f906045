"""Directions and pixels against numpy from the documentation; poses; hostile arguments."""

import copy

import equistream as es
import independent
import numpy as np
import pytest


def test_equirect_directions_and_back():
    camera = es.EquirectCamera(64, 32)
    u, v = independent.pixel_centres(64, 32)
    expected = independent.equirect_direction(u, v, 64, 32)
    np.testing.assert_allclose(camera.directions(), expected, atol=1e-15)
    np.testing.assert_allclose(camera.pixels(expected), np.stack([u, v], -1), atol=1e-11)
    assert camera.directions([10.5, 3.0]).shape == (3,)
    np.testing.assert_allclose(camera.directions([[32.0, 16.0]]), [[0, 0, -1]], atol=1e-15)
    assert camera.pixel_angle_rad() == pytest.approx(2 * np.pi / 64, rel=1e-12)


def test_perspective_directions_and_back():
    camera = es.PerspectiveCamera(40, 30, np.radians(70))
    u, v = independent.pixel_centres(40, 30)
    expected = independent.unit(independent.perspective_direction(u, v, 40, 30, np.radians(70)))
    np.testing.assert_allclose(camera.directions(), expected, atol=1e-15)
    np.testing.assert_allclose(camera.pixels(expected * 7), np.stack([u, v], -1), atol=1e-11)
    assert np.isnan(camera.pixels([0, 0, 1.0])).all()
    focal_px = 20 / np.tan(np.radians(35))
    assert (camera.focal_px(), camera.pixel_angle_rad()) == pytest.approx((focal_px, 1 / focal_px), rel=1e-12)


def test_partial_range():
    camera = es.EquirectCamera(20, 10, longitudes=(-1, 1), latitudes=(-0.5, 0.5))
    assert not camera.is_full_sphere and es.EquirectCamera(20, 10).is_full_sphere
    np.testing.assert_allclose(camera.pixels(camera.directions([3.25, 4.5])), [3.25, 4.5], atol=1e-12)
    assert camera == es.EquirectCamera(20, 10, (-1, 1), (-0.5, 0.5)) and camera != es.EquirectCamera(20, 10)
    assert "longitudes" in repr(camera)


def test_poses():
    half = np.sqrt(0.5)
    pose = es.Pose((1, 2, 3), (half, 0, half, 0))  # a quarter turn to the left about +Y
    np.testing.assert_allclose(pose.to_world([0, 0, -1]), [-1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(pose.to_camera(pose.to_world([[0.1, 0.2, 0.3]])), [[0.1, 0.2, 0.3]], atol=1e-15)
    np.testing.assert_allclose(pose.matrix @ [0, 0, -1, 1], [0, 2, 3, 1], atol=1e-15)
    assert es.Pose.from_matrix(pose.matrix) == pose and es.Pose() != pose and pose != None  # noqa: E711
    looking = es.Pose.look_at((0, 1, 5), (0, 1, 0))
    assert looking == es.Pose((0, 1, 5))
    with pytest.raises(ValueError):
        pose.position_m[0] = 4
    with pytest.raises(AttributeError):
        pose.position_m = (0, 0, 0)
    assert copy.copy(es.FrameInfo()).index == 0
    eye = es.eye_pose(es.PerspectiveCamera(4, 4), pose, "right", 0.064)
    np.testing.assert_allclose(eye.position_m, [1, 2, 3 - 0.032], atol=1e-12)


def test_paths(tmp_path):
    file = tmp_path / "head.csv"
    path = es.PosePath([(0, es.Pose()), (2, es.Pose((4, 0, 0)))])
    path.write(file)
    read = es.PosePath.read(file)
    assert len(read) == 2 and read.duration_s == 2
    np.testing.assert_allclose(read.at(1).position_m, [2, 0, 0])
    file.write_text("1,2\n")
    with pytest.raises(es.InputError, match="head.csv"):
        es.PosePath.read(file)


@pytest.mark.parametrize("make", [
    lambda: es.EquirectCamera(0, 5), lambda: es.EquirectCamera(10, 5, longitudes=(1, -1)), lambda: es.EquirectCamera(1 << 20, 1),
    lambda: es.EquirectCamera(10, 5, latitudes=(0, 2)), lambda: es.PerspectiveCamera(10, 5, float("nan")), lambda: es.PerspectiveCamera(10, 5, 4),
    lambda: es.Pose((0, 0, float("nan"))), lambda: es.Pose((0, 0, 0), (2, 0, 0, 0)), lambda: es.Pose.from_matrix(np.eye(3)),
    lambda: es.Pose.from_matrix(np.diag([1, 1, -1, 1.0])), lambda: es.Pose.from_matrix(2 * np.eye(4)), lambda: es.Pose.from_matrix(np.full((4, 4), np.nan)),
    lambda: es.Pose.look_at((0, 0, 0), (0, 0, 0)), lambda: es.Pose.look_at((0, 0, 0), (0, 1, 0)),
    lambda: es.EquirectCamera(4, 2).directions([1, 2, 3]), lambda: es.EquirectCamera(4, 2).directions(["a", "b"]),
    lambda: es.EquirectCamera(4, 2).pixels(3.0), lambda: es.frame_info(es.EquirectCamera(4, 2), eye="middle"),
    lambda: es.frame_info(es.EquirectCamera(4, 2), moving=[]), lambda: es.frame_info(es.EquirectCamera(4, 2), packing="sbs"),
    lambda: es.frame_info(es.EquirectCamera(4, 2), index=-1), lambda: es.frame_info(es.EquirectCamera(4, 2), exposure=0),
    lambda: es.frame_info(es.EquirectCamera(4, 2), scene="x" * 300), lambda: es.frame_info(es.EquirectCamera(4, 2), colour="red"),
    lambda: es.PosePath([]), lambda: es.PosePath([(1, es.Pose()), (0, es.Pose())]), lambda: es.to_display(np.zeros((4, 4, 3)), exposure=-1),
    lambda: es.to_display(np.zeros((4, 4, 7))), lambda: es.quantise_8bit(np.zeros((0, 4, 3), np.float32)), lambda: es.DisplayTransform("nonsense")])
def test_bad_arguments_are_told_in_one_line(make):
    with pytest.raises(es.InputError) as caught:
        make()
    assert "expected" in str(caught.value) and "\n" not in str(caught.value)


def test_display_transform():
    linear = np.linspace(0, 1.2, 60, dtype=np.float32).reshape(5, 4, 3)
    np.testing.assert_array_less(np.abs(es.to_display(linear).astype(int) - independent.bytes_of(independent.srgb(linear)).astype(int)), 2)
    transform = es.DisplayTransform()
    display = transform.to_display(linear * 0.5, 1.5)
    np.testing.assert_allclose(transform.to_linear(display, 1.5), np.minimum(linear * 0.5, 1 / 1.5), atol=2e-5)


def test_false_colours_are_warm_near_and_cold_far():
    """On a log scale: 2 is half way from 1 to 4; 0.15 + 0.85 of the pure colour, of 255."""
    expected = [[[255, 38, 38], [147, 255, 147], [38, 38, 255], [0, 0, 0]]]
    np.testing.assert_array_equal(es.false_colour([[1, 2, 4, np.inf]]), expected)
