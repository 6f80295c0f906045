"""Chart 5: for each breaker each method's accuracy less the ceiling's, against its strength. Below it: the share of failing pixels that the reliability map flags.
Chart 6: what the eye sees while the server is late: dB and degrees against delay, jitter, loss and silence.
"""

import math
import textwrap

import matplotlib.pyplot as plt
from experiments.stability import CEILING, fails_enough
from found import load
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from . import looks

COLOURS = {"eye-depth": "#145a32", "rotation": "#7f8c8d", "proxy-sphere": "#8e44ad", "surface": "#145a32", "mesh": "#28b463", "splat": "#76d7c4", "gather": "#45b39d", "mesh-plain": "#b9770e", "lean": "#8e44ad", "sphere": "#7f8c8d",
           "paper": "#2e86c1"}
TITLES = {"paper": "the paper's: surface from the left eye's sphere"}
ACROSS = 4


LEAST_DB = -20
"""Beside the ceiling; what is lower is drawn here, with an arrow."""


def draw_breaker(level, known, name, breaker):
    values = list(breaker["found"])
    at = range(len(values))
    ceiling = [breaker["found"][value][CEILING]["psnr_db"] for value in values]
    level.axhline(0, **looks.LEVEL)
    for method, colour in COLOURS.items():
        if method not in breaker["found"][values[0]]:
            continue
        figures = [breaker["found"][value][method] for value in values]
        beside = [f["psnr_db"] - most for f, most in zip(figures, ceiling)]
        level.plot(at, [max(db, LEAST_DB) for db in beside], color=colour, linewidth=1.3, marker="o", markersize=3)
        level.plot([i for i in at if beside[i] < LEAST_DB], [LEAST_DB for db in beside if db < LEAST_DB], color=colour, linestyle="none", marker="v", markersize=6)
        told = [f["failing_recall"] if fails_enough(f) else math.nan for f in figures]
        known.plot(at, [100 * share for share in told], color=colour, linewidth=1.1, marker="o", markersize=2.5)
    level.set_ylim(LEAST_DB - 1, 2)
    level.set_title(name, loc="left", fontsize=9.5)
    level.set_xticks(at, [])
    known.set_xticks(at, values, fontsize=looks.SMALL, rotation=45)
    known.set_ylim(-3, 103)
    known.set_xlabel(textwrap.fill(breaker["knob"], 44), fontsize=looks.SMALL)


FROM_THE_CENTRE = {"eye-depth": "the client's geometry", "surface": "the client's geometry", "mesh": "streamed depth", "splat": "streamed depth, splatted", "rotation": "rotation", "sphere": "rotation"}
"""Methods that a stream from the head's centre can be shown by; older results have older names."""


def nearest_to_the_ceiling(breakers):
    """Which of them has the most dB at the hardest end of most knobs."""
    best = []
    for breaker in breakers.values():
        hardest = list(breaker["found"].values())[-1]
        best.append(max((method for method in FROM_THE_CENTRE if method in hardest), key=lambda method: hardest[method]["psnr_db"]))
    words = [FROM_THE_CENTRE[method] for method in best]
    most = max(dict.fromkeys(words), key=words.count)
    return f"At the hardest end {most} is the best from the head's centre in {words.count(most)} of {len(words)} breakers"


