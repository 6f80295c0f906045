#!/usr/bin/env python3
"""Renders what the reliability map is fitted to and judged by: sources, and the eyes that their reprojection should show.

    reliability_pairs.py --bin build/release/bin --work FOLDER [--lights NAMES] [SCENE ...]

A shot is one head pose with two eyes: one at rest, 31.5 mm from the source, and one that leans by up to 0.1 m and turns. A wide
shot is a whole view at a tenth of a headset's resolution, a close one a part of it at two fifths. The source is rendered as densely
as the eyes (and made three times coarser later, which a box filter allows exactly, and which leaves the middle pixel's depth where it
was). Each picture is rendered with two seeds: their mean is the picture, their difference says where noise is too near the
tolerance. The source's frames before and after, as the head moves along the scene's path, are rendered once: a codec sees the source as one
of them.

That noise must stay far below the tolerance. FOLDER/direct has scenes without much of it: the real ones keep geometry, textures,
materials and sun, get lamps along the camera's path (relight), and show direct light only. FOLDER/path-traced has the scenes as they are:
their sources as they are streamed, of 8 samples a pixel, as rendered and denoised, at the eyes' density and a third of it. There the truth
is denoised where it must be; reference tiles of many more samples say what that made of it. Finished renders are kept: run it again to
go on.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SEEDS = {"eyes": (1, 3), "source": (2, 4), "streamed": 5}
# Frames of the shots.
SCENES = {"kitchen": (20, 100), "sibenik": (20, 90), "sponza-crytek": (62, 110), "san-miguel": (2, 80), "voxel-city": (20, 90), "pavilion": (20, 100)}
BREAKERS = {"leaf": (0,), "near": (0,), "wires": (0,), "mirror": (0,), "glass": (0,)}
DIRECT_LIGHT, PATH_TRACED = "direct", "path-traced"
# Samples per pixel and seed of the eyes and the source, scatterings.
DIRECT, GLOWING = (64, 32, 1), (32, 16, 2)
TRUE_PATH_TRACED, TRUE_GLOWING = (192, 256, 8), (64, 32, 2)
# What is streamed, path traced: the name of such a source, and its denoiser.
STREAMED_SAMPLES = 8
SOURCES = {"rendered": "off", "denoised": "balanced"}
COARSER = (1, 3)  # sources than eyes, in pixels
SMALLER = 4
# Lamps: metres above the path, side in metres, power (side squared times radiance).
LAMPS = {"kitchen": (0.35, 0.1, 4.0), "sibenik": (2.5, 1.0, 90.0), "sponza-crytek": (1.5, 0.3, 25.0), "san-miguel": (1.2, 0.03, 15.0),
         "voxel-city": (2.5, 0.5, 40.0), "pavilion": (1.0, 0.3, 15.0)}
LAMP_TIMES_S = (0.4, 2.3, 4.6)
EYE_SIZE = (192, 108)
# Name -> field of view of the eye in degrees, size of the source in pixels.
SHOTS = {"wide": (90.0, (219, 168)), "close": (28.0, (270, 180))}
LEANS_M = ((0.05, 0.03, -0.02), (-0.04, -0.05, 0.03))
TURNS_RAD = (0.05, -0.04)
FRAMES_PER_SECOND = 1000  # of the shots: eyes and source see one moment
# Of the frames around the source; what a codec makes of the seventh is neither its best nor its worst.
RUN_FRAMES, RUN_SOURCE = 10, 6


def read_path(file):
    with open(file, newline="") as lines:
        rows = [row for row in csv.reader(line for line in lines if line[0] not in "#t")]
    return np.array(rows, float)


def pose_at(path, time_s):
    """Position and quaternion w x y z of the nearest key: shots need no pose in between."""
    row = path[np.argmin(np.abs(path[:, 0] - time_s))]
    return row[1:4], row[4:8]


def times(a, b):
    """The quaternion product."""
    w, v, x, u = a[0], np.asarray(a[1:]), b[0], np.asarray(b[1:])
    return np.concatenate([[w * x - v @ u], w * u + x * v + np.cross(v, u)])


def turned(quaternion, vector):
    return times(times(quaternion, np.concatenate([[0.0], vector])), quaternion * (1, -1, -1, -1))[1:]


def write_path(file, *poses):
    """One pose a millisecond: nothing moves in between."""
    lines = ["time_s,x_m,y_m,z_m,qw,qx,qy,qz"]
    for index, (position, quaternion) in enumerate(poses):
        lines.append(f"{index / FRAMES_PER_SECOND}," + ",".join(f"{value:.9g}" for value in (*position, *quaternion)))
    file.write_text("\n".join(lines) + "\n")


def path_of(description, folder):
    camera = description["camera"]
    if "path" in camera:
        return read_path(folder / camera["path"])
    return np.array([[key["time_s"], *key["position_m"], *key["orientation_wxyz"]] for key in camera["keys"]])


class Shots:
    def __init__(self, options, light, scene):
        self.options, self.light, self.name = options, light, scene
        self.folder = options.work / light / scene
        self.folder.mkdir(parents=True, exist_ok=True)
        self.scene = self.description()
        description = json.loads(self.scene.read_text())
        self.path = path_of(description, self.scene.parent)
        self.frames_per_second = description.get("frames_per_second", 30)

    def description(self):
        described = REPOSITORY / "scenes/descriptions" / f"{self.name}.json"
        if not described.exists():
            described = self.folder / "scene" / f"{self.name}.json"
            if not described.exists():
                self.run("scene", "generate", self.name, "--out", described.parent)
        return described if self.light == PATH_TRACED or self.name not in LAMPS else self.relit(described)

    def relit(self, described):
        target = self.folder / "lamps" / f"{self.name}.json"
        if target.exists():
            return target
        target.parent.mkdir(exist_ok=True)
        description = json.loads(described.read_text())
        model = described.parent / description["model"]
        if not model.exists():
            model = pathlib.Path(os.environ["EQUISTREAM_SCENES"]) / self.name / description["model"]
        path = path_of(description, described.parent)
        above_m, side_m, power = LAMPS[self.name]
        centres = [pose_at(path, time_s)[0] + (0, above_m, 0) for time_s in LAMP_TIMES_S]
        relight(model, target.parent / f"{self.name}.glb", [(centre, side_m, power / side_m ** 2) for centre in centres])
        keys = [{"time_s": row[0], "position_m": list(row[1:4]), "orientation_wxyz": list(row[4:8])} for row in path]
        relit = {"name": self.name, "model": f"{self.name}.glb", "camera": {"keys": keys}, "head_box": {"lean_m": 0.1}, "frames_per_second": 30}
        if "sun" in description and self.name != "sibenik":  # whose sun is for its windows alone
            relit["sun"] = description["sun"]
        if "moving" in description:
            relit["moving"] = description["moving"]
        target.write_text(json.dumps(relit, indent=1))
        return target

    def run(self, *words):
        result = subprocess.run([self.options.bin / "equistream", *map(str, words)], capture_output=True, text=True)
        if result.returncode != 0:
            raise SystemExit(f"equistream {' '.join(map(str, words))}: exit {result.returncode}: {result.stderr.strip()}")

    def render(self, out, frames, *words):
        if len(list(out.glob("*/frame.*.exr"))) < frames:
            shutil.rmtree(out, ignore_errors=True)  # what is there may be of other settings
            self.run("render", self.scene, "--frames", f"0-{frames - 1}", "--fps", FRAMES_PER_SECOND, "--progress", "none", "--out", out, *words)

    def shoot(self, index, kind):
        frames = {**SCENES, **BREAKERS}[self.name]
        if index >= len(frames):
            return
        fov_deg, (width, height) = SHOTS[kind]
        folder = self.folder / f"{kind}-{index}"
        folder.mkdir(exist_ok=True)
        position, orientation = pose_at(self.path, frames[index] / self.frames_per_second)
        around = [pose_at(self.path, (frames[index] + k - RUN_SOURCE) / self.frames_per_second) for k in range(RUN_FRAMES)]
        lean = position + turned(orientation, np.array(LEANS_M[index]))
        turn = np.array([math.cos(TURNS_RAD[index] / 2), 0, math.sin(TURNS_RAD[index] / 2), 0])
        write_path(folder / "head.csv", (position, orientation))
        write_path(folder / "run.csv", *around)
        write_path(folder / "eyes.csv", (position, orientation), (lean, times(orientation, turn)))
        per_degree = EYE_SIZE[0] / 2 / math.tan(math.radians(fov_deg) / 2) * math.pi / 180

        def eyes(name, smaller, *words):
            size = "x".join(str(side // smaller) for side in EYE_SIZE)
            self.render(folder / name, 2, "--path", folder / "eyes.csv", "--camera", "perspective", "--eye", "left", "--fov", fov_deg, "--size", size, *words)

        def sphere(name, path, frames, coarser, *words):
            self.render(folder / name, frames, "--path", folder / path, "--lock", "path", "--range", f"{width / per_degree:.9g},{height / per_degree:.9g}",
                        "--size", f"{width // coarser}x{height // coarser}", *words)

        if self.light == PATH_TRACED:
            self.shoot_path_traced(eyes, sphere)
        else:
            self.shoot_direct(eyes, sphere)
        print(f"{self.light} {self.name} {kind}-{index}", flush=True)

    def shoot_direct(self, eyes, sphere):
        eye_samples, source_samples, bounces = GLOWING if self.name in BREAKERS else DIRECT
        light = ("--max-bounces", bounces, "--spp")
        for run in (0, 1):
            eyes(f"eyes-{run}", 1, "--aovs", "depth", *light, eye_samples, "--seed", SEEDS["eyes"][run])
            sphere(f"source-{run}", "head.csv", 1, 1, "--aovs", "depth,specular", *light, source_samples, "--seed", SEEDS["source"][run])
        sphere("run", "run.csv", RUN_FRAMES, 1, "--aovs", "depth", *light, source_samples, "--seed", SEEDS["source"][0])

    def shoot_path_traced(self, eyes, sphere):
        eye_samples, source_samples, bounces = TRUE_GLOWING if self.name in BREAKERS else TRUE_PATH_TRACED
        light = ("--max-bounces", bounces, "--spp")
        for run in (0, 1):
            true = ("--denoise", "high", "--aovs", "depth,specular,raw,reference", *light)
            eyes(f"eyes-{run}", 1, *true, eye_samples, "--seed", SEEDS["eyes"][run])
            sphere(f"source-{run}", "head.csv", 1, 1, *true, source_samples, "--seed", SEEDS["source"][run])
        for name, denoiser in SOURCES.items():
            streamed = ("--denoise", denoiser, "--aovs", "depth,specular", *light, STREAMED_SAMPLES, "--seed", SEEDS["streamed"])
            eyes(f"small-{name}", SMALLER, *streamed)
            for coarser in COARSER:
                eyes(f"eyes-{name}-{coarser}", coarser, *streamed)
                sphere(f"run-{name}-{coarser}", "run.csv", RUN_FRAMES, coarser, *streamed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=[*SCENES, *BREAKERS], help=", ".join((*SCENES, *BREAKERS)))
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder for the renders; not in the repository")
    parser.add_argument("--lights", default=f"{DIRECT_LIGHT},{PATH_TRACED}", help="names between commas (%(default)s)")
    options = parser.parse_args()
    options.bin, options.work = options.bin.resolve(), options.work.resolve()
    # A first shot of every scene before the second of any.
    for index in (0, 1):
        for light in options.lights.split(","):
            for kind in SHOTS:
                for scene in options.scenes:
                    Shots(options, light, scene).shoot(index, kind)


JSON_CHUNK, BIN_CHUNK = 0x4E4F534A, 0x004E4942


def read_glb(file):
    data = pathlib.Path(file).read_bytes()
    if data[:4] != b"glTF":
        raise SystemExit(f"{file}: expected a binary glTF, found something else")
    chunks, at = {}, 12
    while at < len(data):
        length, kind = struct.unpack_from("<II", data, at)
        chunks[kind] = data[at + 8:at + 8 + length]
        at += 8 + length
    return json.loads(chunks[JSON_CHUNK]), chunks[BIN_CHUNK]


def write_glb(file, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    pathlib.Path(file).write_bytes(struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<II", len(text), JSON_CHUNK) + text
                                   + struct.pack("<II", len(binary), BIN_CHUNK) + binary)


def card(centre, side_m, towards):
    """Four corners of a square around a centre, and its two triangles."""
    normal = np.asarray(towards, float) / np.linalg.norm(towards)
    across = np.cross(normal, [0.0, 0.3, 1.0])
    across /= np.linalg.norm(across)
    along = np.cross(normal, across)
    corners = [centre + 0.5 * side_m * (s * across + t * along) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return np.asarray(corners, np.float32), np.asarray([0, 1, 2, 0, 2, 3], np.uint16)


def add(document, binary, values, target, component, kind):
    """Another accessor over bytes at the end of the buffer."""
    binary += b"\0" * (-len(binary) % 4)
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes, "target": target})
    accessor = {"bufferView": len(document["bufferViews"]) - 1, "componentType": component, "count": len(values), "type": kind}
    if kind == "VEC3":
        accessor.update(min=values.min(axis=0).tolist(), max=values.max(axis=0).tolist())
    document["accessors"].append(accessor)
    return binary + values.tobytes(), len(document["accessors"]) - 1


def relight(source, target, lamps):
    """`lamps`: (centre in metres, side in metres, radiance) each."""
    document, binary = read_glb(source)
    for material in document["materials"]:
        material.pop("emissiveFactor", None)
        material.get("extensions", {}).pop("KHR_materials_emissive_strength", None)
    used = set(document.get("extensionsUsed", [])) | {"KHR_materials_emissive_strength"}
    document["extensionsUsed"] = sorted(used)
    for index, (centre, side_m, radiance) in enumerate(lamps):
        corners, triangles = card(np.asarray(centre, float), side_m, (0.25, 1, 0.15 + 0.1 * index))
        binary, positions = add(document, binary, corners, 34962, 5126, "VEC3")
        binary, indices = add(document, binary, triangles, 34963, 5123, "SCALAR")
        document["materials"].append({"name": f"lamp {index}", "doubleSided": True, "emissiveFactor": [1, 1, 1],
                                      "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
                                      "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": radiance},
                                                     "KHR_materials_ior": {"ior": 1}}})
        document["meshes"].append({"name": f"lamp {index}", "primitives": [
            {"attributes": {"POSITION": positions}, "indices": indices, "material": len(document["materials"]) - 1}]})
        document["nodes"].append({"name": f"lamp {index}", "mesh": len(document["meshes"]) - 1})
        document["scenes"][document.get("scene", 0)]["nodes"].append(len(document["nodes"]) - 1)
    document["extensionsUsed"] = sorted(set(document["extensionsUsed"]) | {"KHR_materials_ior"})
    document["buffers"][0]["byteLength"] = len(binary)
    write_glb(target, document, binary)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("reliability_pairs.py: interrupted; run it again to go on")
