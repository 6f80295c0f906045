"""Chart 4: accuracy against triangles kept on the client, bits of depth, mesh cells, draws and samples; the budget e that the client chooses marked, and the knee."""

import textwrap

import matplotlib.pyplot as plt
from curves import AXES, CHOSEN_PX, CODE_BITS, sample_points
from found import ceiling_psnr, db, load
from rates import CLOSE_DB, knee, least_within

from . import looks

LEAST_SPAN_DB = 0.1
"""Of a panel: what is less is no difference."""


def draw_panel(axes, points, best):
    costs, levels = [point[0] for point in points], [point[1] for point in points]
    axes.plot(costs, levels, color="#145a32", marker="o", markersize=4.5, linewidth=1.3)
    for cost, level, error_px in points:
        if error_px == CHOSEN_PX:
            axes.plot([cost], [level], marker="o", color="#c0392b", markersize=8, markerfacecolor="none", markeredgewidth=1.6)
    curve = [(cost, level) for cost, level, _ in points]
    axes.axvline(least_within(curve), color="#2e86c1", linewidth=1.2)
    axes.axvline(knee(curve), color="#2e86c1", linewidth=1, linestyle=(0, (3, 3)))
    if best is not None:
        looks.level(axes, best, f"without: {best:.2f} dB")
    low, high = axes.get_ylim()
    if high - low < LEAST_SPAN_DB:
        axes.set_ylim((low + high - LEAST_SPAN_DB) / 2, (low + high + LEAST_SPAN_DB) / 2)
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


def without(result, label):
    """The level with nothing left out."""
    if label.startswith("triangles"):
        return db(result["triangles"][0])
    return db(result["depth_bits"][0]) if label.startswith("bits") else None


def draw_depths(axes, result):
    """By rays, by our draws and by the paper's: what each of them sees and how long it takes."""
    points = [(entry["title"], db(entry)) for entry in result["draws"]]
    bars = axes.bar(range(len(points)), [level for _, level in points], width=0.5, color="#145a32")
    axes.bar_label(bars, [f"{entry['depth_ms']:,.0f} ms" for entry in result["draws"]], fontsize=7.5)
    axes.set_xticks(range(len(points)), [textwrap.fill(title, 14) for title, _ in points], fontsize=7)
    lowest, highest = min(level for _, level in points) - 1, max(level for _, level in points)
    axes.set_ylim(lowest, highest + (highest - lowest) / 4)
    axes.set_xlabel("whose draws the client's depth is of,\nmilliseconds a frame, OpenGL in software", fontsize=8)


def draw_all(folder):
    results, systems = load(folder, "parsimony"), load(folder, "systems")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(AXES) + 1, len(results), figsize=(max(3.3 * len(results), 7), 2.7 * (len(AXES) + 1) + 0.6), squeeze=False, layout="constrained")
    for column, result in enumerate(results.values()):
        panels[0][column].set_title(result["scene"], loc="left")
        for row, (label, points) in enumerate(AXES.items()):
            draw_panel(panels[row][column], points(result), without(result, label))
            panels[row][column].set_xlabel(label, fontsize=8)
            if result["scene"] in systems and points is not sample_points:
                looks.ceiling_note(panels[row][column], ceiling_psnr(systems[result["scene"]]))
        draw_depths(panels[-1][column], result)
    for row in panels:
        row[0].set_ylabel("dB, both eyes")
    first = next(iter(results.values()))
    looks.title(figure, looks.provenance_line(first) + f". Noise-free but for samples. Red ring: e = {CHOSEN_PX:g} px, the client's own choice, and the {CODE_BITS} bits of the depth code; blue: the least within {CLOSE_DB:g} dB of the dearest; dashed: the knee by curvature.")
    looks.save(figure, folder / "parsimony")
    plt.close(figure)
