"""Chart 3: a sphere's accuracy against its width and its bytes, with the perspective render's line and where they cross; PSNR and SSIM, noise and all, below. One column a scene."""

import matplotlib.pyplot as plt
from curves import REFERENCES, SPHERE, matching, of, parity_width, points, widths
from found import db, interval_db, load, psnr, ssim, together_psnr
from render_list import EYES

from . import looks

REFERENCE = "perspective"


def quality_colours(qualities):
    return dict(zip(qualities, plt.get_cmap("viridis")([0.08 + 0.8 * i / max(len(qualities) - 1, 1) for i in range(len(qualities))])))


def mean_ssim(entry):
    return sum(ssim(entry, eye) for eye in EYES) / len(EYES)


def draw_ceiling(axes, eyes, accuracy):
    level = together_psnr([eyes[eye]["mean_square"] for eye in EYES])
    if accuracy is db:
        looks.ceiling_note(axes, level)
    elif accuracy is psnr:
        looks.level(axes, level, f"truth against truth: {level:.1f} dB")
    else:
        similar = sum(eyes[eye]["ssim"] for eye in EYES) / len(EYES)
        looks.level(axes, similar, f"truth against truth: {similar:.2f}")


def draw_widths(axes, result, accuracy):
    """At each CRF, beside the perspective view at the same; a cross where their noise-free errors are equal."""
    entries = result["first"]
    qualities = sorted({entry["crf"] for entry in entries if entry["crf"] is not None})
    for crf, colour in quality_colours(qualities).items():
        ws = widths(entries, SPHERE)
        spheres = [next(e for e in entries if e["system"] == SPHERE and e["width"] == w and e["crf"] == crf) for w in ws]
        if accuracy is db:
            for entry in spheres:
                looks.interval(axes, entry["width"], interval_db(entry), colour)
        axes.plot(ws, [accuracy(entry) for entry in spheres], color=colour, marker="o", markersize=4, linewidth=1.3, label=f"CRF {crf:g}")
        reference = next((e for e in entries if e["system"] == REFERENCE and e["crf"] == crf), None)
        if reference is None or (level := accuracy(reference)) is None:
            continue
        axes.axhline(level, color=colour, linewidth=1, linestyle=(0, (4, 3)))
        if accuracy is db and (width := parity_width(entries, SPHERE, db(reference), crf)) is not None:
            axes.plot([width], [db(reference)], marker="x", color=colour, markersize=9, markeredgewidth=2)
    uncoded = [e for e in entries if e["system"] == SPHERE and e["crf"] is None]
    axes.plot([e["width"] for e in uncoded], [accuracy(e) for e in uncoded], color="#555555", linewidth=1, marker="*", label="uncoded")
    axes.axvline(matching(result["settings"]), color="#bbbbbb", linewidth=1)
    draw_ceiling(axes, result["ceiling"]["first"], accuracy)
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


def draw_bytes(axes, result):
    """Of each width, all the preset's frames."""
    entries = result["all"]
    for width, colour in quality_colours(widths(entries, SPHERE)).items():
        axes.plot(*zip(*sorted(points(of(entries, SPHERE, width)))), color=colour, marker="o", markersize=4, linewidth=1.3, label=f"sphere, {width} columns")
    for (system, title), style in zip(REFERENCES.items(), ("-", ":")):
        axes.plot(*zip(*sorted(points(of(entries, system)))), color=looks.COLOURS[system], linestyle=style, marker="s", markersize=4, linewidth=1.6,
                  label=title)
    draw_ceiling(axes, result["ceiling"]["all"], db)
    axes.set_xscale("log")
    looks.log_axis(axes.xaxis)


COLUMNS, BYTES = "columns of the sphere", "bytes a frame (all tracks)"
NOISE_FREE = "noise-free, dB (linear), both eyes"
ROWS = ((lambda axes, result: draw_widths(axes, result, db), NOISE_FREE, COLUMNS), (draw_bytes, NOISE_FREE, BYTES),
        (lambda axes, result: draw_widths(axes, result, psnr), "PSNR, noise and all, dB", COLUMNS),
        (lambda axes, result: draw_widths(axes, result, mean_ssim), "SSIM, noise and all", COLUMNS))


def draw_all(folder):
    results = load(folder, "parity")
    if not results:
        return
    plt.rcParams.update(looks.STYLE)
    figure, panels = plt.subplots(len(ROWS), len(results), figsize=(max(3.5 * len(results), 7) + 1.5, 3.6 * len(ROWS) + 0.8), squeeze=False, layout="constrained")
    for column, result in enumerate(results.values()):
        first, last = result["first_frames"].split("-")
        panels[0][column].set_title(f"{result['scene']}, " + (f"frame {first}" if first == last else f"frames {first}-{last}"), loc="left")
        for row, (draw, _, label) in zip(panels, ROWS):
            draw(row[column], result)
            row[column].set_xlabel(label)
    for row, (_, label, _) in zip(panels, ROWS):
        row[0].set_ylabel(label)
        looks.legend_beside(row[-1])
    first = next(iter(results.values()))
    looks.title(figure, looks.provenance_line(first) + ". Against columns: dashed is the perspective view at the same CRF, a cross where the sphere equals it; grey: 2 pi f columns. Vertical lines: 95 % of the noise. Curves of bytes: all frames.")
    looks.save(figure, folder / "parity")
    plt.close(figure)
