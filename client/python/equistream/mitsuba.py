"""A spherical camera and correct AOVs for Mitsuba 3, and its renders as frames.

Importing this makes the plugins `equirect` and `equirect_aov` known to Mitsuba, before or after `mi.set_variant`, for the
variants that they were compiled for (`MITSUBA_VARIANTS`):

>>> import mitsuba as mi
>>> import equistream.mitsuba
>>> mi.set_variant("llvm_ad_rgb")
>>> scene = mi.load_dict({"type": "scene", "sensor": {"type": "equirect"}, "integrator": {"type": "equirect_aov", "aovs": "all", "nested": {"type": "path"}}})

Renderer, render_frame and render_sequence turn a scene, whatever sensor and integrator it has, into frames at our poses.
"""

from __future__ import annotations

import hashlib
import math
import re
from pathlib import Path
from typing import Any, Iterable, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import EquirectCamera, FrameInfo, InputError, PerspectiveCamera, Pose, PosePath, eye_pose
from .build_facts import MITSUBA_VARIANTS, MITSUBA_VERSION
from .cameras import Camera, frame_info
from .depth import SceneDepth
from .frames import AOVS, Frame, PathLike, Sequence, SequenceWriter

PLUGINS = Path(__file__).resolve().parent / "plugins"
"""Where the plugins are: `mitsuba -a` of this folder's parent makes the command line find them too."""

if not MITSUBA_VERSION or not (PLUGINS / "equirect.so").exists():
    raise ImportError("equistream.mitsuba: expected the plugins equirect and equirect_aov in this package, found none: it was built "
                      "where mitsuba's wheel was not; `pip install .` with build isolation fetches it")
try:
    import mitsuba as mi
except ImportError as problem:
    raise ImportError(f"equistream.mitsuba: expected mitsuba {MITSUBA_VERSION} (pip install mitsuba=={MITSUBA_VERSION}), found none ({problem})") from None
if mi.__version__ != MITSUBA_VERSION:
    raise ImportError(f"equistream.mitsuba: expected mitsuba {MITSUBA_VERSION}, which the plugins were built for, found {mi.__version__}")

if str(PLUGINS.parent) not in [str(mi.file_resolver()[i]) for i in range(len(mi.file_resolver()))]:
    mi.file_resolver().append(str(PLUGINS.parent))

_HALF_TURN = np.diag([-1.0, 1.0, -1.0, 1.0])  # Mitsuba's cameras look along +Z with +X to the left

DEFAULT_AOVS = "depth,motion,normal,albedo,ids"


def to_world(pose: Pose) -> Any:
    """A pose as Mitsuba's `to_world`."""
    _require_variant()
    return mi.ScalarTransform4f(pose.matrix @ _HALF_TURN)


def pose_of(to_world: Any) -> Pose:
    """The pose of a Mitsuba `to_world` (of a sensor, say), which may turn and move only."""
    matrix = np.array(getattr(to_world, "matrix", to_world), dtype=np.float64)
    return Pose.from_matrix(matrix.reshape(4, 4, -1)[:, :, 0] @ _HALF_TURN)


def _require_variant() -> None:
    if mi.variant() not in MITSUBA_VARIANTS:
        raise InputError(f"equistream.mitsuba: expected a variant (mi.set_variant) of {', '.join(MITSUBA_VARIANTS)}, found {mi.variant() or 'none'}")


def frame_from_tensor(image: Any, aov_names: Iterable[str], info: FrameInfo) -> Frame:
    """What `mi.render` gave (rows x columns x channels: colour, then `integrator.aov_names()`), as a frame.

    Channels by our names (depth.Z, backward.u, ...) become planes; the first ones colour. Others are left out.
    """
    names = list(aov_names)
    array = np.asarray(image)
    camera = info.camera
    if array.ndim != 3 or array.shape[:2] != (camera.height, camera.width) or array.shape[2] < len(names):
        raise InputError(f"frame_from_tensor: expected {camera.height}x{camera.width}x{len(names)} or more numbers, "
                         f"found {'x'.join(map(str, array.shape))}")
    first = array.shape[2] - len(names)
    frame = Frame(info)
    if first:
        frame.planes["colour"] = _rgba(array[:, :, :first])
    for plane, aov in AOVS.items():
        if plane != "colour" and all(channel in names for channel in aov["channels"]):
            at = [first + names.index(channel) for channel in aov["channels"]]
            samples = array[:, :, at[0]] if len(at) == 1 else array[:, :, at]
            frame.planes[plane] = np.ascontiguousarray(samples, dtype=np.uint32 if aov["is_id"] else np.float32)
    return frame


