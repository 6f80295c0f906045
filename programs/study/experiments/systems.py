"""The paper's experiment, every system: what is rendered, coded and reprojected, for how many bytes and milliseconds, and how near the truth it comes.

A system is a source (a perspective view, a sphere at an eye or at the head's centre, two of them), a way of playing it and what comes along for gaps.
Each is played before coding and through each codec at each of the paper's two qualities. The whole error, PSNR and SSIM are of one seed's views, the
noise-free error takes both (docs/compare.md).
"""

import dataclasses
import os

from baselines import copy_ms, v360_ms
from perceived import FLIP_PICTURES, flip, perceived, pixels_a_degree
from presets import SEEDS
from render_list import EYES

PAPER_FILL = ["--fill", "small,spread"]
OUR_FILL = ["--fill", "small-wide,pushpull"]
NO_FILL = ["--fill", "none"]


@dataclasses.dataclass(frozen=True)
class System:
    name: str
    title: str
    places: tuple
    """Of spheres, one for each eye that has one of its own; empty: perspective views."""
    play: tuple
    depth: str = "scene"
    """Whose the eyes' depth is: the client's scene, the stream's, or none."""
    small: bool = True
    """A small right eye comes along."""
    views: int = 1
    """Perspective ones."""
    in_full: bool = True
    """In every coding; else before coding and in the first alone, or not even in that where a preset has few values of everything."""
    by_default: bool = False
    """Rendered with the tracks that play fills gaps from, coded and played as programs do unless told otherwise."""
    told: bool = False
    """The sphere tells of mirrors and glass (AOVs specular and virtual), where the scene has any."""

    @property
    def is_sphere(self):
        return bool(self.places)


SYSTEMS = (
    System("perspective", "perspective view, right eye reprojected (paper, 1)", (), ("--method", "eye-depth", *PAPER_FILL)),
    System("pair", "both eyes rendered and coded", (), ("--method", "rotation", *NO_FILL), depth="none", small=False, views=2),
    System("sphere-left", "sphere at the left eye (paper, 2)", ("left",), ("--method", "eye-depth", *PAPER_FILL)),
    System("two-spheres", "a sphere at each eye, turned", ("left", "right"), ("--method", "rotation", *NO_FILL), depth="none", small=False),
    System("centre", "sphere at the head's centre, client's geometry", ("centre",), ("--method", "eye-depth", *OUR_FILL)),
    System("centre-told", "centre, client's geometry, mirrors and glass told of", ("centre",), ("--method", "eye-depth", *OUR_FILL), told=True),
    System("default", "centre, client's geometry, as programs do by default", ("centre",), (), by_default=True),
    System("centre-mesh", "centre, streamed depth, mesh", ("centre",), ("--method", "mesh", *OUR_FILL), depth="stream"),
    System("centre-turned", "centre, turned only", ("centre",), ("--method", "rotation", *NO_FILL), depth="none", small=False),
    System("centre-plain-mesh", "centre, plain mesh", ("centre",), ("--method", "mesh-plain", *NO_FILL), depth="stream", small=False, in_full=False),
    System("centre-splat", "centre, splat", ("centre",), ("--method", "splat", *OUR_FILL), depth="stream", in_full=False),
    System("centre-lean", "centre, leaning without depth", ("centre",), ("--method", "proxy-sphere", *NO_FILL), depth="none", small=False, in_full=False),
)


@dataclasses.dataclass(frozen=True)
class Coding:
    codec: str
    crf: int

    @property
    def name(self):
        return f"{self.codec}-crf{self.crf:g}"


def codings(preset, crfs=None):
    """None is no coding; the first of the others is the one that every system goes through."""
    return [None, *(Coding(codec, crf) for codec in preset.codecs for crf in crfs or preset.crfs)]


