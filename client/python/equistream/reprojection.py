"""From a sphere to what an eye sees: the client's own engines and fill chain."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any, Iterable, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import DepthNeeds, EquirectCamera, FrameInfo, InputError, PerspectiveCamera, Pose
from .arrays import as_depth, as_plane, as_yuv
from .colour import to_display
from .depth import DepthFunction, ExactDepth, atlas_of, cast, cast_patches
from .frames import Frame
from .streams import FeedFrame, FeedPicture, Picture

AnyPicture = Union[Frame, FeedPicture, Picture]
AnySource = Union[AnyPicture, FeedFrame]

METHODS: tuple[str, ...] = tuple(_core.METHODS)
"""The names that Reprojector takes; docs/guide/play.md says what each is for."""

FILL_PASSES: tuple[str, ...] = _core.FILL_PASSES
"""The passes of the fill chain, in the order in which they are best run."""

DEFAULT_FILL: str = _core.DEFAULT_FILL
"""The default of `play`: the FILL_PASSES that show rendered surfaces, then push-pull (docs/decisions/0004)."""

MIRRORS: tuple[str, ...] = _core.MIRRORS
"""What Reprojector can do with mirrors and glass."""

ORIGINS = ("gap", "source", "small", "neighbours", "earlier", "patches", "hidden", "geometry", "push_pull", "base")
"""Names of the values of EyePicture.origin: where a pixel's colour came from."""

RISKS: tuple[str, ...] = tuple(_core.RISKS)
"""What makes a pixel less reliable, in the order of EyePicture.risks' channels."""

RISK_GROUPS: tuple[str, ...] = tuple(_core.RISK_GROUPS)
"""Names of the values of EyePicture.risk_groups: which weights apply to a pixel's risks."""

RELIABILITY_TOLERANCE = _core.RELIABILITY_TOLERANCE
"""Of 255: a pixel is good if no channel differs from the true eye's by more."""


@dataclass
class EyePicture:
    """What one eye sees."""

    rgba: NDArray[np.uint8]
    """Display-referred sRGB, rows x columns x 4; alpha is 255 where there is colour, all are 0 where nothing is known."""
    origin: NDArray[np.uint8]
    """Where each pixel's colour came from: index into ORIGINS."""
    gaps: NDArray[np.bool_]
    """What the source did not see, and what its mirrors and glass do not show this eye, before any fill."""
    filled: dict[str, int]
    """How many pixels each pass of the fill chain filled."""
    mirrors: dict[str, int]
    """Pixels of mirrors and glass: `kept` as they were (within the error budget), looked up anew `by_image`, kept though `displaced` (by
    less than a degree) for want of an image, and made `gaps`."""
    camera: PerspectiveCamera
    pose: Pose
    depth_m: Optional[NDArray[np.float32]] = field(default=None)
    """The eye's own depth, where the method needed it (+inf for a miss) or found it (NaN in what is still a gap)."""
    reliability: Optional[NDArray[np.uint8]] = field(default=None)
    """Where asked for: 255 times the probability that no channel is off by more than RELIABILITY_TOLERANCE."""
    risks: Optional[NDArray[np.float32]] = field(default=None)
    """Where asked for: what reliability is estimated from, rows x columns x RISKS."""
    risk_groups: Optional[NDArray[np.uint8]] = field(default=None)
    """With `risks`: index into RISK_GROUPS, 255 for gaps."""

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """The colours alone: what `equistream play` writes into a PNG of the same frame, bit for bit."""
        return np.ascontiguousarray(self.rgba[:, :, :3])

    def __repr__(self) -> str:
        return (f"EyePicture({self.camera.width}x{self.camera.height}, {int(self.gaps.sum())} gaps, "
                f"{int((self.origin == 0).sum())} left, {self.pose!r})")


@dataclass
class _View:
    """One picture as the engine takes it."""

    info: FrameInfo
    colours: _core.Colours
    depth_m: Optional[NDArray[np.float32]]
    specular: Optional[NDArray[np.float32]] = None
    virtual_depth_m: Optional[NDArray[np.float32]] = None

    def core(self, with_depth: bool) -> _core.Source:
        source = _core.Source(self.colours, self.info.camera, self.info.camera_pose, self.depth_m if with_depth else None,
                              self.info.box_radius_m)
        if self.specular is not None:
            source.show_mirrors(self.specular, self.virtual_depth_m)
        return source