def _rgba(colour: NDArray[Any]) -> NDArray[np.float32]:
    """Luminance, luminance and alpha, RGB or RGBA."""
    channels = colour.shape[2]
    if channels > 4:
        raise InputError(f"frame_from_tensor: expected 1 to 4 channels of colour, found {channels}")
    rgba = np.ones((*colour.shape[:2], 4), np.float32)
    rgba[:, :, :3] = colour[:, :, :3] if channels >= 3 else colour[:, :, :1]
    if channels in (2, 4):
        rgba[:, :, 3] = colour[:, :, -1]
    return rgba


class Renderer:
    """Renders a scene's frames at our poses, whatever sensor the scene has; made once, it is not compiled again for each frame.

    `camera` is an EquirectCamera or PerspectiveCamera; `integrator` gives colour (default: the scene's own); `aovs` as for
    `equistream render`. `near_clip`, `far_clip`: what is nearer or farther is not seen, in the scene's unit, along the axis
    of a flat view and along the rays of a sphere. Rays begin in the medium of the scene's first sensor. `hide_emitters`: where
    the colour's integrator hides lamps, they are no surfaces either. Colour uses the box filter, as all our hosts. Alpha is
    Mitsuba's: 1 for a sky, too.
    """

    def __init__(self, scene: Any, camera: Camera, *, aovs: str = DEFAULT_AOVS, integrator: Any = None, near_clip: Optional[float] = None,
                 far_clip: Optional[float] = None, sampler: str = "independent", hide_emitters: bool = False) -> None:
        _require_variant()
        if not isinstance(scene, mi.Scene):
            raise InputError(f"Renderer: expected a mitsuba.Scene of variant {mi.variant()}, found {type(scene).__module__}.{type(scene).__name__}")
        if not isinstance(camera, (EquirectCamera, PerspectiveCamera)):
            raise InputError(f"Renderer: expected an EquirectCamera or PerspectiveCamera, found {type(camera).__name__}")
        self.scene, self.camera, self.aovs = scene, camera, aovs
        self.planes = _core.planes_of_groups(aovs)
        nested = integrator if integrator is not None else _colour_of(scene.integrator())
        self.hide_emitters = hide_emitters
        self.integrator = mi.load_dict({"type": "equirect_aov", "aovs": aovs, "hide_emitters": hide_emitters, "nested": nested})
        self.clip = {name: clip for name, clip in (("near_clip", near_clip), ("far_clip", far_clip)) if clip is not None}
        self.sensor = mi.load_dict(self._sensor(sampler))
        self._parameters = (mi.traverse(self.sensor), mi.traverse(self.integrator))
        self._number_shapes()

    def _sensor(self, sampler: str) -> dict[str, Any]:
        camera = self.camera
        own = self.scene.sensors()[0].get_medium() if self.scene.sensors() else None
        sensor: dict[str, Any] = self.clip | ({"medium": own} if own is not None else {}) | {
            "to_world": to_world(Pose()),
            "film": {"type": "hdrfilm", "width": camera.width, "height": camera.height, "pixel_format": "rgba",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": sampler}}
        if isinstance(camera, PerspectiveCamera):
            return sensor | {"type": "perspective", "fov": float(np.degrees(camera.fov_x_rad)), "fov_axis": "x"}
        west, east = np.degrees(camera.longitudes)
        south, north = np.degrees(camera.latitudes)
        return sensor | {"type": "equirect", "longitude_min": float(west), "longitude_max": float(east),
                         "latitude_min": float(south), "latitude_max": float(north)}

    def _number_shapes(self) -> None:
        """Mitsuba gives shapes another order in every process: ids that are to last go by what shapes are."""
        shapes = self.scene.shapes()
        facts = [(_lasting(shape.id()), str(shape)) for shape in shapes]
        ranks = {i: rank + 1 for rank, i in enumerate(sorted(range(len(shapes)), key=facts.__getitem__))}
        tables = {"object_id": [ranks[i] for i in range(len(shapes))]}
        tables["instance_id"] = tables["object_id"]
        if shapes and all(shape.class_name() != "Instance" for shape in shapes):
            materials = [(_lasting(shape.bsdf().id()), str(shape.bsdf())) for shape in shapes]
            known = sorted(set(materials))
            tables["material_id"] = [known.index(material) + 1 for material in materials]
        parameters = self._parameters[1]
        for name, _ in list(parameters):
            if shapes and name.rsplit(".", 1)[-1] in tables:
                parameters[name] = tables[name.rsplit(".", 1)[-1]]
        parameters.update()

    @property
    def host(self) -> str:
        """Name and version of the renderer, as frames hold it."""
        return f"mitsuba {mi.__version__} {mi.variant()}"

    def _place(self, pose: Pose, previous: Pose, following: Pose) -> None:
        sensor, integrator = self._parameters
        neighbours = sensor if isinstance(self.camera, EquirectCamera) else integrator
        prefix = {name.rsplit(".", 1)[-1]: name for name, _ in neighbours}
        for name, value in (("to_world_previous", previous), ("to_world_next", following)):
            neighbours[prefix[name]] = to_world(value)
        sensor[next(name for name, _ in sensor if name.rsplit(".", 1)[-1] == "to_world")] = to_world(pose)
        sensor.update()
        integrator.update()

    def frame(self, pose: Pose, *, previous: Optional[Pose] = None, next: Optional[Pose] = None, spp: int = 16, seed: int = 0,
              info: Optional[FrameInfo] = None) -> Frame:
        """The frame of a camera at `pose` (see eye_pose for a head's eyes); neighbours' poses give motion, none means no movement.

        `info` gives what else the frame is to say of itself (index, time, head, scene, ...). Each index and eye has noise of
        its own, all from `seed`.
        """
        if spp < 1:
            raise InputError(f"spp: expected at least 1, found {spp}")
        self._place(pose, previous if previous is not None else pose, next if next is not None else pose)
        described = frame_info(self.camera, like=info, seed=seed, samples_per_pixel=spp, host=self.host)
        image = mi.render(self.scene, sensor=self.sensor, integrator=self.integrator, spp=spp, seed=_seed_of(described))
        described.camera_pose = pose
        if info is None:
            described.head = pose
        return frame_from_tensor(image, self.integrator.aov_names(), described)

    def __repr__(self) -> str:
        return f"Renderer({self.camera!r}, aovs='{self.aovs}', {mi.variant()})"


def _colour_of(integrator: Any) -> Any:
    """What renders colour: of our own integrator, and of those that add channels to another one's, the nested one."""
    if integrator is None:
        return {"type": "path"}
    if integrator.class_name() not in ("EquirectAovIntegrator", "AOVIntegrator", "MomentIntegrator", "StokesIntegrator"):
        return integrator
    nested: list[Any] = []

    class Nested(mi.TraversalCallback):  # type: ignore[misc]
        def put(self, name: str, value: Any, *_: Any) -> None:
            if isinstance(value, mi.Integrator):
                nested.append(value)

    integrator.traverse(Nested())
    return _colour_of(nested[0]) if nested else integrator


def _lasting(name: str) -> str:
    """What has no name is called by its address."""
    return re.sub(r"object_\d+", "object", name)


def _seed_of(info: FrameInfo) -> int:
    """Frames count up from one number: scalar variants keep the lowest bits of a seed alone, and random ones would meet."""
    words = hashlib.blake2b(f"{info.seed} {info.eye}".encode(), digest_size=4)
    return (int.from_bytes(words.digest(), "little") + info.index) % 2 ** 32


def _shows_lamps(integrator: Any) -> bool:
    """Whether one pixel of a sky is bright: neither Mitsuba's text of an integrator nor its parameters tell."""
    sky = mi.load_dict({"type": "scene", "sky": {"type": "constant"},
                        "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}}}})
    try:
        return bool(np.asarray(mi.render(sky, integrator=integrator, spp=64)).any())
    except Exception:  # noqa: BLE001  a user's own, for which a sky alone is too little
        return True


def _fingerprint(renderer: Renderer, path: PosePath) -> str:
    """Names what decides the pixels besides what frames say of themselves: the plugins, the scene, the integrator, the path."""
    digest = hashlib.blake2b(digest_size=16)
    for plugin in sorted(PLUGINS.glob("*.so")):
        digest.update(plugin.read_bytes())
    digest.update(b"lamps are hidden" if renderer.hide_emitters else b"")
    digest.update(repr(renderer.clip).encode() if renderer.clip else b"")
    facts = []
    integrator = _colour_of(renderer.integrator)
    digest.update(b"" if _shows_lamps(integrator) else b"the colour's lamps are hidden")
    for what in (renderer.scene, integrator):
        facts += [line.encode() for line in str(what).splitlines()]
        for name, value in mi.traverse(what):
            try:
                held = np.ascontiguousarray(getattr(value, "matrix", value)).tobytes()
            except (TypeError, ValueError):
                held = repr(value).encode()
            facts.append(_lasting(name).encode() + hashlib.blake2b(held).digest())
    for fact in sorted(facts):  # Mitsuba gives shapes another order in every process
        digest.update(hashlib.blake2b(fact).digest())
    for time_s, pose in path.keys:
        digest.update(f"{time_s!r} {pose.position_m.tolist()} {pose.orientation.tolist()}".encode())
    return digest.hexdigest()


def render_frame(scene: Any, pose: Optional[Pose] = None, camera: Optional[Camera] = None, *, aovs: str = DEFAULT_AOVS, spp: int = 16,
                 seed: int = 0, integrator: Any = None, previous: Optional[Pose] = None, next: Optional[Pose] = None,
                 info: Optional[FrameInfo] = None, near_clip: Optional[float] = None, far_clip: Optional[float] = None,
                 hide_emitters: bool = False) -> Frame:
    """One frame of a scene: by default a full sphere, 1024x512, where the scene's own sensor stands. Settings as Renderer's."""
    _require_variant()
    if pose is None:
        if not scene.sensors():
            raise InputError("render_frame: expected a pose, or a scene with a sensor, found neither")
        pose = pose_of(scene.sensors()[0].world_transform())
    renderer = Renderer(scene, camera if camera is not None else EquirectCamera(1024, 512), aovs=aovs, integrator=integrator,
                        near_clip=near_clip, far_clip=far_clip, hide_emitters=hide_emitters)
    return renderer.frame(pose, previous=previous, next=next, spp=spp, seed=seed, info=info)


def render_sequence(scene: Any, path: PosePath, folder: PathLike, camera: Camera, *, frames: Iterable[int], fps: float = 30, eye: str = "centre",
                    ipd_m: float = 0.063, lock: str = "world", aovs: str = DEFAULT_AOVS, spp: int = 16, seed: int = 0, name: str = "",
                    integrator: Any = None, exposure: float = 1.0, head_radius_m: float = 0.0, overwrite: bool = False,
                    near_clip: Optional[float] = None, far_clip: Optional[float] = None, hide_emitters: bool = False) -> Sequence:
    """Renders frames along a head's path into a folder (`OUT/centre`, say) that `equistream encode` and `play` take.

    Frame N is at N / fps seconds; at the path's ends a missing neighbour means no movement, whichever frames are asked for.
    Frames that are there are kept if scene, path and settings are those they were made with; else the folder is refused, or
    with `overwrite` emptied. `name` is the scene's; other settings are as Renderer's.
    """
    numbers = sorted(set(frames))
    if not numbers or numbers[0] < 0:
        raise InputError(f"frames: expected frame numbers from 0, found {numbers[:3]}")
    renderer = Renderer(scene, camera, aovs=aovs, integrator=integrator, near_clip=near_clip, far_clip=far_clip, hide_emitters=hide_emitters)

    def camera_pose_at(index: int) -> Pose:
        return eye_pose(camera, path.at(index / fps), eye, ipd_m, lock)

    def described(index: int) -> FrameInfo:
        return frame_info(camera, camera_pose_at(index), index=index, time_s=index / fps, frames_per_second=fps, eye=eye, ipd_m=ipd_m,
                          lock=lock, scene=name, exposure=exposure, head_radius_m=head_radius_m, head=path.at(index / fps), seed=seed,
                          samples_per_pixel=spp, host=renderer.host)

    frame_info(camera, frames_per_second=fps)  # which refuses what is no rate
    last = math.floor(path.duration_s * fps + 1e-6)
    with SequenceWriter(folder, overwrite=overwrite, fingerprint=_fingerprint(renderer, path)) as writer:
        writer.begin(described(numbers[0]), renderer.planes)
        for index in numbers:
            if writer.keeps(index):
                continue
            before, after = max(index - 1, 0), index + 1 if index < last else index
            writer.write(renderer.frame(camera_pose_at(index), previous=camera_pose_at(before), next=camera_pose_at(after), spp=spp, seed=seed,
                                        info=described(index)))
    return Sequence(folder)


def depth_source(scene: Any, *, near_clip: Optional[float] = None, far_clip: Optional[float] = None, hide_emitters: bool = False) -> SceneDepth:
    """Distances by Mitsuba's own rays, of patches too, for `equistream.reproject(..., depth=depth_source(scene))`: no second Embree, no rasteriser.

    Give the same near_clip, far_clip and hide_emitters as when the frames were rendered.
    """
    _require_variant()
    renderers: dict[Camera, Renderer] = {}

    def cast(camera: Camera, pose: Pose) -> NDArray[np.float32]:
        if camera not in renderers:
            renderers[camera] = Renderer(scene, camera, aovs="depth", integrator={"type": "depth"}, near_clip=near_clip, far_clip=far_clip, hide_emitters=hide_emitters)
        return renderers[camera].frame(pose, spp=1)["depth"]

    return SceneDepth(cast)


__all__ = ["DEFAULT_AOVS", "PLUGINS", "Renderer", "depth_source", "frame_from_tensor", "pose_of", "render_frame", "render_sequence", "to_world"]
