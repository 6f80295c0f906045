#!/usr/bin/env python3
"""Files that others wrote, whole and damaged ones: which are read, which refused, and whether what is read is right.

usage: foreign_files.py BIN_DIR --report FILE [--fuzz BUILD] NAME=FOLDER...

EXR files are imported as one picture and compared with the package OpenEXR, pixel by pixel. OBJ and glTF files are scenes' models; their triangles and their
extent are compared with the packages tinyobjloader and trimesh. *refused* is one line and status 2; anything else but status 0 is a fault, and so are a minute
or 4 GiB. --fuzz: each file goes through the fuzz target of its kind too, whose build has sanitizers; a find is a fault.
"""

import argparse
import collections
import json
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from kept import result_text  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

SECONDS, BYTES = 60, 4 << 30
TARGETS = {"exr": "foreign_exr", "obj": "obj", "gltf": "model"}
SAME_M, SAME_HALF = 1e-4, 1e-3
"""Of an extent, relative to its size; of a pixel, relative: frames hold halves."""


def kind_of(path):
    """exr, obj, gltf; None: of no such kind."""
    if not path.is_file():
        return None
    if path.suffix.lower() in (".exr", ".obj"):
        return path.suffix.lower()[1:]
    if path.suffix.lower() in (".gltf", ".glb"):
        return "gltf"
    is_exr = open(path, "rb").read(4) == b"\x76\x2f\x31\x01"
    return "exr" if is_exr or "Damaged" in path.parts and not path.suffix else None


def run(words, cwd):
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    try:
        return subprocess.run([str(word) for word in words], cwd=cwd, capture_output=True, text=True, errors="replace", timeout=SECONDS, preexec_fn=limit)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(words, -1, "", f"more than {SECONDS} s")


def outcome(done):
    lines = [line for line in done.stderr.strip().splitlines() if not re.search(r": no file \"|left out", line)]
    if done.returncode == 0:
        return "read", ""
    if done.returncode == 2 and len(lines) == 1:
        return "refused", lines[0]
    return "fault", f"status {done.returncode}: {' / '.join(lines)[-300:]}"


def gltf_shape(path):
    """How many triangles, and their corners, by trimesh."""
    import trimesh
    scene = trimesh.load_scene(str(path))
    placed = [(scene.graph[node][0], scene.geometry[scene.graph[node][1]]) for node in scene.graph.nodes_geometry]
    corners = [trimesh.transform_points(mesh.vertices[np.unique(mesh.faces)], place) for place, mesh in placed]
    return sum(len(mesh.faces) for _, mesh in placed), np.concatenate(corners)


def obj_shape(path):
    """The same by tinyobjloader: trimesh takes an index that counts from the end from the wrong one."""
    import tinyobjloader
    reader, config = tinyobjloader.ObjReader(), tinyobjloader.ObjReaderConfig()
    config.triangulate = True
    if not reader.ParseFromFile(str(path), config):
        raise ValueError(reader.Error())
    indices = np.array([index.vertex_index for shape in reader.GetShapes() for index in shape.mesh.indices], int)
    return len(indices) // 3, np.array(reader.GetAttrib().vertices).reshape(-1, 3)[indices]


