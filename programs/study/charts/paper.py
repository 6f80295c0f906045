"""Chart 2: our own of the paper's Figures 1 and 5 to 8, of its systems: bytes, time a frame by stage, PSNR and SSIM of each eye. Its figures have no numbers in its text, so none of theirs is drawn.

PSNR and SSIM carry the noise of truth and source, and a sphere's samples are more to an eye's pixel than a view's; what the noise hides, the noise-free error beside them shows.
"""

import base64
import io

import matplotlib.pyplot as plt
import numpy as np
from found import ceiling_psnr, db, light_text, load, psnr, ssim
from kept import all_pictures
from PIL import Image
from render_list import EYES
from steps import write_whole

from . import looks

SYSTEMS = {"perspective": "perspective", "sphere-left": "sphere, left eye", "centre": "sphere, centre", "two-spheres": "two spheres"}
PAPERS = ("perspective", "sphere-left")
"""Of them, the paper's own, which send a small stream along."""
STAGES = {"decode": "#7f8c8d", "convert": "#b2babb", "depth": "#1e8449", "reproject": "#2e86c1", "fill": "#d4ac0d"}
CODEC = "h264"


def entries(result, crf):
    """Of the paper's codec."""
    by_name = {entry["system"]: entry for entry in result["systems"] if entry["codec"] == CODEC and entry["crf"] == crf}
    return {name: by_name[name] for name in SYSTEMS if name in by_name}


def panels_of(results, rows, height):
    figure, panels = plt.subplots(rows, len(results), figsize=(looks.PAGE_IN, height * rows + 1.6), squeeze=False, sharey="row", layout="constrained")
    for column, result in enumerate(results.values()):
        panels[0][column].set_title(result["scene"] + light_text(result).replace(" (", "\n("), loc="left", fontsize=9)
    return figure, panels


def finish(figure, results, finding, words, file):
    first = next(iter(results.values()))
    looks.title(figure, finding, f"{words} H.264, spheres of {first['settings']['sphere_width']} columns; {looks.provenance_line(first)}", 1)
    looks.save(figure, file)
    plt.close(figure)


def bars(axes, names, values, colours, **options):
    axes.bar(range(len(names)), values, color=colours, width=0.72, **options)
    axes.set_xticks(range(len(names)), [SYSTEMS[name] for name in names], rotation=50, ha="right", fontsize=looks.SMALL)


# Name -> of an entry, of a result's ceiling.
MEASURES = {"PSNR, dB": (psnr, ceiling_psnr), "SSIM": (ssim, lambda result, eye: result["ceiling"][eye]["ssim"]), "noise-free, dB": (db, None)}


def draw_quality(results, file):
    """Figures 7 and 8."""
    crfs = next(iter(results.values()))["settings"]["crfs"]
    rows = [(measure, eye) for measure in MEASURES for eye in EYES]
    figure, panels = panels_of(results, len(rows), 2.1)
    for column, result in enumerate(results.values()):
        for row, (measure, eye) in enumerate(rows):
            axes, (value, ceiling) = panels[row][column], MEASURES[measure]
            for i, crf in enumerate(crfs):
                found = entries(result, crf)
                axes.plot(np.arange(len(found)) + 0.3 * (i - 0.5), [value(entry, eye) for entry in found.values()], color=("#1f618d", "#d35400")[i % 2], marker="os"[i % 2], markersize=5,
                          linestyle="none", label=f"CRF {crf:g}")
            axes.set_xlim(-0.6, len(found) - 0.4)
            axes.set_xticks(range(len(found)), [SYSTEMS[name] for name in found] if row == len(rows) - 1 else [], rotation=50, ha="right", fontsize=looks.SMALL)
            if ceiling:
                axes.axhline(ceiling(result, eye), **looks.LEVEL, label="truth against truth")
            panels[row][0].set_ylabel(f"{measure}, {eye} eye", fontsize=looks.SMALL)
    looks.legend_above(panels[0][0], 3, 1.25)
    lost = looks.span([db(by["perspective"], "left") - db(by["sphere-left"], "left") for by in (entries(result, max(crfs)) for result in results.values()) if set(PAPERS) <= set(by)])
    finish(figure, results, looks.told("Resampled from a sphere at its own place an eye loses {lost} dB (CRF {crf:g}, noise-free)", "PSNR and SSIM of each eye", lost=lost, crf=max(crfs)), "The paper's Figures 7 and 8, ours.", file)


