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


def depth_gains(results):
    """dB of the whole error that depth has beyond turning the same sphere, a scene each, at the coarsest of its CRFs in the paper's codec."""
    for result in results.values():
        by_system = {entry["system"]: seen_db(entry) for entry in of_one_width(result) if entry["codec"] == "h264" and entry["crf"] == max(result["settings"]["crfs"])}
        if None not in (by_system.get("centre"), by_system.get("centre-turned")):
            yield by_system["centre"] - by_system["centre-turned"]


def draw_accuracy(results, cost, label, file):
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(results), len(KINDS), figsize=(looks.PAGE_IN, 2.9 * len(results) + 2.2), squeeze=False, sharex=True, sharey="col", layout="constrained")
    for row, result in enumerate(results.values()):
        for column, (kind, known) in enumerate(KINDS.items()):
            axes = panels[row][column]
            axes.set_xscale("log")
            draw_accuracy_panel(axes, result, cost, *known)
            looks.log_axis(axes.xaxis)
            axes.set_ylabel(kind)
            panels[-1][column].set_xlabel(label)
        looks.ceiling_note(panels[row][-1], ceiling_psnr(result))
        panels[row][0].set_title(f"{result['scene']}, {result['settings']['frames']} frames{light_text(result)}", loc="left")
    first = next(iter(results.values()))
    entries = [entry for result in results.values() for entry in of_one_width(result) if cost(entry) is not None]
    looks.legend(figure, {entry["system"] for entry in entries}, titles_of(results), {coding_name(entry) for entry in entries})
    gain = looks.span(depth_gains(results))
    looks.title(figure, looks.told("Depth gives a sphere {gain} dB beyond turning it (CRF {crf:g})", "Accuracy of every system", gain=gain, crf=max(first["settings"]["crfs"])),
                looks.provenance_line(first) + f". Dashed steps: Pareto front; lines: 95 % of the noise. Not drawn: above {looks.HIGHEST_DB} dB.")
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
        axes.annotate(f"{db(entry):.1f} dB", (100, row), xytext=(3, 0), textcoords="offset points", va="center", fontsize=looks.SMALL)
    axes.set_yticks(range(len(entries)), [result["titles"][entry["system"]] for entry in entries], fontsize=looks.SMALL)
    pixels = ", ".join(f"{kind} {100 * share:.0f}" for kind, (share, _) in kinds_of(next(entry for entry in result["systems"] if entry["system"] == "centre")).items())
    axes.set_title(f"{result['scene']}\n", loc="left")
    axes.text(0, 1.01, f"of the pixels, from the centre, %: {pixels}", transform=axes.transAxes, fontsize=looks.SMALL, color="#555555")
    axes.set_xlim(0, 100)
    axes.set_xlabel("of the noise-free error, %")


def most_of_the_error(results):
    """The kind of pixels that has the largest share of the error in most scenes, those scenes' number, and its shares there in per cent."""
    found = [shares(next(entry for entry in result["systems"] if entry["system"] == "centre")) for result in results.values()]
    largest = [max(by_kind, key=by_kind.get) for by_kind in found]
    most = max(set(largest), key=largest.count)
    words = {"hidden": "where the sphere saw nothing", "mirrors": "in mirrors and glass", "edges": "along edges", "elsewhere": "in plain surfaces"}
    return words[most], largest.count(most), looks.span([100 * by_kind[most] for by_kind, kind in zip(found, largest) if kind == most], 0)


def draw_where(folder):
    results = load(folder, "where")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(results), 1, figsize=(looks.PAGE_IN, 3.1 * len(results) + 1), squeeze=False, layout="constrained")
    for axes, result in zip(panels.flat, results.values()):
        draw_where_panel(axes, result)
    first = next(iter(results.values()))
    figure.legend(handles=[plt.Rectangle((0, 0), 1, 1, color=KIND_COLOURS[kind], label=title) for kind, title in first["kinds"].items()], loc="outside lower center",
                  ncol=2, frameon=False, fontsize=looks.SMALL)
    most, scenes, share = most_of_the_error(results)
    looks.title(figure, f"In {scenes} of {len(results)} scenes most of a sphere's error lies {most}: {share} %", looks.provenance_line(first) + f". Uncoded, spheres {first['settings']['sphere_width']} wide; a pixel is of the first kind that it belongs to; edges: {first['edge_px']:g} px or more by the eyes' distance.")
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
    axes.set_xticks(range(len(result["heads"])), [head_text(head).replace(", ", ",\n") for head in result["heads"]], fontsize=looks.SMALL)
    looks.ceiling_note(axes, ceiling_psnr({"ceiling": result["ceiling"][result["heads"][0]["name"]]}))
    axes.set_title(result["scene"], loc="left")


def losses(results, system):
    """dB from the head as told to the one that has moved furthest without turning, a scene each."""
    for result in results.values():
        moved = max((head for head in result["heads"] if not head["turned_deg"]), key=lambda head: head["moved_m"])["name"]
        found = by_head(result, system)
        if moved in found and None not in (levels := (db(next(iter(found.values()))), db(found[moved]))):
            yield levels[0] - levels[1]


def draw_moved(folder):
    results = load(folder, "moved")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(results), 1, figsize=(looks.PAGE_IN, 2.7 * len(results) + 2), squeeze=False, sharey=True, layout="constrained")
    for axes, result in zip(panels.flat, results.values()):
        draw_moved_panel(axes, result)
        axes.set_ylabel("noise-free, dB (linear)")
    first = next(iter(results.values()))
    found = {entry["system"] for result in results.values() for entry in result["systems"]}
    looks.legend(figure, found, titles_of(results), ())
    by_depth, turned = (looks.span(losses(results, system)) for system in ("centre", "centre-turned"))
    furthest_cm = max(100 * head["moved_m"] for head in first["heads"])
    looks.title(figure, looks.told("{cm:g} cm from where the head was told a sphere with geometry loses {by_depth} dB, turned alone {turned}", "Heads that moved on",
                                   cm=furthest_cm, by_depth=by_depth, turned=turned),
                looks.provenance_line(first) + f", of which here one frame. Uncoded, spheres {first['settings']['sphere_width']} wide. How far the head has gone from where it was told. Lines: 95 % of the noise. "
                f"Not drawn: above {looks.HIGHEST_DB} dB.")
    looks.save(figure, folder / "moved")
    plt.close(figure)


def draw_all(folder):
    draw_accuracies(folder)
    draw_where(folder)
    draw_moved(folder)
