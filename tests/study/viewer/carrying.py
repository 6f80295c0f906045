#!/usr/bin/env python3
"""What motion extrapolation is worth while frames are late: docs/results/latency/carrying.json, and the tables of docs/results/latency.md.

    carrying.py --bin build/release/bin --work W

The scene is the bundled `motion`, which glows and so has no noise: what differs from the truth differs in place. Every refresh is compared with a
render of both eyes at that refresh's own time. Without --bin only the tables are made again.
"""

import argparse
import json
import math
import pathlib
import sys

import numpy as np
from PIL import Image

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "programs/study"), str(REPOSITORY / "tests/programs")]
from independent import colour_of, read_frame, srgb  # noqa: E402
from kept import result_text  # noqa: E402
from pages import cell, place, table  # noqa: E402
from steps import Steps, provenance, run_as_program, write_whole  # noqa: E402

RESULT = REPOSITORY / "docs/results/latency/carrying.json"
PAGE = REPOSITORY / "docs/results/latency.md"
SPHERE, EYES, FOV_DEG = "960x480", "400x400", 100
FRAMES, REFRESH_HZ, FIRST, LAST = 30, 90, 45, 84  # refreshes that every network has something to show for
PITCH_DEG, SWAY_RAD = 35, 0.3  # the ball is behind, the block above
NETWORKS = {"50 ms": "delay=50", "100 ms": "delay=100", "200 ms": "delay=200", "100 ms, 300 ms of silence": "delay=100,stall=0.4:0.3"}
METHOD = ["--method", "mesh", "--depth", "stream"]
SHOWN = {"held": ["--extrapolate", "0"], "carried": []}
"""How moving objects are shown. The page calls `carried` extrapolated."""


