#!/usr/bin/env python3
"""What a refresh of the viewer costs on this machine's OpenGL, stage by stage: docs/results/viewer/refresh.json, and its tables in docs/results/viewer.md.

    refresh.py --bin build/release/bin --work W [--earlier BIN]

As `view --json --times` tells it in a window on a display without a screen (Xvfb), everything shown drawn by one eye of 1280x720. What is shown is
rendered into W first. To be run on a machine that does nothing else. --earlier takes the uploads once more by the programs in BIN, from before
pictures were mapped. Without --bin only the tables are made again.
"""

import argparse
import json
import pathlib
import subprocess
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "programs/study"), *(str(REPOSITORY / "tests/programs" / room) for room in ("", "viewer"))]
from display import Display  # noqa: E402
from kept import result_text  # noqa: E402
from pages import cell, place, table  # noqa: E402
from steps import Failed, Steps, provenance, run_as_program, write_whole  # noqa: E402

RESULT = REPOSITORY / "docs/results/viewer/refresh.json"
PAGE = REPOSITORY / "docs/results/viewer.md"
WINDOW = "1280x720"
STAGES = ("upload", "depth", "extrapolate", "reproject", "fill", "reliability", "display")
# What is shown and how. Each of a group differs from the group's first in what it is called by.
REFRESHES = {
    "depth of the scene's geometry": ["walk.mkv", "--scene", "pavilion.json", "--mirrors", "surface"],
    "mirrors and glass reworked": ["walk.mkv", "--scene", "pavilion.json", "--mirrors", "images"],
    "the small stream before push-pull": ["walk.mkv", "--scene", "pavilion.json", "--mirrors", "surface", "--fill", "small,pushpull"],
    "the stream's own depth (mesh)": ["walk.mkv", "--mirrors", "surface"],
    "rotation alone": ["walk.mkv", "--method", "rotation"],
    "moving things as frames show them": ["moving.mkv", "--scene", "motion.json", "--extrapolate", "0"],
    "moving things extrapolated": ["moving.mkv", "--scene", "motion.json"],
    "the same by the stream's own depth (mesh)": ["moving.mkv"],
}
NOW = {"carry": "extrapolate", "moving things carried on": "moving things extrapolated"}
"""Names in results of earlier versions, and what they are called now."""
UPLOADS = {"copied": ["--upload", "copied"], "mapped": ["--upload", "mapped"]}


def make_inputs(steps, sphere, large):
    quiet = ["--progress", "none"]
    for scene in ("pavilion", "motion"):
        steps.run(f"scene-{scene}", "scene", "generate", scene, "--out", ".")
    steps.run("walk", "render", "pavilion.json", "--frames", "40-47", "--size", sphere, "--spp", 4, "--aovs", "all", "--small", "right", "--out", "walk", *quiet)
    steps.run("encode-walk", "encode", "walk", "--fill", "small", "--depth", "auto", "--out", "walk.mkv", *quiet)
    steps.run("moving", "render", "motion.json", "--frames", "0-7", "--size", sphere, "--spp", 4, "--aovs", "depth,motion,ids", "--out", "moving", *quiet)
    steps.run("encode-moving", "encode", "moving", "--depth", "auto", "--motion", "auto", "--out", "moving.mkv", *quiet)
    steps.run("large", "render", "pavilion.json", "--frames", "40-43", "--size", large, "--spp", 1, "--aovs", "none", "--out", "large", *quiet)
    steps.run("encode-large", "encode", "large", "--out", "large.mp4", *quiet)


def viewed(programs, display, work, words, seconds):
    command = [str(word) for word in [programs / "equistream", "view", *words, "--size", WINDOW, "--times", "--json", "--seconds", seconds]]
    done = subprocess.run(command, cwd=work, env=display.environment, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{' '.join(command)}: exit {done.returncode}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    if report["refreshes"] == 0:
        raise Failed(f"{' '.join(command)}: expected refreshes within {seconds} s, found none")
    return {"command": " ".join(["equistream", *command[1:]]), **report}


def measure(programs, options):
    work, seconds = options.work.resolve(), options.seconds
    sizes = {"sphere": options.sphere, "large": options.large}
    work.mkdir(parents=True, exist_ok=True)
    make_inputs(Steps(work, programs, {}, sizes), **sizes)
    display = Display()
    try:
        refreshes = [{"name": name, **viewed(programs, display, work, words, seconds)} for name, words in REFRESHES.items()]
        ways = [(way, programs, words) for way, words in UPLOADS.items()]
        if options.earlier:
            ways.insert(0, ("before", options.earlier.resolve(), []))
        uploads = [{"name": way, **viewed(of, display, work, ["large.mp4", "--method", "rotation", "--decode", "software", *words], seconds)} for way, of, words in ways]
    finally:
        display.close()
    return {"command": f"tests/study/viewer/refresh.py --bin BIN --work W --sphere {options.sphere} --large {options.large} --seconds {seconds:g}",
            **provenance(programs, REPOSITORY), "window": WINDOW, **sizes, "refreshes": refreshes, "uploads": uploads}


def refresh_rows(result):
    for run in result["refreshes"]:
        stages = {NOW.get(stage, stage): ms for stage, ms in run["stages_ms"].items()}
        yield [NOW.get(run["name"], run["name"]), *(cell(stages[stage], 1) for stage in STAGES), cell(sum(stages.values()), 1), str(run["refreshes"])]


def upload_rows(result):
    for run in result["uploads"]:
        upload_ms = run["stages_ms"]["upload"] * run["refreshes"] / max(1, run["frames"])
        yield [run["name"], cell(upload_ms, 1), cell(run.get("decode_ms"), 1), str(run["frames"]), cell(run["frames"] / run["seconds"], 1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", type=pathlib.Path, help="folder for what is shown")
    parser.add_argument("--earlier", type=pathlib.Path, help="folder of programs from before pictures were mapped")
    parser.add_argument("--sphere", default="1920x960", help="size of what refreshes show (default: %(default)s)")
    parser.add_argument("--large", default="3840x1920", help="size of what is uploaded (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=30, help="of each view")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="whose tables are made")
    options = parser.parse_args()
    if options.bin:
        if not options.work:
            parser.error("--work: expected a folder, found nothing")
        write_whole(RESULT, result_text(measure(options.bin.resolve(), options)))
    result = json.loads(RESULT.read_text())
    page = options.page.read_text()
    page = place(page, "refresh", "all", table(["what is drawn", *STAGES, "all, ms", "refreshes"], list(refresh_rows(result)), labels=1))
    page = place(page, "upload", "all", table(["decoded pictures", "upload of a frame, ms", "waited for the decoder, ms", "frames", "frames/s"], list(upload_rows(result)), labels=1))
    write_whole(options.page, page)
    print(f"{options.page}: {len(result['refreshes'])} refreshes, {len(result['uploads'])} uploads")


if __name__ == "__main__":
    run_as_program(main)
