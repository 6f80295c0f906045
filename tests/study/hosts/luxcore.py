#!/usr/bin/env python3
"""Whether `import` reads what LuxCore writes: a room's sphere by pyluxcore (PyPI), beside the default host's (docs/results/trust/luxcore.json).

    luxcore.py --bin build/release/bin --work FOLDER [--out FILE]      with a Python that has pyluxcore and the packages of tests/requirements.txt

LuxCore takes a pixel's depth, normal and albedo where one of its samples went: ours lie in its middle. So depth is held to what the nine pixels around have.
Shares are of the pixels whose neighbours are of the same side of a box.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "tests/programs"), str(REPOSITORY / "programs/study")]
from independent import read_frame  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

SIZE, SAMPLES, EYE_M = (512, 256), 64, (0.3, 1.5, 0.2)
BOXES = [("floor", (0, -0.1, 0), (9, 0.1, 9), (0.5, 0.5, 0.5)), ("ahead", (0, 1.5, -4), (0.5, 0.9, 0.5), (0.8, 0.1, 0.1)),
         ("left", (-3, 1.2, 0), (0.4, 0.4, 0.8), (0.1, 0.8, 0.1)), ("above", (0, 5, 0), (0.6, 0.3, 0.6), (0.1, 0.1, 0.8)),
         ("behind", (1, 1, 3), (0.7, 1, 0.2), (0.7, 0.6, 0.1))]
CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def corners(middle, half):
    return [tuple(m + s * h for m, s, h in zip(middle, signs, half)) for signs in CORNERS]


def to_z_up(point):
    return point[0], -point[2], point[1]


def write_scene(folder):
    """For the default host."""
    lines, paint = ["mtllib room.mtl"], []
    for i, (name, middle, half, colour) in enumerate(BOXES):
        lines += [f"o {name}", f"usemtl {name}", *(f"v {x} {y} {z}" for x, y, z in corners(middle, half)), *(f"f {' '.join(str(8 * i + corner + 1) for corner in quad)}" for quad in QUADS)]
        paint += [f"newmtl {name}", f"Kd {' '.join(map(str, colour))}"]
    (folder / "room.obj").write_text("\n".join(lines) + "\n")
    (folder / "room.mtl").write_text("\n".join(paint) + "\n")
    description = {"model": "room.obj", "camera": {"keys": [{"time_s": 0, "position_m": EYE_M}]}, "sky": {"radiance": [1, 1, 1]}}
    (folder / "room.json").write_text(json.dumps(description) + "\n")
    return folder / "room.json"


def render_by_luxcore(folder):
    import pyluxcore
    pyluxcore.Init(lambda _message: None)

    def properties(lines):
        made = pyluxcore.Properties()
        made.SetFromString("\n".join(lines) + "\n")
        return made

    def words(values):
        return " ".join(f"{value:.9g}" for value in values)

    ahead = to_z_up((EYE_M[0], EYE_M[1], EYE_M[2] - 1))
    scene = pyluxcore.Scene()
    scene.Parse(properties(["scene.camera.type = environment", f"scene.camera.lookat.orig = {words(to_z_up(EYE_M))}", f"scene.camera.lookat.target = {words(ahead)}",
                            "scene.camera.up = 0 0 1", "scene.lights.sky.type = constantinfinite", "scene.lights.sky.color = 1 1 1"]))
    for name, middle, half, colour in BOXES:
        triangles = [triangle for a, b, c, d in QUADS for triangle in ((a, b, c), (a, c, d))]
        scene.DefineMesh(name, [to_z_up(corner) for corner in corners(middle, half)], triangles, None, None, None, None)
        scene.Parse(properties([f"scene.materials.{name}.type = matte", f"scene.materials.{name}.kd = {words(colour)}",
                                f"scene.objects.{name}.shape = {name}", f"scene.objects.{name}.material = {name}"]))
    outputs = "RGB", "DEPTH", "SHADING_NORMAL", "ALBEDO"
    written = [line for i, output in enumerate(outputs) for line in (f"film.outputs.{i}.type = {output}", f"film.outputs.{i}.filename = {folder}/lux_{output}.0000.exr")]
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties(
        ["renderengine.type = PATHCPU", "sampler.type = SOBOL", f"film.width = {SIZE[0]}", f"film.height = {SIZE[1]}", "film.filter.type = NONE",
         "film.imagepipelines.0.0.type = NOP", f"batch.haltspp = {SAMPLES}", "path.pathdepth.total = 12", *written]), scene))
    session.Start()
    while not session.HasDone():
        session.UpdateStats()
        time.sleep(0.2)
    session.GetFilm().Save()
    session.Stop()
    return pyluxcore.Version()


def compared(theirs, ours, is_sphere=True):
    def vector(frame, layer, names):
        return np.stack([frame[f"{layer}{name}"] for name in names], axis=-1)

    ids = ours["object_id"]
    inner = np.ones(ids.shape, bool)
    for axis in (0, 1):
        for step in (-1, 1):
            inner &= np.roll(ids, step, axis) == ids
    inner[[0, -1]] = False
    if not is_sphere:
        inner[:, [0, -1]] = False
    same = inner.copy()
    normals = vector(ours, "normal.", "XYZ")
    for axis in (0, 1):
        for step in (-1, 1):
            inner &= (np.roll(normals, step, axis) * normals).sum(axis=-1) > 0.99
    hit = inner & np.isfinite(ours["depth.Z"])
    depth = np.abs(theirs["depth.Z"][hit] / ours["depth.Z"][hit] - 1)
    around = np.stack([np.roll(np.where(np.isfinite(ours["depth.Z"]), ours["depth.Z"], 1e9), (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)])
    lies = (theirs["depth.Z"] >= around.min(axis=0)) & (theirs["depth.Z"] <= around.max(axis=0))
    albedo = np.abs(vector(theirs, "albedo.", "RGB") - vector(ours, "albedo.", "RGB")).max(axis=-1)[hit]
    turned = (vector(theirs, "normal.", "XYZ") * normals).sum(axis=-1)[hit]
    light = [np.mean(frame[c][same]) for frame in (theirs, ours) for c in "RGB"]
    return {"pixels": int(hit.sum()), "misses": int(np.sum(~np.isfinite(ours["depth.Z"][same]))), "misses_alike": float(np.mean(np.isfinite(theirs["depth.Z"][same]) == np.isfinite(ours["depth.Z"][same]))),
            "depth_off_p50": float(np.median(depth)), "depth_off_p99": float(np.quantile(depth, 0.99)), "depth_between_neighbours": float(np.mean(lies[hit])),
            "albedo_alike": float(np.mean(albedo < 0.01)), "normals_alike": float(np.mean(turned > 0.999)),
            "mean_light_ratio_rgb": [light[i] / light[i + 3] for i in range(3)]}


def arguments(description, out):
    """--bin, --work, a folder that is there then, and --out, a file beside the others of trust.md."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/trust" / out)
    asked = parser.parse_args()
    asked.work.mkdir(parents=True, exist_ok=True)
    return asked


