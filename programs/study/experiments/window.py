"""Only what is looked at: a dense window within a coarse sphere, beside all else that as many bytes can be.

Every source has depth of its own and is played by `mesh`, as one without the scene's geometry is; the pair of rendered eyes has none. At rest all frames count,
coded at each CRF; heads that have turned or moved since the source was rendered see one frame of it, coded at HEADS_CRF. Heads of some time later see it too:
late by a delay, or when nothing has come since. Nothing in the scene moves meanwhile.
"""

import dataclasses
import json
import math
import subprocess

import equistream as es
import render_list
from presets import SEEDS
from render_list import EYES, moved_eyes
from steps import Failed, read_json

from .moved import Head, path_file, path_of, told_of
from .related_streams import in_turns
from .related_video import coded, file_of, indices, mean_bytes, rgb, shown, write

CRFS, HEADS_CRF = (20, 24, 28, 32), 24
HEADS = (*(Head(f"turned-{degrees}", degrees, 0) for degrees in (5, 10, 20, 40)), Head("leaned", 0, 0.05), Head("leaned-far", 0, 0.1))
LATER_S = (0, 0.1, 0.2, 0.4, 1, 2, 4)
"""By how much what is seen is late: delays, then ends of silences."""
SWING_DEG, SWING_S = 60, 1
"""To either side, as a sine of time: it begins in the middle, at SWING_DEG / SWING_S degrees a second, which is the fastest."""
JUMP_DEG = 90
PAIR = "pair"


@dataclasses.dataclass(frozen=True)
class Later:
    """The head that the source was rendered for, so much later: it has walked on along the scene's path and looks about."""
    name: str
    late_s: float
    turned_deg: float
    position_m: tuple

    def pose(self, head):
        return es.Pose(self.position_m, Head(self.name, self.turned_deg, 0).pose(head).orientation)


def path_of_scene(description):
    camera = read_json(description)["camera"]
    if "path" in camera:
        return es.PosePath.read(description.parent / camera["path"])
    return es.PosePath([(key["time_s"], es.Pose(key["position_m"], key["orientation_wxyz"])) for key in camera["keys"]])


def later_heads(path, time_s):
    """Where the path ends they walk it back."""
    for late_s in LATER_S:
        walked_s = min(time_s + late_s, 2 * path.duration_s - time_s - late_s)
        yield Later(f"later-{1000 * late_s:g}ms", late_s, SWING_DEG * math.sin(late_s / SWING_S), tuple(map(float, path.at(walked_s).position_m)))


@dataclasses.dataclass(frozen=True)
class Source:
    name: str
    title: str
    render: object
    """Of a seed: its folder."""


def sources(work):
    preset = work.preset
    yield Source("base", f"sphere of {preset.base_width} columns", lambda seed: work.render(render_list.base(preset, seed)))
    for width in (preset.half_width, preset.sphere_width):
        yield Source(f"sphere-{width}", f"sphere of {width} columns", lambda seed, width=width: work.sphere("centre", width, seed))
    yield Source("margin", f"view of {render_list.MARGIN_VIEW_DEG} degrees", lambda seed: work.render(render_list.margin_view(preset, seed)))
    for columns, across, high in preset.windows:
        yield Source(f"window-{columns}", f"window of {across}x{high} degrees, {columns} columns, in a sphere of {preset.base_width}",
                     lambda seed, spec=(columns, across, high): work.render(render_list.window(preset, seed, *spec)))


def pixels_of(work, folder):
    """Rendered a frame, of all that is looked up."""
    parts = [part for part in (work.folder / folder).iterdir() if part.name in ("centre", "window")]
    sizes = [es.read_frame_info(next(iter(sorted(part.glob("frame.*.exr"))))).camera.size for part in parts]
    return sum(width * height for width, height in sizes)


def encode(work, source, seed, crf):
    folder = source.render(seed)
    return work.encode(f"window-{source.name}-{seed}-crf{crf}", folder, "--crf", crf, "--depth", "auto", "--fill", "none", timed=False)


def at_rest(work, source, crf):
    views, runs = [], []
    for seed in SEEDS:
        stream, encoded = encode(work, source, seed, crf)
        view, played = work.play(f"window-{source.name}-{seed}-crf{crf}", stream, "--method", "mesh")
        views.append(view)
        runs.append((encoded, played))
    return {"source": source.name, "crf": crf, "bytes_a_frame": sum(sum(encoded["bytes"].values()) for encoded, _ in runs) / len(runs) / work.preset.frames,
            "milliseconds": runs[0][1]["milliseconds"], "commands": [runs[0][0]["command"], runs[0][1]["command"]],
            **work.wholly(f"window-{source.name}-crf{crf}", views, work.truths())}