class Player:
    """Plays systems of one scene, whatever they are made of; `frames` are some of the preset's, for which all is as short. For the heads that sources
    were rendered at, or for those of the path `head`."""

    def __init__(self, work, frames=None, head=None, seeds=SEEDS):
        self.work = work
        self.frames = frames
        self.head = head
        self.seeds = seeds

    def sources(self, system, width, seed):
        """What is played, one folder for each that eyes have of their own."""
        if system.by_default:
            return [self.work.whole_sphere(place, seed) for place in system.places]
        if system.told:
            return [self.work.told_sphere(place, seed) for place in system.places]
        if system.is_sphere:
            return [self.work.sphere(place, width, seed) for place in system.places]
        if system.views == 1:
            return [self.work.perspective(seed)]
        return self.work.pair(seed)

    def encoded(self, system, source, coding, name, timed=False):
        depth = ["--depth", "auto"] if system.depth == "stream" else []
        mirrors = ["--mirrors", "always"] if system.told else []
        tracks = ["--fill", "small" if system.small else "none", "--fill-crf", coding.crf] if system.small else ["--fill", "none"]
        if system.by_default:
            tracks = []
        kind = "default" if system.by_default else ("depth-" if depth else "") + ("small" if system.small else "alone")
        return self.work.encode(f"{name}-{kind}-{coding.name}", source, "--codec", coding.codec, "--crf", coding.crf, *tracks, *depth, *mirrors,
                                *self.chosen_frames(), timed=timed)

    def chosen_frames(self):
        return ["--frames", self.frames] if self.frames else []

    def depth_words(self, system, coding):
        if system.depth == "scene":
            return ["--scene", self.work.description]
        if system.depth == "none":
            return []
        return ["--depth", "exact" if coding is None else "stream"]

    def play(self, system, width, coding, seed, timed=False):
        """Views of both eyes, and what playing each source said."""
        said, views = [], []
        for source in self.sources(system, width, seed):
            label = source.removeprefix("renders/").replace("/", "-") + (f"-{self.frames}" if self.frames else "")
            stream, encoded = (source, None) if coding is None else self.encoded(system, source, coding, label, timed)
            name = "-".join([system.name, label, coding.name if coding else "none", *([self.head.stem] if self.head else [])])
            view, played = self.work.play(name, stream, *system.play, *self.depth_words(system, coding), *(["--head", self.head] if self.head else []),
                                          *(self.chosen_frames() if coding is None else []), timed=timed)
            views.append(view)
            said.append({**played, **({"encoded": encoded} if encoded else {})})
        return self.each_eye_of_its_own(views), said

    def each_eye_of_its_own(self, views):
        """One folder of both eyes: the left of the first, the right of the last."""
        if len(views) == 1:
            return views[0]
        both = self.work.folder / f"{views[0]}-with-{views[1].removeprefix('views/')}"
        both.mkdir(exist_ok=True)
        for eye, view in (("left", views[0]), ("right", views[1])):
            wanted = os.path.relpath(self.work.folder / view / eye, both)  # so that the work folder may be moved or copied
            if not (both / eye).is_symlink() or os.readlink(both / eye) != wanted:
                (both / eye).unlink(missing_ok=True)
                (both / eye).symlink_to(wanted)
        return str(both.relative_to(self.work.folder))

    def play_seeds(self, system, width, coding, timed=False):
        """Views and what was said, a tuple of each: beside each other unless somebody asks how long playing takes."""
        def played(seed):
            return self.play(system, width, coding, seed, timed)

        self.work.description  # a bundled scene is generated before two ask for it
        alone = timed or len(self.seeds) == 1
        return zip(*(map(played, self.seeds) if alone else self.work.steps.side_by_side(played, self.seeds)))

    def score(self, system, width, coding, timed=False):
        """Of all seeds: the noise-free error takes two."""
        views, said = self.play_seeds(system, width, coding, timed)
        name, judge = views[0].removeprefix("views/"), self.work.beside if len(views) > 1 else self.work.wholly
        return {"system": system.name, "width": width if system.is_sphere else None, "codec": coding.codec if coding else None,
                 "crf": coding.crf if coding else None, "n": {"frames": said[0][0]["frames"], "seeds": len(views)}, "views": list(views),
                 **cost(said), **judge(name, views, self.work.truths(), self.frames)}


DECODING = ("decode", "convert")
STAGES = (*DECODING, "depth", "reproject", "fill")


