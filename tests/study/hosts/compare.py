#!/usr/bin/env python3
"""Renders one frame of each scene in both hosts and says how far they agree.

    compare.py SCENE.json ... --out FOLDER [--bin build/release/bin] [--size WxH] [--spp N] [--seeds N] [--frame N] [--require LIST]

FOLDER gets NAME.json and, side by side, NAME-colour.png (embedded, Mitsuba, difference). Exits 1 if --require fails.
"""

import argparse
import json
import pathlib
import shutil
import sys
import tempfile
import time

import numpy as np
from PIL import Image

import hosts
from independent import srgb

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from steps import machine, versions  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--bin", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    parser.add_argument("--size", default="512x256")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=4, help="independent renders of each host, at least 2")
    parser.add_argument("--frame", type=int, default=0)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="Mitsuba's; scalar_rgb starts sooner on many thousand shapes")
    parser.add_argument("--require", default="", help="of depth, motion, ids, colour: what must agree for exit 0")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the frames; else they are removed")
    settings = parser.parse_args()
    settings.width, settings.height = (int(x) for x in settings.size.split("x"))
    return settings


def save_pictures(out, name, a, b, exposure):
    """Embedded host, Mitsuba, their difference four times over around grey."""
    left, right = srgb(a.mean(0) * exposure), srgb(b.mean(0) * exposure)
    apart = np.clip(0.5 + 4 * (right - left), 0, 1)
    sheet = np.concatenate([left, right, apart], 0)
    Image.fromarray((255 * sheet + 0.5).astype(np.uint8)).save(out / f"{name}-colour.png")


def save_failures(out, name, t):
    picture = np.clip(np.abs(t).max(-1) / 10, 0, 1)
    image = Image.fromarray((255 * picture).astype(np.uint8))
    image.resize((image.width * hosts.BLOCK, image.height * hosts.BLOCK), Image.Resampling.NEAREST).save(out / f"{name}-z.png")


def meets(result, what):
    return {"depth": (result["geometry"]["depth_within_1e-4"] or 0) >= 0.999,
            "motion": min(result["geometry"]["backward_within_0.01_px"] or 0, result["geometry"]["forward_within_0.01_px"] or 0) >= 0.999,
            "ids": min(result["geometry"]["ids_agree"].values()) >= 0.999, "colour": result["colour"]["passes"]}[what]


def compare(programs, scene, settings):
    work = settings.keep / scene.stem if settings.keep else pathlib.Path(tempfile.mkdtemp(prefix="equistream_hosts_"))
    work.mkdir(parents=True, exist_ok=True)
    try:
        start = time.monotonic()
        planes_a, colours_a = hosts.frames(programs, "embree", scene, work, settings)
        middle = time.monotonic()
        planes_b, colours_b = hosts.frames(programs, "mitsuba", scene, work, settings)
        end = time.monotonic()
    finally:
        if not settings.keep:
            shutil.rmtree(work, ignore_errors=True)
    geometry = hosts.geometry(planes_a, planes_b)
    colour, t = hosts.z_test(colours_a, colours_b, np.isfinite(planes_a["depth.Z"]) & np.isfinite(planes_b["depth.Z"]))
    exposure = json.loads(scene.read_text()).get("exposure", 1)
    save_pictures(settings.out, scene.stem, colours_a, colours_b, exposure)
    if not colour["passes"]:
        save_failures(settings.out, scene.stem, t)
    result = {"scene": scene.stem, "settings": {"size": settings.size, "spp": settings.spp, "seeds": settings.seeds, "frame": settings.frame, "variant": settings.variant},
              "command": f"tests/study/hosts/compare.py {scene.name} --size {settings.size} --spp {settings.spp} --seeds {settings.seeds} "
                         f"--frame {settings.frame} --variant {settings.variant} --out FOLDER",
              "versions": versions(programs.program, REPOSITORY), "machine": machine(),
              "geometry": geometry, "colour": colour, "seconds": {"embedded": round(middle - start, 1), "mitsuba": round(end - middle, 1)}}
    kept = settings.out / "hosts.json"
    every = json.loads(kept.read_text()) if kept.exists() else {}
    kept.write_text(json.dumps({**every, scene.stem: result}, indent=1, sort_keys=True) + "\n")
    return result


def main():
    settings = arguments()
    settings.out.mkdir(parents=True, exist_ok=True)
    required = [w for w in settings.require.split(",") if w]
    failed = []
    try:
        programs = hosts.Programs(settings.bin)
        for scene in settings.scenes:
            result = compare(programs, scene, settings)
            print(json.dumps(result, indent=1), flush=True)
            failed += [f"{scene.stem}: {what}" for what in required if not meets(result, what)]
    except hosts.Failed as failure:
        sys.exit(f"compare.py: {failure}")
    if failed:
        sys.exit("compare.py: the hosts do not agree: " + "; ".join(failed))


if __name__ == "__main__":
    main()
