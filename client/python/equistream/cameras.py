"""Poses, cameras and what a frame says of itself. Formulas are compiled from the C++ library's one header of conventions."""

from __future__ import annotations

import copy as copy_module
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import EquirectCamera, FrameInfo, InputError, PerspectiveCamera, Pose, eye_pose
from .arrays import as_array, as_points

__all__ = ["Camera", "EquirectCamera", "FrameInfo", "PerspectiveCamera", "Pose", "eye_pose", "frame_info"]

Camera = Union[EquirectCamera, PerspectiveCamera]


def _directions(self: Any, pixels: Optional[ArrayLike] = None) -> NDArray[np.float64]:
    """Unit directions in the camera's frame of pixel coordinates (..., 2); without any, of all pixel centres (rows, columns, 3)."""
    if pixels is None:
        u, v = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        pixels = np.stack([u, v], axis=-1)
    points, shape = as_points(pixels, "directions: pixels", 2)
    return self._directions(points).reshape(*shape, 3)


def _pixels(self: Any, directions: ArrayLike) -> NDArray[np.float64]:
    """Pixel coordinates (..., 2) of directions (..., 3) in the camera's frame, which need not be unit. NaN behind a perspective view."""
    points, shape = as_points(directions, "pixels: directions", 3)
    return self._pixels(points).reshape(*shape, 2)


def _size(self: Any) -> tuple[int, int]:
    """(width, height)"""
    return self.width, self.height


# _core.patterns tells type checkers of what follows.
for _camera in (EquirectCamera, PerspectiveCamera):
    setattr(_camera, "directions", _directions)
    setattr(_camera, "pixels", _pixels)
    setattr(_camera, "size", property(_size))


def _matrix(self: Pose) -> NDArray[np.float64]:
    """4x4 world from camera."""
    matrix = np.eye(4)
    matrix[:3, :3] = self._rotation()
    matrix[:3, 3] = self.position_m
    return matrix


def _from_matrix(matrix: ArrayLike) -> Pose:
    """The pose of a 4x4 (or 3x4) world-from-camera matrix, which may turn and move but neither scale nor mirror."""
    array = as_array(matrix, "Pose.from_matrix")
    if array.shape not in ((4, 4), (3, 4)) or array.dtype.kind not in "iuf":
        raise InputError(f"Pose.from_matrix: expected 4x4 numbers, found {array.shape} of {array.dtype}")
    if array.shape == (4, 4) and not np.allclose(array[3], [0, 0, 0, 1], atol=1e-6):
        raise InputError(f"Pose.from_matrix: expected a last row 0 0 0 1, found {array[3].tolist()}")
    rows = array[:3, :3].astype(np.float64)
    if not np.isfinite(array).all():
        raise InputError("Pose.from_matrix: expected finite numbers, found NaN or infinity")
    return Pose._from_rotation(array[:3, 3].astype(np.float64).tolist(), rows.tolist())


def _look_at(origin: ArrayLike, target: ArrayLike, up: ArrayLike = (0, 1, 0)) -> Pose:
    """At `origin`, looking at `target`, with `up` upwards in the image."""
    eye, aim, top = (np.asarray(v, dtype=np.float64).reshape(3) for v in (origin, target, up))
    back = eye - aim
    right = np.cross(top, back)
    if not np.linalg.norm(right) > 1e-12 * max(float(np.linalg.norm(top) * np.linalg.norm(back)), 1e-300):
        raise InputError("Pose.look_at: expected a target away from the origin and up not along the view, found neither")
    back, right = back / np.linalg.norm(back), right / np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, eye
    return _from_matrix(matrix)


def _to_world(self: Pose, directions: ArrayLike) -> NDArray[np.float64]:
    """Directions (..., 3) in the camera's frame, turned into the world's."""
    points, shape = as_points(directions, "Pose.to_world", 3)
    return (points @ np.asarray(self._rotation()).T).reshape(*shape, 3)


def _to_camera(self: Pose, directions: ArrayLike) -> NDArray[np.float64]:
    """Directions (..., 3) in the world, turned into the camera's frame."""
    points, shape = as_points(directions, "Pose.to_camera", 3)
    return (points @ np.asarray(self._rotation())).reshape(*shape, 3)


setattr(Pose, "matrix", property(_matrix))
setattr(Pose, "from_matrix", staticmethod(_from_matrix))
setattr(Pose, "look_at", staticmethod(_look_at))
setattr(Pose, "to_world", _to_world)
setattr(Pose, "to_camera", _to_camera)


def frame_info(camera: Camera, pose: Optional[Pose] = None, like: Optional[FrameInfo] = None, **fields: Any) -> FrameInfo:
    """A FrameInfo for a camera at a pose, with any of its other fields by keyword; `head` is the pose's place unless given.

    `like` gives the fields that are not named, instead of the defaults.
    """
    info = copy_module.copy(like) if like is not None else FrameInfo()
    info.camera = camera
    if pose is not None:
        info.camera_pose = pose
        info.head = pose
    for name, value in fields.items():
        try:
            if not hasattr(FrameInfo, name) or name == "camera" or name.startswith("_"):
                raise AttributeError
            setattr(info, name, value)
        except AttributeError:  # of those that follow from others too
            raise InputError(f"frame_info: expected a field of FrameInfo, found '{name}'") from None
    return info
