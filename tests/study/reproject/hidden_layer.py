#!/usr/bin/env python3
"""How much of what eyes uncover the hidden layer holds, and how large it is: docs/results/reproject/hidden-layer.json.

    hidden_layer.py --bin build/release/bin --work FOLDER [SCENE ...]

A sphere with its hidden layer, and the depth of spheres at random places in the head box (uniform in the ball), all rendered by
`render`. A pixel of such an eye's sphere is a gap if its point lies behind all four pixels around its direction from the centre by
more than the error budget in w = B / (r - B). It is held if one of the hidden layer's four pixels around that direction shows a surface
there: within the budget of it, or between those of the layer's pixels around. Pixels count by their solid angle.
"""

import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "programs"))
from independent import equirect_direction, equirect_pixel, pixel_centres, read_frame  # noqa: E402
from renders import FRAMES, REPOSITORY, scene_parser  # noqa: E402
from results import keep  # noqa: E402
from steps import Failed, provenance, run_as_program, write_whole  # noqa: E402

BUDGET = 1 / (4 * 960)


def render(programs, scene, out, *options):
    words = [str(w) for w in ("render", scene, "--spp", 1, "--ipd", 0.063, "--progress", "none", *options, "--out", out)]
    done = subprocess.run([programs / "equistream", *words], cwd=REPOSITORY, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"equistream {' '.join(words)}: exit {done.returncode}: {done.stderr.strip()}")


def places_in_ball(radius, count, seed):
    random = np.random.default_rng(seed)
    d = random.normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True) * radius * random.uniform(size=(count, 1)) ** (1 / 3)


def bounded(distance, radius):
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isinf(distance), 0.0, np.where(distance <= radius, np.inf, radius / (distance - radius)))


def around(plane, u, v):
    """The four pixels whose centres are around (u, v)."""
    height, width = plane.shape
    x, y = np.floor(u - 0.5).astype(int), np.floor(v - 0.5).astype(int)
    return np.stack([plane[np.clip(y + j, 0, height - 1), (x + i) % width] for j in (0, 1) for i in (0, 1)])


def spread(w):
    """Least and largest over each pixel and its eight neighbours, NaN left out."""
    padded = np.pad(np.pad(w, ((0, 0), (1, 1)), "wrap"), ((1, 1), (0, 0)), "edge")
    height, width = w.shape
    all_nine = np.stack([padded[j:j + height, i:i + width] for j in range(3) for i in range(3)])
    low = np.where(np.isnan(all_nine), np.inf, all_nine).min(axis=0)
    high = np.where(np.isnan(all_nine), -np.inf, all_nine).max(axis=0)
    return np.where(np.isnan(w), np.nan, low), np.where(np.isnan(w), np.nan, high)


def gaps_of_eye(offset, depth, main_w, hidden, radius):
    """Solid angle of an eye's gaps, and of those that the layer holds; and of the whole sphere."""
    height, width = depth.shape
    u, v = pixel_centres(width, height)
    solid = np.cos(np.pi * (0.5 - v / height))
    d = equirect_direction(u, v, width, height)
    sky = np.isinf(depth)
    points = offset + np.where(sky, 0.0, depth)[..., None] * d
    points[sky] = d[sky]
    reach = np.where(sky, np.inf, np.linalg.norm(points, axis=-1))
    w = bounded(reach, radius)
    height, width = main_w.shape
    at = equirect_pixel(points, width, height)
    gap = np.isfinite(w) & (w < around(main_w, *at).min(axis=0) - BUDGET)
    low, high = (around(plane, *at) for plane in hidden)
    held = gap & ((low - BUDGET <= w) & (w <= high + BUDGET)).any(axis=0)
    return np.array([solid[gap].sum(), solid[held].sum(), solid.sum()])


def measure(options, scene):
    work = (options.work / scene).resolve()
    description = REPOSITORY / f"scenes/descriptions/{scene}.json"
    lean = json.loads(description.read_text())["head_box"]["lean_m"]
    radius = lean + 0.063 / 2
    size = f"{options.width}x{options.width // 2}"
    render(options.bin, description, work / "centre", "--frames", FRAMES[scene], "--size", size, "--layers", "--aovs", "depth")
    main_depth, hidden_depth = (read_frame(work / "centre" / name / f"frame.{FRAMES[scene]:04d}.exr")["depth.Z"] for name in ("centre", "hidden"))
    head = json.loads((work / "centre/centre/manifest.json").read_text())["first_frame"]["head"]
    offsets = places_in_ball(radius, options.eyes, options.seed)
    # One frame an eye: the path jumps from one to the next, a second each; things stand where they did.
    lines = ["time_s,x,y,z,qw,qx,qy,qz"]
    for i, offset in enumerate(offsets):
        place = np.asarray(head["position_m"]) + offset
        lines.append(",".join(repr(float(v)) for v in [float(i), *place, 1, 0, 0, 0]))
    path = work / "eyes.csv"
    write_whole(path, "\n".join(lines) + "\n")
    render(options.bin, description, work / "eyes", "--path", path, "--fps", 1, "--size", options.eye_size, "--max-bounces", 0, "--aovs", "depth")
    main_w = bounded(main_depth, radius)
    there = ~np.isnan(hidden_depth)
    hidden = spread(np.where(there, bounded(hidden_depth, radius), np.nan))
    sums = np.array([gaps_of_eye(offset, read_frame(work / f"eyes/centre/frame.{i:04d}.exr")["depth.Z"], main_w, hidden, radius)
                     for i, offset in enumerate(offsets)])
    each = sums[:, 1] / np.maximum(sums[:, 0], 1e-12)
    return {"head_box_radius_m": radius, "layer_share_of_pixels": float(there.mean()), "layer_share_that_is_sky": float(np.isinf(hidden_depth).mean()),
            "gap_share": {"mean": float((sums[:, 0] / sums[:, 2]).mean()), "largest": float((sums[:, 0] / sums[:, 2]).max())},
            "held_share_of_gaps": {"all": float(sums[:, 1].sum() / sums[:, 0].sum()), "worst_eye": float(each.min()), "median_eye": float(np.median(each))}}


def main():
    parser = scene_parser(__doc__, work="folder for renders; not in the repository")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/hidden-layer.json", help="file of all scenes' results")
    parser.add_argument("--width", type=int, default=960, help="columns of the sphere")
    parser.add_argument("--eye-size", default="480x240")
    parser.add_argument("--eyes", type=int, default=64)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.bin = options.bin.resolve()
    for scene in options.scenes:
        measured = measure(options, scene)
        command = f"hidden_layer.py {scene} --width {options.width} --eye-size {options.eye_size} --eyes {options.eyes} --seed {options.seed}"
        result = {"scene": scene, "frame": FRAMES[scene], "command": command,
                  "n": {"eyes": options.eyes, "seed": options.seed}, "measured": measured,
                  **provenance(options.bin, REPOSITORY)}
        keep(options.out, scene, result)


if __name__ == "__main__":
    run_as_program(main)
