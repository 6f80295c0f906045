"""How little is enough: accuracy against triangles of the client's model, bits of depth, share of the budget that mesh cells may use, draws, and samples.

Each axis is swept with all else at its best, by the sphere at the head's centre at its full width, before coding: both eyes, both seeds.
Accuracy against the sphere's width is parity's (parity.py).
"""

import json
import pathlib
import sys

import equistream as es
import numpy as np
from narrowed import made_once
from PIL import Image
from presets import SEEDS
from render_list import EYES, noisy_sphere
from scene_work import STRESS
from steps import digest

from .systems import stage_ms

sys.path.insert(0, str(STRESS))
from breakers import coarse  # noqa: E402

BITS = (3, 4, 5, 6, 7, 8, 10, 12)
DEPTHS = {"ray": "one cast of rays", "gl": "one multi-draw an eye and sphere", "gl-cube": "the paper's seven draws"}
FILL = ["--fill", "pushpull"]


def sources(work):
    return [work.sphere("centre", work.preset.sphere_width, seed) for seed in SEEDS]


def played(work, label, *words):
    """The errors of both seeds' spheres, played in one way."""
    views = work.steps.side_by_side(lambda seed, source: work.play(f"{label}-{seed}", source, *words)[0], SEEDS, sources(work))
    return work.scored(label, views)


def triangles(work):
    """Of the client's model, by error budget."""
    surface = ["--method", "eye-depth", *FILL]
    points = [{"error_px": 0, "triangles": None, **played(work, "model-none", "--scene", work.description, *surface)}]
    for error_px in work.preset.budgets_px:
        file, step = f"models/{error_px:g}px.json", f"model-{error_px:g}px"
        (work.folder / "models").mkdir(exist_ok=True)
        work.steps.run(step, "model", work.description, "--error-px", error_px, "--focal", work.preset.focal_px, "--rounds", work.preset.model_rounds, *work.preset.model_words, "--json",
                       "--progress", "none", "--out", file)
        figures = json.loads(work.steps.output_of(step))
        points.append({"error_px": error_px, "triangles": figures["triangles"]["after"], "bytes": figures["bytes"],
                       **played(work, f"model-{error_px:g}px", "--model", file, *surface)})
    return points


def draws(work):
    """The same depth by rays, by our draws and by the paper's, and how long the faster seed's takes: milliseconds a frame, both eyes."""
    found = []
    for depth, title in DEPTHS.items() if work.preset.every_value else list(DEPTHS.items())[:2]:
        views, said = zip(*(work.play(f"depth-{depth}-{seed}", source, "--scene", work.description, "--depth", depth, "--method", "eye-depth", *FILL, timed=True)
                            for seed, source in zip(SEEDS, sources(work))))
        found.append({"depth": depth, "title": title, "depth_ms": min(stage_ms(report["milliseconds"], "depth") for report in said),
                      **work.scored(f"depth-{depth}", views)})
    return found


def reprojected(work, label, change, **settings):
    """The errors of what the `mesh` engine makes of the spheres, their depth changed by `change(depth_m, box_radius_m)` -> (depth_m, tolerance of w)."""
    by = f"{digest(pathlib.Path(es.__file__).parent, '_core*')} {work.preset.eye} {settings}\n"
    for seed, source in zip(SEEDS, sources(work)):
        spheres, out = work.folder / source / "centre", work.folder / f"views/{label}-{seed}"
        made_once(out, [spheres], lambda spheres=spheres, out=out, seed=seed: draw_views(work, es.Reprojector("mesh", fill="pushpull", **settings), spheres, change, seed, out), by)
    return work.scored(label, [f"views/{label}-{seed}" for seed in SEEDS])


def draw_views(work, engine, spheres, change, seed, out):
    for frame in es.Sequence(spheres):
        depth_m, tolerance_w = change(frame["depth"], frame.info.box_radius_m)
        draw_eyes(work, engine, frame, depth_m, tolerance_w, seed, out)


def draw_eyes(work, engine, frame, depth_m, tolerance_w, seed, out):
    frame["depth"] = depth_m
    for eye in EYES:
        true = es.read_frame_info(work.folder / f"{work.truth(seed)}/{eye}/frame.{frame.info.index:04}.exr")
        picture = engine(frame, true.camera, true.camera_pose, depth_tolerance_w=tolerance_w)
        (out / eye).mkdir(parents=True, exist_ok=True)
        Image.fromarray(picture.rgb).save(out / eye / f"frame.{frame.info.index:04}.png")


def depth_bits(work):
    """Of w in equal steps."""
    points = [{"bits": None, **reprojected(work, "bits-all", lambda depth_m, box_radius_m: (depth_m, 0.0))}]
    return points + [{"bits": bits, **reprojected(work, f"bits-{bits}", lambda depth_m, box_radius_m, bits=bits: coarse(depth_m, box_radius_m, bits))}
                     for bits in (BITS if work.preset.every_value else BITS[::5])]


def mesh_cells(work):
    """By the error budget of the engine; how many those are in the first frame."""
    frame = next(iter(es.Sequence(work.folder / sources(work)[0] / "centre", "depth")))
    return [{"error_px": error_px, "cells": adaptive_cells(work, frame["depth"], frame.info.box_radius_m, error_px),
             **reprojected(work, f"cells-{error_px:g}px", lambda depth_m, box_radius_m: (depth_m, 0.0), error_budget_px=error_px)}
            for error_px in work.preset.budgets_px]


