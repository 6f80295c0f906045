"""Chart 3: a sphere's whole error against its width and its bytes, with the perspective render's line and where they cross. One row a scene."""

import matplotlib.pyplot as plt
from curves import REFERENCES, SPHERE, matching, of, parity_of, parity_width, points, widths
from found import light_text, load, seen_db, seen_interval_db

from . import looks

REFERENCE = "perspective"


def frames_text(result):
    first, last = result["frames"].split("-")
    return f"frame {first}" if first == last else f"frames {first}-{last}"


def quality_colours(qualities):
    return dict(zip(qualities, plt.get_cmap("viridis")([0.08 + 0.8 * i / max(len(qualities) - 1, 1) for i in range(len(qualities))])))


def draw_widths(axes, result):
    """At each CRF, beside the perspective view at the same; a cross where they are equal."""
    entries = result["entries"]
    qualities = sorted({entry["crf"] for entry in entries if entry["crf"] is not None})
    ws = widths(entries, SPHERE)
    for crf, colour in quality_colours(qualities).items():
        spheres = [next(e for e in entries if e["system"] == SPHERE and e["width"] == w and e["crf"] == crf) for w in ws]
        for entry in spheres:
            looks.interval(axes, entry["width"], seen_interval_db(entry), colour)
        axes.plot(ws, [seen_db(entry) for entry in spheres], color=colour, marker="o", markersize=4, linewidth=1.3, label=f"CRF {crf:g}")
        reference = next((e for e in entries if e["system"] == REFERENCE and e["crf"] == crf), None)
        if reference is None:
            continue
        level = seen_db(reference)
        axes.axhline(level, color=colour, linewidth=1, linestyle=(0, (4, 3)))
        if (width := parity_width(entries, SPHERE, level, crf)) is not None:
            axes.plot([width], [level], marker="x", color=colour, markersize=9, markeredgewidth=2)
    uncoded = [e for e in entries if e["system"] == SPHERE and e["crf"] is None]
    axes.plot([e["width"] for e in uncoded], [seen_db(e) for e in uncoded], color="#555555", linewidth=1, marker="*", label="uncoded")
    axes.axvline(matching(result["settings"]), color="#bbbbbb", linewidth=1)
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


def draw_bytes(axes, result):
    """Of each width."""
    entries = result["entries"]
    for width, colour in quality_colours(widths(entries, SPHERE)).items():
        axes.plot(*zip(*sorted(points(of(entries, SPHERE, width)))), color=colour, marker="o", markersize=4, linewidth=1.3, label=f"sphere, {width} columns")
    for (system, title), style in zip(REFERENCES.items(), ("-", ":")):
        axes.plot(*zip(*sorted(points(of(entries, system)))), color=looks.COLOURS[system], linestyle=style, marker="s", markersize=4, linewidth=1.6,
                  label=title)
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


COLUMNS = ((draw_widths, "columns of the sphere"), (draw_bytes, "bytes a frame (all tracks)"))


def parity_times(results):
    """Widths at which the sphere has what the view has at the same CRF, in those of 2 pi f columns."""
    for result in results.values():
        for row in parity_of(result, SPHERE, REFERENCE):
            if row["width"] is not None:
                yield row["width"] / matching(result["settings"])


def draw_all(folder):
    results = load(folder, "parity")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(results), len(COLUMNS), figsize=(looks.PAGE_IN, 3 * len(results) + 1.5), squeeze=False, sharex="col", sharey=True, layout="constrained")
    for row, result in zip(panels, results.values()):
        row[0].set_title(f"{result['scene']}, {frames_text(result)}{light_text(result)}", loc="left")
        row[0].set_ylabel("whole error, dB, both eyes")
        for axes, (draw, _) in zip(row, COLUMNS):
            draw(axes, result)
    for axes, top, (_, label) in zip(panels[-1], panels[0], COLUMNS):
        axes.set_xlabel(label)
        looks.legend_above(top, 2)
    first = next(iter(results.values()))
    times = looks.span(parity_times(results))
    looks.title(figure, looks.told("A sphere equals a perspective view at {times} times 2 pi f columns, where it does", "No sphere equals a perspective view", times=times),
                looks.provenance_line(first) + ". Of display values. Against columns: dashed is the perspective view at the same CRF, a cross where the sphere equals it; grey: 2 pi f columns. Vertical lines: 95 % of the noise.", 5)
    looks.save(figure, folder / "parity")
    plt.close(figure)
