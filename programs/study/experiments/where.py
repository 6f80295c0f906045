"""Where the error of each system lies: each pixel of the eyes is of the first kind below that it belongs to, and the kinds' errors add up to all of it.

Of uncoded systems at the preset's own width, so that nothing but reprojection is told apart, by the noise-free error over each kind's pixels (docs/compare.md).
"""

import equistream as es
import numpy as np
from narrowed import made_once
from perceived import frames_of
from PIL import Image
from presets import SEEDS
from render_list import EYES, eyes_geometry
from scipy.ndimage import binary_dilation, maximum_filter, minimum_filter

from .systems import SYSTEMS, Player, systems_of

KINDS = {"hidden": "hidden from the source", "mirrors": "mirrors and glass", "edges": "edges of depth", "elsewhere": "elsewhere"}
EDGE_PX = 1
"""Of an edge, at least: how far apart the eyes' distance moves its two sides in the picture."""
REACH = np.ones((3, 3), bool)
"""Around an edge or a mirror: pixels that may show something of both sides."""


def edges(distance_m, focal_px, ipd_m):
    """Where the distances within reach of a pixel differ by an edge or more; +inf where nothing was hit."""
    shift_px = focal_px * ipd_m / distance_m
    return maximum_filter(shift_px, footprint=REACH) - minimum_filter(shift_px, footprint=REACH) >= EDGE_PX


def kinds_of(hidden, specular, distance_m, focal_px, ipd_m):
    """{kind: mask}, of which each pixel is in exactly one."""
    found, free = {}, np.ones_like(hidden)
    for kind, mask in (("hidden", hidden), ("mirrors", binary_dilation(specular, REACH)), ("edges", edges(distance_m, focal_px, ipd_m)), ("elsewhere", free)):
        found[kind] = mask & free
        free = free & ~mask
    return found


def that_knows_gaps(system):
    """The system from the same place that goes by the client's own geometry; None where each eye has a source of its own."""
    return next((other for other in SYSTEMS if (other.places, other.views, other.depth) == (system.places, system.views, "scene")), None)


def write_masks(frames, gaps, out, focal_px):
    """Of one eye, OUT/KIND/EYE/FRAME.png; without `gaps` nothing is hidden."""
    for file in frames_of(frames):
        frame = es.read_frame(file)
        picture = f"{file.stem}.png"
        hidden = np.asarray(Image.open(gaps / picture)) > 0 if gaps else np.zeros(frame["depth"].shape, bool)
        for kind, mask in kinds_of(hidden, frame["specular"] > 0, frame["depth"], focal_px, frame.info.ipd_m).items():
            folder = out / kind / frames.name
            folder.mkdir(parents=True, exist_ok=True)
            Image.fromarray(np.where(mask, 255, 0).astype(np.uint8)).save(folder / picture)


def masks(player, system):
    """{kind: a folder, relative}."""
    work, knowing = player.work, that_knows_gaps(system)
    name = f"masks/{knowing.name if knowing else 'none'}"
    geometry = work.folder / work.render(eyes_geometry(work.preset))
    view = work.folder / player.play(knowing, work.preset.sphere_width, None, SEEDS[0])[0] if knowing else None
    gaps = {eye: view / "gaps" / eye for eye in EYES if view and (view / "gaps" / eye).exists()}

    def make():
        for eye in EYES:
            write_masks(geometry / eye, gaps.get(eye), work.folder / name, work.preset.focal_px)

    made_once(work.folder / name, [*(geometry / eye for eye in EYES), *gaps.values()], make)
    return {kind: f"{name}/{kind}" for kind in KINDS}


def of_system(player, system):
    work = player.work
    views, _ = player.play_seeds(system, work.preset.sphere_width, None)
    truth = [work.truth(seed) for seed in SEEDS]
    found = {"system": system.name, "width": work.preset.sphere_width if system.is_sphere else None, "kinds": {}}
    for kind, mask in masks(player, system).items():
        compared = work.compare(f"where-{system.name}-{kind}", views[0], truth[0], "--second", views[1], truth[1], "--metrics", "none", "--gaps", mask)["eyes"]
        found["kinds"][kind] = {eye: figures.get("gaps", {"fraction": 0}) for eye, figures in compared.items()}
    # Of all pixels, whichever mask came along.
    return {**found, "noise_free": {eye: {"noise_free": figures["noise_free"]} for eye, figures in compared.items()}}


def run(work):
    """Of all systems but what is rendered for the very eye, which has no error of reprojection."""
    player = Player(work)
    systems = [system for system in systems_of(work) if system.views == 1]
    return {"n": {"frames": work.preset.frames, "seeds": len(SEEDS)}, "kinds": KINDS, "edge_px": EDGE_PX,
            "titles": {system.name: system.title for system in systems}, "systems": [of_system(player, system) for system in systems]}