def pair_at_rest(work, crf):
    """Both eyes' views in turns in one stream."""
    views, runs = [], []
    for seed, rendered in ((seed, work.pair(seed)) for seed in SEEDS):
        both, decoded, view = f"related/both-{seed}", f"related/pair-crf{crf}-{seed}", f"views/window-pair-crf{crf}-{seed}"
        for eye, folder in zip(EYES, rendered):
            shown(work, folder, f"related/{eye}-{seed}")
        for index in indices(work):
            for place, eye in enumerate(EYES):
                write(work, both, in_turns(work, index, place), rgb(file_of(work, f"related/{eye}-{seed}", index)))
        runs.append(coded(work, both, crf, decoded))
        for index in indices(work):
            for place, eye in enumerate(EYES):
                write(work, f"{view}/{eye}", index, rgb(file_of(work, decoded, in_turns(work, index, place))))
        views.append(view)
    return {"source": PAIR, "crf": crf, "bytes_a_frame": mean_bytes(runs), "commands": [runs[0][1]], **work.wholly(f"window-pair-crf{crf}", views, work.truths())}


def elsewhere(work, head, number, truths, source):
    path, views, commands = path_of(work, head, number), [], []
    for seed in SEEDS:
        stream, _ = encode(work, source, seed, HEADS_CRF)
        view, played = work.play(f"window-{head.name}-{source.name}-{seed}", stream, "--method", "mesh", "--head", path, "--frames", number)
        views.append(view)
        commands.append(played["command"])
    return {"head": head.name, "source": source.name, "command": commands[0], **work.wholly(f"window-{head.name}-{source.name}", views, truths, str(number))}


def truths_of(work, head, number, path):
    """The study's own of the head that the source was rendered for."""
    if getattr(head, "late_s", None) == 0:
        return [work.truth(seed) for seed in SEEDS]
    return [work.render(moved_eyes(work.preset, work.scene, f"window-{head.name}", seed, path), str(number)) for seed in SEEDS]


def frames_of(work, stream):
    """{track: the kind of each frame and its bytes}."""
    command = ["ffprobe", "-v", "error", "-show_entries", "frame=stream_index,pict_type,pkt_size:stream=index:stream_tags=handler_name", "-of", "json", stream]
    done = subprocess.run(command, cwd=work.folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{' '.join(command)}: exit {done.returncode}: {done.stderr.strip()}")
    said = json.loads(done.stdout)
    return {track["tags"]["handler_name"]: [(frame["pict_type"], int(frame["pkt_size"])) for frame in said["frames"] if frame["stream_index"] == track["index"]]
            for track in said["streams"]}


def jump(work, staying, number):
    """What a jump of the gaze after frame `number` costs in the stream, beside one whose gaze goes on: of one window and one seed."""
    spec = render_list.window(work.preset, SEEDS[0], *work.preset.windows[0])
    told = {index: told_of(work, index) for index in indices(work)}
    path = path_file(work, "jump", [(info.time_s, Head("jump", JUMP_DEG * (index > number), 0).pose(info.head)) for index, info in told.items()])
    jumping = Source("jump", "", lambda seed: work.render(dataclasses.replace(spec, name=f"window-jump-{seed}", options=(*spec.options, "--path", path))))
    streams = {name: encode(work, source, SEEDS[0], HEADS_CRF) for name, source in (("goes on", staying), ("jumps", jumping))}
    return {"turned_deg": JUMP_DEG, "source": staying.name, "crf": HEADS_CRF, "at": number + 1 - work.first, "commands": [encoded["command"] for _, encoded in streams.values()],
            "frames": {name: frames_of(work, stream) for name, (stream, _) in streams.items()}}


def run(work):
    number = (work.first + work.last) // 2
    all_sources = list(sources(work))
    later = list(later_heads(path_of_scene(work.description), told_of(work, number).time_s))
    rest = [at_rest(work, source, crf) for source in all_sources for crf in CRFS] + [pair_at_rest(work, crf) for crf in CRFS]
    heads = []
    for head in (*HEADS, *later):
        path = path_of(work, head, number)
        truths = truths_of(work, head, number, path)
        heads += [elsewhere(work, head, number, truths, source) for source in all_sources]
    pixels = {source.name: pixels_of(work, source.render(SEEDS[0])) for source in all_sources}
    pixels[PAIR] = 2 * work.preset.eye[0] * work.preset.eye[1]
    return {"n": {"frames": work.preset.frames, "seeds": len(SEEDS)}, "titles": {**{source.name: source.title for source in all_sources}, PAIR: "both eyes rendered, coded in turns"},
            "rendered_pixels": pixels, "heads": [dataclasses.asdict(head) for head in HEADS], "later": [dataclasses.asdict(head) for head in later], "rest": rest, "elsewhere": heads,
            "jump": jump(work, next(source for source in all_sources if source.name.startswith("window")), number)}
