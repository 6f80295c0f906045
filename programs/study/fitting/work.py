"""A scene's folder of `equistream fit`: one that is given by its description, and ways of streaming and playing it."""

import dataclasses
import json
import math
import pathlib
import urllib.parse

import equistream as es
import found
import render_list
from experiments.systems import Coding, Player, System
from found import gap_error
from presets import SEEDS, focal_length_px, matching_width
from scene_work import SceneWork
from steps import Failed, read_json, scene_files

RENDERED = {"small": "", "hidden": "--layers", "patches": "--patches"}
"""Track -> what `render` makes it by; a small eye has words of its own."""
MULTIPLE = 16
"""Of widths, so that small streams, of a quarter of the rows, are whole and even."""
NARROWEST = 256
BASE = 4
"""Times as coarse as its window is a base."""
NARROWEST_BASE = 128
"""Streams have 64 rows at least."""


@dataclasses.dataclass(frozen=True)
class Asked:
    """What is measured with: SceneWork's preset."""
    eye: tuple
    fov_deg: float
    first: int
    last: int
    truth_samples: int
    """A pixel of each of the two truths."""
    max_samples: int
    """A pixel of spheres that are tried."""
    times: float
    """How much wider the widest sphere is than one that matches the eyes."""
    window: tuple = None
    """Degrees across and down that are tried in a coarse sphere; None: no window is."""
    name: str = "fit"
    repeat: int = 1

    def frame_range(self, _scene):
        return self.first, self.last

    def truth_samples_of(self, _scene):
        return self.truth_samples

    @property
    def focal_px(self):
        return focal_length_px(self.eye, self.fov_deg)

    @property
    def matching(self):
        return matching_width(self.eye, self.fov_deg)

    @property
    def matching_width(self):
        """The one of `widths` that is nearest to it."""
        return min(self.widths, key=lambda width: abs(width - self.matching))

    @property
    def widths(self):
        """Half an octave apart, the widest first, down to a quarter of the matching one."""
        last = math.floor(2 * math.log2(4 * self.times) + 0.01)
        widths = [max(1, round(self.matching * self.times / 2 ** (step / 2) / MULTIPLE)) * MULTIPLE for step in range(last + 1)]
        return [width for width in widths if width >= NARROWEST] or [NARROWEST]


def density(width):
    """Columns of a sphere that windows are cut from, as dense as one of that width; `render` takes these multiples."""
    return math.ceil(width / (2 * MULTIPLE)) * 2 * MULTIPLE


def base_width(width):
    """Of the sphere around such a window."""
    return max(NARROWEST_BASE, round(width / BASE / MULTIPLE) * MULTIPLE)


@dataclasses.dataclass(frozen=True)
class Light:
    """How spheres and views are rendered."""
    samples: int
    """A pixel, whatever the width."""
    denoise: str = "off"

    @property
    def name(self):
        return f"{self.samples}spp" + (f"-{self.denoise}" if self.denoise != "off" else "")

    @property
    def title(self):
        return f"{self.samples} sample{'s' if self.samples > 1 else ''} a pixel" + (f", denoised ({self.denoise})" if self.denoise != "off" else "")

    def words(self, options):
        return (*options, *(("--denoise", self.denoise) if self.denoise != "off" else ()))


def named_by_gltf(model):
    """Buffers and images that lie in files of their own, as far as they are there."""
    scene = read_json(model)
    uris = {each["uri"] for key in ("buffers", "images") for each in scene.get(key, ()) if not each.get("uri", "data:").startswith("data:")}
    return [file for uri in sorted(uris) if (file := model.parent / urllib.parse.unquote(uri)).is_file()]


