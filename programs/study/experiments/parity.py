"""The paper's open question: how wide a sphere, and how many bytes of it, equal a perspective render.

Spheres of every width and the paper's perspective view, through the first codec at several qualities: curves of accuracy against bytes. Two sets: all the
preset's frames, of spheres as wide as are rendered for all; and the first frames alone, of the widest sphere too, beside which everything is as short.
"""

from presets import SEEDS

from .systems import SYSTEMS, Coding, Player

BY_NAME = {system.name: system for system in SYSTEMS}
VIEWS, SPHERE = ("perspective", "pair"), "centre"


def qualities(preset, crfs):
    return [None, *(Coding(preset.codecs[0], crf) for crf in crfs)]


def entries(player, widths):
    preset = player.work.preset
    for view in VIEWS:
        for coding in qualities(preset, preset.curve_crfs):
            yield player.score(BY_NAME[view], None, coding)
    for width in widths:
        for coding in qualities(preset, preset.curve_crfs + preset.coarse_crfs):
            yield player.score(BY_NAME[SPHERE], width, coding)


def ceiling(work, *frames):
    """Truth beside the truth of the other seed."""
    truths = [work.truth(seed) for seed in SEEDS]
    return work.compare("-".join(["ceiling", *frames]), *truths, *(["--frames", *frames] if frames else []))["eyes"]


def run(work):
    preset = work.preset
    every = Player(work)
    frames = f"{work.first}-{work.first + preset.widest.frames - 1}"
    short = every if preset.widest.frames == preset.frames else Player(work, frames)
    return {"n_seeds": len(SEEDS), "all": list(entries(every, preset.widths)),
            "first": list(entries(short, sorted({*preset.widths, preset.widest.width}))), "first_frames": frames,
            "ceiling": {"all": ceiling(work), "first": ceiling(work, frames)}}
