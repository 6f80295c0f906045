"""Charts of every system, one panel a scene. 1: accuracy against time a frame and against bytes: the whole error and the noise-free one.
Where the error lies: one bar a system, shared out between hidden pixels, mirrors and glass, edges and the rest; how large it is beside it. What is left when
the head has turned and moved on from where the server thought it was.
"""

import matplotlib.pyplot as plt
from drawing import pareto
from found import all_bytes, ceiling_psnr, coding_name, db, interval_db, light_text, load, ms, seen_db, seen_interval_db, titles_of
from tables.where import by_head, head_text, kinds_of, shares

from . import looks

KINDS = {"whole error of display values, dB": (seen_db, seen_interval_db), "noise-free, dB (linear)": (db, interval_db)}
COSTS = {"time": (ms, "client, ms a frame (both eyes)"), "bytes": (all_bytes, "bytes a frame, all tracks")}


def of_one_width(result):
    """Older results have narrower spheres too."""
    return [entry for entry in result["systems"] if entry["width"] in (None, result["settings"]["sphere_width"])]


def draw_accuracy_panel(axes, result, cost, accuracy, interval):
    points = []
    for entry in of_one_width(result):
        x, y = cost(entry), accuracy(entry)
        if x is None or y is None or y > looks.HIGHEST_DB:
            continue
        looks.point(axes, entry, x, y)
        looks.interval(axes, x, interval(entry), looks.COLOURS[entry["system"]])
        points.append((x, y))
    looks.front(axes, pareto(points))


def draw_accuracy(results, cost, label, file):
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(KINDS), len(results), figsize=(max(3.5 * len(results), 7), 4.2 * len(KINDS)), squeeze=False, sharey="row", layout="constrained")
    for column, result in enumerate(results.values()):
        for row, (kind, known) in enumerate(KINDS.items()):
            axes = panels[row][column]
            axes.set_xscale("log")
            draw_accuracy_panel(axes, result, cost, *known)
            looks.log_axis(axes.xaxis)
            looks.ceiling_note(axes, ceiling_psnr(result))
            panels[row][0].set_ylabel(kind)
        panels[0][column].set_title(f"{result['scene']}, {result['settings']['frames']} frames{light_text(result)}", loc="left")
        panels[-1][column].set_xlabel(label)
    first = next(iter(results.values()))
    entries = [entry for result in results.values() for entry in of_one_width(result) if cost(entry) is not None]
    looks.legend(figure, {entry["system"] for entry in entries}, titles_of(results), {coding_name(entry) for entry in entries})
    looks.title(figure, looks.provenance_line(first) + f". Dashed steps: Pareto front; lines: 95 % of the noise. Not drawn: above {looks.HIGHEST_DB} dB.")
    looks.save(figure, file)
    plt.close(figure)


def draw_accuracies(folder):
    results = load(folder, "systems")
    if results:
        for name, (cost, label) in COSTS.items():
            draw_accuracy(results, cost, label, folder / f"accuracy-{name}")


KIND_COLOURS = {"hidden": "#c0392b", "mirrors": "#2e86c1", "edges": "#d4ac0d", "elsewhere": "#95a5a6"}


def draw_where_panel(axes, result):
    entries = list(reversed(result["systems"]))
    for row, entry in enumerate(entries):
        left = 0
        for kind, share in shares(entry).items():
            axes.barh(row, 100 * share, left=100 * left, height=0.7, color=KIND_COLOURS[kind])
            left += share
        axes.annotate(f"{db(entry):.1f} dB", (100, row), xytext=(3, 0), textcoords="offset points", va="center", fontsize=8)
    axes.set_yticks(range(len(entries)), [result["titles"][entry["system"]] for entry in entries], fontsize=8)
    pixels = ", ".join(f"{kind} {100 * share:.0f}" for kind, (share, _) in kinds_of(next(entry for entry in result["systems"] if entry["system"] == "centre")).items())
    axes.set_title(f"{result['scene']}\n", loc="left")
    axes.text(0, 1.01, f"of the pixels, from the centre, %: {pixels}", transform=axes.transAxes, fontsize=7.5, color="#555555")
    axes.set_xlim(0, 100)
    axes.set_xlabel("of the noise-free error, %")


def draw_where(folder):
    results = load(folder, "where")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    columns = min(2, len(results))
    rows = -(-len(results) // columns)
    figure, panels = plt.subplots(rows, columns, figsize=(7.5 * columns, 3.6 * rows + 0.6), squeeze=False, layout="constrained")
    for axes, result in zip(panels.flat, results.values()):
        draw_where_panel(axes, result)
    for axes in panels.flat[len(results):]:
        axes.set_axis_off()
    first = next(iter(results.values()))
    figure.legend(handles=[plt.Rectangle((0, 0), 1, 1, color=KIND_COLOURS[kind], label=title) for kind, title in first["kinds"].items()], loc="outside lower center",
                  ncol=len(KIND_COLOURS), frameon=False, fontsize=8.5)
    looks.title(figure, looks.provenance_line(first) + f". Uncoded, spheres {first['settings']['sphere_width']} wide; a pixel is of the first kind that it belongs to; edges: {first['edge_px']:g} px or more by the eyes' distance.")
    looks.save(figure, folder / "where")
    plt.close(figure)


def draw_moved_panel(axes, result):
    names = [name for name in result["titles"] if name in looks.COLOURS]
    for i, system in enumerate(names):
        colour = looks.COLOURS[system]
        for at, entry in enumerate(by_head(result, system).values()):
            level = db(entry)
            if level is None or level > looks.HIGHEST_DB:
                continue
            x = at + 0.8 * ((i + 0.5) / len(names) - 0.5)
            axes.plot([x], [level], marker="o", color=colour, markersize=5, linestyle="none")
            looks.interval(axes, x, interval_db(entry), colour)
    axes.set_xticks(range(len(result["heads"])), [head_text(head).replace(", ", ",\n") for head in result["heads"]], fontsize=8)
    looks.ceiling_note(axes, ceiling_psnr({"ceiling": result["ceiling"][result["heads"][0]["name"]]}))
    axes.set_title(result["scene"], loc="left")


def draw_moved(folder):
    results = load(folder, "moved")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(1, len(results), figsize=(max(3.8 * len(results), 7), 4.6), squeeze=False, sharey=True, layout="constrained")
    for axes, result in zip(panels[0], results.values()):
        draw_moved_panel(axes, result)
    panels[0][0].set_ylabel("noise-free, dB (linear), both eyes")
    first = next(iter(results.values()))
    found = {entry["system"] for result in results.values() for entry in result["systems"]}
    looks.legend(figure, found, titles_of(results), ())
    looks.title(figure, looks.provenance_line(first) + f", of which here one frame. Uncoded, spheres {first['settings']['sphere_width']} wide. How far the head has gone from where it was told. Lines: 95 % of the noise. "
                f"Not drawn: above {looks.HIGHEST_DB} dB.")
    looks.save(figure, folder / "moved")
    plt.close(figure)


def draw_all(folder):
    draw_accuracies(folder)
    draw_where(folder)
    draw_moved(folder)
