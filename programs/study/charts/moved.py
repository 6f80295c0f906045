"""What is left of each system when the head has turned and moved on from where the server thought it was."""

import matplotlib.pyplot as plt
from figures.moved import by_head, head_text
from found import ceiling_psnr, db, interval_db, load

from . import looks


def draw_panel(axes, result):
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


def draw_all(folder):
    results = load(folder, "moved")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(1, len(results), figsize=(max(3.8 * len(results), 7), 4.6), squeeze=False, sharey=True, layout="constrained")
    for axes, result in zip(panels[0], results.values()):
        draw_panel(axes, result)
    panels[0][0].set_ylabel("noise-free, dB (linear), both eyes")
    first = next(iter(results.values()))
    found = {entry["system"] for result in results.values() for entry in result["systems"]}
    looks.legend(figure, found, first["titles"], (), (None,))
    looks.title(figure, looks.provenance_line(first) + f", of which here one frame. Uncoded, spheres {first['settings']['sphere_width']} wide. How far the head has gone from where it was told. Lines: 95 % of the noise. "
                f"Not drawn: above {looks.HIGHEST_DB} dB.")
    looks.save(figure, folder / "moved")
    plt.close(figure)
