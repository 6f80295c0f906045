"""Only what is looked at: a dense window within a coarse sphere, beside all else that as many bytes can be.

Every source has depth of its own and is played by `mesh`, as one without the scene's geometry is; the pair of rendered eyes has none. At rest all frames count,
coded at each CRF; heads that have turned or moved since the source was rendered see one frame of it, coded at HEADS_CRF.
"""

import dataclasses

import equistream as es
import render_list
from presets import SEEDS
from render_list import EYES, moved_eyes

from .moved import Head, path_of
from .related_streams import in_turns
from .related_video import coded, file_of, indices, mean_bytes, rgb, shown, write

CRFS, HEADS_CRF = (20, 24, 28, 32), 24
HEADS = (*(Head(f"turned-{degrees}", degrees, 0) for degrees in (5, 10, 20, 40)), Head("leaned", 0, 0.05), Head("leaned-far", 0, 0.1))
PAIR = "pair"


@dataclasses.dataclass(frozen=True)
class Source:
    name: str
    title: str
    render: object
    """Of a seed: its folder."""


def sources(work):
    preset = work.preset
    yield Source("base", f"sphere of {preset.base_width} columns", lambda seed: work.render(render_list.base(preset, seed)))
    half = preset.sphere_width // 2
    for width in (half, preset.sphere_width):
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
            **work.scored(f"window-{source.name}-crf{crf}", views)}


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
    return {"source": PAIR, "crf": crf, "bytes_a_frame": mean_bytes(runs), "commands": [runs[0][1]], **work.scored(f"window-pair-crf{crf}", views)}


def elsewhere(work, head, number, truths, source):
    path, views, commands = path_of(work, head, number), [], []
    for seed in SEEDS:
        stream, _ = encode(work, source, seed, HEADS_CRF)
        view, played = work.play(f"window-{head.name}-{source.name}-{seed}", stream, "--method", "mesh", "--head", path, "--frames", number)
        views.append(view)
        commands.append(played["command"])
    return {"head": head.name, "source": source.name, "command": commands[0], **work.beside(f"window-{head.name}-{source.name}", views, truths, str(number))}


def run(work):
    number = (work.first + work.last) // 2
    all_sources = list(sources(work))
    rest = [at_rest(work, source, crf) for source in all_sources for crf in CRFS] + [pair_at_rest(work, crf) for crf in CRFS]
    heads = []
    for head in HEADS:
        path = path_of(work, head, number)
        truths = [work.render(moved_eyes(work.preset, work.scene, f"window-{head.name}", seed, path), str(number)) for seed in SEEDS]
        heads += [elsewhere(work, head, number, truths, source) for source in all_sources]
    pixels = {source.name: pixels_of(work, source.render(SEEDS[0])) for source in all_sources}
    pixels[PAIR] = 2 * work.preset.eye[0] * work.preset.eye[1]
    return {"n": {"frames": work.preset.frames, "seeds": len(SEEDS)}, "titles": {**{source.name: source.title for source in all_sources}, PAIR: "both eyes rendered, coded in turns"},
            "rendered_pixels": pixels, "heads": [dataclasses.asdict(head) for head in HEADS], "rest": rest, "elsewhere": heads}