def _colours(rgb: Any, yuv: Any, where: str, size: tuple[int, int]) -> _core.Colours:
    if rgb is not None:
        return _core.Colours(as_plane(rgb, f"{where}: rgb", np.uint8, 3, size), None)
    return _core.Colours(None, as_yuv(yuv, f"{where}: yuv", size))


def _view(picture: Any, where: str) -> _View:
    yuv = getattr(picture, "yuv", None)
    if isinstance(picture, Frame):
        info: Optional[FrameInfo] = picture.info
        rgb: Any = to_display(picture["colour"], picture.info.exposure) if "colour" in picture else None
        depth: Any = picture.planes.get("depth")
        specular: Any = picture.planes.get("specular")
        virtual_depth: Any = picture.planes.get("virtual_depth")
    elif isinstance(picture, (FeedPicture, Picture)):
        info, rgb, depth = picture.info, picture.rgb, getattr(picture, "depth_m", None)
        specular, virtual_depth = getattr(picture, "specular", None), getattr(picture, "virtual_depth_m", None)
    else:
        raise InputError(f"{where}: expected a Frame, Picture, FeedPicture or FeedFrame, found {type(picture).__name__}")
    if info is None:
        raise InputError(f"{where}: expected a picture tagged with its pose, found ordinary video (open_feed reads it as a sphere)")
    if rgb is None and yuv is None:
        raise InputError(f"{where}: expected a picture with colour, found none")
    size = (info.camera.width, info.camera.height)

    def plane(samples: Any, name: str) -> Optional[NDArray[np.float32]]:
        return None if samples is None else as_plane(samples, f"{where}: {name}", np.float32, 1, size)

    return _View(info, _colours(rgb, yuv, where, size), None if depth is None else as_depth(depth, f"{where}: depth", size),
                 plane(specular, "specular"), plane(virtual_depth, "virtual depth"))


def _measured_loss(source: Any, info: FrameInfo) -> Optional[_core.VisibleLossMeter]:
    if not isinstance(source, Frame) or not {"reference", "reference_repeat"} <= set(source.planes) or info.visible_loss is not None or info.crf is not None:
        return None
    shown, reference, repeat = (to_display(source[name], info.exposure) for name in ("colour", "reference", "reference_repeat"))
    known = np.uint8(255 * (source["reference"][:, :, 3] > 0))
    meter = _core.VisibleLossMeter()
    meter.add_reference(shown, np.dstack([reference, known]), repeat)
    return meter


def _layer(picture: FeedPicture) -> Optional[_core.Source]:
    """A second layer, whose depth is NaN where there is none; nothing where it came without depth."""
    if (picture.rgb is None and picture.yuv is None) or picture.depth_m is None:
        return None
    size = (picture.info.camera.width, picture.info.camera.height)
    return _core.Source(_colours(picture.rgb, picture.yuv, "hidden", size), picture.info.camera, picture.info.camera_pose,
                        as_plane(picture.depth_m, "hidden: depth", np.float32, 1, size), picture.info.box_radius_m)


def _patches(picture: FeedPicture, depth: Optional[DepthFunction], box_radius_m: float) -> Optional[_core.Patches]:
    """The atlas of a frame as passes take it, its depth as it came or cast; nothing where neither can be."""
    if picture.rgb is None and picture.yuv is None:
        return None
    depth_m: Any = picture.depth_m
    if depth_m is None and depth is not None:
        depth_m = cast_patches(depth, picture.info)
    if depth_m is None:
        return None
    atlas = atlas_of(picture.info, "patches")
    size = (atlas.width, atlas.height)
    return _core.Patches(_colours(picture.rgb, picture.yuv, "patches", size),
                         as_plane(depth_m, "patches: depth", np.float32, 1, size), picture.info, box_radius_m)


def _covers_all(info: FrameInfo) -> bool:
    return isinstance(info.camera, EquirectCamera) and info.camera.is_full_sphere