class Judge:
    def __init__(self, programs, room):
        self.program, self.room, self.number = programs / "equistream", room, 0

    def exr(self, path):
        self.number += 1
        picture = self.room / f"picture.{self.number:06}.exr"
        picture.symlink_to(path)
        out = self.room / f"imported-{self.number}"
        said, why = outcome(run([self.program, "import", picture, "--fov", "60", "--colour-space", "rec709", "--progress", "none", "--out", out], self.room))
        return said, why, self.same_pixels(path, out) if said == "read" else None

    @staticmethod
    def same_pixels(path, out):
        """None: the other reader does not read it, or it has not the colours that we take."""
        import OpenEXR
        frames = list(out.rglob("frame.*.exr"))
        try:
            with OpenEXR.File(str(path), separate_channels=True) as file:
                theirs = [file.parts[0].channels[name].pixels.astype(np.float32) for name in "RGB"]
                window = file.parts[0].header["dataWindow"]
                display = file.parts[0].header["displayWindow"]
                has_views = "multiView" in file.parts[0].header
        except Exception:
            return None
        if has_views or [list(map(int, corner)) for corner in window] != [list(map(int, corner)) for corner in display]:
            return None  # what lies beyond or is missing is import's own rule, which import_test holds
        with OpenEXR.File(str(frames[0]), separate_channels=True) as file:
            ours = [file.parts[0].channels[name].pixels.astype(np.float32) for name in "RGB"]
        if ours[0].shape != theirs[0].shape:
            return False
        with np.errstate(invalid="ignore", over="ignore"):
            fine = [(np.abs(a - b) <= SAME_HALF * np.abs(b) + 1e-6) | ~np.isfinite(b) | (np.abs(b) > 60000) | (b < 0) for a, b in zip(ours, theirs)]
        compared = np.mean([np.isfinite(b) & (np.abs(b) <= 60000) & (b >= 0) for b in theirs])
        return bool(np.all(fine)) if compared > 0.5 else None

    def model(self, path):
        description = self.room / "described.json"
        description.write_text(json.dumps({"model": str(path), "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}}))
        done = run([self.program, "scene", "info", description, "--json"], self.room)
        said, why = outcome(done)
        return said, why, self.same_shape(path, json.loads(done.stdout), done.stderr) if said == "read" else None

    @staticmethod
    def same_shape(path, info, warnings):
        """None: the other reader does not read it."""
        try:
            triangles, corners = (obj_shape if kind_of(path) == "obj" else gltf_shape)(path)
        except Exception:
            return None
        if not len(corners):
            return None
        bounds = np.array([corners.min(axis=0), corners.max(axis=0)])
        without_area = sum(1 + int(more or 0) for more in re.findall(r"a face without an area is left out(?: \(and (\d+) more\))?", warnings))
        size = float(np.linalg.norm(bounds[1] - bounds[0])) or 1.0
        is_as_large = np.abs(np.array(info["bounding_box_m"]) - bounds).max() <= SAME_M * size
        return bool(triangles in (info["triangles"], info["triangles"] + without_area) and is_as_large)

    obj = gltf = model


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("sources", nargs="+", metavar="NAME=FOLDER")
    parser.add_argument("--report", type=pathlib.Path, required=True)
    parser.add_argument("--fuzz", type=pathlib.Path)
    asked = parser.parse_args()
    counts, told = collections.defaultdict(collections.Counter), []
    with tempfile.TemporaryDirectory() as room:
        judge = Judge(asked.bin.resolve(), pathlib.Path(room))
        for name, folder in (source.split("=", 1) for source in asked.sources):
            for path in sorted(pathlib.Path(folder).resolve().rglob("*")):
                kind = kind_of(path)
                if kind is None:
                    continue
                said, why, is_right = getattr(judge, kind)(path)
                if asked.fuzz:
                    done = run_fuzzed(asked.fuzz / f"bin/fuzz_{TARGETS[kind]}", path)
                    if done:
                        said, why = "fault", done
                row = counts[f"{name}, {kind}"]
                row[said] += 1
                row["right"] += is_right is True
                row["other"] += is_right is False
                if said == "fault" or is_right is False or said == "refused":
                    told.append({"file": f"{name}/{path.relative_to(pathlib.Path(folder).resolve())}", "is": "otherwise" if is_right is False else said,
                                 "why": why.replace(str(path.parent), "").replace(room, "")[-200:]})
                    if said != "refused":
                        print(f"{told[-1]}", flush=True)
    report = {**provenance(asked.bin, REPOSITORY), "kinds": {name: dict(row) for name, row in counts.items()}, "told": told}
    write_whole(asked.report, result_text(report))
    for name, row in counts.items():
        print(name, dict(row))
    return any(row["fault"] or row["other"] for row in counts.values())


def run_fuzzed(program, path):
    """What a sanitizer says; empty: nothing."""
    done = subprocess.run([program, "-timeout=60", "-rss_limit_mb=6000", "-malloc_limit_mb=3000", path], capture_output=True, text=True, errors="replace",
                          timeout=600, env={"ASAN_OPTIONS": "new_delete_type_mismatch=0:detect_leaks=0", "LLVM_PROFILE_FILE": "/dev/null"})
    lines = [line for line in done.stderr.splitlines() if re.search("ERROR|runtime error|find:|SUMMARY", line)]
    return "" if done.returncode == 0 else (lines or ["no message"])[0][-200:]


if __name__ == "__main__":
    sys.exit(main())
