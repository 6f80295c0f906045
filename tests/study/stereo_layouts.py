#!/usr/bin/env python3
"""What both eyes of a turned, tilted or moved head see of one sphere with depth, of a sphere for each eye with and without depth, and of omnidirectional
stereo: PSNR against the truth, over both eyes. A room of 2.5 m with twelve balls around the head, by closed form, so that nothing is noisy. Prints the table
of docs/guide/encode.md.

usage: stereo_layouts.py BIN_DIR
"""

import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "programs"))
from independent import *

PROGRAMS = Programs(sys.argv[1])
WIDTH, HEIGHT, IPD = 1024, 512, 0.063
SIDES = {"left": -0.5 * IPD, "right": 0.5 * IPD}
BALLS = [(np.zeros(3), 2.5)] + [
    (0.9 * np.array([np.sin(a) * np.cos(e), np.sin(e), -np.cos(a) * np.cos(e)]), 0.14)
    for a, e in zip(np.radians(np.arange(0, 360, 30)), np.radians([0, 25, -20, 40, -5, 15] * 2))]
LAYOUTS = {"mono": ("mono", "--depth", "auto"), "both": ("both", "--depth", "auto", "--stereo", "top-bottom"),
           "turned": ("both", "--stereo", "top-bottom"), "ods": ("ods", "--stereo", "top-bottom")}
HEADS = {"as rendered": (0, 0, 0, 0), "turned by 90 degrees": (90, 0, 0, 0), "turned by 180 degrees": (180, 0, 0, 0), "looking up by 60 degrees": (0, 60, 0, 0),
         "tilted by 20 degrees": (0, 0, 20, 0), "moved by 5 cm": (0, 0, 0, 0.05)}


def seen_along(origin, direction):
    """Colours and distances."""
    nearest, colour = np.full(direction.shape[:-1], np.inf), np.zeros(direction.shape)
    for k, (centre, radius) in enumerate(BALLS):
        o = origin + 0 * direction - centre
        b = np.sum(o * direction, -1)
        square = b * b - np.sum(o * o, -1) + radius ** 2
        root = np.sqrt(np.maximum(square, 0))
        distance = np.where(square < 0, np.inf, root - b if k == 0 else np.where(-b - root > 0, -b - root, np.inf))
        nearer = distance < nearest
        point = origin + np.where(np.isfinite(distance), distance, 0)[..., None] * direction
        colour = np.where(nearer[..., None], 0.5 + 0.4 * np.sin((6 if k == 0 else 25) * point + np.array([0, 1, 2]) + k), colour)
        nearest = np.where(nearer, distance, nearest)
    return colour, nearest


def frames(root):
    u, v = pixel_centres(WIDTH, HEIGHT)
    longitude, latitude = 2 * np.pi * (u / WIDTH - 0.5), np.pi * (0.5 - v / HEIGHT)
    beside = np.stack([np.cos(longitude), 0 * longitude, np.sin(longitude)], -1)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.clip((np.degrees(np.abs(latitude)) - 60) / 15, 0, 1))
    (root / "still.csv").write_text("0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n")
    views = [("mono", "centre", np.zeros(3))]
    for eye, side in SIDES.items():
        views += [("both", eye, np.array([side, 0, 0])), ("ods", eye, side * fade[..., None] * beside)]
    for kind, eye, origin in views:
        colour, distance = seen_along(origin, equirect_direction(u, v, WIDTH, HEIGHT))
        channels = {c: np.ascontiguousarray(colour[..., k].astype(np.float32)) for k, c in enumerate("RGB")} | {"depth.Z": distance.astype(np.float32)}
        file = root / f"{kind}.{eye}.0000.exr"
        OpenEXR.File({"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}, channels).write(str(file))
        PROGRAMS.run("import", file, "--camera", "ods" if kind == "ods" else "equirect", "--eye", eye, "--ipd", IPD, "--lean", 0.1, "--lock", "world",
                     "--path", root / "still.csv", "--out", root / kind)


def product(a, b):
    (w, x, y, z), (p, q, r, s) = a, b
    return w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r, w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p


def main(root):
    frames(root)
    for layout, (folder, *options) in LAYOUTS.items():
        PROGRAMS.run("encode", root / folder, *options, "--crf", 12, "--preset", "veryfast", "--out", root / f"{layout}.mkv")
    print("| the head | " + " | ".join(LAYOUTS) + " |\n|---|" + "--:|" * len(LAYOUTS))
    for head, (*turn_deg, aside_m) in HEADS.items():
        yaw, pitch, roll = np.radians(turn_deg) / 2
        quaternion = product(product((np.cos(yaw), 0, -np.sin(yaw), 0), (np.cos(pitch), np.sin(pitch), 0, 0)), (np.cos(roll), 0, 0, np.sin(roll)))
        (root / "head.csv").write_text("".join(f"{t},{aside_m},0,0," + ",".join(map(repr, map(float, quaternion))) + "\n" for t in (0, 1)))
        turn = rotation(quaternion)
        rays = unit(perspective_direction(*pixel_centres(480, 360), 480, 360, np.radians(80))) @ turn.T
        true = [srgb(seen_along(np.array([aside_m, 0, 0]) + turn @ np.array([side, 0, 0]), rays)[0]) for side in SIDES.values()]
        row = []
        for layout in LAYOUTS:
            PROGRAMS.run("play", root / f"{layout}.mkv", "--head", root / "head.csv", "--fov", 80, "--size", "480x360", "--overwrite", "--out", root / "views")
            seen = [np.asarray(Image.open(next((root / "views" / eye).glob("*.png"))).convert("RGB")) / 255.0 for eye in SIDES]
            row.append(f"{psnr_db(np.stack(seen), np.stack(true)):.1f}")
        print(f"| {head} | " + " | ".join(row) + " |", flush=True)
    print("| bytes a frame | " + " | ".join(str((root / f"{layout}.mkv").stat().st_size) for layout in LAYOUTS) + " |")


with tempfile.TemporaryDirectory(prefix="equistream_stereo_") as folder:
    main(pathlib.Path(folder))