def draw_breakers(folder):
    for result in load(folder, "stability").values():
        plt.rcParams.update(looks.STYLE)
        breakers = result["breakers"]
        rows = math.ceil(len(breakers) / ACROSS)
        figure, panels = plt.subplots(2 * rows, ACROSS, figsize=(looks.PAGE_IN, 3.6 * rows + 1.2), squeeze=False, sharey="row", layout="constrained",
                                      gridspec_kw={"height_ratios": [2, 1] * rows})
        for axes in panels.flat[:]:
            axes.tick_params(labelsize=looks.SMALL)
        for i in range(ACROSS * rows):
            pair = [panels[2 * (i // ACROSS) + j][i % ACROSS] for j in range(2)]
            if i < len(breakers):
                draw_breaker(*pair, *list(breakers.items())[i])
            else:
                for axes in pair:
                    axes.axis("off")
        for row in range(rows):
            panels[2 * row][0].set_ylabel("dB beside the ceiling", fontsize=looks.SMALL)
            panels[2 * row + 1][0].set_ylabel("% flagged", fontsize=looks.SMALL)
        found = {method for breaker in breakers.values() for by_method in breaker["found"].values() for method in by_method}
        handles = [Line2D([], [], color=colour, marker="o", markersize=3, label=TITLES.get(method, method)) for method, colour in COLOURS.items() if method in found]
        handles.append(Line2D([], [], **looks.LEVEL, label="ceiling: a sphere at each eye, turned"))
        figure.legend(handles=handles, loc="outside lower center", ncol=4, frameon=False, fontsize=looks.SMALL)
        looks.title(figure, nearest_to_the_ceiling(breakers), "PSNR of 200x112 eyes, noise and all, less that of the ceiling, by strength, harmless on the left. Below: of failing pixels (off by more than 10 of 255 beyond what the ceiling is off by around them) "
                            "how many the reliability map flags, where there are 0.5 % of them and twice as many as by chance.")
        looks.save(figure, folder / "stability")
        plt.close(figure)


LATE_COLOURS = {"eye-depth": "#145a32", "rotation": "#7f8c8d", "surface": "#145a32", "mesh": "#28b463", "held": "#d4ac0d", "sphere": "#7f8c8d", "views": "#c0392b", "wide-views": "#2e86c1", "reprojected-views": "#8e44ad"}


def draw_sweep(level, degrees, label, by_value, titles):
    values = list(by_value)
    at = range(len(values))
    for method in titles:
        runs, colour = [next(run for run in by_value[value] if run["method"] == method) for value in values], LATE_COLOURS[method]
        level.plot(at, [run["psnr_db"] for run in runs], color=colour, marker="o", markersize=4, linewidth=1.4, label=titles[method])
        level.plot(at, [run["worst_refresh_db"] for run in runs], color=colour, linewidth=0.9, linestyle=(0, (2, 2)))
    runs = [by_value[value][0] for value in values]
    for key, colour, words in (("unreprojected_error_deg", "#c0392b", "frames shown as they come"), ("error_deg", "#145a32", "reprojected: how far the head is foretold wrong")):
        degrees.plot(at, [run[key]["mean"] for run in runs], color=colour, marker="o", markersize=4, linewidth=1.4, label=words)
        degrees.plot(at, [run[key]["p95"] for run in runs], color=colour, linewidth=0.9, linestyle=(0, (2, 2)))
    level.set_xticks(at, [])
    degrees.set_xticks(at, values, fontsize=looks.SMALL)
    degrees.set_yscale("symlog", linthresh=0.01)
    degrees.yaxis.set_major_formatter(FuncFormatter(looks.plain_number))
    degrees.set_xlabel(textwrap.fill(label, 24), fontsize=looks.SMALL)


def late_finding(result):
    """What the longest delay costs a sphere with geometry and one that is turned."""
    by_value = next(iter(result["sweeps"].values()))
    ends = [{run["method"]: run["psnr_db"] for run in by_value[value]} for value in (list(by_value)[0], list(by_value)[-1])]
    by_depth, turned = (next((f"{ends[0][name] - ends[1][name]:.1f}" for name in names if name in ends[0]), None) for names in (("eye-depth", "surface"), ("rotation", "sphere")))
    return looks.told("{ms} ms of delay cost a sphere with geometry {by_depth} dB, turned alone {turned}", "A late server", ms=list(by_value)[-1], by_depth=by_depth, turned=turned)


def draw_late(folder):
    for result in load(folder, "latency").values():
        plt.rcParams.update(looks.STYLE)
        sweeps = result["sweeps"]
        figure, panels = plt.subplots(2, len(sweeps), figsize=(looks.PAGE_IN, 7.6), squeeze=False, sharey="row", layout="constrained")
        for column, (label, by_value) in enumerate(sweeps.items()):
            draw_sweep(panels[0][column], panels[1][column], label, by_value, result["titles"])
        panels[0][0].set_ylabel("dB of all refreshes, both eyes")
        panels[1][0].set_ylabel("degrees")
        for row in panels:
            looks.legend_above(row[0], 2, 1.04)
        n = result["n"]
        looks.title(figure, late_finding(result), f"Scene motion, {n['seconds']} s at {n['frames_hz']} frames a second, refreshes {n['refreshes']} at {n['refresh_hz']} Hz. Above dotted: the worst refresh; "
                            "below dotted: the 95th percentile.", 4)
        figure.get_layout_engine().set(h_pad=0.25)
        looks.save(figure, folder / "latency")
        plt.close(figure)


def draw_all(folder):
    draw_breakers(folder)
    draw_late(folder)