def stage_ms(milliseconds, stage):
    """A frame, both eyes: the mean of decoding, which comes in bursts, and of other stages the median, which leaves out what else the machine did."""
    times = milliseconds.get(stage)
    return times["mean" if stage in DECODING else "p50"] if times else 0.0


def client_ms(sources, stage):
    """Of all sources that a system plays, each for both eyes: where each eye has its own, a client decodes all of them and makes one eye of each."""
    both = sum(stage_ms(milliseconds, stage) for milliseconds in sources)
    return both if stage in DECODING else both / len(sources)


def faster(runs):
    """Of the seeds' runs, each the `milliseconds` of every source."""
    return min(runs, key=lambda sources: sum(client_ms(sources, stage) for stage in STAGES))


def cost(said):
    """Bytes a frame of each track, mean of the seeds, and milliseconds a frame of each stage, of the faster seed's run; sources of a system add up. All times of
    all runs, with their percentiles, stand beside it."""
    runs = [[played["milliseconds"] for played in sources] for sources in said]
    best = faster(runs)
    commands = [[played.get("encoded", {}).get("command"), played["command"]] for played in said[0]]
    found = {"ms": {stage: client_ms(best, stage) for stage in STAGES}, "milliseconds": runs, "commands": [[word for word in pair if word] for pair in commands],
             "gap_fraction": {eye: played["eyes"][eye]["gap_fraction"] for played, eye in zip((said[0][0], said[0][-1]), ("left", "right"))}}
    if "encoded" in said[0][0]:
        tracks = {}
        for sources in said:
            for played in sources:
                for track, count in played["encoded"]["bytes"].items():
                    tracks[track] = tracks.get(track, 0) + count / len(said) / played["frames"]
        found["bytes_a_frame"] = tracks
        found["encode_s_a_frame"] = sum(played["encoded"]["wall_s"] / played["frames"] for played in said[0])
    return found


def baselines(work, player, coding):
    """Of the sphere at the head's centre, by its width."""
    turned = next(system for system in SYSTEMS if system.name == "centre-turned")
    width = work.preset.sphere_width
    source = work.sphere("centre", width, SEEDS[0])
    stream, _ = player.encoded(turned, source, coding, source.removeprefix("renders/"))
    return {"copy": copy_ms(work.preset.eye), "v360": {width: v360_ms(work.folder / stream, work.preset.eye, work.preset.fov_deg)}}


def anaglyph(work, player, coding):
    """The paper's Figure 1: of the sphere at the head's centre, coded."""
    system = next(system for system in SYSTEMS if system.name == "centre")
    source = work.sphere("centre", work.preset.sphere_width, SEEDS[0])
    stream, _ = player.encoded(system, source, coding, source.removeprefix("renders/"))
    view, played = work.play("anaglyph", stream, *system.play, *player.depth_words(system, coding), "--layout", "anaglyph")
    return {"view": view, "command": played["command"]}


def systems_of(work):
    """Those that the scene asks for."""
    return [system for system in SYSTEMS if not system.told or work.tells_of_mirrors("centre")]


def run(work):
    player, preset = Player(work), work.preset
    entries = []
    for system in systems_of(work):
        chosen = codings(preset) if system.in_full else codings(preset)[:2 if preset.every_value else 1]
        entries += [player.score(system, preset.sphere_width, coding, preset.timed) for coding in chosen]
    truths = work.truths()
    seen = work.steps.side_by_side(lambda entry: perceived(work.folder, entry["views"], truths, preset.focal_px), entries)
    for entry, figures in zip(entries, seen):
        entry["perceived"] = figures
    return {"scene_info": work.info, "anaglyph": anaglyph(work, player, codings(preset)[1]), "baselines_ms": baselines(work, player, codings(preset)[1]), "flip_pictures": min(FLIP_PICTURES, preset.frames),
            "flip_pixels_a_degree": pixels_a_degree(preset.focal_px),
            "flip_ceiling": sum(flip(*(work.folder / truth / eye for truth in truths), pixels_a_degree(preset.focal_px)) for eye in EYES) / len(EYES),
            "ceiling": work.compare("ceiling", *truths)["eyes"], "systems": entries,
            "titles": {system.name: system.title for system in SYSTEMS}}