class FitWork(SceneWork):
    def __init__(self, work, programs, description, fingerprint, asked, progress=None):
        """`fingerprint` is what `scene info` says: another scene, or the same changed, is measured in another folder."""
        self.given = description.resolve()
        super().__init__(work, programs, f"{render_list.size_text(asked.eye)}-{asked.fov_deg:g}deg-{asked.first}-{asked.last}-truth{asked.truth_samples}-"
                         f"{fingerprint[:12]}", asked, progress)

    @property
    def description(self):
        return self.given

    def lit(self, name, light, size, eye, options=render_list.DEPTH, **more):
        return self.render(render_list.Render(f"{name}-{light.name}", SEEDS[0], light.samples, size, eye, options=light.words(options), **more))

    def eyes(self, light):
        return self.lit("eyes", light, self.preset.eye, "both", fov_deg=self.preset.fov_deg)

    def light_sphere(self, place, width, light):
        return self.lit(f"sphere-{width}", light, (width, width // 2), place)

    def window(self, way, width):
        """As dense as that sphere, around the gaze."""
        base = base_width(width)
        across, down = way.window
        aovs = render_list.WITH_MIRRORS if way.told else render_list.DEPTH
        return self.lit(f"{'told-' if way.told else ''}window-{across:g}x{down:g}-{width}", way.light, (base, base // 2), "centre",
                        (*aovs, "--window", f"gaze,{across:g}x{down:g}", "--density", density(width)))

    def light_cpu_s(self, width, light):
        """Of rendering that sphere."""
        return json.loads((self.folder / f"steps/render-sphere-{width}-{light.name}.json").read_text())["cpu_s"]

    def tells_of_mirrors(self, place):
        width = self.preset.matching_width
        told = self.render(render_list.geometry("mirrors", place, SEEDS[0], width, False, render_list.WITH_MIRRORS))
        return any(bool(frame["specular"].any()) for frame in es.Sequence(self.folder / told / place, "specular"))

    def told_sphere(self, place, width, light):
        """With what AOVs tell of mirrors and glass."""
        return self.lit(f"told-{width}", light, (width, width // 2), place, render_list.WITH_MIRRORS)

    def with_tracks(self, way, width):
        """With the track that its fill takes; on trial the first frame, with all of them."""
        fill = way.fill
        name = "-".join(["trial" if fill.on_trial else fill.track, *(["told"] if way.told else []), str(width)])
        words = [word for track, word in RENDERED.items() if fill.on_trial or track == fill.track]
        aovs = render_list.WITH_MIRRORS if way.told else render_list.DEPTH
        return self.lit(name, way.light, (width, width // 2), "centre", (*aovs, *(word for word in words if word)), small=fill.on_trial or fill.track == "small",
                        frames=1 if fill.on_trial else 0)

    def wholly(self, name, views, truths, frames=None, eyes=None):
        """The whole error, and in gaps apart."""
        gaps = ["--gaps", f"{views[0]}/gaps"] if (self.folder / views[0] / "gaps").exists() else []
        chosen = ["--frames", frames] if frames else []
        return {"whole": self.compare(name, views[0], truths[0], "--truth2", truths[1], "--metrics", "none", *gaps, *chosen)["eyes"]}

    def scene_bytes(self):
        """Of what a client has of the whole scene: the description, the model and what lies beside it. Of an OBJ those are its images; its materials are few
        bytes.
        """
        description, model = scene_files(self.given)[:2]
        beside = 0
        if model.suffix.lower() == ".gltf":
            beside = sum(file.stat().st_size for file in named_by_gltf(model))
        elif model.suffix.lower() == ".obj":
            beside = self.info["texture_bytes"]
        return description.stat().st_size + model.stat().st_size + beside

    def model(self, error_px):
        """The client's model of this budget: its file, relative, and what `model` said of it."""
        file, step = f"models/{error_px:g}px/{self.given.stem}-model.json", f"model-{error_px:g}px"
        (self.folder / file).parent.mkdir(parents=True, exist_ok=True)
        self.steps.run(step, "model", self.given, "--error-px", error_px, "--focal", f"{self.preset.focal_px:g}", "--json", "--progress", "none", "--out", file)
        return file, json.loads(self.steps.output_of(step))


@dataclasses.dataclass(frozen=True)
class Fill:
    passes: str = "pushpull"
    track: str = ""
    """Sent for them."""
    on_trial: bool = False
    """On the first frame, of a render that has all tracks."""


@dataclasses.dataclass(frozen=True)
class Way(System):
    """A system that says itself how it is coded and played."""
    fill: Fill = Fill()
    light: Light = Light(1)
    depth_share: float = 0
    """Of streamed depth."""
    geometry: tuple = ()
    """The words for where the client's depth is from; else the scene."""
    window: tuple = None
    """Degrees across and down of what is as dense as the width says, around the gaze; None: all of the sphere."""

    @property
    def tracks(self):
        """What `encode` is told."""
        depth = ["--depth", "auto", "--depth-share", f"{self.depth_share:g}"] if self.depth_share else []
        return ["--fill", self.fill.track or "none", *depth, *(["--mirrors", "always"] if self.told else [])]


def sphere(title, fill, told, light, method="eye-depth", **more):
    name = f"{title}-{fill.passes}{'-told' if told else ''}{'-trial' if fill.on_trial else ''}-{light.name}".replace(" ", "-").replace(",", "+")
    return Way(name, f"{title}, {fill.passes}{', mirrors told of' if told else ''}", ("centre",), ("--method", method, "--fill", fill.passes), small=False, fill=fill, told=told, light=light, **more)


def by_scene(fill, told, light):
    return sphere("scene", fill, told, light)


def by_model(fill, told, light, budget_px, file):
    return sphere(f"model {budget_px:g} px", fill, told, light, geometry=("--model", file))


def by_streamed_depth(fill, told, light, share):
    return sphere(f"depth {share:g}", fill, told, light, "mesh", depth="stream", depth_share=share, geometry=("--depth", "stream"))


def windowed(way, window):
    """Pass `base` shows the sphere around it."""
    across, down = window
    fill = dataclasses.replace(way.fill, passes=f"base,{way.fill.passes}")
    place = way.play.index("--fill") + 1
    return dataclasses.replace(way, name=f"{way.name}-window-{across:g}x{down:g}", title=f"window of {across:g}x{down:g} degrees, {way.title}", window=window,
                               fill=fill, play=(*way.play[:place], fill.passes, *way.play[place + 1:]))


def perspective(light):
    return Way(f"perspective-{light.name}", "perspective view", (), ("--method", "eye-depth", "--fill", "pushpull"), small=False, light=light)


def pair(light):
    return Way(f"pair-{light.name}", "view of each eye", (), ("--method", "rotation", "--fill", "none"), depth="none", small=False, views=2, light=light)


@dataclasses.dataclass(frozen=True)
class Point:
    """What one way has at one width and CRF (None: uncoded)."""
    way: Way
    width: int
    crf: int
    db: float
    low: float
    high: float
    bytes: float
    """A frame, all tracks; None uncoded."""
    entry: dict = dataclasses.field(compare=False, repr=False, default=None)


def known(db, frames):
    """The same, or Failed where so many frames have no error to be seen."""
    if db is None:
        raise Failed(f"expected frames whose error is known, found {frames} without, as where all is black; --frames names others, "
                     "--truth-spp takes more samples")
    return db


class Measurer(Player):
    """Scores ways, each point once, and remembers what was tried in order."""

    def __init__(self, work, codec, frames=None):
        super().__init__(work, frames)
        self.codec, self.tried = codec, {}

    def sources(self, system, width, seed):
        if system.fill.track or system.fill.on_trial:
            return [self.work.with_tracks(system, width)]
        if system.window:
            return [self.work.window(system, width)]
        if system.is_sphere:
            made = self.work.told_sphere if system.told else self.work.light_sphere
            return [made(place, width, system.light) for place in system.places]
        eyes = self.work.eyes(system.light)
        return [f"{eyes}/{eye}" for eye in render_list.EYES[:system.views]]

    def play_seeds(self, system, width, coding, timed=False):
        """One render beside two truths."""
        view, said = self.play(system, width, coding, SEEDS[0], timed)
        return [view], [said]

    def encoded(self, system, source, coding, name, timed=False):
        label = "-".join([system.fill.track or "alone", *([f"depth-{system.depth_share:g}"] if system.depth_share else [])])
        return self.work.encode(f"{name}-{label}-{coding.name}", source, "--codec", coding.codec, "--crf", coding.crf, *system.tracks,
                                *self.chosen_frames(), timed=timed)

    def depth_words(self, system, coding):
        return list(system.geometry) or super().depth_words(system, coding)

    def at(self, way, width, crf):
        key = (way.name, width, crf)
        if key not in self.tried:
            entry = self.score(way, width, None if crf is None else Coding(self.codec, crf))
            figures = found.error(entry, kind=found.WHOLE)
            db = known(found.whole_db(entry), entry["n"]["frames"])
            self.tried[key] = Point(way, width, crf, db, figures["db_low"], figures["db_high"], found.all_bytes(entry), entry)
        return self.tried[key]

    @staticmethod
    def gap_error(point):
        return gap_error(point.entry["whole"], "whole")
