"""Systems beside the paper's that it names, each as small as it informs a choice: other layouts, difference streams, motion vectors, grids of blocks.

All of renders that the systems are given anyway (systems.py), so that it costs coding and looking up alone. Here: warping by a grid (adaptive image-space
stereo view synthesis, Didyk et al. 2010): a regular one of depth points, coarser and coarser, beside our adaptive mesh. The sphere at the head's centre,
uncoded; depth points stand on every k-th pixel and are put back bilinearly in 1/r, which the engines draw pixel by pixel. Both eyes, noise-free.
"""

import collections

import equistream as es
import numpy as np
from presets import SEEDS
from render_list import EYES

from .parsimony import adaptive_cells, sources
from .related_layouts import latitude_points, layout_points
from .related_streams import difference_points, let_through, search_points
from .related_video import counted, display, write

STEPS = (1, 2, 4, 8, 16)
GRIDS = {"mesh-plain": "regular grid, stretched over edges", "mesh": "regular grid, cut at edges"}
ADAPTIVE = "adaptive mesh, by error budget"
FILL = "pushpull"
GRID_BUDGET_PX = 0.25
"""By which edges are cut."""

Variant = collections.namedtuple("Variant", "label engine step")


def weights(length, step, closes):
    """length x points: bilinear from every step-th sample; of an axis that does not close, from the last one too."""
    at = np.arange(0, length, step)
    ends = np.append(at, length) if closes else np.unique(np.append(at, length - 1))
    before = np.clip(np.searchsorted(ends, np.arange(length), side="right") - 1, 0, max(len(ends) - 2, 0))
    share = (np.arange(length) - ends[before]) / (ends[before + 1] - ends[before])
    found = np.zeros((length, len(at) if closes else len(ends)))
    for offset, part in ((0, 1 - share), (1, share)):
        np.add.at(found, (np.arange(length), (before + offset) % found.shape[1]), part)
    return found, (at if closes else ends)


def coarsened(depth_m, step):
    """A sphere's depth of every step-th sample each way, and how many cells those are."""
    (down, rows), (across, columns) = (weights(depth_m.shape[axis], step, axis == 1) for axis in (0, 1))
    cells = (len(rows) - 1) * len(columns)
    if step == 1:
        return depth_m, cells
    with np.errstate(divide="ignore"):
        inverse = down @ (1 / depth_m.astype(np.float64))[np.ix_(rows, columns)] @ across.T
        return (1 / inverse).astype(np.float32), cells


def variants(preset):
    steps, budgets = (STEPS, preset.budgets_px) if preset.every_value else (STEPS[::4], preset.budgets_px)
    for method in GRIDS:
        yield from (Variant(f"grid-{method}-{step}", es.Reprojector(method, fill=FILL, error_budget_px=GRID_BUDGET_PX), step) for step in steps)
    yield from (Variant(f"adaptive-{budget:g}px", es.Reprojector("mesh", fill=FILL, error_budget_px=budget), budget) for budget in budgets)


def draw(work, chosen):
    """Views of both seeds by every variant, and its cells of the first frame."""
    cells = {}
    for seed, source in zip(SEEDS, sources(work)):
        for frame in es.Sequence(work.folder / source / "centre"):
            full, rgb = frame["depth"], display(frame)
            eyes = [es.read_frame_info(work.folder / f"{work.truth(seed)}/{eye}/frame.{frame.info.index:04}.exr") for eye in EYES]
            for variant in chosen:
                depth_m, count = (full, None) if variant.label.startswith("adaptive") else coarsened(full, variant.step)
                if variant.label not in cells:
                    cells[variant.label] = count if count is not None else adaptive_cells(work, full, frame.info.box_radius_m, variant.step)
                for eye in eyes:
                    seen = variant.engine(es.FeedPicture(frame.info, rgb, depth_m), eye.camera, eye.camera_pose)
                    write(work, f"views/related-{variant.label}-{seed}/{eye.eye}", frame.info.index, seen.rgb)
    return cells


def block_points(work):
    """Noise-free error against the number of cells of the whole sphere."""
    chosen = list(variants(work.preset))
    cells = draw(work, chosen)
    points = []
    for variant in chosen:
        adaptive = variant.label.startswith("adaptive")
        views = [f"views/related-{variant.label}-{seed}" for seed in SEEDS]
        method = variant.engine.method
        said = f"error_budget_px={variant.step:g})" if adaptive else f"error_budget_px={GRID_BUDGET_PX:g}) of every {variant.step}th depth"
        points.append({"kind": "adaptive" if adaptive else method, "title": ADAPTIVE if adaptive else GRIDS[method],
                       "error_px" if adaptive else "step": variant.step, "cells": cells[variant.label],
                       **work.scored(f"related-{variant.label}", views), "n": {**counted(work), "eyes": len(EYES), "frames_of_cells": 1},
                       "command": f"es.Reprojector('{method}', fill='{FILL}', {said}"})
    return points


def run(work):
    crfs = work.preset.curve_crfs if work.preset.every_value else work.preset.crfs
    checked, layouts = layout_points(work, crfs)
    return {"lookup_check": checked, "layouts": layouts, "latitudes": latitude_points(work, work.preset.crfs), "differences": difference_points(work, crfs),
            "searches": search_points(work), "let_through": let_through(work), "blocks": block_points(work)}
