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
    """One decoded picture of a track. `info` is None in foreign videos.

    `rgb` is 8-bit display-referred sRGB, rows x columns x 3; of a depth track it is None, and `depth_m` the radial depth. Of an HDR
    stream (`encode --transfer pq`) it is None too, and `pq` has R'G'B' from 0 to 1: BT.2020 primaries, SMPTE ST 2084, white at 203 cd/m2.
    open_feed brings such pictures to an sRGB display.
    """

    role: str
    info: Optional[FrameInfo]
    rgb: Optional[NDArray[np.uint8]]
    pq: Optional[NDArray[np.float32]]
    depth_m: Optional[NDArray[np.float32]]
    decode_ms: float
    convert_ms: float
    bytes: int

    def __repr__(self) -> str:
        plane = next((plane for plane in (self.rgb, self.pq, self.depth_m) if plane is not None), None)
        size = f"{plane.shape[1]}x{plane.shape[0]}" if plane is not None else "no picture"
        return f"Picture({self.role}, {size}, {self.bytes} bytes, {self.info!r})"


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
        found: Any = self._core.next()
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
    """A picture and where it was seen from. `rgb` is 8-bit sRGB; `depth_m` the renderer's own or the depth track's, where asked for.

    So are, of a main picture with mirrors or glass, `specular` (1 there, 0 elsewhere) and `virtual_depth_m`, how far away what they show is.
    """

    info: FrameInfo
    rgb: Optional[NDArray[np.uint8]]
    depth_m: Optional[NDArray[np.float32]] = None
    specular: Optional[NDArray[np.float32]] = None
    virtual_depth_m: Optional[NDArray[np.float32]] = None
    yuv: Optional[tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]] = None
    """In place of `rgb`, where asked for: the decoder's own planes Y', Cb and Cr (BT.709, limited range, 4:2:0), not copied. A
    Reprojector takes them as they are and makes of them the very picture that it makes of their RGB."""

    def __repr__(self) -> str:
        return f"FeedPicture({self.info!r}, depth: {'yes' if self.depth_m is not None else 'no'})"


@dataclass
class FeedFrame:
    """What arrives for one frame: the main picture, those that fill gaps, and views rendered beside it for their depth.

    `right` is the right eye's picture, of video with both eyes in each; `main` is the left one's. `base` is the coarse sphere around `main`, where that is a window; `small` is the second eye, `hidden` the surfaces behind the main picture's, `patches` the atlas of what the head box uncovers.

    `posed` is False for ordinary video: it is read as a full sphere without a pose.
    """

    main: FeedPicture
    small: Optional[FeedPicture] = None
    posed: bool = True
    depth_views: list[FeedPicture] = field(default_factory=list)
    hidden: Optional[FeedPicture] = None
    patches: Optional[FeedPicture] = None
    base: Optional[FeedPicture] = None
    right: Optional[FeedPicture] = None

    def __repr__(self) -> str:
        return f"FeedFrame({self.main!r}, small: {'yes' if self.small else 'no'}, depth views: {len(self.depth_views)})"


class Feed:
    """Frames as a client receives them: of a stream (file or URL), or of a folder of rendered frames as if coded without loss.

    `depth` reads depth too, and mirrors and glass: the renderer's (folders), or their tracks'. `yuv` leaves a stream's pictures in the
    decoder's planes. `first_frame` and `last_frame` choose by number; a folder starts there, a
    stream decodes what comes before and leaves it out.
    """

    def __init__(self, source: PathLike, *, depth: bool = False, yuv: bool = False, first_frame: int = 0,
                 last_frame: Optional[int] = None) -> None:
        if first_frame < 0 or (last_frame is not None and last_frame < first_frame):
            raise InputError(f"open_feed: expected frames from 0 on, the last not before the first, found {first_frame} to {last_frame}")
        self.source = os.fspath(source)
        self._core = _core.Feed(self.source, depth, yuv, first_frame, 2**63 - 1 if last_frame is None else last_frame)

    @property
    def truncation(self) -> str:
        """After the end: empty, or one line on why there was no more."""
        return self._core.truncation()

    def __iter__(self) -> Iterator[FeedFrame]:
        return self

    def __next__(self) -> FeedFrame:
        found: Any = self._core.next()
        if found is None:
            raise StopIteration
        others = {name: None if found[name] is None else FeedPicture(**found[name]) for name in ("right", "base", "small", "hidden", "patches")}
        return FeedFrame(FeedPicture(**found["main"]), posed=found["posed"],
                         depth_views=[FeedPicture(**view) for view in found["depth_views"]], **others)

    def __repr__(self) -> str:
        return f"Feed('{self.source}')"


def open_feed(source: PathLike, *, depth: bool = False, yuv: bool = False, first_frame: int = 0,
              last_frame: Optional[int] = None) -> Feed:
    """Opens a stream, or a folder of rendered frames, as a client would. See Feed."""
    return Feed(source, depth=depth, yuv=yuv, first_frame=first_frame, last_frame=last_frame)
