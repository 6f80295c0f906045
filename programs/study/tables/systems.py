"""Tables of what every system did: accuracy in all measures, time and bytes; scenes (the paper's Table 1) and bytes (its Table 2) beside the paper's."""

from experiments.systems import DECODING, STAGES, client_ms, faster
from found import KINDS, NOISE_FREE, all_bytes, ceiling_psnr, coding_name, decibels, error, gap_error, light_text, ms, psnr, ssim, together
from pages import both_kinds, cell, error_short, error_text, table
from render_list import EYES

FRAMES = 150
"""Of the paper's sequences."""

# The paper's Table 2, MB per 150 frames at 1080p in H.264 at CRF 16 and 24, main and small right-eye stream; as its text gives it.
STANDS_FOR = {"voxel-city": "Rungholt", "sponza-crytek": "Sponza", "san-miguel": "San Miguel", "kitchen": "Kitchen", "sibenik": "Sibenik"}
CRFS = (16, 24)
MEGABYTES = {
    "Rungholt": {"perspective": ((28.3, 9.83), (2.97, 1.28)), "equirect": ((27.9, 10.5), (2.85, 1.33))},
    "Sponza": {"perspective": ((27.7, 4.61), (1.77, 0.487)), "equirect": ((22.9, 3.88), (1.69, 0.502))},
    "San Miguel": {"perspective": ((37.1, 10.3), (2.94, 1.00)), "equirect": ((37.4, 10.9), (2.97, 1.08))},
    "Kitchen": {"perspective": ((16.3, 1.22), (0.567, 0.208)), "equirect": ((14.7, 1.05), (0.438, 0.151))},
    "Sibenik": {"perspective": ((21.1, 4.40), (1.79, 0.458)), "equirect": ((19.2, 4.05), (1.95, 0.492))},
}
"""Scene -> stream -> (main at each CRF, small at each CRF)."""


def paper_streams(scene, crf):
    """MB of the perspective main and small stream, and of the equirect ones; None where the paper has no such scene or CRF."""
    name = STANDS_FOR.get(scene)
    if name is None or crf not in CRFS:
        return None
    at = CRFS.index(crf)
    return [MEGABYTES[name][source][track][at] for source in ("perspective", "equirect") for track in (0, 1)]


def mean(values):
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def worst_text(entry, kind):
    """Of the worst hundredth of both eyes' pixels, dB."""
    return cell(together([entry[kind][eye][f"{kind}_worst_percent"]["linear"] for eye in EYES])["db"] if kind in entry else None, 1)


def gaps_text(entry, kind):
    """Of the pixels that the source did not see, each eye's by how many it has, dB."""
    by_eye = entry.get(kind, {}).values()
    gaps = [figures["gaps"] for figures in by_eye if "gaps" in figures]
    shares = [gap["fraction"] for gap in gaps]
    if not sum(shares):
        return "-"
    pooled = {key: sum(share * gap[kind]["linear"][key] for share, gap in zip(shares, gaps)) / sum(shares) for key in ("mean_square", "mean_square_low", "mean_square_high")}
    return error_short(together([pooled]))


def gap_share_text(entry):
    """Of the error, in per cent."""
    in_gaps, whole = gap_error(entry["noise_free"])
    return f"{100 * in_gaps / whole:.1f}" if in_gaps and whole > 0 else "-"


def slowest_ms(entry):
    """Of the faster run (experiments/systems.py): what decoding takes on average, which comes in bursts, and of other stages the 99th percentiles, the slowest of so few."""
    if not entry["codec"]:
        return None
    sources = faster(entry["milliseconds"])
    slowest = sum(played[stage]["p99"] for played in sources for stage in STAGES if stage in played and stage not in DECODING)
    return sum(client_ms(sources, stage) for stage in DECODING) + slowest / len(sources)


def flicker_db(entry, kind):
    """On display values. Results from before `compare` measured it have the noise-free one, beside FLIP."""
    found = [(figures.get("flicker") or {}).get(kind, {}).get("display") for figures in entry.get(kind, {}).values()]
    if kind == NOISE_FREE and not any(found):
        found = [figures.get("flicker") for figures in entry["perceived"].values()]
    return decibels(mean([figure["mean_square"] for figure in found])) if found and all(found) else None


def flicker_text(entry, kind):
    return cell(flicker_db(entry, kind), 1)


def times_text(entry, baselines):
    """How many copies of both views, and how many of FFmpeg's turns of the same sphere, the client's milliseconds are."""
    if ms(entry) is None:
        return "-"
    turn = baselines["v360"].get(str(entry["width"]))
    return f"{ms(entry) / baselines['copy']:,.0f} / {cell(ms(entry) / turn if turn else None, 1)}"


