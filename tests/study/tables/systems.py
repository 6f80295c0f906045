"""Tables of what every system did: accuracy in all measures, time and bytes; scenes (the paper's Table 1) and bytes (its Table 2) beside the paper's."""

from found import all_bytes, ceiling_psnr, coding_name, error, ms, psnr
from noise_free import decibels
from pages import cell, noise_free_text, table
from render_list import EYES

from . import paper

FRAMES = 150
"""Of the paper's sequences."""


def mean(values):
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def pooled_db(entry, part):
    """Of the squares of both eyes; `part(eye's figures)` is a PSNR."""
    values = [part(entry["against_other_seed"][eye]) for eye in EYES]
    known = [10 ** (-value / 10) for value in values if value is not None]
    return decibels(sum(known) / len(known)) if known else None


def flicker_db(entry):
    found = [entry["perceived"][eye]["flicker"] for eye in EYES]
    return decibels(sum(figure["mean_square"] for figure in found) / len(found)) if all(found) else None


def system_row(entry, titles):
    noise_free = {scale: noise_free_text(error(entry, scale=scale)) for scale in ("linear", "display")}
    by_eye = [psnr(entry, eye) for eye in EYES]
    return [titles[entry["system"]], coding_name(entry), str(entry["width"] or "-"), cell(ms(entry), 1), cell(all_bytes(entry), 0), noise_free["linear"], noise_free["display"],
            " / ".join(cell(value, 1) for value in by_eye), " / ".join(cell(entry["against_other_seed"][eye]["ssim"], 3) for eye in EYES),
            cell(pooled_db(entry, lambda eye: eye["psnr_worst_percent_db"]), 1), cell(100 * mean(entry["gap_fraction"].values()), 2),
            cell(pooled_db(entry, lambda eye: eye.get("gaps", {}).get("psnr_db")), 1), cell(mean([entry["perceived"][eye]["flip"] for eye in EYES]), 3), cell(flicker_db(entry), 1)]


SYSTEM_HEAD = ["system", "coding", "columns", "ms a frame", "bytes a frame", "noise-free dB [95 %], linear", "the same, display", "PSNR left / right", "SSIM left / right", "worst 1 %, dB",
               "gaps, %", "in gaps, dB", "FLIP", "flicker, dB"]


def systems_of(scene, result):
    """The table of one scene, with its ceiling, n and baselines."""
    n, baselines = result["systems"][0]["n"], result["baselines_ms"]
    turning = ", ".join(f"{ms:.2f} ms at {width} columns" for width, ms in baselines["v360"].items())
    ceiling = " / ".join(cell(ceiling_psnr(result, eye), 1) for eye in EYES)
    notes = (f"n = {n['frames']} frames x {n['seeds']} seeds, FLIP of the first {result['flip_pictures']} frames (truth beside truth {cell(result['flip_ceiling'], 3)}). Ceiling, truth beside truth: {ceiling} dB. "
             f"The same in the same run: a copy of both views {baselines['copy']:.3f} ms; FFmpeg's v360 of both, decoding apart, {turning}.")
    return notes + "\n\n" + table(SYSTEM_HEAD, [system_row(entry, result["titles"]) for entry in result["systems"]])


def scene_row(scene, info):
    return [scene, paper.STANDS_FOR.get(scene, "-"), f"{info['triangles']:,}", f"{info['unique_triangles']:,}", str(info["textures"]), cell(info["path_length_m"], 1), cell(info["turn_deg"], 0),
            cell(info["nearest_m"]), f"{info['sphere_width']:.0f}", f"{info['depth_levels']:.0f}"]


def scenes(systems):
    """Table 1."""
    return table(["scene", "stands for", "triangles", "unique", "textures", "path, m", "turns, degrees", "nearest, m", "columns for e at 960 px", "depth levels"],
                 [scene_row(scene, result["scene_info"]) for scene, result in systems.items()])


def bytes_rows(sizes):
    for scene, result in sizes.items():
        views = {(row["codec"], row["crf"]): row for row in result["rows"] if row["source"] == "perspective"}
        for row in result["rows"]:
            if row["source"] == "perspective":
                continue
            view, megabytes = views[row["codec"], row["crf"]], lambda of, track: of["bytes_a_frame"].get(track, 0) * FRAMES / 1e6
            ratio = row["bytes_a_frame"]["main"] / view["bytes_a_frame"]["main"]
            theirs = paper.ratio(scene, row["crf"]) if row["codec"] == "h264" else None
            yield [scene, row["source"], row["codec"], f"{row['crf']:g}", cell(megabytes(view, "main")), cell(megabytes(view, "small"), 3), cell(megabytes(row, "main")), cell(megabytes(row, "small"), 3),
                   cell(ratio), cell(theirs), f"{view['samples']:.0f} / {row['samples']:.0f}"]


def sizes_table(sizes):
    """Table 2."""
    return table(["scene", "sphere", "codec", "CRF", f"perspective, MB per {FRAMES} frames", "its small stream", "sphere", "its small stream", "sphere / perspective", "the paper's", "samples a pixel"],
                 list(bytes_rows(sizes)), labels=3)


def lock_rows(sizes):
    for scene, result in sizes.items():
        by = {(row["lock"], row["codec"], row["crf"]): row["bytes_a_frame"]["main"] for row in result["locks"]}
        for lock, codec, crf in by:
            if lock == "world":
                yield [scene, codec, f"{crf:g}", cell(by[lock, codec, crf], 0), cell(by["path", codec, crf], 0), cell(by[lock, codec, crf] / by["path", codec, crf])]


def locks_table(sizes):
    return table(["scene", "codec", "CRF", "world-locked, bytes a frame", "path-locked", "world / path"], list(lock_rows(sizes)))


def parts(systems, sizes):
    """Sections of tables.md."""
    found = []
    if systems:
        found += ["## Scenes (the paper's Table 1)", scenes(systems)]
        for scene, result in systems.items():
            found += [f"## Systems in {scene}", systems_of(scene, result)]
    if sizes:
        found += ["## Bytes (the paper's Table 2)", sizes_table(sizes), "## World-locked and path-locked", locks_table(sizes)]
    return found
