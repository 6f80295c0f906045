"""The paper's open question: how wide a sphere, and how many bytes of it, equal a perspective render.

Spheres of several widths and the paper's perspective view, through the first codec at several qualities: curves of the whole error against bytes. The first
frames alone, of one seed: the widest spheres take long.
"""

from presets import SEEDS

from .systems import SYSTEMS, Coding, Player

BY_NAME = {system.name: system for system in SYSTEMS}
VIEWS, SPHERE = ("perspective", "pair"), "centre"


def qualities(preset, crfs):
    return [None, *(Coding(preset.codecs[0], crf) for crf in crfs)]


def wanted(preset):
    """(system, width, coding) of every entry."""
    for view in VIEWS:
        for coding in qualities(preset, preset.curve_crfs):
            yield BY_NAME[view], None, coding
    for width in preset.parity.widths:
        for coding in qualities(preset, preset.curve_crfs + preset.coarse_crfs):
            yield BY_NAME[SPHERE], width, coding


def run(work):
    preset = work.preset
    frames = f"{work.first}-{work.first + preset.parity.frames - 1}"
    player = Player(work, frames, seeds=SEEDS[:1])
    work.truths()  # this, and all spheres, before two ask for one
    for system, width, _ in wanted(preset):
        player.sources(system, width, SEEDS[0])
    entries = work.steps.side_by_side(lambda which: player.score(*which), list(wanted(preset)))
    return {"n": {"frames": preset.parity.frames, "seeds": 1}, "frames": frames, "entries": entries}
