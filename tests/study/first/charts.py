#!/usr/bin/env python3
"""Draws docs/results/first/*.svg and *.png from the JSON files beside them, and from nothing else.

    charts.py [--results FOLDER]
"""

import argparse
import pathlib
import sys

import results

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from drawing import STYLE, plain_number  # noqa: E402

import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

COLOURS = {"perspective": "#c0392b", "sphere-left": "#2e86c1", "sphere-centre": "#1e8449"}
MARKERS = {"uncoded": "*", "H.264, CRF 16": "o", "H.264, CRF 24": "s", "H.265, CRF 16": "^", "H.265, CRF 24": "D"}
SIZES = {"*": 11, "o": 7, "s": 6.5, "^": 7.5, "D": 6}


# Beyond this an error is that of rounding to 8 bits: the perspective system's left eye, uncoded, is the truth itself.
HIGHEST_DB = 55


def noise_free(entry, eye):
    """(dB, lower error bar, upper error bar, only a bound) on display values."""
    figures = entry["noise_free"]["eyes"][eye]["display"]
    if figures["only_bounded"]:
        return figures["db_low"], 0, 0, True
    return figures["db"], figures["db"] - figures["db_low"], figures["db_high"] - figures["db"], False


def draw_points(axes, result, eye, x_of, row):
    for entry in result["systems"]:
        x = x_of(entry)
        if x is None:
            continue
        marker = MARKERS.get(results.coding_name(entry), "P")
        colour = COLOURS[entry["system"]]
        rotated = entry["method"] == "sphere"
        look = dict(marker=marker, markersize=SIZES.get(marker, 7), color=colour, markeredgecolor=colour, linestyle="none",
                    markerfacecolor="white" if rotated else colour, markeredgewidth=1.2, alpha=0.9)
        if row == "noise-free":
            y, below, above, bound = noise_free(entry, eye)
            if y is None or y > HIGHEST_DB:
                continue
            axes.errorbar([x], [y], yerr=[[below], [above]], ecolor=colour, elinewidth=0.9, capsize=2, **look)
            if bound:
                axes.annotate("", (x, y), (0, 13), textcoords="offset points",
                              arrowprops={"arrowstyle": "<-", "color": colour, "lw": 0.9})
        else:
            y = results.psnr(entry["against_other_seed"], eye)
            if y is not None and y < HIGHEST_DB:
                axes.plot([x], [y], **look)


def draw_ceiling(axes, result, eye):
    ceiling = result["ceiling"]["eyes"][eye]["psnr_db"]
    axes.axhline(ceiling, color="#555555", linewidth=1.1, linestyle=(0, (5, 3)))
    axes.annotate(f"truth against truth: {ceiling:.1f} dB", (0.98, ceiling), xycoords=("axes fraction", "data"), xytext=(0, 3),
                  textcoords="offset points", ha="right", va="bottom", fontsize=8, color="#555555")


def legend(figure, codings, columns):
    entries = [Line2D([], [], marker="o", linestyle="none", color=colour, markersize=7, label=results.SYSTEM_NAMES[system])
               for system, colour in COLOURS.items()]
    entries += [Line2D([], [], marker="o", linestyle="none", color="#444444", markersize=7, label="reprojected (surface)"),
                Line2D([], [], marker="o", linestyle="none", color="#444444", markerfacecolor="white", markersize=7, label="rotated only (sphere)")]
    entries += [Line2D([], [], marker=MARKERS[name], linestyle="none", color="#444444", markersize=SIZES[MARKERS[name]], label=name)
                for name in MARKERS if name in codings]
    figure.legend(handles=entries, loc="lower center", ncol=columns, frameon=False, fontsize=9)


def chart(all_results, x_of, x_label, title, file):
    columns = [(result, eye) for result in all_results for eye in ("left", "right")]
    figure, axes = plt.subplots(2, len(columns), figsize=(3.4 * max(len(columns), 2.6) + 0.6, 8.6), squeeze=False, sharex=True, sharey="row")
    codings = set()
    for column, (result, eye) in enumerate(columns):
        for row, kind in enumerate(("noise-free", "PSNR")):
            panel = axes[row][column]
            panel.set_xscale("log")
            panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            panel.xaxis.set_major_formatter(FuncFormatter(plain_number))
            panel.xaxis.set_minor_formatter(NullFormatter())
            draw_points(panel, result, eye, x_of, kind)
            if kind == "PSNR":
                draw_ceiling(panel, result, eye)
                panel.set_xlabel(x_label)
            else:
                panel.set_title(f"{result['scene']} {result['settings']['frames']}, {eye} eye")
        codings |= {results.coding_name(entry) for entry in result["systems"] if x_of(entry) is not None}
    axes[0][0].set_ylabel("noise-free error, dB (95 % interval)")
    axes[1][0].set_ylabel("PSNR against the truth of another seed, dB")
    settings = all_results[0]["settings"]
    figure.suptitle(title, fontsize=13, fontweight="bold", x=0.01, ha="left")
    figure.text(0.01, 0.925, f"{settings['sphere_size']} spheres, {settings['eye_size']} eyes, {settings['spp']} samples per pixel (bytes depend on noise); "
                f"{all_results[0]['machine']['cpu']}, {all_results[0]['machine']['cores']} cores.\n"
                f"Arrow: the interval reaches zero error. Not drawn: above {HIGHEST_DB} dB (a picture that is the truth itself).",
                fontsize=8.5, color="#555555", linespacing=1.4)
    figure.tight_layout(rect=(0, 0.09, 1, 0.925))
    legend(figure, codings, 5 if len(columns) > 2 else 3)
    figure.savefig(file.with_suffix(".svg"), metadata={"Date": None})
    figure.savefig(file.with_suffix(".png"), dpi=110)
    plt.close(figure)
    print(file.with_suffix(".svg"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=results.RESULTS)
    folder = parser.parse_args().results
    found = results.load(folder)
    if not found:
        raise SystemExit(f"charts.py: {folder}: expected SCENE.json files as run.py makes them, found none")
    plt.rcParams.update(STYLE)
    chart(found, results.client_ms, "client, ms a frame (both eyes)", "Accuracy against time", folder / "accuracy-time")
    chart(found, results.bytes_per_frame, "bytes a frame (all tracks)", "Accuracy against bytes", folder / "accuracy-bytes")


if __name__ == "__main__":
    main()