def main():
    asked = arguments(__doc__, "luxcore.json")
    program, work = asked.bin.resolve() / "equistream", asked.work.resolve()
    scene = write_scene(work)
    version = render_by_luxcore(work)
    (work / "head.csv").write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "0," + ",".join(map(str, to_z_up(EYE_M))) + ",0.7071067811865476,0.7071067811865476,0,0\n")
    subprocess.run([program, "import", *(work / f"lux_{name}.####.exr" for name in ("RGB", "DEPTH", "SHADING_NORMAL", "ALBEDO")),
                    "--preset", "luxcore", "--path", work / "head.csv", "--overwrite", "--out", work / "lux"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "render", scene, "--frames", "0-0", "--size", f"{SIZE[0]}x{SIZE[1]}", "--spp", str(SAMPLES), "--unbiased", "--aovs", "depth,normal,albedo,ids", "--overwrite",
                    "--progress", "none", "--out", work / "ours"], check=True, stdout=subprocess.DEVNULL)
    found = compared(read_frame(work / "lux/centre/frame.0000.exr"), read_frame(work / "ours/centre/frame.0000.exr"))
    write_whole(asked.out, json.dumps({**provenance(asked.bin, REPOSITORY), "luxcore": version, "size": SIZE, "samples": SAMPLES, **found}, indent=1) + "\n")
    print(json.dumps(found, indent=1))
    sys.stdout.flush()
    os._exit(0)  # pyluxcore crashes where Python ends


if __name__ == "__main__":
    main()
