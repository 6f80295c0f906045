"""Chart 1: accuracy against time a frame and against bytes, every system, one panel a scene: noise-free above, PSNR with the truth's own noise below."""

import matplotlib.pyplot as plt
from drawing import pareto
from found import all_bytes, ceiling_psnr, coding_name, db, interval_db, load, ms, psnr

from . import looks

KINDS = {"noise-free, dB (linear)": db, "PSNR, dB": psnr}
COSTS = {"time": (ms, "client, ms a frame (both eyes)"), "bytes": (all_bytes, "bytes a frame, all tracks, noise and all")}


def draw_panel(axes, result, cost, accuracy):
    narrowest = result["settings"]["system_widths"][0] if len(result["settings"]["system_widths"]) > 1 else None
    points = []
    for entry in result["systems"]:
        x, y = cost(entry), accuracy(entry)
        if x is None or y is None or y > looks.HIGHEST_DB:
            continue
        looks.point(axes, entry, x, y, narrowest)
        if accuracy is db:
            looks.interval(axes, x, interval_db(entry), looks.COLOURS[entry["system"]])
        points.append((x, y))
    looks.front(axes, pareto(points))


def draw(results, cost, label, file):
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(KINDS), len(results), figsize=(max(3.5 * len(results), 7), 8.4), squeeze=False, sharey="row", layout="constrained")
    for column, result in enumerate(results.values()):
        for row, (kind, accuracy) in enumerate(KINDS.items()):
            axes = panels[row][column]
            axes.set_xscale("log")
            draw_panel(axes, result, cost, accuracy)
            looks.log_axis(axes.xaxis)
            ceiling = ceiling_psnr(result)
            if accuracy is psnr:
                looks.level(axes, ceiling, f"truth against truth: {ceiling:.1f} dB")
            else:
                looks.ceiling_note(axes, ceiling)
            panels[row][0].set_ylabel(kind)
        panels[0][column].set_title(f"{result['scene']}, {result['settings']['frames']} frames", loc="left")
        panels[-1][column].set_xlabel(label)
    first = next(iter(results.values()))
    entries = [entry for result in results.values() for entry in result["systems"] if cost(entry) is not None]
    looks.legend(figure, {entry["system"] for entry in entries}, first["titles"], {coding_name(entry) for entry in entries}, first["settings"]["system_widths"])
    looks.title(figure, looks.provenance_line(first) + f". Dashed steps: Pareto front; lines: 95 % of the noise. Not drawn: above {looks.HIGHEST_DB} dB.")
    looks.save(figure, file)
    plt.close(figure)


def draw_all(folder):
    results = load(folder, "systems")
    if results:
        for name, (cost, label) in COSTS.items():
            draw(results, cost, label, folder / f"accuracy-{name}")
