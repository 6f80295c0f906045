"""Systems beside the paper's that it names: layouts, rows of a sphere, difference streams, motion search and grids of blocks, one row of panels each."""

import matplotlib.pyplot as plt
from found import db, load
from tables.related import ANCHOR, DEFAULT_SEARCH, SECOND_EYE, beside, curve, of

from . import looks

LAYOUTS = {ANCHOR: "#145a32", "cube": "#c0392b", "eac": "#2e86c1", "cylinder": "#b9770e"}
SECOND_EYE_COLOURS = {"direct": "#d4ac0d", "together": "#2e86c1", "difference": "#8e44ad"}
GRIDS = {"adaptive": "#145a32", "mesh": "#2e86c1", "mesh-plain": "#b9770e"}


def log_bytes(axes):
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis, narrow=True)


def draw_layouts(axes, result):
    for name, colour in LAYOUTS.items():
        points = of(result["layouts"], layout=name)
        axes.plot(*zip(*curve(points, "left")), color=colour, marker="o", markersize=4, linewidth=1.3, label=points[0]["title"])
        axes.axhline(db(points[0], "left"), color=colour, linewidth=0.9, linestyle=(0, (4, 3)))
    log_bytes(axes)
    axes.set_xlabel("bytes a frame, sphere at\nthe left eye (dashed: uncoded)", fontsize=looks.SMALL)


def draw_latitudes(axes, result):
    """Shares of the whole sphere's."""
    rows = list(beside(result["latitudes"], ("crf",), "latitude_deg", 90))
    labels = sorted({point["latitude_deg"] for point, _ in rows})
    crfs = sorted({point["crf"] for point, _ in rows})
    width = 0.8 / (len(crfs) + 2)
    for at, latitude in enumerate(labels):
        here = [(point, whole) for point, whole in rows if point["latitude_deg"] == latitude]
        bars = [("#cccccc", "pixels", here[0][0]["pixel_share"]), ("#7f8c8d", "solid angle", here[0][0]["solid_angle_share"]),
                *((plt.get_cmap("viridis")(0.2 + 0.5 * i), f"bytes, CRF {point['crf']:g}", point["bytes_a_frame"] / whole["bytes_a_frame"])
                  for i, (point, whole) in enumerate(here))]
        for i, (colour, name, share) in enumerate(bars):
            axes.bar(at + (i - len(bars) / 2 + 0.5) * width, 100 * share, width, color=colour, label=name if at == 0 else None)
    axes.set_xticks(range(len(labels)), [f"{label:g}" for label in labels], fontsize=looks.SMALL)
    axes.set_xlabel("rows of the sphere,\ndegrees up and down", fontsize=looks.SMALL)


def draw_differences(axes, result):
    for kind, title in SECOND_EYE.items():
        axes.plot(*zip(*curve(of(result["differences"], kind=kind), "right")), color=SECOND_EYE_COLOURS[kind], marker="o", markersize=4, linewidth=1.3, label=title)
    levels = [level for point in of(result["differences"], kind="reprojected") if (level := db(point, "right")) is not None]
    axes.axhspan(min(levels), max(levels), color="#bbbbbb", alpha=0.5, linewidth=0, label="reprojected, by CRF, nothing sent")
    log_bytes(axes)
    axes.set_xlabel("bytes a frame\nof the second eye", fontsize=looks.SMALL)


def draw_searches(axes, result):
    """Bytes beside the default's, with the PSNR beside its."""
    sources = list(dict.fromkeys(point["source"] for point in result["searches"]))
    ticks = []
    for i, source in enumerate(sources):
        for point, default in beside(of(result["searches"], source=source), ("source",), "search", DEFAULT_SEARCH):
            saved = 100 * (point["bytes_a_frame"] / default["bytes_a_frame"] - 1)
            axes.bar(len(ticks), saved, 0.7, color="#2e86c1" if i == 0 else "#145a32", label=source if point["search"] == DEFAULT_SEARCH else None)
            axes.annotate("" if point is default else f"{point['psnr_db'] - default['psnr_db']:+.2f} dB", (len(ticks), 1), xycoords=("data", "axes fraction"), ha="center", va="top",
                          fontsize=looks.SMALL, rotation=90)
            ticks.append(point["search"])
    axes.axhline(0, color="#555555", linewidth=0.8)
    axes.margins(y=0.7)
    axes.set_xticks(range(len(ticks)), ticks, fontsize=looks.SMALL, rotation=90)
    axes.set_xlabel(f"motion search of x264\nat CRF {result['searches'][0]['crf']:g}, and its range", fontsize=looks.SMALL)


def draw_blocks(axes, result):
    for kind, colour in GRIDS.items():
        points = sorted(of(result["blocks"], kind=kind), key=lambda point: point["cells"])
        axes.plot([point["cells"] for point in points], [db(point) for point in points], color=colour, marker="o", markersize=4, linewidth=1.3, label=points[0]["title"])
    log_bytes(axes)
    axes.set_xlabel("cells of the sphere\nat the head's centre", fontsize=looks.SMALL)


PANELS = ((draw_layouts, "left eye, dB"), (draw_latitudes, "% of the whole sphere's"), (draw_differences, "right eye, dB"),
          (draw_searches, f"bytes beside {DEFAULT_SEARCH}, %"), (draw_blocks, "both eyes, dB"))


def better_layout(results):
    """dB of the left eye that the equi-angular cube map has beyond the equirectangular image, uncoded."""
    for result in results.values():
        levels = {point["layout"]: db(point, "left") for point in reversed(result["layouts"])}
        if None not in (levels.get("eac"), levels.get(ANCHOR)):
            yield levels["eac"] - levels[ANCHOR]


def draw_all(folder):
    results = load(folder, "related")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(PANELS), len(results), figsize=(looks.PAGE_IN, 3.1 * len(PANELS) + 1), squeeze=False, sharey="row", layout="constrained")
    for column, result in enumerate(results.values()):
        panels[0][column].set_title(result["scene"], loc="left")
        for row, (draw, label) in zip(panels, PANELS):
            draw(row[column], result)
            row[0].set_ylabel(label, fontsize=looks.SMALL)
    for i, row in enumerate(panels):
        looks.legend_above(row[0], 5, 1.12 if i else 1.2)
    figure.get_layout_engine().set(h_pad=0.36)
    first = next(iter(results.values()))
    gain = looks.span(better_layout(results))
    looks.title(figure, looks.told("As many pixels as an equi-angular cube map give {gain} dB more than equirectangular", "Systems that the paper names", gain=gain),
                looks.provenance_line(first) + ". Noise-free on linear values; x264 by FFmpeg; layouts have as many pixels each.")
    looks.save(figure, folder / "related")
    plt.close(figure)