def adaptive_cells(work, depth_m, box_radius_m, budget_px):
    return sum(count_cells(depth_m, box_radius_m, budget_px / work.preset.focal_px).values())


def samples(work):
    """A pixel of the sphere: the whole error."""
    truth, second_truth = (work.truth(seed) for seed in SEEDS)
    points = []
    for count in work.preset.samples_swept:
        source = work.render(noisy_sphere(work.preset, count))
        views, _ = work.play(f"samples-{count}", source, "--scene", work.description, "--method", "eye-depth", *FILL)
        points.append({"samples": count, "whole": work.compare(f"samples-{count}", views, truth, "--truth2", second_truth, "--metrics", "none")["eyes"]})
    return points


def run(work):
    return {"triangles": triangles(work), "draws": draws(work), "depth_bits": depth_bits(work), "mesh_cells": mesh_cells(work), "samples": samples(work)}


# How many cells the client's adaptive mesh has: client/warp/mesh.h's rule once more, in numpy, for counting alone. A sphere's pixels are a lattice of
# points (q, 1/r), q the unit direction. Blocks of 32x32 cells are quadtrees: a cell is whole if its four parts are and its two triangles hold all its points
# within a tolerance of w. Which neighbours the mesh joins decides nothing here: that rule allows eight times as much.

SIDE = 32
MESH_SHARE = 0.25
"""Of the error budget (bound.h), of which cells take half: those that fan out to meet smaller ones leave their triangles by as much again."""
LEAST_REACH_SHARE = 1e-3
AT_ONCE = 1 << 21
"""Points that are looked at together."""


class Lattice:
    """Rows -1 to H and columns 0 to W; over a pole lies the row itself, half a turn on."""

    def __init__(self, depth_m):
        rows, columns = depth_m.shape
        self.rows, self.columns = rows + 1, columns  # of cells
        y, x = np.arange(-1, rows + 1), np.arange(columns + 1)
        over = (y < 0) | (y >= rows)
        inner = np.where(y < 0, -1 - y, np.where(y >= rows, 2 * rows - 1 - y, y))
        column = (x[None, :] + over[:, None] * (columns // 2)) % columns
        with np.errstate(divide="ignore"):
            inverse = np.where(depth_m > 0, 1 / depth_m, np.nan)
        self.k = inverse[inner[:, None], column]
        self.q = es.EquirectCamera(columns, rows).directions()[inner[:, None], column]


def share_beyond_box(inverse, box_radius_m):
    return np.maximum(1 - box_radius_m * inverse, LEAST_REACH_SHARE)


def same(a, b, box_radius_m, tolerance):
    return box_radius_m * np.abs(a - b) <= tolerance * (share_beyond_box(a, box_radius_m) * share_beyond_box(b, box_radius_m))


def plane_through(q, k):
    """m of 1/r = m . q through three points: n x 3 x 3 and n x 3."""
    return np.linalg.solve(q, k[..., None])[..., 0]


def holds(lattice, y, x, size, box_radius_m, tolerance):
    """Both triangles of the cells at (y, x), split from the first corner to the opposite one."""
    step = np.arange(size + 1)
    j, i = np.meshgrid(step, step, indexing="ij")
    good = np.empty(len(y), bool)
    batch = max(1, AT_ONCE // (size + 1) ** 2)
    for begin in range(0, len(y), batch):
        part = slice(begin, begin + batch)
        rows, columns = y[part, None, None] + j, x[part, None, None] + i
        q, k = lattice.q[rows, columns], lattice.k[rows, columns]
        fine = np.ones(len(q), bool)
        for third, inside in (((0, -1), i >= j), ((-1, 0), i <= j)):
            corners = ((0, 0), third, (-1, -1))
            plane = plane_through(np.stack([q[:, r, c] for r, c in corners], axis=1), np.stack([k[:, r, c] for r, c in corners], axis=1))
            fine &= (same(np.einsum("nijc,nc->nij", q, plane), k, box_radius_m, tolerance) | ~inside).all(axis=(1, 2))
        good[part] = fine
    return good


def count_cells(depth_m, box_radius_m, budget_rad):
    """{side: cells} of a whole sphere's depth for an eye's error budget."""
    lattice = Lattice(np.asarray(depth_m, np.float64))
    within = 0.5 * np.sin(MESH_SHARE * budget_rad)
    flat = np.ones((lattice.rows, lattice.columns), bool)
    found, size = {}, 1
    while True:
        above = np.zeros((-(-flat.shape[0] // 2), -(-flat.shape[1] // 2)), bool)
        if 2 * size <= SIDE:
            whole = flat[:flat.shape[0] // 2 * 2, :flat.shape[1] // 2 * 2]
            y, x = np.nonzero(whole[::2, ::2] & whole[::2, 1::2] & whole[1::2, ::2] & whole[1::2, 1::2])
            fit = (2 * size * (y + 1) <= lattice.rows) & (2 * size * (x + 1) <= lattice.columns)
            y, x = y[fit], x[fit]
            above[y, x] = holds(lattice, 2 * size * y, 2 * size * x, 2 * size, box_radius_m, within)
        own = ~np.repeat(np.repeat(above, 2, axis=0), 2, axis=1)[:flat.shape[0], :flat.shape[1]]
        found[size] = int(np.count_nonzero(own & (flat | (size == 1))))
        if 2 * size > SIDE:
            return found
        flat, size = above, 2 * size