def draw_times(results, file):
    """Figure 6, with what turning the sphere to both views takes FFmpeg."""
    crf = next(iter(results.values()))["settings"]["crfs"][0]
    figure, panels = panels_of(results, 1, 3.2)
    for column, result in enumerate(results.values()):
        found, bottom = entries(result, crf), None
        for stage, colour in STAGES.items():
            values = np.array([entry["ms"][stage] for entry in found.values()])
            bars(panels[0][column], list(found), values, colour, bottom=bottom, label=stage)
            bottom = values if bottom is None else bottom + values
        panels[0][column].axhline(result["baselines_ms"]["v360"][str(result["settings"]["sphere_width"])], **looks.LEVEL, label="v360 of both views")
    panels[0][0].set_ylabel("ms a frame, both eyes")
    looks.legend_above(panels[0][0], len(STAGES) + 1, 1.18)
    shares = looks.span([100 * entry["ms"]["depth"] / sum(entry["ms"].values()) for result in results.values() if (entry := entries(result, crf).get("centre"))], 0)
    finish(figure, results, looks.told("Depth takes {shares} % of a sphere's time on the client", "Time by stage", shares=shares), f"The paper's Figure 6, ours, CRF {crf:g}.", file)


def draw_bytes(results, file):
    """Figure 5."""
    crfs = next(iter(results.values()))["settings"]["crfs"]
    figure, panels = panels_of(results, 1, 3.2)
    for column, result in enumerate(results.values()):
        for i, name in enumerate(PAPERS):
            tracks = [entries(result, crf)[name]["bytes_a_frame"] for crf in crfs]
            at = np.arange(len(crfs)) + 0.8 * (i + 0.5) / len(PAPERS) - 0.4
            main = [by["main"] / 1000 for by in tracks]
            panels[0][column].bar(at, main, width=0.75 / len(PAPERS), color=("#c0392b", "#2e86c1")[i], label=SYSTEMS[name])
            panels[0][column].bar(at, [by["small"] / 1000 for by in tracks], width=0.75 / len(PAPERS), color="#444444", bottom=main, label="small stream" if i == 0 else None)
        panels[0][column].set_xticks(range(len(crfs)), [f"CRF {crf:g}" for crf in crfs], fontsize=looks.SMALL)
    panels[0][0].set_ylabel("kB a frame")
    looks.legend_above(panels[0][0], 3, 1.18)
    times = looks.span([sphere / view for result in results.values() for crf in crfs
                        for view, sphere in [[sum(entries(result, crf)[name]["bytes_a_frame"].values()) for name in PAPERS]]])
    finish(figure, results, looks.told("A sphere takes {times} times the bytes of a perspective view", "Bytes", times=times), "The paper's Figure 5, ours.", file)


def picture(data_uri):
    return Image.open(io.BytesIO(base64.b64decode(data_uri.split(",", 1)[1])))


def draw_anaglyphs(pictures, file):
    """Figure 1."""
    figure, panels = plt.subplots(1, len(pictures), figsize=(max(4.8 * len(pictures), 6), 3.2), squeeze=False, layout="constrained")
    for axes, (scene, found) in zip(panels[0], pictures.items()):
        axes.imshow(picture(found["anaglyph"]))
        axes.set_title(f"{scene}, frame {found['frame']}", loc="left")
        axes.axis("off")
    looks.title(figure, "Both eyes from one coded sphere at the head's centre", "For red and cyan glasses (Dubois 2001).")
    drawn = io.BytesIO()
    figure.savefig(drawn, format="jpeg", dpi=100, pil_kwargs={"quality": 80})
    write_whole(file.with_suffix(".jpg"), drawn.getvalue())
    print(file.with_suffix(".jpg"))
    plt.close(figure)


def draw_all(folder):
    plt.rcParams.update(looks.STYLE)
    if systems := load(folder, "systems"):
        if pictures := all_pictures(folder, systems):
            draw_anaglyphs(pictures, folder / "paper-anaglyph")
        draw_quality(systems, folder / "paper-quality")
        draw_times(systems, folder / "paper-times")
        draw_bytes(systems, folder / "paper-bytes")
