"""From scene-referred linear light to what a display shows."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import InputError
from .arrays import as_array, as_plane


class DisplayTransform:
    """The display transform of every equistream program; `view` names a view of the bundled OpenColorIO config."""

    def __init__(self, view: str = "Un-tone-mapped") -> None:
        self._core = _core.DisplayTransform(view)
        self.view = view

    def to_display(self, linear: ArrayLike, exposure: float = 1.0) -> NDArray[np.float32]:
        """Linear Rec.709 radiance (3 or 4 channels) times exposure -> display sRGB in [0, 1], 3 channels."""
        display: Any = self._core.to_display(_picture(linear, "to_display", alpha=True), _exposure(exposure))
        return display

    def to_linear(self, display: ArrayLike, exposure: float = 1.0) -> NDArray[np.float32]:
        """The inverse, for display values in [0, 1]."""
        linear: Any = self._core.to_linear(_picture(display, "to_linear", alpha=False), _exposure(exposure))
        return linear

    def __repr__(self) -> str:
        return f"DisplayTransform('{self.view}')"


def _exposure(exposure: float) -> float:
    if not 0 < exposure < np.inf:
        raise InputError(f"exposure: expected a number above 0, found {exposure}")
    return exposure


def _picture(value: Any, where: str, alpha: bool) -> NDArray[np.float32]:
    array = as_array(value, where)
    channels = 4 if alpha and array.ndim == 3 and array.shape[2] == 4 else 3
    return as_plane(array, where, np.float32, channels)


@lru_cache(maxsize=1)
def default_transform() -> DisplayTransform:
    return DisplayTransform()


def to_display(linear: ArrayLike, exposure: float = 1.0) -> NDArray[np.uint8]:
    """Linear radiance as an 8-bit sRGB picture: what a stream carries and what imshow shows."""
    return quantise_8bit(default_transform().to_display(linear, exposure))


def quantise_8bit(display: ArrayLike) -> NDArray[np.uint8]:
    """floor(255 x + 1/2), clamped; NaN is 0."""
    array = as_array(display, "quantise_8bit")
    channels = array.shape[2] if array.ndim == 3 else 1
    quantised: Any = _core.quantise_8bit(as_plane(array, "quantise_8bit", np.float32, channels))
    return quantised


def false_colour(depth_m: ArrayLike) -> NDArray[np.uint8]:
    """A picture of distances: near warm, far cold, on a log scale; misses black."""
    depth = np.asarray(depth_m, dtype=np.float64)
    hit = np.isfinite(depth) & (depth > 0)
    picture = np.zeros((*depth.shape, 3), np.uint8)
    if hit.any():
        logs = np.log(depth[hit])
        t = (logs - logs.min()) / max(float(np.ptp(logs)), 1e-9)
        colours = np.stack([1 - t, 1 - np.abs(2 * t - 1), t], axis=-1)
        picture[hit] = np.round(255 * np.clip(0.15 + 0.85 * colours, 0, 1)).astype(np.uint8)
    return picture
