"""Window and base beside what else as many bytes can be (experiments/window.py): whole error on display values against bytes and the client's milliseconds,
and against how late it is seen, a row of panels a scene; and the tables of OUT/../window.md, where that page is.
"""

import math

import matplotlib.pyplot as plt
from found import WHOLE, db, load
from pages import cell, place, table
from steps import write_whole

from . import looks

COLOURS = {"base": "#aab7b8", "margin": "#c0392b", "pair": "#d4ac0d"}
SPHERE_COLOURS, WINDOW_COLOURS = ("#85c1e9", "#1f618d"), ("#82e0aa", "#28b463", "#145a32")
SILENCES_S = (1, 2, 4)
AXES = ("bytes a frame", "client's milliseconds a frame")


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


def draw_all(folder):
    results = load(folder, "window")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    # Results from before heads of later have a panel less.
    panels = len(AXES) + any("later" in result for result in results.values())
    figure, rows = plt.subplots(len(results), panels, figsize=(looks.PAGE_IN, 2.6 * len(results) + 1.6), squeeze=False, sharey="row", layout="constrained")
    for row, (scene, result) in zip(rows, results.items()):
        for axis, axes in enumerate(row[:len(AXES)]):
            draw_scene(axes, result, axis)
            axes.set_xlabel(AXES[axis], fontsize=looks.SMALL)
        for axes in row[len(AXES):]:
            draw_later(axes, result)
        row[0].set_ylabel(f"{scene}\nwhole error, dB", fontsize=looks.SMALL)
    handles, labels = rows[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=looks.SMALL, frameon=False)
    gain = looks.span(gains(results))
    looks.title(figure, looks.told("For a sphere's bytes a window within a base has {gain} dB more, while the gaze stays", "Window and base", gain=gain),
                looks.provenance_line(next(iter(results.values()))) + ". Milliseconds: of the client, both eyes. Right: what is seen by a head that has turned and moved on.")
    looks.save(figure, folder / "window")
    plt.close(figure)
    write_page(folder, results)


def gains(results):
    """The best window's dB beyond the widest sphere at the sphere's own CRFs, for no more bytes, a scene each: at the most bytes."""
    for result in results.values():
        sphere = max((entry for entry in result["rest"] if entry["source"] == f"sphere-{result['settings']['sphere_width']}"), key=lambda entry: entry["bytes_a_frame"], default=None)
        windows = [level(entry) for entry in result["rest"] if sphere and entry["source"].startswith("window") and entry["bytes_a_frame"] <= sphere["bytes_a_frame"]]
        if windows:
            yield max(windows) - level(sphere)


def draw_scene(axes, result, axis):
    """Times differ by what else a machine does, so they are points without a line."""
    for name, colour in colours(result["titles"]).items():
        entries = [entry for entry in result["rest"] if entry["source"] == name]
        points = [(cost, level(entry)) for entry in entries if (cost := (entry["bytes_a_frame"], client_ms(entry))[axis]) is not None]
        if points:
            axes.plot(*zip(*points), color=colour, marker="o", markersize=4, linestyle=("-", "none")[axis], linewidth=1.3, label=legend_text(result, name))
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)
    axes.tick_params(labelsize=looks.SMALL)


def legend_text(result, name):
    return f"{result['titles'][name]} ({result['rendered_pixels'][name] / 1e6:.2f} million pixels rendered)"


def draw_later(axes, result):
    heads = result.get("later", [])
    for name, colour in colours(result["titles"]).items():
        points = [(place, found[name]) for place, found in enumerate(levels(result, head["name"]) for head in heads) if name in found]
        if points:
            axes.plot(*zip(*points), color=colour, marker="o", markersize=4, linewidth=1.3)
    axes.set_xticks(range(len(heads)), [late_text(head) for head in heads], rotation=90)
    axes.set_xlabel("how late it is seen", fontsize=looks.SMALL)
    axes.tick_params(labelsize=looks.SMALL)


def levels(result, head):
    """{source: dB}, of what a head sees that is elsewhere."""
    return {entry["source"]: level(entry) for entry in result["elsewhere"] if entry["head"] == head}


def late_text(head):
    return f"{head['late_s']:g} s" if head["late_s"] >= 1 else f"{1000 * head['late_s']:g} ms"


def by_lateness(result):
    """{late_s: {source: dB}}."""
    return {head["late_s"]: levels(result, head["name"]) for head in result["later"]}


def later_table(results):
    rows = []
    for scene, result in results.items():
        found, there = by_lateness(result), [head["position_m"] for head in result["later"]]
        rows += [[scene, title, *(cell(by_source[source]) for by_source in found.values())] for source, title in result["titles"].items() if source in found[0]]
        rows.append([scene, "*metres that the head has gone*", *(cell(math.dist(there[0], position)) for position in there)])
    heads = next(iter(results.values()))["later"]
    return table(["scene", "source", *(f"{late_text(head)}, turned by {head['turned_deg']:.0f} degrees" for head in heads)], rows)


def silence_table(results):
    """The worst that is seen from the last frame on to the end of each silence; and less the worst of the whole sphere in as long."""
    rows = []
    for scene, result in results.items():
        found, sphere = by_lateness(result), f"sphere-{result['settings']['sphere_width']}"
        for source, title in result["titles"].items():
            if source in found[0]:
                worst = [{name: min(by_source[name] for late_s, by_source in found.items() if late_s <= silence_s) for name in (source, sphere)} for silence_s in SILENCES_S]
                rows.append([scene, title, *(cell(by_name[source]) for by_name in worst), *(f"{by_name[source] - by_name[sphere]:+.2f}" for by_name in worst)])
    return table(["scene", "source", *(f"worst in {silence_s} s" for silence_s in SILENCES_S), *(f"beyond the sphere's in {silence_s} s" for silence_s in SILENCES_S)], rows)


def jump_table(results):
    """kB and kinds of the first frame; of all frames from the jump on; and of as many where the gaze goes on."""
    rows = []
    for scene, result in results.items():
        at, frames = result["jump"]["at"], result["jump"]["frames"]
        for track, steady in frames["goes on"].items():
            rows.append([scene, track, *map(frames_text, (steady[:1], steady[at:], frames["jumps"][track][at:]))])
    return table(["scene", "track", "first frame, kB", "later frames, kB", "the same after a jump, kB"], rows)


def frames_text(frames):
    """kB of all of them, and their kinds."""
    return f"{sum(count for _, count in frames) / 1000:.2f} {''.join(kind for kind, _ in frames)}"


def rest_table(results):
    rows = []
    for scene, result in results.items():
        for entry in result["rest"]:
            count, pixels, ms = entry["bytes_a_frame"], result["rendered_pixels"][entry["source"]], client_ms(entry)
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
    later = {scene: result for scene, result in results.items() if "later" in result}
    for name, made_of, of in (("rest", rest_table, results), ("heads", heads_table, results), ("pair", beside_pair, results),
                              ("later", later_table, later), ("silence", silence_table, later), ("jump", jump_table, later)):
        if of:
            text = place(text, name, "all", made_of(of))
    write_whole(page, text)
    print(page)
