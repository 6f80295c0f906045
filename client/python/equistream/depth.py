"""Depth functions: distances from code that knows the scene, for cameras and for patches that a stream sends without depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterable, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import FrameInfo, InputError, PatchAtlas, Pose
from .arrays import as_depth
from .cameras import Camera

DepthFunction = Callable[[Camera, Pose], ArrayLike]
"""Gives the distance in metres from a camera at a pose to what each pixel-centre ray hits, +inf for a miss.

One with a method `cast_patches(info)` also gives the distances of an atlas of patches, rows x columns of `info.patches`: SceneDepth, or an
object of your own that casts `patch_rays(info)`. Unused pixels may have any value that is a distance.
"""


@dataclass
class PatchRays:
    """The rays that an atlas of patches shows, in the world."""

    origins_m: NDArray[np.float64]
    """Where they begin, rows x columns x 3."""
    directions: NDArray[np.float64]
    """Unit, rows x columns x 3."""
    used: NDArray[np.bool_]
    """Which pixels are used; the rays of the others mean nothing."""


def atlas_of(info: FrameInfo, where: str) -> PatchAtlas:
    if info.patches is None:
        raise InputError(f"{where}: expected a picture of patches (`FeedFrame.patches`), found {info!r}")
    return info.patches


def patch_rays(info: FrameInfo) -> PatchRays:
    """Of the picture with this info, `frame.patches.info` of a FeedFrame: what a ray caster's `cast_patches` has to cast."""
    atlas = atlas_of(info, "patch_rays")
    samples = atlas.samples()
    sphere, pixels = samples[:, :, 0], samples[:, :, 1:]
    origins = info.camera_pose.position_m + info.camera_pose.to_world(atlas.offsets_m)
    return PatchRays(origins[np.maximum(sphere, 0)], info.camera_pose.to_world(atlas.sphere.directions(pixels + 0.5)), sphere >= 0)


class SceneDepth:
    """A depth function that answers for any camera anywhere in the scene, and so for patches too.

    `SceneDepth(depth)` wraps a plain depth function. For patches it calls that for a whole sphere at each position of the atlas.
    """

    def __init__(self, depth: DepthFunction) -> None:
        self._depth = depth

    def __call__(self, camera: Camera, pose: Pose) -> ArrayLike:
        return self._depth(camera, pose)

    def cast_patches(self, info: FrameInfo) -> NDArray[np.float32]:
        """Distances of an atlas, rows x columns; +inf in unused pixels."""
        atlas = atlas_of(info, "cast_patches")
        sphere = atlas.sphere
        number, column, row = np.moveaxis(atlas.samples(), 2, 0)
        # Borders of the last blocks lie beyond the sphere's grid: no eye looks there.
        number = np.where((column < sphere.width) & (row < sphere.height), number, -1)
        depth = np.full(number.shape, np.inf, np.float32)
        for index, offset_m in enumerate(info.camera_pose.to_world(atlas.offsets_m)):
            here = number == index
            if here.any():
                pose = Pose((info.camera_pose.position_m + offset_m).tolist(), info.camera_pose.orientation.tolist())
                depth[here] = cast(self._depth, sphere, pose, "the patches' depth")[row[here], column[here], 0]
        return depth


class ExactDepth:
    """Depth planes that came with pictures, each for exactly its own view."""

    def __init__(self, planes: Iterable[tuple[Camera, Pose, Optional[NDArray[np.float32]]]]) -> None:
        self._planes = list(planes)

    def find(self, camera: Camera, pose: Pose) -> Optional[NDArray[np.float32]]:
        for plane_camera, plane_pose, depth_m in self._planes:
            if depth_m is not None and plane_camera == camera and plane_pose == pose:
                return depth_m
        return None

    def __call__(self, camera: Camera, pose: Pose) -> NDArray[np.float32]:
        depth_m = self.find(camera, pose)
        if depth_m is None:
            raise InputError(f"depth: expected a rendered depth plane of exactly this view ({camera!r} at {pose!r}), or depth=FUNCTION, found neither")
        return depth_m


def cast(depth: DepthFunction, camera: Camera, pose: Pose, where: str) -> NDArray[np.float32]:
    """Rows x columns x 1, checked."""
    return as_depth(depth(camera, pose), where, (camera.width, camera.height))


def cast_patches(depth: DepthFunction, info: FrameInfo) -> Optional[NDArray[np.float32]]:
    """The same of an atlas; nothing where the function knows no more than cameras."""
    caster = getattr(depth, "cast_patches", None)
    if caster is None:
        return None
    atlas = atlas_of(info, "patches")
    return as_depth(caster(info), "the patches' depth", (atlas.width, atlas.height))
