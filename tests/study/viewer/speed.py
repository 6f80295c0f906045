#!/usr/bin/env python3
"""Keeps what ./bench prints of the client on the GPU: docs/results/viewer/speed.json, and its tables in docs/results/viewer.md.

    speed.py --bin build/release/bin

To be run on a machine that does nothing else; without --bin only the tables are made again.
"""

import argparse
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from baselines import bench_result  # noqa: E402
from kept import result_text  # noqa: E402
from pages import cell, place, table  # noqa: E402
from steps import run_as_program, write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
FIGURES = "^gl_"
RESULT = REPOSITORY / "docs/results/viewer/speed.json"
PAGE = REPOSITORY / "docs/results/viewer.md"


def triangles(result, name):
    """As the label of a figure's side says."""
    for note in result["notes"]:
        found = re.match(rf"{re.escape(name)}: (\d+) triangles drawn a frame of (\d+)", note)
        if found:
            return tuple(int(n) for n in found.groups())
    return None


def depth_rows(result):
    scenes = sorted({f["name"].removeprefix("gl_depth_") for f in result["figures"] if f["name"].startswith("gl_depth_")})
    sides = ("eye", "both_eyes", "paper_1_draw", "paper_7_draws")
    for scene in scenes:
        of = {f["peer"]: f for f in result["figures"] if f["name"] == f"gl_depth_{scene}"}
        drawn = {side: triangles(result, f"gl_depth_{scene}/{side}") for side in ("ours", *sides)}
        ours_ms = next(iter(of.values()))["ms"]
        yield [scene, f"{drawn['ours'][1]:,}", f"{cell(ours_ms, 0)} ({drawn['ours'][0]:,})",
               *(f"{cell(of[side]['ratio'] * ours_ms, 0)} ({drawn[side][0]:,})" for side in sides), cell(1 / of["eye"]["ratio"], 2), cell(of["paper_7_draws"]["ratio"], 1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="whose tables are made")
    options = parser.parse_args()
    if options.bin:
        write_whole(RESULT, result_text(bench_result(options.bin, REPOSITORY, FIGURES)))
    result = json.loads(RESULT.read_text())
    page = options.page.read_text()
    page = place(page, "depth", "all", table(["scene", "triangles", "a sphere's samples that an eye looks up, ms (triangles)", "an eye", "both eyes", "paper: 1 draw, an eye",
                                              "paper: 7 draws, a sphere", "sphere / eye", "7 draws / ours"], list(depth_rows(result))))
    eyes = [[f["name"], f["peer"], cell(f["ms"], 1), cell(f["ratio"], 2)] for f in result["figures"] if f["name"].startswith("gl_eyes")]
    page = place(page, "eyes", "all", table(["figure", "peer", "ours, ms", "peer / ours"], eyes))
    write_whole(options.page, page)
    print(f"{options.page}: {len(result['figures'])} figures")


if __name__ == "__main__":
    run_as_program(main)