def system_row(entry, titles, baselines):
    errors = [error_text(error(entry, scale=scale, kind=kind)) for kind in KINDS for scale in ("linear", "display")]
    by_eye = [psnr(entry, eye) for eye in EYES]
    return [titles[entry["system"]], coding_name(entry), str(entry["width"] or "-"), cell(ms(entry), 1), cell(slowest_ms(entry), 1), times_text(entry, baselines), cell(all_bytes(entry), 0), *errors,
            " / ".join(cell(value, 1) for value in by_eye), " / ".join(cell(ssim(entry, eye), 3) for eye in EYES),
            both_kinds(worst_text, entry), cell(100 * mean(entry["gap_fraction"].values()), 2), both_kinds(gaps_text, entry), gap_share_text(entry), cell(mean([entry["perceived"][eye]["flip"] for eye in EYES]), 3),
            both_kinds(flicker_text, entry)]


SYSTEM_HEAD = ["system", "coding", "columns", "ms a frame", "slowest, ms", "times a copy / v360", "bytes a frame", "whole dB [95 %], linear", "the same, display", "noise-free dB [95 %], linear", "the same, display", "PSNR left / right", "SSIM left / right", "worst 1 %, whole / noise-free dB",
               "gaps, %", "in its own gaps, whole / noise-free dB", "of the noise-free error in gaps, %", "FLIP", "flicker, whole / noise-free dB"]


def systems_of(scene, result):
    """The table of one scene, with its ceiling, n and baselines."""
    n, baselines = result["systems"][0]["n"], result["baselines_ms"]
    turning = ", ".join(f"{ms:.2f} ms at {width} columns" for width, ms in baselines["v360"].items())
    ceiling = " / ".join(cell(ceiling_psnr(result, eye), 1) for eye in EYES)
    notes = (f"n = {n['frames']} frames x {n['seeds']} seeds, FLIP of the first {result['flip_pictures']} frames at {result['flip_pixels_a_degree']:.1f} pixels a degree (truth beside truth {cell(result['flip_ceiling'], 3)}). Ceiling, truth beside truth: {ceiling} dB. "
             f"The same in the same run: a copy of both views {baselines['copy']:.3f} ms; FFmpeg's v360 of both, decoding apart, {turning}.")
    return notes + "\n\n" + table(SYSTEM_HEAD, [system_row(entry, result["titles"], baselines) for entry in result["systems"]])


def scene_row(scene, info):
    return [scene, STANDS_FOR.get(scene, "-"), f"{info['triangles']:,}", f"{info['unique_triangles']:,}", str(info["textures"]), cell(info["path_length_m"], 1), cell(info["turn_deg"], 0),
            cell(info["nearest_m"]), f"{info['sphere_width']:.0f}", cell(info["depth_levels"], 0)]


def scenes(systems):
    """Table 1."""
    return table(["scene", "stands for", "triangles", "unique", "textures", "path, m", "turns, degrees", "nearest, m", "columns for e at 960 px", "depth levels"],
                 [scene_row(scene, result["scene_info"]) for scene, result in systems.items()])


def bytes_rows(results):
    for scene, result in results.items():
        coded = {(entry["system"], entry["crf"]): entry["bytes_a_frame"] for entry in result["systems"] if entry["codec"] == "h264"}
        for crf in result["settings"]["crfs"]:
            ours = [coded[system, crf][track] * FRAMES / 1e6 for system in ("perspective", "sphere-left") for track in ("main", "small")]
            theirs = paper_streams(scene, crf)
            yield [scene, f"{crf:g}", *map(megabytes_text, ours), cell(ours[2] / ours[0]), *([f"{size:g}" for size in theirs] + [cell(theirs[2] / theirs[0])] if theirs else ["-"] * 5)]


def megabytes_text(size):
    return f"{size:.3g}"


def bytes_table(results):
    """Table 2."""
    return table(["scene", "CRF", f"perspective, MB per {FRAMES} frames (scaled from n)", "its small stream", "sphere", "its small stream", "sphere / perspective",
                  "the paper's perspective, MB", "its small stream", "its sphere", "its small stream", "sphere / perspective"], list(bytes_rows(results)))


def parts(systems):
    """Sections of tables.md."""
    if not systems:
        return []
    found = ["## Scenes (the paper's Table 1)", scenes(systems)]
    for scene, result in systems.items():
        found += [f"## Systems in {scene}{light_text(result)}", systems_of(scene, result)]
    return [*found, "## Bytes (the paper's Table 2)", bytes_table(systems)]
