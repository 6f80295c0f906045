"""Frames: EXR files, and folders of them with a manifest."""

from __future__ import annotations

import copy
import os
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Iterable, Iterator, Mapping, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import FrameInfo, InputError
from .arrays import as_plane

PathLike = Union[str, "os.PathLike[str]"]

AOVS: dict[str, dict[str, Any]] = {row["name"]: row for row in _core.catalogue()}
"""The planes a frame can carry, by name: group, channels, is_id, unit, meaning."""


@dataclass
class Frame:
    """One camera pose and its planes: `frame["depth"]` is a numpy array, `frame.info` says where it was seen from.

    Planes of one channel are rows x columns, others rows x columns x channels; float32, ids uint32. Arrays that were read
    own the memory that the file was decoded into; they may be kept, changed and put into other frames.
    """

    info: FrameInfo
    planes: dict[str, NDArray[Any]] = field(default_factory=dict)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.planes:
            raise KeyError(f"expected a plane of {', '.join(self.planes) or 'none at all'}, found '{name}'")
        return self.planes[name]

    def __setitem__(self, name: str, plane: Any) -> None:
        require_plane_name(name)
        self.planes[name] = plane

    def __contains__(self, name: object) -> bool:
        return name in self.planes

    def __iter__(self) -> Iterator[str]:
        return iter(self.planes)

    def __len__(self) -> int:
        return len(self.planes)

    def keys(self) -> Iterable[str]:
        return self.planes.keys()

    def __repr__(self) -> str:
        return f"Frame({self.info!r}, planes: {', '.join(self.planes) or 'none'})"


def require_plane_name(name: str) -> None:
    if name not in AOVS:
        raise InputError(f"plane: expected one of {', '.join(AOVS)}, found '{name}'")


def plane_names(planes: Union[None, str, Iterable[str]]) -> list[str]:
    names = [] if planes is None else [planes] if isinstance(planes, str) else list(planes)
    for name in names:
        require_plane_name(name)
    return names


def read_frame(file: PathLike, planes: Union[None, str, Iterable[str]] = None) -> Frame:
    """Reads an EXR frame: all its planes, or those named. Another program's file gets a default FrameInfo of its size."""
    info, arrays = _core.read_exr(Path(file), plane_names(planes))
    return Frame(info, arrays)


def read_frame_info(file: PathLike) -> FrameInfo:
    """Reads what a frame says of itself, and no pixels."""
    return _core.read_exr_info(Path(file))


def checked_planes(frame: Frame) -> list[tuple[str, NDArray[Any]]]:
    """In the catalogue's order; a single channel's may be rows x columns."""
    picture = frame.info.patches or frame.info.camera
    for name in frame.planes:
        require_plane_name(name)
    checked = []
    for name, aov in AOVS.items():
        if name in frame.planes:
            dtype = np.uint32 if aov["is_id"] else np.float32
            checked.append((name, as_plane(frame.planes[name], f"plane {name}", dtype, len(aov["channels"]),
                                           (picture.width, picture.height))))
    if not checked:
        raise InputError("frame: expected at least one plane, found none")
    return checked


def write_frame(file: PathLike, frame: Frame, *, single_part: bool = False) -> int:
    """Writes a frame to an EXR file, whole or not at all. Returns how many colour pixels were not finite.

    `single_part` writes one part with depth besides as plain Z, for programs that read only these.
    """
    if not isinstance(frame, Frame):
        raise InputError(f"write_frame: expected a Frame, found {type(frame).__name__}")
    return _core.write_exr(Path(file), frame.info, checked_planes(frame), single_part)


