"""A scene's folder of `equistream fit`: one that is given by its description, and ways of streaming and playing it."""

import dataclasses
import hashlib
import json
import math
import os
import pathlib

import equistream as es
import found
import numpy as np
import render_list
from experiments.systems import Coding, Player, System
from found import decibels, gap_error
from perceived import display, frames_of
from presets import SEEDS, focal_length_px, matching_width
from scene_work import SceneWork

RENDERED = {"small": "", "hidden": "--layers", "patches": "--patches"}
"""Track -> what `render` makes it by; a small eye has words of its own."""
MULTIPLE = 16
"""Of widths, so that small streams, of a quarter of the rows, are whole and even."""
NARROWEST = 256


@dataclasses.dataclass(frozen=True)
class Asked:
    """What is measured with: SceneWork's preset."""
    eye: tuple
    fov_deg: float
    first: int
    last: int
    samples: int
    """A pixel of eyes and of a sphere that matches them."""
    times: float
    """How much wider than that the widest sphere is."""
    name: str = "fit"
    repeat: int = 1

    def frame_range(self, _scene):
        return self.first, self.last

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
        """Half an octave apart, the widest first, down to a quarter of the matching one: every other one is exactly half as wide."""
        last = math.floor(2 * math.log2(4 * self.times) + 0.01)
        unit = MULTIPLE * 2 ** (last // 2)
        rendered = [max(1, round(self.matching * self.times / 2 ** (half / 2) / unit)) * unit for half in (0, 1)]
        widths = [rendered[step % 2] // 2 ** (step // 2) for step in range(last + 1)]
        return [width for width in widths if width >= NARROWEST] or [NARROWEST]

    def rendered_width(self, width):
        """Of the sphere that the one of `width` is filtered from: one of the two widest."""
        return self.widths[self.widths.index(width) % 2]

    def samples_at(self, width):
        """A pixel: every sphere has as many in all as one that matches, or as the widest with one a pixel."""
        widest, rendered = self.widths[0], self.rendered_width(width)
        return max(1, round(self.samples * (self.matching / widest) ** 2)) * (1 if rendered == widest else 2) * (rendered // width) ** 2


def files_of(description):
    """A description and its model, where docs/scenes.md says that it is looked for."""
    model = json.loads(description.read_text())["model"]
    shared = pathlib.Path(os.environ.get("EQUISTREAM_SCENES", description.parent))
    places = (description.parent / model, shared / model, shared / pathlib.Path(model).stem / model)
    return [description, *[place for place in places if place.is_file()][:1]]


def fingerprint(description):
    """Another scene, or the same changed, is measured in another folder."""
    sums = hashlib.sha256()
    for file in files_of(description):
        with open(file, "rb") as content:
            sums.update(hashlib.file_digest(content, "sha256").digest())
    return sums.hexdigest()[:12]


class FitWork(SceneWork):
    def __init__(self, work, programs, description, asked, progress=None):
        self.given = description.resolve()
        super().__init__(work, programs, f"{render_list.size_text(asked.eye)}-{asked.fov_deg:g}deg-{asked.first}-{asked.last}-{asked.samples}spp-{asked.widths[0]}-"
                         f"{fingerprint(description)}", asked, progress)

    @property
    def description(self):
        return self.given

    def truth(self, seed):
        return self.render(render_list.Render(f"truth-{seed}", seed, self.preset.samples, self.preset.eye, "both", fov_deg=self.preset.fov_deg))

    def perspective(self, seed):
        return f"{self.truth(seed)}/left"

    def pair(self, seed):
        return [f"{self.truth(seed)}/{eye}" for eye in render_list.EYES]

    def rendered_sphere(self, place, width, seed):
        return self.render(render_list.Render(f"sphere-{width}-{seed}", seed, self.preset.samples_at(width), (width, width // 2), place))

    def sphere(self, place, width, seed):
        rendered = self.preset.rendered_width(width)
        wide = self.rendered_sphere(place, rendered, seed)
        return wide if width == rendered else self.narrowed(wide, width, seed)

    def told_sphere(self, place, seed, width=None):
        """With what AOVs tell of mirrors and glass; of the width that matches the eyes unless told."""
        width = width or self.preset.matching_width
        return self.with_geometry(self.rendered_sphere(place, self.preset.rendered_width(width), seed), f"told-at-{width}", width, seed, render_list.WITH_MIRRORS)

    def with_tracks(self, way, width, seed):
        """Rendered as wide as it is, with the track that its fill takes; on trial the first frame, with all of them and few samples."""
        fill = way.fill
        name = "-".join(["trial" if fill.on_trial else fill.track, *(["told"] if way.told else []), f"{width}-{seed}"])
        samples = self.preset.samples if fill.on_trial else self.preset.samples_at(width)
        words = [word for track, word in RENDERED.items() if fill.on_trial or track == fill.track]
        aovs = render_list.WITH_MIRRORS if way.told else render_list.DEPTH
        return self.render(render_list.Render(name, seed, samples, (width, width // 2), "centre", small=fill.on_trial or fill.track == "small",
                                              options=(*aovs, *(word for word in words if word)), frames=1 if fill.on_trial else 0))

    def scored(self, name, views, frames=None):
        """Noise-free alone, and in gaps apart."""
        (view, truth), (second, second_truth) = ((view, self.truth(seed)) for view, seed in zip(views, SEEDS))
        gaps = ["--gaps", f"{view}/gaps"] if (self.folder / view / "gaps").exists() else []
        chosen = ["--frames", frames] if frames else []
        return {"noise_free": self.compare(name, view, truth, "--second", second, second_truth, "--metrics", "none", *gaps, *chosen)["eyes"]}

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
    depth_share: float = 0
    """Of streamed depth."""
    geometry: tuple = ()
    """The words for where the client's depth is from; else the scene."""

    @property
    def tracks(self):
        """What `encode` is told."""
        depth = ["--depth", "auto", "--depth-share", f"{self.depth_share:g}"] if self.depth_share else []
        return ["--fill", self.fill.track or "none", *depth, *(["--mirrors", "always"] if self.told else [])]


def sphere(title, fill, told, method="eye-depth", **more):
    name = f"{title}-{fill.passes}{'-told' if told else ''}{'-trial' if fill.on_trial else ''}".replace(" ", "-").replace(",", "+")
    return Way(name, f"{title}, {fill.passes}{', mirrors told of' if told else ''}", ("centre",), ("--method", method, "--fill", fill.passes), small=False, fill=fill, told=told, **more)


def by_scene(fill, told):
    return sphere("scene", fill, told)


def by_model(fill, told, budget_px, file):
    return sphere(f"model {budget_px:g} px", fill, told, geometry=("--model", file))


def by_streamed_depth(fill, told, share):
    return sphere(f"depth {share:g}", fill, told, "mesh", depth="stream", depth_share=share, geometry=("--depth", "stream"))


PERSPECTIVE = Way("perspective", "perspective view", (), ("--method", "eye-depth", "--fill", "pushpull"), small=False)
PAIR = Way("pair", "view of each eye", (), ("--method", "rotation", "--fill", "none"), depth="none", small=False, views=2)


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


def linear(file):
    """A view, undone to light times exposure."""
    return es.DisplayTransform().to_linear(display(file))


class Measurer(Player):
    """Scores ways, each point once, and remembers what was tried in order."""

    def __init__(self, work, codec, frames=None):
        super().__init__(work, frames)
        self.codec, self.tried = codec, {}

    def sources(self, system, width, seed):
        if system.fill.track or system.fill.on_trial:
            return [self.work.with_tracks(system, width, seed)]
        if system.told:
            return [self.work.told_sphere(place, seed, width) for place in system.places]
        return super().sources(system, width, seed)

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
            figures = found.error(entry)
            self.tried[key] = Point(way, width, crf, found.db(entry), figures["db_low"], figures["db_high"], found.all_bytes(entry), entry)
        return self.tried[key]

    @staticmethod
    def gap_error(point):
        return gap_error(point.entry["noise_free"])

    def noise_db(self, way, width):
        """What one render's uncoded views have of it, on linear values as the error is: two renders differ by twice its square."""
        views = [self.work.folder / view for view in self.at(way, width, None).entry["views"]]
        pairs = [pair for eye in render_list.EYES for pair in zip(*(frames_of(view / eye) for view in views), strict=True)]
        return decibels(float(np.mean([np.mean((linear(one) - linear(other)) ** 2) / 2 for one, other in pairs])))
