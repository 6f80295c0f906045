#!/usr/bin/env python3
"""Lays out what each system showed, beside the truth: docs/results/first/SCENE.jpg, from the work folder that run.py filled.

    pictures.py --bin build/release/bin --work FOLDER [--frame N] SCENE
"""

import argparse
import pathlib
import sys

import numpy as np

import results
from run import SYSTEMS

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from drawing import rgb, truth  # noqa: E402

import matplotlib.pyplot as plt  # noqa: E402

DIFFERENCE_GAIN = 4
# An eye's view of the rows below it: what was shown, how far it is from the truth, and where the source saw nothing.
COLUMNS = ("left eye", "right eye", f"right: difference x {DIFFERENCE_GAIN}", "right: gaps")


def row_of(work, system, coding, frame, true_right):
    views = work / f"views/{system}-surface-{coding}-1"
    left, right, gaps = (rgb(views / name / f"frame.{frame:04d}.png") for name in ("left", "right", "gaps/right"))
    difference = np.abs(right.astype(int) - true_right.astype(int)) * DIFFERENCE_GAIN
    return left, right, np.minimum(difference, 255).astype(np.uint8), gaps


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--frame", type=int, required=True)
    parser.add_argument("--coding", default="h264-crf16")
    parser.add_argument("--out", type=pathlib.Path, default=results.RESULTS)
    options = parser.parse_args()
    work = options.work / options.scene
    program = options.bin.resolve() / "equistream"
    left, right = (truth(program, work.resolve(), "truth-1", eye, options.frame) for eye in ("left", "right"))
    rows = [("truth", (left, right, None, None))]
    rows += [(results.SYSTEM_NAMES[system], row_of(work, system, options.coding, options.frame, right)) for system in SYSTEMS]
    height, width = right.shape[:2]
    figure, axes = plt.subplots(len(rows), len(COLUMNS), figsize=(14, 14 / len(COLUMNS) * height / width * len(rows) + 0.4), squeeze=False)
    for (name, pictures), line in zip(rows, axes):
        for title, picture, panel in zip(COLUMNS, pictures, line):
            panel.set_axis_off()
            if picture is not None:
                panel.imshow(picture, interpolation="antialiased")
            if name == "truth":
                panel.set_title(title, fontsize=11, fontweight="bold")
        line[0].text(6, 14, name, fontsize=9, color="white", va="top", bbox={"facecolor": "black", "alpha": 0.6, "pad": 2, "linewidth": 0})
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1 - 0.28 / figure.get_figheight(), wspace=0.01, hspace=0.01)
    file = options.out / f"{options.scene}.jpg"
    figure.savefig(file, dpi=100, pil_kwargs={"quality": 85, "optimize": True})
    print(file)


if __name__ == "__main__":
    main()
