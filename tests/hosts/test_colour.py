"""Colour: the furnace, the same picture as other sensors take, the same picture with and without our integrator."""

import pathlib

import mitsuba as mi
import numpy as np
import pytest
from conftest import diffuse, film, planes, pose, scene, sensor, sphere
from independent import (equirect_direction, equirect_pixel, leave_behind, perspective_direction, pixel_centres, sample,
                         unit)


def test_furnace(any_variant):
    """A white ball that is lit evenly from all around is as bright as what is around it."""
    glow = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
    shapes = {"ball": sphere((0, 0, -3), 2.5, diffuse(1, 1, 1)), "glow": glow}
    nested = {"type": "path", "max_depth": -1, "rr_depth": 1000}
    found = planes(scene(shapes, sensor(64, 32), aovs="depth", nested=nested), spp=256)
    hit, colour = np.isfinite(found["depth.Z"]), found["colour"][..., :3]
    assert hit.sum() > 300
    # Four wavelengths a sample make spectral variants noisy: at the end a standard error of 0.001 there, 0.0005 elsewhere.
    assert colour[hit].mean() == pytest.approx(1.0, abs=5e-3 if "spectral" in any_variant else 3e-3)
    if "spectral" not in any_variant:
        assert np.median(np.abs(colour[~hit] - 1)) < 1e-5


def test_colour_is_the_nested_integrators_own(variant):
    shapes = {"ball": sphere((0, 0, -3), bsdf=diffuse(0.8, 0.3, 0.1)), "sky": {"type": "constant"}}
    camera = sensor(filter="gaussian")
    path = {"type": "path", "max_depth": 4}
    stock = mi.load_dict({"type": "scene", "sensor": camera, "integrator": path, **shapes})
    alone = mi.render(stock, spp=16, seed=3)
    beside = planes(scene(shapes, camera, nested=path), spp=16, seed=3)
    assert beside["colour"] == pytest.approx(np.array(alone), rel=2e-6)


def test_environment_is_where_perspective_sees_it(variant):
    """A map whose colour tells the direction: looked up by the sphere and by a stock camera, in the same directions."""
    u, v = pixel_centres(512, 256)
    d = equirect_direction(u, v, 512, 256)
    picture = mi.Bitmap((0.5 + 0.5 * d).astype(np.float32))
    shapes = {"sky": {"type": "envmap", "bitmap": picture, "scale": 1.0}}
    whole = planes(scene(shapes, sensor(256, 128), aovs="none"), spp=64)["colour"]
    for turn in (np.eye(3), np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]]), np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])):
        view = {"type": "perspective", "fov": 60.0, "to_world": pose((0, 0, 0), turn), "film": film(48, 48)}
        flat = planes(scene(shapes, view, aovs="none"), spp=64)["colour"]
        towards = unit(perspective_direction(*pixel_centres(48, 48), 48, 48, np.radians(60))) @ np.array(turn).T
        looked_up = sample(whole, *equirect_pixel(towards, 256, 128))
        assert looked_up == pytest.approx(flat, abs=0.02)


def test_colour_by_z_test_against_a_stock_camera(variant):
    """A stock view of a room, and the finer pixels of the sphere that fall into each of its own."""
    shapes = {"room": {"type": "cube", "to_world": mi.ScalarTransform4f().scale(2), "bsdf": diffuse(0.7, 0.6, 0.5)},
              "ball": sphere((0.2, -0.3, -1.3), 0.4, diffuse(0.2, 0.4, 0.8)),
              "lamp": sphere((0, 1.2, -0.2), 0.3, emitter={"type": "area", "radiance": 5.0})}
    nested = {"type": "path", "max_depth": 4}
    side, width, height, fov = 16, 1440, 720, np.radians(40)
    crop = {"crop_width": 180, "crop_height": 180, "crop_offset_x": 630, "crop_offset_y": 270}
    view = {"type": "perspective", "fov": 40.0, "to_world": pose(), "film": film(side, side)}
    u, v = pixel_centres(180, 180)
    x, y, z = np.moveaxis(equirect_direction(u + 630, v + 270, width, height), -1, 0)
    column, row = (0.5 * side / np.tan(0.5 * fov)) * np.stack([x, -y]) / -z + 0.5 * side
    inside = (column >= 0) & (column < side) & (row >= 0) & (row < side)
    pixel = (row[inside].astype(int) * side + column[inside].astype(int))
    count = np.bincount(pixel, minlength=side * side)
    assert count.min() > 50

    def gathered(colour):
        sums = [np.bincount(pixel, colour[..., c][inside], minlength=side * side) for c in range(3)]
        return np.stack(sums, -1).reshape(side, side, 3) / count.reshape(side, side, 1)

    ball = scene(shapes, sensor(width, height, film_options=crop), "none", nested)
    flat = scene(shapes, view, "none", nested)
    runs = {"sphere": [gathered(planes(ball, spp=2, seed=seed)["colour"]) for seed in range(12)],
            "flat": [planes(flat, spp=128, seed=100 + seed)["colour"] for seed in range(12)]}
    means = {name: np.mean(r, 0) for name, r in runs.items()}
    errors = {name: np.var(r, 0, ddof=1) / len(r) for name, r in runs.items()}
    # The pixels' own borders differ a little where the picture has an edge.
    edges = sum(np.abs(step) for step in np.gradient(means["flat"].mean(-1)))[..., None]
    off = means["sphere"] - means["flat"]
    z = off / np.sqrt(errors["sphere"] + errors["flat"] + (0.05 * edges) ** 2 + 1e-12)
    # A t of 22 degrees of freedom is beyond 3.2 in 0.4 percent of 768 values: 12 would be a one in ten thousand chance.
    if (np.abs(z) > 3.2).sum() > 12 or abs(z.mean()) > 0.2:
        left = leave_behind(pathlib.Path("failed"), f"colour-{mi.variant()}", means["sphere"], means["flat"])
        pytest.fail(f"{(np.abs(z) > 3.2).sum()} of {z.size} values beyond 3.2 standard errors, mean {z.mean():.2f}: {left}")
