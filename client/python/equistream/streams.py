"""Streams, and pictures as a client receives them."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import FrameInfo, InputError

PathLike = Union[str, "os.PathLike[str]"]


@dataclass
class Picture:
    """One decoded picture of a track: 8-bit display-referred sRGB, rows x columns x 3. `info` is None in foreign videos."""

    role: str
    info: Optional[FrameInfo]
    rgb: NDArray[np.uint8]
    decode_ms: float
    convert_ms: float
    bytes: int

    def __repr__(self) -> str:
        return f"Picture({self.role}, {self.rgb.shape[1]}x{self.rgb.shape[0]}, {self.bytes} bytes, {self.info!r})"


class Stream:
    """A stream's pictures, track by track as they come: `for picture in es.open_stream("walk.mp4")`.

    `tracks` says what there is; after the end `truncation` is empty, or says in a line where the stream was cut.
    """

    def __init__(self, source: PathLike) -> None:
        self.source = os.fspath(source)
        self._core = _core.Stream(self.source)

    @property
    def tracks(self) -> list[dict[str, Any]]:
        """role, name, codec, width, height, frames_per_second, pixel_format, colour, equirect; pictures and bytes so far."""
        return self._core.tracks()

    @property
    def container(self) -> str:
        return self._core.container()

    @property
    def truncation(self) -> str:
        return self._core.truncation()

    def __iter__(self) -> Iterator[Picture]:
        return self

    def __next__(self) -> Picture:
        found = self._core.next()
        if found is None:
            raise StopIteration
        return Picture(**found)

    def __repr__(self) -> str:
        tracks = ", ".join(f"{t['role']} {t['codec']} {t['width']}x{t['height']}" for t in self.tracks)
        return f"Stream('{self.source}', {tracks})"


def open_stream(source: PathLike) -> Stream:
    """Opens a file or URL; any ordinary video will do. Ctrl-C ends a wait for a source that is silent."""
    return Stream(source)


@dataclass
class FeedPicture:
    """A picture and where it was seen from. `rgb` is 8-bit sRGB; `depth_m` the renderer's own, where it was asked for."""

    info: FrameInfo
    rgb: Optional[NDArray[np.uint8]]
    depth_m: Optional[NDArray[np.float32]] = None

    def __repr__(self) -> str:
        return f"FeedPicture({self.info!r}, depth: {'yes' if self.depth_m is not None else 'no'})"


@dataclass
class FeedFrame:
    """What arrives for one frame: the main picture, the small second-eye one, and views rendered beside it for their depth.

    `posed` is False for foreign video, which is taken for a full sphere around nobody's head.
    """

    main: FeedPicture
    small: Optional[FeedPicture] = None
    posed: bool = True
    depth_views: list[FeedPicture] = field(default_factory=list)

    def __repr__(self) -> str:
        return f"FeedFrame({self.main!r}, small: {'yes' if self.small else 'no'}, depth views: {len(self.depth_views)})"


class Feed:
    """Frames as a client receives them: of a stream (file or URL), or of a folder of rendered frames as if coded without loss.

    `depth` reads the renderer's depth too (folders). `first_frame` and `last_frame` choose by number; a folder starts there, a
    stream decodes what comes before and leaves it out.
    """

    def __init__(self, source: PathLike, *, depth: bool = False, first_frame: int = 0, last_frame: Optional[int] = None) -> None:
        if first_frame < 0 or (last_frame is not None and last_frame < first_frame):
            raise InputError(f"open_feed: expected frames from 0 on, the last not before the first, found {first_frame} to {last_frame}")
        self.source = os.fspath(source)
        self._core = _core.Feed(self.source, depth, first_frame, 2**63 - 1 if last_frame is None else last_frame)

    @property
    def truncation(self) -> str:
        """After the end: empty, or one line on why there was no more."""
        return self._core.truncation()

    def __iter__(self) -> Iterator[FeedFrame]:
        return self

    def __next__(self) -> FeedFrame:
        found = self._core.next()
        if found is None:
            raise StopIteration
        small = found["small"]
        return FeedFrame(FeedPicture(**found["main"]), None if small is None else FeedPicture(**small), found["posed"],
                         [FeedPicture(**view) for view in found["depth_views"]])

    def __repr__(self) -> str:
        return f"Feed('{self.source}')"


def open_feed(source: PathLike, *, depth: bool = False, first_frame: int = 0, last_frame: Optional[int] = None) -> Feed:
    """Opens a stream, or a folder of rendered frames, as a client would. See Feed."""
    return Feed(source, depth=depth, first_frame=first_frame, last_frame=last_frame)