class Sequence:
    """A folder of frames: `len`, `for frame in`, `sequence[i]` by position, `sequence.read(index)` by frame number."""

    def __init__(self, folder: PathLike, planes: Union[None, str, Iterable[str]] = None) -> None:
        self.folder = Path(folder)
        self.indices: list[int] = _core.list_frames(self.folder)
        self._planes = plane_names(planes)
        if not self.indices:
            raise InputError(f"{self.folder}: expected frames (frame.NNNN.exr), found none")

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, position: int) -> Frame:
        return self.read(self.indices[position])

    def __iter__(self) -> Iterator[Frame]:
        return (self.read(index) for index in self.indices)

    def file(self, index: int) -> Path:
        return self.folder / _core.frame_file_name(index)

    def read(self, index: int) -> Frame:
        """The frame with this number."""
        return read_frame(self.file(index), self._planes)

    def info(self, index: Optional[int] = None) -> FrameInfo:
        """What a frame says of itself (the first one's unless a number is given)."""
        return read_frame_info(self.file(self.indices[0] if index is None else index))

    @property
    def manifest(self) -> Mapping[str, Any]:
        """shared (FrameInfo), planes, command, fingerprint."""
        return _core.read_manifest(self.folder)

    def __repr__(self) -> str:
        return f"Sequence('{self.folder}', {len(self)} frames, {self.indices[0]} to {self.indices[-1]})"


class SequenceWriter:
    """Writes frames into a folder that `equistream encode`, `play` and everything else reads.

    The first frame's settings (camera, seed, samples, host, ...) and planes go into the manifest; later frames must share
    them. `writer.keeps(index)` says whether a frame is there already, before time is spent on one; one that is written again
    is replaced. A folder of other frames is refused, or with `overwrite` replaced. `fingerprint` names whatever else decides
    the pixels.

    >>> with es.SequenceWriter("out/centre") as writer:
    ...     writer.write(frame)
    """

    def __init__(self, folder: PathLike, *, overwrite: bool = False, fingerprint: str = "") -> None:
        self.folder = Path(folder)
        self._overwrite = overwrite
        self._fingerprint = fingerprint
        self._writer: Optional[_core.SequenceWriter] = None
        self._shared: Optional[FrameInfo] = None
        self._planes: list[str] = []
        self._closed = False

    def keeps(self, index: int) -> bool:
        """Whether this frame is there and stays. What it was made with, and whether it is whole, is known after `begin` or the first write."""
        if self._writer is not None:
            return self._writer.keeps(index)
        return not self._overwrite and (self.folder / _core.frame_file_name(index)).exists()

    def begin(self, info: FrameInfo, planes: Iterable[str]) -> None:
        """Opens the folder for frames with these settings and planes, before there is one; refuses it if it holds others."""
        if self._closed:
            raise InputError(f"{self.folder}: expected an open SequenceWriter, found one that was closed")
        if self._writer is None:
            names = plane_names(planes)
            names = [name for name in AOVS if name in names]
            self._writer = _core.SequenceWriter(self.folder, info, names, self._overwrite, self._fingerprint)
            self._shared, self._planes = copy.copy(info), names

    def write(self, frame: Frame) -> None:
        planes = checked_planes(frame)
        names = [name for name, _ in planes]
        self.begin(frame.info, names)
        assert self._writer is not None
        assert self._shared is not None
        for what, before, now in (("planes", self._planes, names), *(
                (name, getattr(self._shared, name), getattr(frame.info, name)) for name in _shared_fields)):
            if before != now:
                raise InputError(f"{self.folder}: frame {frame.info.index}: expected {what} {before} as in the frames before it, found {now}")
        self._writer.write(frame.info, planes)

    def close(self) -> None:
        """Releases the folder for other writers."""
        if self._writer is not None:
            self._writer.close()
        self._closed = True

    def __enter__(self) -> "SequenceWriter":
        return self

    def __exit__(self, kind: Optional[type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"SequenceWriter('{self.folder}'{', closed' if self._closed else ''})"


_shared_fields = ("camera", "frames_per_second", "eye", "ipd_m", "lock", "head_radius_m", "exposure", "seed", "samples_per_pixel",
                  "scene", "host", "geometry_fingerprint", "denoiser")
