#!/usr/bin/env python3
"""Whether `import` reads what Mitsuba's own integrators write: a room by `aov` and by `path` alone, beside our plugin's exact planes of the same cameras.

    mitsuba_own.py --bin build/release/bin --work FOLDER [--out FILE]      with build/venv/bin/python3; plugins/ of the build lies beside its bin/

`aov` takes a plane where each sample went, and the film averages them; ours lie in the pixel's middle. So depth is held to what the nine pixels around have.
Shares are of the pixels whose neighbours are of the same side of a box. Where boxes meet the sky, `aov` averages distances and zeros: those pixels are counted apart.
"""

import json
import pathlib
import subprocess
import sys

import mitsuba as mi
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "tests/programs"), str(REPOSITORY / "programs/study")]
from independent import colour_of, read_frame  # noqa: E402
from kept import result_text  # noqa: E402
from luxcore import BOXES, EYE_M, arguments, compared  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

SAMPLES, FLAT, SPHERE, FOV_DEG = 64, (480, 320), (512, 256), 80
LOOK_AT_M, UP = (-1.6, 1.1, -3.0), (0.2, 1, 0.1)
PLANES = "depth:depth,normal:sh_normal,albedo:albedo,object_id:shape_index"
FLOATS = {"component_format": "float32", "rfilter": {"type": "box"}}
CAMERAS = {"flat": {"type": "perspective", "fov": FOV_DEG, "near_clip": 0.25, "film": FLOATS},
           "sphere": {"type": "equirect", "film": FLOATS},
           "defaults": {"type": "perspective", "fov": FOV_DEG, "film": {}}}
"""The last has Mitsuba's own film, which is of halves and a Gaussian filter, and its own near plane."""
IMPORTED_WITH = {"flat": ["--fov", FOV_DEG, "--near", 0.25], "sphere": [], "defaults": ["--fov", FOV_DEG]}


def scene():
    """The room, a panel whose back is seen, and the cameras: those of exact planes have a film of floats, whatever the other has."""
    def diffuse(colour):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}

    to_world = mi.ScalarTransform4f().look_at(origin=EYE_M, target=LOOK_AT_M, up=UP)
    parts = {"type": "scene", "sky": {"type": "constant"}}
    for name, middle, half, colour in BOXES:
        parts[name] = {"type": "cube", "to_world": mi.ScalarTransform4f().translate(middle).scale(half), "bsdf": diffuse(colour)}
    parts["panel"] = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([-1.8, 2.2, -3.2]).rotate([0, 1, 0], 160).scale(0.5),
                      "bsdf": {"type": "twosided", "of": diffuse((0.2, 0.6, 0.6))}}
    sensors = []
    for name, camera in CAMERAS.items():
        width, height = SPHERE if name == "sphere" else FLAT
        for film in (camera["film"], FLOATS):
            sensors.append({**camera, "to_world": to_world, "film": {"type": "hdrfilm", "width": width, "height": height, **film},
                            "sampler": {"type": "independent", "sample_count": SAMPLES}})
    return mi.load_dict({**parts, **{f"camera{i}": sensor for i, sensor in enumerate(sensors)}})


def render(room, sensor, integrator, file, seed, samples=SAMPLES):
    mi.render(room, sensor=room.sensors()[sensor], integrator=mi.load_dict(integrator), spp=samples, seed=seed)
    room.sensors()[sensor].film().write(str(file))


def path_of(room):
    """Of the head that rests: Mitsuba's cameras look along +Z and have +X to their left."""
    matrix = np.array(room.sensors()[0].world_transform().matrix, float).reshape(4, 4)
    x, y, z = -matrix[:3, 0], matrix[:3, 1], -matrix[:3, 2]
    w = 0.5 * np.sqrt(1 + x[0] + y[1] + z[2])
    pose = [0, *matrix[:3, 3], w, (y[2] - z[1]) / (4 * w), (z[0] - x[2]) / (4 * w), (x[1] - y[0]) / (4 * w)]
    return "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + ",".join(f"{value:.9g}" for value in pose) + "\n"


