"""Chart 3: a sphere's accuracy against its width and against its bytes, with the perspective render's line and where they cross, one panel a scene."""

import matplotlib.pyplot as plt
from found import db, load
from parity_figures import matching, of, parity_width, points, widths

from . import looks

SYSTEM, REFERENCE = "centre", "perspective"


def quality_colours(qualities):
    return dict(zip(qualities, plt.get_cmap("viridis")([0.08 + 0.8 * i / max(len(qualities) - 1, 1) for i in range(len(qualities))])))


def draw_widths(axes, result):
    """At each CRF, beside the perspective view at the same."""
    entries = result["first"]
    qualities = sorted({entry["crf"] for entry in entries if entry["crf"] is not None})
    for crf, colour in quality_colours(qualities).items():
        ws = widths(entries, SYSTEM)
        levels = [db(next(e for e in entries if e["system"] == SYSTEM and e["width"] == w and e["crf"] == crf)) for w in ws]
        axes.plot(ws, levels, color=colour, marker="o", markersize=4, linewidth=1.3, label=f"CRF {crf:g}")
        reference = next(e for e in entries if e["system"] == REFERENCE and e["crf"] == crf)
        axes.axhline(db(reference), color=colour, linewidth=1, linestyle=(0, (4, 3)))
        width = parity_width(entries, SYSTEM, db(reference), crf)
        if width is not None:
            axes.plot([width], [db(reference)], marker="x", color=colour, markersize=9, markeredgewidth=2)
    uncoded = [e for e in entries if e["system"] == SYSTEM and e["crf"] is None]
    axes.plot([e["width"] for e in uncoded], [db(e) for e in uncoded], color="#555555", linewidth=1, marker="*", label="uncoded")
    axes.axvline(matching(result["settings"]), color="#bbbbbb", linewidth=1)
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


def draw_bytes(axes, result):
    """Of each width, all the preset's frames."""
    entries = result["all"]
    for width, colour in quality_colours(widths(entries, SYSTEM)).items():
        axes.plot(*zip(*sorted(points(of(entries, SYSTEM, width)))), color=colour, marker="o", markersize=4, linewidth=1.3, label=f"sphere, {width} columns")
    for system, style in ((REFERENCE, "-"), ("pair", ":")):
        axes.plot(*zip(*sorted(points(of(entries, system)))), color=looks.COLOURS[system], linestyle=style, marker="s", markersize=4, linewidth=1.6,
                  label="perspective view, the other eye reprojected" if system == REFERENCE else "both eyes rendered")
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


def draw_all(folder):
    results = load(folder, "parity")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(2, len(results), figsize=(max(3.5 * len(results), 7), 8.2), squeeze=False, layout="constrained")
    for column, result in enumerate(results.values()):
        draw_widths(panels[0][column], result)
        draw_bytes(panels[1][column], result)
        panels[0][column].set_title(f"{result['scene']}, frames {result['first_frames']}", loc="left")
        panels[0][column].set_xlabel("columns of the sphere")
        panels[1][column].set_xlabel("bytes a frame (all tracks)")
    for row in panels:
        row[0].set_ylabel("noise-free, dB (linear), both eyes")
        row[-1].legend(fontsize=7, frameon=False)
    first = next(iter(results.values()))
    looks.title(figure, looks.provenance_line(first) + ". Above: dashed is the perspective view at the same CRF, a cross where the sphere equals it; grey: 2 pi f columns.")
    looks.save(figure, folder / "parity")
    plt.close(figure)
