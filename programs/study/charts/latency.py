"""Chart 6: what the eye sees while the server is late: dB and degrees against delay, jitter, loss and silence."""

import matplotlib.pyplot as plt
from found import load

from . import looks

COLOURS = {"surface": "#145a32", "mesh": "#28b463", "held": "#d4ac0d", "sphere": "#7f8c8d", "views": "#c0392b", "wide-views": "#2e86c1", "reprojected-views": "#8e44ad"}


def draw_sweep(level, degrees, label, by_value, titles):
    values = list(by_value)
    at = range(len(values))
    for method in titles:
        runs, colour = [next(run for run in by_value[value] if run["method"] == method) for value in values], COLOURS[method]
        level.plot(at, [run["psnr_db"] for run in runs], color=colour, marker="o", markersize=4, linewidth=1.4, label=titles[method])
        level.plot(at, [run["worst_refresh_db"] for run in runs], color=colour, linewidth=0.9, linestyle=(0, (2, 2)))
    runs = [by_value[value][0] for value in values]
    for key, colour, words in (("unreprojected_error_deg", "#c0392b", "frames shown as they come"), ("error_deg", "#145a32", "reprojected: how far the head is foretold wrong")):
        degrees.plot(at, [run[key]["mean"] for run in runs], color=colour, marker="o", markersize=4, linewidth=1.4, label=words)
        degrees.plot(at, [run[key]["p95"] for run in runs], color=colour, linewidth=0.9, linestyle=(0, (2, 2)))
    level.set_xticks(at, [])
    degrees.set_xticks(at, values, fontsize=8)
    degrees.set_yscale("symlog", linthresh=0.01)
    degrees.set_xlabel(label, fontsize=8)


def draw_all(folder):
    for result in load(folder, "latency").values():
        plt.rcParams.update(looks.STYLE)
        sweeps = result["sweeps"]
        figure, panels = plt.subplots(2, len(sweeps), figsize=(3.2 * len(sweeps) + 2.5, 5.4), squeeze=False, sharey="row", layout="constrained")
        for column, (label, by_value) in enumerate(sweeps.items()):
            draw_sweep(panels[0][column], panels[1][column], label, by_value, result["titles"])
        panels[0][0].set_ylabel("dB of all refreshes, both eyes")
        panels[1][0].set_ylabel("degrees")
        for row in panels:
            looks.legend_beside(row[-1])
        n = result["n"]
        looks.title(figure, f"Scene motion, {n['seconds']} s at {n['frames_hz']} frames a second, refreshes {n['refreshes']} at {n['refresh_hz']} Hz. Above dotted: the worst refresh; "
                            "below dotted: the 95th percentile.")
        looks.save(figure, folder / "latency")
        plt.close(figure)
