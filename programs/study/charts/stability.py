"""Chart 5: for each breaker accuracy against its strength, every method and the ceiling; below it how much of what fails the reliability map flags."""

import math

import matplotlib.pyplot as plt
from experiments.stability import CEILING, fails_enough
from found import load
from matplotlib.lines import Line2D

from . import looks

COLOURS = {"surface": "#145a32", "mesh": "#28b463", "splat": "#76d7c4", "gather": "#45b39d", "mesh-plain": "#b9770e", "lean": "#8e44ad", "sphere": "#7f8c8d",
           "paper": "#2e86c1"}
TITLES = {"paper": "the paper's: surface from the left eye's sphere"}
ACROSS = 5


def draw_breaker(level, known, name, breaker):
    values = list(breaker["found"])
    at = range(len(values))
    for method, colour in {CEILING: "#333333", **COLOURS}.items():
        if method not in breaker["found"][values[0]]:
            continue
        figures = [breaker["found"][value][method] for value in values]
        is_ceiling = method == CEILING
        level.plot(at, [f["psnr_db"] for f in figures], color=colour, linewidth=1.3, marker="" if is_ceiling else "o", markersize=3, linestyle=(0, (4, 3)) if is_ceiling else "-")
        if not is_ceiling:
            told = [f["failing_recall"] if fails_enough(f) else math.nan for f in figures]
            known.plot(at, [100 * share for share in told], color=colour, linewidth=1.1, marker="o", markersize=2.5)
    level.set_title(name, loc="left", fontsize=9)
    level.set_xticks(at, [])
    known.set_xticks(at, values, fontsize=6.5, rotation=45)
    known.set_ylim(-3, 103)
    known.set_xlabel(breaker["knob"], fontsize=7)


def draw_all(folder):
    for result in load(folder, "stability").values():
        plt.rcParams.update(looks.STYLE)
        breakers = result["breakers"]
        rows = math.ceil(len(breakers) / ACROSS)
        figure, panels = plt.subplots(2 * rows, ACROSS, figsize=(3.1 * ACROSS, 3.4 * rows + 0.8), squeeze=False, layout="constrained",
                                      gridspec_kw={"height_ratios": [2, 1] * rows})
        for axes in panels.flat[:]:
            axes.tick_params(labelsize=7)
        for i in range(ACROSS * rows):
            pair = [panels[2 * (i // ACROSS) + j][i % ACROSS] for j in range(2)]
            if i < len(breakers):
                draw_breaker(*pair, *list(breakers.items())[i])
            else:
                for axes in pair:
                    axes.axis("off")
        for row in range(rows):
            panels[2 * row][0].set_ylabel("dB, both eyes", fontsize=8)
            panels[2 * row + 1][0].set_ylabel("% flagged", fontsize=8)
        handles = [Line2D([], [], color=colour, marker="o", markersize=3, label=TITLES.get(method, method)) for method, colour in COLOURS.items()]
        handles.append(Line2D([], [], color="#333333", linestyle=(0, (4, 3)), label="ceiling: a sphere at each eye, turned"))
        figure.legend(handles=handles, loc="outside lower center", ncol=5, frameon=False, fontsize=8.5)
        looks.title(figure, "PSNR of 200x112 eyes, noise and all, by strength, harmless on the left. Below: of failing pixels (off by more than 10 of 255 beyond what the ceiling is off by around them) "
                            "how many the reliability map flags, where there are 0.5 % of them and twice as many as by chance.")
        looks.save(figure, folder / "stability")
        plt.close(figure)
