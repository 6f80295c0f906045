"""Window and base beside what else as many bytes can be (experiments/window.py): whole error on display values against bytes, rendered pixels and the client's
milliseconds, a row of panels a scene; and the tables of OUT/../window.md, where that page is.
"""

import io

import matplotlib.pyplot as plt
from found import WHOLE, db, load
from kept import lean_svg
from pages import cell, place, table
from steps import write_whole

from . import looks

COLOURS = {"base": "#aab7b8", "margin": "#c0392b", "pair": "#d4ac0d"}
SPHERE_COLOURS, WINDOW_COLOURS = ("#85c1e9", "#1f618d"), ("#82e0aa", "#28b463", "#145a32")
AXES = ("bytes a frame", "rendered pixels a frame", "client's milliseconds a frame, both eyes")


def level(entry):
    return db(entry, scale="display", kind=WHOLE)


def colours(names):
    found = dict(COLOURS)
    for prefix, shades in (("sphere", SPHERE_COLOURS), ("window", WINDOW_COLOURS)):
        found |= dict(zip([name for name in names if name.startswith(prefix)], shades))
    return found


def client_ms(entry):
    """Both eyes: the median of each stage but of writing files; None where nothing was played."""
    if "milliseconds" not in entry:
        return None
    return sum(times["p50"] for stage, times in entry["milliseconds"].items() if times and stage != "write")


def costs(result, entry):
    return entry["bytes_a_frame"], result["rendered_pixels"][entry["source"]], client_ms(entry)


def draw_all(folder):
    results = load(folder, "window")
    if not results:
        return
    figure, rows = plt.subplots(len(results), len(AXES), figsize=(12, 2.9 * len(results)), squeeze=False)
    for row, (scene, result) in zip(rows, results.items()):
        for axis, axes in enumerate(row):
            draw_scene(axes, result, axis)
            axes.set_xlabel(AXES[axis], fontsize=8)
        row[0].set_ylabel(f"{scene}\nwhole error, dB", fontsize=8)
    handles, labels = rows[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=2, fontsize=7.5, frameon=False)
    figure.tight_layout(rect=(0, 0.28 / len(results), 1, 1))
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg")
    plt.close(figure)
    write_whole(folder / "window.svg", lean_svg(buffer.getvalue()))
    write_page(folder, results)


def draw_scene(axes, result, axis):
    for name, colour in colours(result["titles"]).items():
        entries = [entry for entry in result["rest"] if entry["source"] == name]
        points = [(cost, level(entry)) for entry in entries if (cost := costs(result, entry)[axis]) is not None]
        if points:
            axes.plot(*zip(*points), color=colour, marker="o", markersize=4, linewidth=1.3, label=result["titles"][name])
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)
    axes.tick_params(labelsize=7)


def rest_table(results):
    rows = []
    for scene, result in results.items():
        for entry in result["rest"]:
            count, pixels, ms = costs(result, entry)
            rows.append([scene, result["titles"][entry["source"]], str(entry["crf"]), cell(level(entry)), f"{count / 1000:,.1f}", f"{pixels / 1000:,.0f}", cell(ms, 1)])
    return table(["scene", "source", "CRF", "whole error, dB", "kB a frame", "thousand pixels rendered", "ms, both eyes"], rows)


def heads_table(results):
    rows = []
    for scene, result in results.items():
        heads = [head["name"] for head in result["heads"]]
        for source, title in result["titles"].items():
            found = {entry["head"]: level(entry) for entry in result["elsewhere"] if entry["source"] == source}
            if found:
                rows.append([scene, title, *(cell(found[head]) for head in heads)])
    titles = [f"turned by {head['turned_deg']:g} degrees" if head["turned_deg"] else f"{100 * head['moved_m']:g} cm aside" for head in next(iter(results.values()))["heads"]]
    return table(["scene", "source", *titles], rows)


def beside_pair(results):
    """Each window beside the pair: what it has at no more bytes, less what the pair has, at each of the pair's CRFs; and its rendered pixels in one view's."""
    rows = []
    for scene, result in results.items():
        width, height = result["settings"]["eye"]
        for name in (name for name in result["titles"] if name != "pair"):
            gains = []
            for pair in (entry for entry in result["rest"] if entry["source"] == "pair"):
                affordable = [level(entry) for entry in result["rest"] if entry["source"] == name and entry["bytes_a_frame"] <= pair["bytes_a_frame"]]
                gains.append(f"{max(affordable) - level(pair):+.2f}" if affordable else "-")
            rows.append([scene, result["titles"][name], *gains, f"{result['rendered_pixels'][name] / (width * height):.1f}"])
    crfs = [str(entry["crf"]) for entry in next(iter(results.values()))["rest"] if entry["source"] == "pair"]
    return table(["scene", "source", *(f"dB beyond the pair at CRF {crf}" for crf in crfs), "pixels, of one view"], rows)


def write_page(folder, results):
    page = folder.resolve().with_name("window.md")
    if not page.exists():
        return
    text = page.read_text()
    for name, made in (("rest", rest_table(results)), ("heads", heads_table(results)), ("pair", beside_pair(results))):
        text = place(text, name, "all", made)
    write_whole(page, text)
    print(page)
