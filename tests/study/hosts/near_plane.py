#!/usr/bin/env python3
"""Mitsuba's own depth beside ours on a scene whose camera has near_clip 1: docs/results/mitsuba/near-plane.{json,png}.

    near_plane.py --plugins build/release [--variant scalar_rgb]

Three balls on a floor under an open sky, seen by the stock `perspective` sensor with the default film, so Mitsuba's `depth` integrator, its `aov`
integrator and `equirect_aov` are asked for the same pixels. What each says is held against the distance along the pixel-centre ray in closed
form. A pixel counts as an edge if any of its eight neighbours sees another surface.
"""

import argparse
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import mitsuba as mi
import numpy as np
from matplotlib.colors import LogNorm

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from steps import machine, versions  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
WIDTH, HEIGHT, FOV_DEG, NEAR_CLIP_M, SPP, SEED = 480, 270, 70, 1.0, 16, 1
EYE_M = np.array([0, 1.6, 0])
FLOOR_HALF_M = 20.0
BALLS = (((-1.1, 1.5, -3.0), 0.7), ((0.2, 1.0, -5.5), 1.0), ((1.3, 1.7, -2.2), 0.4))  # centre, radius in metres


def sensor():
    return {"type": "perspective", "fov": FOV_DEG, "fov_axis": "x", "near_clip": NEAR_CLIP_M, "far_clip": 1000.0,
            "to_world": mi.ScalarTransform4f().look_at(origin=EYE_M.tolist(), target=(EYE_M + [0, 0, -1]).tolist(), up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "pixel_format": "rgb", "component_format": "float32"},
            "sampler": {"type": "independent", "sample_count": SPP}}


def scene():
    to_floor = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(FLOOR_HALF_M)
    parts = {"type": "scene", "sky": {"type": "constant"}, "sensor": sensor(), "floor": {"type": "rectangle", "to_world": to_floor}}
    for number, (centre, radius) in enumerate(BALLS):
        parts[f"ball{number}"] = {"type": "sphere", "center": list(centre), "radius": radius}
    return mi.load_dict(parts)


def true_depth():
    """Distance in metres along each pixel-centre ray, +inf for a miss, and which surface is seen (-1 for none)."""
    focal = 0.5 * WIDTH / np.tan(0.5 * np.radians(FOV_DEG))
    u, v = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    direction = np.stack([(u - WIDTH / 2) / focal, (HEIGHT / 2 - v) / focal, -np.ones_like(u)], axis=-1)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    to_floor = np.where(direction[..., 1] < 0, -EYE_M[1] / np.minimum(direction[..., 1], -1e-12), np.inf)
    landing = EYE_M + np.where(np.isfinite(to_floor), to_floor, 0)[..., None] * direction
    found = [np.where(np.max(np.abs(landing[..., [0, 2]]), axis=-1) < FLOOR_HALF_M, to_floor, np.inf)]
    for centre, radius in BALLS:
        offset = EYE_M - np.array(centre)
        half_b = direction @ offset
        discriminant = half_b ** 2 - (offset @ offset - radius ** 2)
        found.append(np.where(discriminant > 0, -half_b - np.sqrt(np.maximum(discriminant, 0)), np.inf))
    distances_m = np.stack(found)
    nearest = distances_m.min(axis=0)
    return nearest, np.where(np.isfinite(nearest), distances_m.argmin(axis=0), -1)


def edges(surface):
    padded = np.pad(surface, 1, mode="edge")
    neighbours = [padded[dy:dy + HEIGHT, dx:dx + WIDTH] for dy in range(3) for dx in range(3)]
    return np.any([neighbour != surface for neighbour in neighbours], axis=0)


def channel(of_scene, integrator, name):
    """One AOV of a render, or its last channel."""
    loaded = mi.load_dict(integrator)
    image = np.array(mi.render(of_scene, integrator=loaded, spp=SPP, seed=SEED), dtype=np.float64)
    names = list(loaded.aov_names())
    return image[..., image.shape[-1] - len(names) + names.index(name) if name else 0]


def figures(depth, truth, surface):
    hit = surface >= 0
    miss = (surface < 0) & ~edges(surface)
    inner = hit & ~edges(surface)
    silhouette = hit & edges(surface)

    def error(where):
        with np.errstate(invalid="ignore"):
            return np.abs(depth[where] - truth[where])

    def within(where):
        return float(np.mean(error(where) <= 1e-4 * truth[where]))

    return {"inside_surfaces": {"pixels": int(inner.sum()), "median_error_m": float(np.median(error(inner))),
                                "share_within_1e-4": within(inner)},
            "edges": {"pixels": int(silhouette.sum()), "median_error_m": float(np.median(error(silhouette))),
                      "worst_error_m": float(np.max(error(silhouette))), "share_within_1e-4": within(silhouette)},
            "misses": {"pixels": int(miss.sum()), "value": sorted({str(value) for value in np.unique(depth[miss])})[:3]}}


def draw(depths, truth, surface, file):
    rows = [("closed form", truth)] + list(depths.items())
    figure, axes = plt.subplots(len(rows), 2, figsize=(9.2, 2.65 * len(rows)), squeeze=False, layout="constrained")
    for (name, depth), (left, right) in zip(rows, axes):
        shown = left.imshow(np.where(np.isfinite(depth), depth, np.nan), cmap="viridis", vmin=0, vmax=12)
        left.set_title(name, fontsize=10, loc="left")
        left.set_facecolor("#dddddd")
        if name == "closed form":
            right.set_axis_off()
            figure.colorbar(shown, ax=right, label="depth, m (grey: infinite)", location="left", shrink=0.9)
        else:
            with np.errstate(invalid="ignore"):
                error = np.where(surface >= 0, np.abs(depth - truth) / truth, np.where(depth == truth, 0, 1))
            wrong = right.imshow(np.maximum(error, 1e-7), cmap="magma", norm=LogNorm(1e-7, 1))
            right.set_title("relative error (a miss that is not infinite: 1)", fontsize=10, loc="left")
            figure.colorbar(wrong, ax=right, shrink=0.9)
    for panel in axes.flat:
        panel.set_xticks([])
        panel.set_yticks([])
    figure.savefig(file, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugins", required=True, type=pathlib.Path, help="folder that holds plugins/equirect_aov.so: the build's")
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/mitsuba")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    mi.file_resolver().append(str(options.plugins.resolve()))
    seen, path = scene(), {"type": "path", "max_depth": 2}
    depths = {
        "Mitsuba's depth integrator": channel(seen, {"type": "depth"}, None),
        "Mitsuba's aov integrator, depth": channel(seen, {"type": "aov", "aovs": "stock:depth", "nested": path}, "stock.T"),
        "equirect_aov, depth": channel(seen, {"type": "equirect_aov", "aovs": "depth", "nested": path}, "depth.Z"),
    }
    truth, surface = true_depth()
    options.out.mkdir(parents=True, exist_ok=True)
    result = {"command": f"tests/study/hosts/near_plane.py --plugins BUILD --variant {options.variant}", "near_clip_m": NEAR_CLIP_M,
              "size": [WIDTH, HEIGHT], "spp": SPP, "seed": SEED,
              "versions": {**versions(options.plugins / "bin/equistream", REPOSITORY), "mitsuba": mi.__version__}, "machine": machine(),
              "of": {name: figures(depth, truth, surface) for name, depth in depths.items()}}
    file = options.out / "near-plane.json"
    file.write_text(json.dumps(result, indent=1) + "\n")
    draw(depths, truth, surface, file.with_suffix(".png"))
    print(file)


if __name__ == "__main__":
    main()