def colour_equal(imported, file):
    """Our frames' colour is of halves."""
    return float(np.mean(colour_of(imported) == colour_of(read_frame(file)).astype(np.float16)))


def around(values):
    return np.stack([np.roll(values, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)])


def beside_sky(theirs, ours):
    """Where hits and misses meet; depth nearer than anything around is one that zeros were averaged into."""
    hits = around(np.isfinite(ours["depth.Z"]))
    edge = hits.any(axis=0) & ~hits.all(axis=0)
    edge[[0, -1]] = edge[:, [0, -1]] = False
    nearest = around(ours["depth.Z"]).min(axis=0)
    return {"beside_sky": int(edge.sum()), "beside_sky_too_near": int(np.sum(theirs["depth.Z"][edge] < nearest[edge] * 0.999))}


def ids_alike(theirs, ours):
    """Numbers differ, shapes do not: of the pixels whose neighbours are of the same shape, those with their shape's most frequent number."""
    alike, of, numbers = 0, 0, []
    for shape in np.unique(ours["object_id"]):
        inner = (around(ours["object_id"]) == shape).all(axis=0)
        inner[[0, -1]] = inner[:, [0, -1]] = False
        values, counts = np.unique(theirs["object_id"][inner], return_counts=True)
        if len(counts):
            numbers.append(int(values[counts.argmax()]))
            alike, of = alike + counts.max(), of + counts.sum()
    return {"shapes_seen": len(numbers), "ids_alike": float(alike / of) if len(set(numbers)) == len(numbers) else 0.0}


def main():
    asked = arguments(__doc__, "mitsuba_own.json")
    program, work = asked.bin.resolve() / "equistream", asked.work.resolve()
    result = {"command": "mitsuba_own.py --bin build/release/bin --work FOLDER", **provenance(asked.bin, REPOSITORY)}
    mi.set_variant("llvm_ad_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    mi.file_resolver().append(str(asked.bin.resolve().parent))
    room, nested = scene(), {"type": "path", "max_depth": 8}
    (work / "head.csv").write_text(path_of(room))

    def imported(name, *options, files=()):
        subprocess.run([program, "import", *(files or [work / f"{name}.exr"]), "--path", work / "head.csv", *map(str, options), "--overwrite", "--out", work / name],
                       check=True, stdout=subprocess.DEVNULL)
        return read_frame(work / name / "centre/frame.0000.exr")

    found = {}
    for i, name in enumerate(CAMERAS):
        render(room, 2 * i, {"type": "aov", "aovs": PLANES, "nested": nested}, work / f"{name}.exr", 1)
        render(room, 2 * i + 1, {"type": "equirect_aov", "aovs": "depth,normal,albedo,ids", "nested": nested}, work / f"{name}_ours.exr", 2)
        theirs, ours = imported(name, *IMPORTED_WITH[name]), read_frame(work / f"{name}_ours.exr")
        found[name] = {**compared(theirs, ours, name == "sphere"), **ids_alike(theirs, ours), **beside_sky(theirs, ours),
                       "colour_equal": colour_equal(theirs, work / f"{name}.exr")}
    # Colour by `path` alone, and then beside planes that one sample gave.
    render(room, 0, nested, work / "beauty.exr", 1)
    render(room, 0, {"type": "aov", "aovs": PLANES, "nested": nested}, work / "planes.exr", 3, samples=1)
    found["path_alone"] = {"colour_equal": colour_equal(imported("beauty", "--fov", FOV_DEG), work / "beauty.exr")}
    theirs, ours = imported("both", *IMPORTED_WITH["flat"], files=[work / "beauty.exr", work / "planes.exr"]), read_frame(work / "flat_ours.exr")
    found["planes_of_one_sample"] = {**compared(theirs, ours, False), **ids_alike(theirs, ours), **beside_sky(theirs, ours),
                                     "colour_equal": colour_equal(theirs, work / "beauty.exr")}
    write_whole(asked.out, result_text({**result, "mitsuba": mi.__version__, "samples": SAMPLES, "files": found}, 3))
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