def write_head(work):
    """The sphere's path, looking back and up, and swaying."""
    def product(a, b):
        w, x, y, z = a
        p, q, r, s = b
        return w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r, w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p

    pitch = math.radians(PITCH_DEG) / 2
    rows = []
    for key in json.loads((work / "motion.json").read_text())["camera"]["keys"]:
        yaw = (math.pi + SWAY_RAD * math.sin(2 * key["time_s"])) / 2
        turn = product((math.cos(yaw), 0, math.sin(yaw), 0), (math.cos(pitch), math.sin(pitch), 0, 0))
        rows.append(",".join(repr(float(value)) for value in [key["time_s"], *key["position_m"], *turn]))
    write_whole(work / "head.csv", "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "\n".join(rows) + "\n")


def make_inputs(steps, work):
    steps.run("scene", "scene", "generate", "motion", "--out", ".")
    write_head(work)
    common = ["--progress", "none"]
    steps.run("frames", "render", "motion.json", "--frames", f"0-{FRAMES}", "--size", SPHERE, "--spp", 4, "--aovs", "depth,motion,ids", "--out", "frames", *common)
    steps.run("truth", "render", "motion.json", "--camera", "perspective", "--eye", "both", "--path", "head.csv", "--fps", REFRESH_HZ, "--frames", f"{FIRST}-{LAST}",
              "--size", EYES, "--fov", FOV_DEG, "--spp", 4, "--seed", 2, "--aovs", "ids", "--out", "truth", *common)
    steps.run("encode", "encode", "frames", "--out", "motion.mp4", "--depth", "auto", "--motion", "auto", "--json", *common)
    return json.loads(steps.output_of("encode"))


def truths(work):
    """Refresh -> both eyes' display pixels and which of them show what moves: the objects that the generator adds last."""
    moving = len(json.loads((work / "motion.json").read_text())["moving"])
    first = read_frame(work / "frames/centre/frame.0000.exr")["object_id"]
    movers = np.unique(first)[-moving:]
    for refresh in range(FIRST, LAST + 1):
        for eye in ("left", "right"):
            frame = read_frame(work / f"truth/{eye}/frame.{refresh:04}.exr")
            yield refresh, eye, 255 * srgb(colour_of(frame)), np.isin(frame["object_id"], movers)


def pixels(work, out, eye, refresh):
    return np.asarray(Image.open(work / out / eye / f"frame.{refresh:04}.png").convert("RGB"), float)


def decibels(squares, count):
    return 10 * math.log10(255 ** 2 * 3 * count / squares)


def score(work, outs):
    """Of each run: dB over all refreshes, of what moves and of all; and how much one refresh differs from the one before at most, in 1/255."""
    sums = {out: {"moving": 0.0, "all": 0.0} for out in outs}
    counts, steps, before = {"moving": 0, "all": 0}, {out: 0.0 for out in outs}, {}
    for refresh, eye, truth, moves in truths(work):
        counts["moving"] += int(moves.sum())
        counts["all"] += moves.size
        for out in outs:
            seen = pixels(work, out, eye, refresh)
            squares = ((seen - truth) ** 2).sum(-1)
            sums[out]["moving"] += float(squares[moves].sum())
            sums[out]["all"] += float(squares.sum())
            if (last := before.get((out, eye))) is not None:
                steps[out] = max(steps[out], float(np.abs(seen - last).mean()))
            before[out, eye] = seen
    return {out: {"moving_db": decibels(sums[out]["moving"], counts["moving"]), "all_db": decibels(sums[out]["all"], counts["all"]),
                  "largest_step_255": steps[out]} for out in outs}, counts["moving"] / counts["all"]


def measure(programs, work):
    work.mkdir(parents=True, exist_ok=True)
    steps = Steps(work, programs, {}, {"sphere": SPHERE, "eyes": EYES})
    encoded = make_inputs(steps, work)
    runs = {}
    for network, spec in NETWORKS.items():
        for shown, options in SHOWN.items():
            out = f"{shown}-{'-'.join(spec.replace('=', ' ').replace(',', ' ').replace(':', ' ').split())}"
            record = steps.run(out, "play", "motion.mp4", *METHOD, "--head", "head.csv", "--refresh", REFRESH_HZ, "--network", spec, *options,
                               "--size", EYES, "--fov", FOV_DEG, "--out", out, "--progress", "none")
            runs[out] = {"network": network, "carry": shown, "command": record["command"]}
    scores, moving_share = score(work, list(runs))
    for out, run in runs.items():
        report = json.loads((work / out / "report.json").read_text())
        moved = [frame["moved_on"]["ms"] for frame in report["frames"] if "moved_on" in frame]
        run.update(scores[out], age_ms=report["viewing"]["age_ms"], moved_on_ms={"mean": float(np.mean(moved)), "max": max(moved)} if moved else None)
    return {"command": "tests/study/viewer/carrying.py --bin BIN --work W", **provenance(programs, REPOSITORY), "seed": 2, "motion": encoded["motion"], "colour_bytes": encoded["tracks"][0]["bytes"],
            "moving_share": moving_share, "refreshes": [FIRST, LAST], "runs": list(runs.values())}


def rows(result):
    by = {(run["network"], run["carry"]): run for run in result["runs"]}
    for network in NETWORKS:
        held, extrapolated = (by[network, shown] for shown in SHOWN)
        yield [network, cell(extrapolated["age_ms"]["mean"], 0), cell(extrapolated["moved_on_ms"]["mean"], 0),
               *(cell(run[key], 1) for key in ("moving_db", "all_db", "largest_step_255") for run in (held, extrapolated))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders and streams")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="whose tables are made")
    options = parser.parse_args()
    if options.bin:
        write_whole(RESULT, result_text(measure(options.bin, options.work.resolve())))
    result = json.loads(RESULT.read_text())
    motion = result["motion"]
    page = place(options.page.read_text(), "bytes", "motion", table(["bodies", "frames", "motion, bytes a frame", "of colour's, %", "moved in 0.2 s, px", "error left, px", "95 %, worst frame, px"], [[
        str(motion["most_regions"]), str(motion["frames"]), cell(motion["bytes"] / motion["frames"], 0), cell(100 * motion["share_of_colour"], 2),
        cell(motion["mean_motion_px"], 1), cell(motion["mean_error_px"], 3), cell(motion["worst_p95_error_px"], 3)]]))
    page = place(page, "carrying", "motion", table(["network", "age of frames, ms", "extrapolated, ms", "what moves: held, dB", "extrapolated, dB", "all: held, dB", "extrapolated, dB",
                                                    "largest step: held", "extrapolated"], list(rows(result))))
    write_whole(options.page, page)
    print(f"{options.page}: {len(result['runs'])} runs")


if __name__ == "__main__":
    run_as_program(main)
