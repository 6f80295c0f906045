"""Where the error of each system lies: one bar a system, its error shared out between hidden pixels, mirrors and glass, edges and the rest; how large it is beside it."""

import matplotlib.pyplot as plt
from figures.where import parts, shares
from found import db, load

from . import looks

COLOURS = {"hidden": "#c0392b", "mirrors": "#2e86c1", "edges": "#d4ac0d", "elsewhere": "#95a5a6"}


def draw_panel(axes, result):
    entries = list(reversed(result["systems"]))
    for row, entry in enumerate(entries):
        left = 0
        for kind, share in shares(entry).items():
            axes.barh(row, 100 * share, left=100 * left, height=0.7, color=COLOURS[kind])
            left += share
        axes.annotate(f"{db(entry):.1f} dB", (100, row), xytext=(3, 0), textcoords="offset points", va="center", fontsize=8)
    axes.set_yticks(range(len(entries)), [result["titles"][entry["system"]] for entry in entries], fontsize=8)
    pixels = ", ".join(f"{kind} {100 * share:.0f}" for kind, (share, _) in parts(next(entry for entry in result["systems"] if entry["system"] == "centre")).items())
    axes.set_title(f"{result['scene']}\n", loc="left")
    axes.text(0, 1.01, f"of the pixels, from the centre, %: {pixels}", transform=axes.transAxes, fontsize=7.5, color="#555555")
    axes.set_xlim(0, 100)
    axes.set_xlabel("of the noise-free error, %")


def draw_all(folder):
    results = load(folder, "where")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    columns = min(2, len(results))
    rows = -(-len(results) // columns)
    figure, panels = plt.subplots(rows, columns, figsize=(7.5 * columns, 3.6 * rows + 0.6), squeeze=False, layout="constrained")
    for axes, result in zip(panels.flat, results.values()):
        draw_panel(axes, result)
    for axes in panels.flat[len(results):]:
        axes.set_axis_off()
    first = next(iter(results.values()))
    figure.legend(handles=[plt.Rectangle((0, 0), 1, 1, color=COLOURS[kind], label=title) for kind, title in first["kinds"].items()], loc="outside lower center",
                  ncol=len(COLOURS), frameon=False, fontsize=8.5)
    looks.title(figure, looks.provenance_line(first) + f". Uncoded, spheres {first['settings']['sphere_width']} wide; a pixel is of the first kind that it belongs to; edges: {first['edge_px']:g} px or more by the eyes' distance.")
    looks.save(figure, folder / "where")
    plt.close(figure)
