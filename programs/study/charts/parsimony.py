"""Chart 4: accuracy against triangles kept on the client, bits of depth, mesh cells, draws and samples; the budget e that the client chooses marked, and the knee."""

import textwrap

import matplotlib.pyplot as plt
from curves import AXES, CHOSEN_PX, CODE_BITS, bit_points, triangle_points
from found import db, load
from rates import CLOSE_DB, cheapest_within, knee

from . import looks

LEAST_SPAN_DB = 0.1
"""Of a row: what is less is no difference."""


def draw_panel(axes, points, best):
    """Beside the level with nothing left out, or the most that was tried: all scenes then share a span."""
    whole = max(level for _, level, _ in points) if best is None else best
    points = [(cost, level - whole, error_px) for cost, level, error_px in points]
    costs, levels = [point[0] for point in points], [point[1] for point in points]
    axes.plot(costs, levels, color="#145a32", marker="o", markersize=4.5, linewidth=1.3)
    for cost, level, error_px in points:
        if error_px == CHOSEN_PX:
            axes.plot([cost], [level], marker="o", color="#c0392b", markersize=8, markerfacecolor="none", markeredgewidth=1.6)
    curve = [(cost, level) for cost, level, _ in points]
    axes.axvline(cheapest_within(curve), color="#2e86c1", linewidth=1.2)
    axes.axvline(knee(curve), color="#2e86c1", linewidth=1, linestyle=(0, (3, 3)))
    axes.axhline(0, **looks.LEVEL)
    axes.annotate(f"whole: {whole:.2f} dB", (0.98, 0.04), xycoords="axes fraction", ha="right", fontsize=looks.SMALL, color="#555555")
    axes.update_datalim([(costs[0], -LEAST_SPAN_DB)])
    axes.autoscale_view()
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis, narrow=True)


def without(result, label):
    """The level with nothing left out."""
    if label.startswith("triangles"):
        return db(result["triangles"][0])
    return db(result["depth_bits"][0]) if label.startswith("bits") else None


def draw_depths(axes, result):
    """By rays, by our draws and by the paper's: what each of them sees and how long it takes."""
    points = [(entry["title"], db(entry)) for entry in result["draws"]]
    best = max(level for _, level in points)
    for i, (entry, (_, level)) in enumerate(zip(result["draws"], points)):
        axes.plot([level - best], [i], color="#145a32", marker="o", markersize=5)
        axes.annotate(f"{entry['depth_ms']:,.0f} ms", (0.03, i + 0.12), xycoords=("axes fraction", "data"), fontsize=looks.SMALL)
    axes.set_ylim(-0.5, len(points) - 0.3)
    axes.set_yticks(range(len(points)), [textwrap.fill(title, 16) for title, _ in points], fontsize=looks.SMALL)
    axes.set_xlabel("dB beside the best;\nms by OpenGL in software", fontsize=looks.SMALL)


def finding(results):
    """The fewest bits of depth and the coarsest model that lose no more than CLOSE_DB, over all scenes."""
    bits = [cheapest_within([(cost, level) for cost, level, _ in bit_points(result)]) for result in results.values()]
    coarsest = []
    for result in results.values():
        points = triangle_points(result)
        least = cheapest_within([(cost, level) for cost, level, _ in points])
        coarsest.append(next(error_px for cost, _, error_px in points if cost == least))
    return f"{looks.span(bits, 0)} bits of depth and a model within {looks.span(coarsest, 0)} px come within {CLOSE_DB:g} dB of the whole"


def draw_all(folder):
    results = load(folder, "parsimony")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(AXES) + 1, len(results), figsize=(looks.PAGE_IN, 2.5 * (len(AXES) + 1) + 1), squeeze=False, sharey="row", layout="constrained")
    for column, result in enumerate(results.values()):
        panels[0][column].set_title(result["scene"], loc="left")
        for row, (label, points) in enumerate(AXES.items()):
            draw_panel(panels[row][column], points(result), without(result, label))
            panels[row][column].set_xlabel(textwrap.fill(label, 26), fontsize=looks.SMALL)
        if column:
            panels[-1][column].sharex(panels[-1][0])
        draw_depths(panels[-1][column], result)
    for row in panels[:-1]:
        row[0].set_ylabel("dB beside the whole")
    first = next(iter(results.values()))
    looks.title(figure, finding(results), looks.provenance_line(first) + f". Noise-free but for samples. Red ring: e = {CHOSEN_PX:g} px, the client's own choice, and the {CODE_BITS} bits of the depth code; blue: the least within {CLOSE_DB:g} dB of the dearest; dashed: the knee by curvature.")
    looks.save(figure, folder / "parsimony")
    plt.close(figure)
