"""What comes in: anything numpy can read becomes what the compiled module takes, or an InputError says why not."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._core import InputError


def shape_text(shape: tuple[int, ...]) -> str:
    return "x".join(str(side) for side in shape) if shape else "a single number"


def as_array(value: Any, where: str) -> NDArray[Any]:
    """Tensors of other packages come as numpy arrays; a list of lists does too."""
    try:
        array = np.asarray(value)
    except Exception as problem:
        raise InputError(f"{where}: expected an array, found {type(value).__name__} ({problem})") from None
    if array.dtype == object:
        raise InputError(f"{where}: expected an array of numbers, found {type(value).__name__}")
    return array


def as_plane(value: Any, where: str, dtype: Any, channels: int, size: Optional[tuple[int, int]] = None) -> NDArray[Any]:
    """Rows x columns x channels, contiguous, of `dtype`; rows x columns will do for one channel. `size` is (width, height).

    Floats of any precision are taken for float32 and integers that fit for integers; nothing else is converted.
    """
    array = as_array(value, where)
    if array.ndim == 2 and channels == 1:
        array = array[:, :, None]
    wanted = f"{size[1]}x{size[0]}x{channels}" if size else f"rows x columns x {channels}"
    fits = array.ndim == 3 and array.shape[2] == channels and (size is None or array.shape[:2] == (size[1], size[0]))
    if not fits:
        raise InputError(f"{where}: expected {wanted} numbers, found {shape_text(array.shape)}")
    if array.size == 0:
        raise InputError(f"{where}: expected at least one pixel, found {shape_text(array.shape)}")
    return np.ascontiguousarray(converted(array, where, np.dtype(dtype)))


def converted(array: NDArray[Any], where: str, dtype: np.dtype[Any]) -> NDArray[Any]:
    if array.dtype == dtype:
        return array
    if dtype.kind == "f" and array.dtype.kind == "f":
        return array.astype(dtype)
    if dtype.kind == "u" and array.dtype.kind in "iu":
        limits = np.iinfo(dtype)
        if array.min() < 0 or array.max() > limits.max:
            raise InputError(f"{where}: expected whole numbers from 0 to {limits.max}, found {array.min()} to {array.max()}")
        return array.astype(dtype)
    raise InputError(f"{where}: expected {dtype}, found {array.dtype}")


def as_depth(value: Any, where: str, size: tuple[int, int]) -> NDArray[np.float32]:
    depth = as_plane(value, where, np.float32, 1, size)
    if not (depth >= 0).all():  # false for NaN too
        at = np.argwhere(~(depth[:, :, 0] >= 0))[0]
        raise InputError(f"{where}: expected distances in metres, +inf for a miss, found {depth[at[0], at[1], 0]} at pixel {at[1]},{at[0]}")
    return depth


def as_yuv(value: Any, where: str, size: tuple[int, int]) -> tuple[NDArray[np.uint8], ...]:
    """Planes Y', Cb and Cr of a picture of this (width, height), both even; rows of neighbouring samples are not copied."""
    planes = tuple(as_array(plane, where) for plane in value)
    half = (size[0] // 2, size[1] // 2)
    wanted = ((size[1], size[0]), (half[1], half[0]), (half[1], half[0]))
    if size[0] % 2 or size[1] % 2 or tuple(plane.shape for plane in planes) != wanted:
        raise InputError(f"{where}: expected three planes, {', '.join(map(shape_text, wanted))} numbers and their sides even, "
                         f"found {', '.join(shape_text(plane.shape) for plane in planes)}")
    planes = tuple(converted(plane, where, np.dtype(np.uint8)) for plane in planes)
    return tuple(plane if plane.strides[1] == 1 else np.ascontiguousarray(plane) for plane in planes)


def as_points(value: Any, where: str, numbers: int) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Points as rows of float64, and the shape that was given without its last axis."""
    array = as_array(value, where)
    if array.dtype.kind not in "iuf":
        raise InputError(f"{where}: expected real numbers, found {array.dtype}")
    if array.ndim == 0 or array.shape[-1] != numbers:
        raise InputError(f"{where}: expected {numbers} numbers along the last axis, found {shape_text(array.shape)}")
    return np.ascontiguousarray(array.reshape(-1, numbers), dtype=np.float64), array.shape[:-1]
