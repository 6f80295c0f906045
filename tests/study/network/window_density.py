#!/usr/bin/env python3
"""At which CRF a window looks better with half of its pixels: docs/results/stream/window_density.json, and the table of docs/decisions/0018.

    window_density.py --bin build/release/bin --work FOLDER [SCENE ...]

A window of 100x70 degrees goes along the path: with all of its pixels, and with half of them once, twice and three times
(`halved_window_grid` of plugin/include/equistream/window.h). Each is coded at several CRFs, and its depth as `serve` divides CRF between them.
Views are held to path-traced truths of two seeds: whole error. Bytes are the window's, colour and depth. Renders stay in FOLDER.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from kept import result_text  # noqa: E402
from pages import place, table  # noqa: E402
from steps import Failed, provenance, run_as_program, write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RESULTS, PAGE = REPOSITORY / "docs/results/stream/window_density.json", REPOSITORY / "docs/decisions/0018-transports.md"
COLUMNS, CRFS, DENOISE = (1920, 1344, 960, 672), (20, 26, 32, 38, 44), ("off", "balanced")
FIRST, LAST, SCORED, SPHERE, WINDOW, SPP = 30, 37, "35-37", "480x240", "gaze,100x70", 4
EYE, TRUTH_SPP, TRUTH_SEEDS, SEED = "640x360", 48, (101, 102), 1
BEST_CRF, COLOUR_FIRST, WORST_CRF = 16, 12, 51
BUNDLED = ("pavilion", "materials", "motion")


class Scene:
    def __init__(self, options, name):
        self.program, self.work = options.bin / "equistream", options.work / name
        self.description = REPOSITORY / f"scenes/descriptions/{name}.json"
        if name in BUNDLED:
            self.description = self.work / f"scene/{name}.json"
            self.description.exists() or self.run("scene", "generate", name, "--out", self.work / "scene")

    def run(self, *words):
        words = [str(word) for word in (self.program, *words)]
        return subprocess.run(words, check=True, capture_output=True, text=True).stdout

    def render(self, name, frames, *words):
        """Frames that are there already stay."""
        self.run("render", self.description, "--frames", frames, *words, "--progress", "none", "--out", self.work / name)
        return self.work / name

    def truths(self):
        return [self.render(f"truth-{seed}", SCORED, "--camera", "perspective", "--eye", "left", "--size", EYE, "--spp", TRUTH_SPP, "--seed", seed)
                for seed in TRUTH_SEEDS]

    def window(self, columns, denoise):
        return self.render(f"window-{columns}-{denoise}", f"{FIRST}-{LAST}", "--window", WINDOW, "--density", columns, "--size", SPHERE, "--spp", SPP,
                           "--seed", SEED, "--denoise", denoise, "--aovs", "depth,guides" if denoise != "off" else "depth")

    def point(self, columns, denoise, crf, truths):
        stream, views = self.work / "window.mkv", self.work / "views"
        depth_crf = max(BEST_CRF, crf - COLOUR_FIRST)
        told = json.loads(self.run("encode", self.window(columns, denoise), "--out", stream, "--crf", crf, "--preset", "veryfast", "--gop", 300,
                                   "--depth", "w10", "--depth-crf", depth_crf, "--fill", "none", "--json", "--progress", "none"))
        subprocess.run(["rm", "-rf", views], check=True)
        self.run("play", stream, "--size", EYE, "--fov", 90, "--method", "mesh", "--frames", SCORED, "--progress", "none", "--out", views)
        seen = json.loads(self.run("compare", views, truths[0], "--truth2", truths[1], "--metrics", "none", "--eyes", "left", "--json", "--progress", "none"))
        of_window = [track["bytes_per_frame"] for track in told["tracks"] if track["name"].startswith("window")]
        whole = seen["eyes"]["left"]["whole"]["display"]
        return {"columns": columns, "denoise": denoise, "crf": crf, "bytes": [round(size) for size in of_window],
                **{key: round(whole[key], 2) for key in ("db", "db_low", "db_high")}}


def gains(points):
    """For a window, and one of half its pixels that takes as many bytes: the first one's CRF, and by how much the second one is better."""
    of = {columns: sorted((math.log(sum(point["bytes"])), point["crf"], point["db"]) for point in points if point["columns"] == columns) for columns in COLUMNS}
    for more, fewer in zip(COLUMNS, COLUMNS[1:]):
        sizes, crfs, dbs = map(np.array, zip(*of[more]))
        for size, _, db in of[fewer]:
            if sizes[0] <= size <= sizes[-1]:
                yield more, float(np.interp(size, sizes, crfs)), db - float(np.interp(size, sizes, dbs))


def draw(results):
    rows = []
    for name, result in results.items():
        for denoise in DENOISE:
            points = [point for point in result["points"] if point["denoise"] == denoise]
            of = {(point["columns"], point["crf"]): point for point in points}
            by_columns = {columns: [] for columns in COLUMNS}
            for columns, crf, gain in gains(points):
                by_columns[columns].append(f"{crf:.0f}: {gain:+.1f}")
            for columns in COLUMNS:
                cells = [f"{of[columns, crf]['db']:.1f} ({sum(of[columns, crf]['bytes']) / 1000:.1f})" for crf in CRFS]
                rows.append([name, "as rendered" if denoise == "off" else "denoised", f"{columns:,}", *cells, ", ".join(reversed(by_columns[columns])) or "-"])
    heads = ["scene", "light", "columns", *(f"CRF {crf}" for crf in CRFS), "half the pixels, same bytes"]
    PAGE.write_text(place(PAGE.read_text(), "density", "all", table(heads, rows, labels=2)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["sponza-crytek", "voxel-city"])
    parser.add_argument("--bin", type=pathlib.Path, help="folder of the programs; without it the table alone is drawn")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders; not in the repository")
    options = parser.parse_args()
    if options.bin and not options.work:
        raise Failed("window_density.py: expected --work FOLDER beside --bin, found none")
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    for name in options.scenes if options.bin else ():
        scene = Scene(options, name)
        truths = scene.truths()
        points = [scene.point(columns, denoise, crf, truths) for denoise in DENOISE for columns in COLUMNS for crf in CRFS]
        results[name] = {"command": f"tests/study/network/window_density.py --bin BIN --work FOLDER {name}", **provenance(options.bin, REPOSITORY),
                         "frames": f"{FIRST}-{LAST}", "scored": SCORED, "sphere": SPHERE, "window": WINDOW, "spp": SPP, "seed": SEED, "eye": EYE,
                         "truth_spp": TRUTH_SPP, "truth_seeds": TRUTH_SEEDS, "points": points}
        RESULTS.parent.mkdir(exist_ok=True)
        write_whole(RESULTS, result_text(results, 3))
    draw(results)


if __name__ == "__main__":
    run_as_program(main)
