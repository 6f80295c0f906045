#!/usr/bin/env python3
"""Draws docs/results/reproject/accuracy-time.svg from docs/results/reproject/accuracy.json and nothing else.

    charts.py [--results FOLDER]
"""

import argparse
import pathlib
import sys

import results

STUDY = pathlib.Path(__file__).resolve().parents[3] / "programs/study"
sys.path[:0] = [str(STUDY), str(STUDY / "charts")]  # this file is called charts, too
import looks  # noqa: E402
from drawing import STYLE, pareto, plain_number  # noqa: E402
from found import only_bounded  # noqa: E402

import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

HEADS = {"stereo": "63 mm stereo", "moved": "head moved 0.25 m"}
# Name -> colour, marker: ours are filled, what they are compared with is hollow.
LOOKS = {"sphere": ("#7f8c8d", "o"), "lean": ("#7f8c8d", "s"), "mesh-plain": ("#b9770e", "D"), "paper": ("#c0392b", "^"), "splat": ("#8e44ad", "v"),
         "gather": ("#2e86c1", "P"), "mesh": ("#16a085", "D"), "surface": ("#1e8449", "o"), "ours": ("#145a32", "*"), "ours-left": ("#d4ac0d", "*")}
HOLLOW = ("sphere", "lean", "mesh-plain", "paper")


def eye_decibels(entry):
    """dB of each eye and of both together, on linear values; a bound where the interval reaches zero error."""
    figures = [results.error(entry, eye, "linear") for eye in results.EYES] + [results.both_eyes(entry, "linear")]
    return [figure["db_low"] if only_bounded(figure) else figure["db"] for figure in figures]


def draw_panel(axes, result, head):
    points = []
    for system, (colour, marker) in LOOKS.items():
        entry = results.find(result, "systems", system, head)
        if entry is None:
            continue
        ms = results.reprojection_ms(entry)
        left, right, both = eye_decibels(entry)
        points.append((ms, both))
        axes.plot([ms, ms], [left, right], color=colour, linewidth=1, zorder=2)
        axes.plot([ms], [both], marker=marker, markersize=11 if marker == "*" else 7, color=colour, linestyle="none",
                  markerfacecolor="white" if system in HOLLOW else colour, markeredgewidth=1.3, label=results.NAMES[system], zorder=3)
    line = pareto(points)
    axes.step(*zip(*line), where="post", color="#aaaaaa", linewidth=1, linestyle=(0, (4, 3)), zorder=1)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(plain_number))
    axes.xaxis.set_minor_formatter(NullFormatter())
    ceiling = sum(result["ceiling"][head]["eyes"][eye]["psnr_db"] for eye in results.EYES) / 2
    axes.set_title(f"{result['scene']},\n{HEADS[head]}", loc="left", fontsize=9.5)
    axes.annotate(f"truth: PSNR {ceiling:.1f} dB", (0.98, 0.02), xycoords="axes fraction", ha="right", fontsize=looks.SMALL, color="#555555")


def gains(found):
    """dB of both eyes that the client's geometry has beyond leaning without depth, a scene each."""
    for result in found.values():
        by_depth, lean = (results.find(result, "systems", system, "stereo") for system in ("surface", "lean"))
        if by_depth and lean:
            yield eye_decibels(by_depth)[2] - eye_decibels(lean)[2]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=results.RESULTS)
    folder = parser.parse_args().results
    found = results.load("accuracy", folder)
    if not found:
        raise SystemExit(f"charts.py: {folder / 'accuracy.json'}: expected scenes, found none")
    plt.rcParams.update(STYLE)
    figure, panels = plt.subplots(len(HEADS), len(found), figsize=(looks.PAGE_IN, 8.6), squeeze=False, sharey="row", layout="constrained")
    for column, result in enumerate(found.values()):
        for row, head in enumerate(HEADS):
            draw_panel(panels[row][column], result, head)
            panels[row][0].set_ylabel("noise-free dB, linear")
        panels[-1][column].set_xlabel("ms a frame")
    first = next(iter(found.values()))
    settings = first["settings"]
    looks.title(figure, looks.told("Depth gives {gain} dB beyond leaning without it, for 63 mm of stereo", "Accuracy against time", gain=looks.span(gains(found))),
                    f"{settings['spheres']['centre']} spheres, {settings['eye_size']} eyes, {settings['spp']} samples per pixel, "
                    f"uncoded, n = 1 frame x {first['n']['seeds']} seeds; {first['machine']['cpu']}, {first['machine']['cores']} cores. Line: from eye to eye. Dashed: the Pareto front. Reprojection and fill of both eyes; truth: one beside the other.")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncol=3, frameon=False, fontsize=9)
    looks.save(figure, folder / "accuracy-time")


if __name__ == "__main__":
    main()