def _looked_at(frame: FeedFrame, pose: Pose) -> FeedPicture:
    """Of a frame with a picture for each eye, the one that was seen from nearer to this eye."""
    if frame.right is None or not frame.posed:
        return frame.main
    return min((frame.main, frame.right), key=lambda picture: np.linalg.norm(np.subtract(picture.info.camera_pose.position_m, pose.position_m)))


class Reprojector:
    """A method and a fill chain, to be used for many frames and eyes.

    `method`: one of METHODS. 'rotation' turns the source only, 'proxy-sphere' moves the eye inside a sphere of one radius; 'eye-depth' moves it
    by the eye's own depth and the source's; 'splat' and 'mesh' need the source's depth alone. `fill`: passes in order, of
    FILL_PASSES, or 'none'; those that have nothing to fill from are passed over ('geometry' always: it needs a ray caster).
    `error_budget_px`: share of an eye's pixel by which engine, mirrors and passes may displace colour. None: 0.25, and 2 for the
    engines 'splat' and 'mesh' alone.
    `mirrors`: pixels of mirrors and glass that would be displaced by more, where the source brings the planes `specular` and
    `virtual_depth`: 'images' looks them up where the image in them lies (where that fails they stay if off by less than a degree, else become
    gaps), 'gaps' makes gaps of all of them, 'surface' leaves them as the engine did. One thread at a time.
    """

    def __init__(self, method: str = "eye-depth", *, fill: str = DEFAULT_FILL, error_budget_px: Optional[float] = None, mirrors: str = "images",
                 reference: Optional[bool] = None) -> None:
        if reference is not None:
            warnings.warn("Reprojector: the argument reference has no effect any more", DeprecationWarning, stacklevel=2)
        if error_budget_px is not None and not 0 < error_budget_px < np.inf:
            raise InputError(f"error_budget_px: expected a number above 0, found {error_budget_px}")
        given, method = method, _core.method_of_today(method)
        if given != method:
            warnings.warn(f"method '{given}' is now called '{method}'", FutureWarning, stacklevel=2)
        self._core = _core.Reprojector(method, fill, error_budget_px, mirrors)
        self.method, self.fill, self.mirrors = method, fill, mirrors

    def needs_depth(self, source: Pose, eye: Pose) -> DepthNeeds:
        """Which depth is needed: that of the `.source`, that of this `.eye`; true if any."""
        return self._core.needs_depth(source, eye)

    def __call__(self, source: AnySource, camera: PerspectiveCamera, pose: Pose, *, depth: Optional[DepthFunction] = None,
                 small: Optional[AnyPicture] = None, earlier: Iterable[AnyPicture] = (),
                 reliability: bool = False, risks: bool = False, depth_tolerance_w: Optional[float] = None) -> EyePicture:
        """What an eye with this camera at this pose sees of `source`.

        `depth(camera, pose)` gives distances where they are needed; without it the depth planes that came with the source are
        used, for exactly the views they belong to. `small` is a second picture for the passes that start with that name (a FeedFrame brings its own, and
        its second layer, patches and the base around a window). Of a FeedFrame with a picture for each eye the one is taken that was seen from nearer
        to this eye; of one that is not posed `main`, so give `frame.right` itself for the right eye. Patches that came without depth are cast by `depth.cast_patches` if
        there is such a method (SceneDepth, `equistream.mitsuba.depth_source`); with a plain function they are left out.
        `earlier` are main pictures of frames before, newest first, with their depth; play keeps one.
        `reliability` and `risks` estimate how far each pixel can be trusted; `depth_tolerance_w` is what depth may be off by, in w;
        unless given, the source's own if its own depth is used, else 0. The visible error of the colours is taken from `source.info`: `visible_loss`, or what
        is usual at its `crf`. A Frame that says neither is measured by its planes `reference` and
        `reference_repeat`, if it has them.
        """
        if not isinstance(camera, PerspectiveCamera):
            raise InputError(f"camera: expected a PerspectiveCamera, found {type(camera).__name__}")
        frame = source if isinstance(source, FeedFrame) else None
        passes = {name.strip() for name in self.fill.split(",")}
        takes_small = not passes.isdisjoint(_core.SMALL_PASSES)
        if small is not None and not takes_small:
            raise InputError(f"small: expected a fill chain with a pass for it, {' or '.join(_core.SMALL_PASSES)}, found '{self.fill}'")
        if frame is not None and takes_small and small is None:
            small = frame.small
        # Without the pass for what lies around a window, the sphere is shown alone.
        around = frame.base if frame is not None else None
        main = _view(source if frame is None else _looked_at(frame, pose) if around is None or "base" in passes else around, "source")
        second = None if small is None else _view(small, "small")
        base = None if around is None or "base" not in passes else _view(around, "base")
        beside = () if frame is None else (frame.main, frame.right, *frame.depth_views)
        own = ExactDepth((v.info.camera, v.info.camera_pose, v.depth_m) for v in (main, base, second, *beside) if v is not None)
        knower = depth if depth is not None else own

        def depth_of(view: _View, where: str, needed: bool) -> Optional[NDArray[np.float32]]:
            if not needed and knower is own:
                found = own.find(view.info.camera, view.info.camera_pose)
                return None if found is None else np.atleast_3d(found)
            return cast(knower, view.info.camera, view.info.camera_pose, where)

        needs = self.needs_depth(main.info.camera_pose, pose)
        # An eye in the very place of a picture that is no whole sphere has gaps too. They are filled by the depth that the other eye
        # needs.
        by_depth = bool(needs) or (not _covers_all(main.info) and bool(self.needs_depth(Pose(), Pose((1, 0, 0)))))
        eye_depth = cast(knower, camera, pose, "the eye's depth") if needs.eye else None
        if needs.source or (by_depth and not needs):
            main.depth_m = depth_of(main, "the source's depth", needs.source)
        if base is not None and by_depth:
            base.depth_m = depth_of(base, "the base's depth", False)
        if second is not None and by_depth and self._core.fill_wants_depth():
            second.depth_m = depth_of(second, "the small view's depth", False)
        patches = None
        if frame is not None and frame.patches is not None and "patches" in passes:
            patches = _patches(frame.patches, depth if by_depth else None, main.info.box_radius_m)
        fill_from = _core.FillFrom(
            None if base is None else base.core(by_depth), None if second is None else second.core(by_depth),
            None if frame is None or frame.hidden is None else _layer(frame.hidden), patches,
            [_view(picture, "earlier").core(True) for picture in earlier])
        if depth_tolerance_w is None:
            depth_tolerance_w = main.info.depth_tolerance_w if depth is None else 0.0
        measured = _measured_loss(source, main.info) if reliability or risks else None
        assess = _core.Assess(reliability, risks, depth_tolerance_w, main.info, measured)
        found = self._core.reproject(main.core(by_depth), fill_from, camera, pose, eye_depth, assess)
        return EyePicture(found["rgba"], found["origin"], found["origin_before_fill"] == 0, found["filled"], found["mirrors"], camera, pose,
                          found["depth_m"] if eye_depth is None else eye_depth[:, :, 0], found["reliability"] if reliability else None,
                          found["risks"] if risks else None, found["risk_groups"] if risks else None)

    def __repr__(self) -> str:
        return f"Reprojector('{self.method}', fill='{self.fill}')"


def reproject(source: AnySource, camera: PerspectiveCamera, pose: Pose, *, depth: Optional[DepthFunction] = None,
              small: Optional[AnyPicture] = None, method: Optional[str] = None, fill: str = DEFAULT_FILL,
              reliability: bool = False) -> EyePicture:
    """What an eye sees of a source, in one call; see Reprojector. `method` is 'eye-depth' where there is depth, else 'rotation'."""
    if method is None:
        picture = source.main if isinstance(source, FeedFrame) else source
        own = picture.planes.get("depth") if isinstance(picture, Frame) else getattr(picture, "depth_m", None)
        method = "eye-depth" if depth is not None or own is not None else "rotation"
    return Reprojector(method, fill=fill)(source, camera, pose, depth=depth, small=small, reliability=reliability)
