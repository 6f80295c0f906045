#!/usr/bin/env python3
"""Writes the tables of docs/results/reproject.md and of the pages beside its JSON (tables.md, speed.md, depth_codes.md), between their
markers, from the JSON files of docs/results/reproject and nothing else. A table without a marker is added to tables.md. Noise-free figures are on linear values, in brackets those on display values.

    report.py [--results FOLDER] [--page FILE]
"""

import argparse
import json
import pathlib
import sys

import results

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from found import only_bounded  # noqa: E402
from pages import both_scales, cell, error_short, error_text, place, table  # noqa: E402

HEAD_NAMES = {"stereo": "63 mm stereo", "moved": "head moved 0.25 m"}


def one_eye(entry, eye, figure):
    return both_scales({scale: error_short(figure(entry, eye, scale)) for scale in results.SCALES})


def eyes_cell(entry, figure):
    """"left / right (left / right)", linear (display)."""
    texts = {scale: [error_short(figure(entry, eye, scale)) for eye in results.EYES] for scale in results.SCALES}
    if all(text == "-" for eyes in texts.values() for text in eyes):
        return "-"
    return both_scales({scale: " / ".join(eyes) for scale, eyes in texts.items()})


def summary(found, head, kind="systems"):
    """Noise-free dB of each system, a column a scene."""
    systems = dict.fromkeys(entry["system"] for result in found.values() for entry in result.get(kind, []))
    rows = []
    for system in systems:
        entries = [results.find(result, kind, system, head) for result in found.values()]
        rows.append([results.NAMES.get(system, system)] + ["-" if entry is None else eyes_cell(entry, results.error) for entry in entries])
    return table(["system", *found], rows, labels=1)


def ceiling_row(result, head, worst_is_noise_free):
    eyes = result["ceiling"][head]["eyes"]
    row = ["truth, another seed (ceiling)"]
    for eye in results.EYES:
        row += ["-", "-", "-", cell(eyes[eye]["psnr_db"]), cell(eyes[eye]["ssim"], 4), "-" if worst_is_noise_free else cell(eyes[eye]["psnr_worst_percent_db"])]
    return [*row, "-", "-"]


def accuracy(result, head):
    entries = [e for kind in ("systems", "coded") for e in result.get(kind, []) if e["head"] == head]
    worst_is_noise_free = all(results.worst_error(entry, eye, "linear") for entry in entries for eye in results.EYES)
    columns = ("noise-free dB, linear,", "display,", "in gaps,", "PSNR dB,", "SSIM,", "worst 1 %, noise-free," if worst_is_noise_free else "worst 1 %, PSNR,")
    rows = [ceiling_row(result, head, worst_is_noise_free)]
    for entry in entries:
        row = [results.NAMES.get(entry["system"], entry["system"])]
        for eye in results.EYES:
            noisy = entry["against_other_seed"]["eyes"][eye]
            worst = one_eye(entry, eye, results.worst_error) if worst_is_noise_free else cell(noisy["psnr_worst_percent_db"])
            row += [error_text(results.error(entry, eye, "linear")), error_short(results.error(entry, eye, "display")),
                    one_eye(entry, eye, results.gap_error), cell(noisy["psnr_db"]), cell(noisy["ssim"], 4), worst]
        gaps = entry["against_other_seed"]["eyes"]["right"].get("gaps")
        rows.append([*row, cell(100 * gaps["fraction"]) if gaps else "-", cell(results.reprojection_ms(entry), 1)])
    return table(["system"] + [f"{column} {eye}" for eye in results.EYES for column in columns] + ["gaps %, right", "reproject + fill, ms"], rows)


def coded(found):
    rows = []
    for scene, result in found.items():
        for head in HEAD_NAMES:
            for system in results.CODED:
                entry = results.find(result, "coded", system, head)
                if entry:
                    rows.append([scene, f"{results.NAMES[system]}, {HEAD_NAMES[head]}", ", ".join(f"{r['crf']:g}" for r in entry["encoded"]),
                                 f"{results.coded_bytes(entry):,.0f}", eyes_cell(entry, results.error), eyes_cell(entry, results.gap_error)])
    return table(["scene", "system", "CRF by seed", "bytes a frame", "noise-free dB", "in gaps"], rows)


def lead(better, worse, digits=2):
    """By how many dB the one of two noise-free figures is ahead of the other; `?` where the interval of either reaches zero error."""
    if better["db"] is None or worse["db"] is None:
        return "?"
    text = f"{better['db'] - worse['db']:+.{digits}f}"
    return (text if float(text) else text[1:]) + ("?" if only_bounded(better) or only_bounded(worse) else "")


def lead_cell(result, entry, rival, is_rival):
    """Of both eyes together; the rival's own dB in its row."""
    if entry is None or rival is None:
        return "-"
    found, against = ({scale: results.both_eyes(e, scale) for scale in results.SCALES} for e in (entry, rival))
    own = {scale: "?" if figure["db"] is None else f"{figure['db']:.2f}" + "?" * only_bounded(figure) for scale, figure in found.items()}
    other_version = "" if results.commit_of(result, entry) == results.commit_of(result, rival) else "*"
    return both_scales(own if is_rival else {scale: lead(found[scale], against[scale]) for scale in results.SCALES}) + other_version


def ahead(found):
    """Both eyes together: the paper's method, and how far each other system that was measured is ahead of it; `*` where another version was."""
    rivals = [("paper", "systems", ("paper-gaps", "ours", "ours-left")), ("paper-coded", "coded", [name for name in results.CODED if name != "paper-coded"])]
    rows = []
    for head, head_name in HEAD_NAMES.items():
        for paper, kind, ours in rivals:
            for system in (paper, *ours):
                pairs = [(result, *(results.find(result, kind, name, head) for name in (system, paper))) for result in found.values()]
                if any(entry for _, entry, _ in pairs):
                    rows.append([head_name, results.NAMES[system]] + [lead_cell(*pair, system == paper) for pair in pairs])
    return table(["head", "system", *found], rows)


def mirrors(found):
    """What becomes of mirrors and glass, of each who was measured with it: noise-free dB, a column a scene."""
    rows = []
    for head, head_name in HEAD_NAMES.items():
        for who, treatments in results.MIRRORS.items():
            for treatment, system in treatments.items():
                entries = [results.find(result, "systems", system, head) for result in found.values()]
                if any(entries):
                    rows.append([head_name, results.NAMES[who], treatment] + ["-" if entry is None else eyes_cell(entry, results.error) for entry in entries])
    return table(["head", "system", "mirrors", *found], rows)


def rungs(result):
    rows = []
    for entry in result.get("rungs", []):
        eyes = entry["played"][0]["eyes"].values()
        pixels, gaps = sum(eye["pixels"] for eye in eyes), sum(eye["gaps"] for eye in eyes)
        counts = {rung: sum(eye["filled"][rung] for eye in eyes) for rung in next(iter(eyes))["filled"]}
        filled = ", ".join(f"{rung} {100 * count / gaps:.1f}" for rung, count in counts.items() if count)
        rows.append([HEAD_NAMES[entry["head"]], entry["fill"], eyes_cell(entry, results.error), eyes_cell(entry, results.gap_error),
                     f"{100 * gaps / pixels:.2f}", filled or "-"])
    return table(["head", "fill", "noise-free dB", "in gaps", "gaps, % of the pixels of all frames played", "filled by, % of gaps"], rows)


def shift(found):
    def share(part, digits=3, within="within_budget"):
        return cell(100 * part[within], digits) if within in part else "-"

    def of(part, whole):
        return cell(100 * part["pixels"] / whole, 1) if whole else "-"

    rows = []
    for scene, result in found.items():
        for run, entry in [(run, entry) for run in result["runs"] for entry in run["engines"]]:
            coloured, smooth, sampled = entry["coloured"], entry["smooth"], entry["sampled"]
            eyes = f"{run['n']['eyes']} of {run['size']}" + (", the client's model" if "model" in run else "")
            rows.append([scene, eyes, results.ENGINES.get(entry["engine"], entry["engine"]), of(coloured, entry["pixels"]), share(coloured, 2), of(smooth, coloured["pixels"]), share(smooth),
                         share(entry.get("added", {})), of(sampled, coloured["pixels"]), share(sampled), share(sampled, within="within_twice_budget"),
                         cell(sampled["p999_px"], 3) if sampled["pixels"] else "-"])
    return table(["scene", "eyes", "engine", "coloured %", "within e, %", "of the coloured smooth %", "within e, %", "added within e, %",
                  "of the coloured sampled %", "within e, %", "within 2 e, %", "99.9 % of their shifts below px"], rows)


def ladders(found, head):
    """What fills first, push-pull the rest: noise-free dB in the gaps, a column a scene."""
    fills = dict.fromkeys(entry["fill"] for result in found.values() for entry in result.get("rungs", []))
    rows = []
    for fill in fills:
        entries = [next((e for e in result.get("rungs", []) if e["fill"] == fill and e["head"] == head), None) for result in found.values()]
        rows.append([fill] + ["-" if entry is None else eyes_cell(entry, results.gap_error) for entry in entries])
    return table(["fill", *found], rows, labels=1)


def model(found):
    """Triangles kept against dB lost to the scene's own geometry, beyond what the scene's own geometry gives."""
    rows = []
    for scene, result in found.items():
        exact = result["scene_geometry"]["eyes"]
        for entry in result["models"]:
            made, eyes = entry["model"], entry["noise_free"]["eyes"]
            lost = {scale: " / ".join(lead(exact[eye]["noise_free"][scale], eyes[eye]["noise_free"][scale], 3) for eye in results.EYES) for scale in results.SCALES}
            before, after = made["triangles"]["before"], made["triangles"]["after"]
            rows.append([scene, f"{made['error_px']:g}", f"{after:,} of {before:,}", cell(100 * after / before, 1), both_scales(lost)])
    return table(["scene", "e, pixels", "triangles", "kept, %", "dB lost, left / right"], rows)


def patches(found):
    rows = []
    for scene, result in found.items():
        for measured in result["results"]:
            for plan in measured["patches"]:  # a larger budget may change nothing
                row = [scene, measured["sphere"], str(measured["block_side"]), cell(100 * measured["gap_share"]), cell(100 * plan["pixel_share"], 1),
                       cell(100 * plan["covered"], 1), cell(100 * measured["all_auxiliary_spheres"], 1), cell(100 * measured["small_stream"], 1)]
                rows += [row] if row not in rows else []
    return table(["scene", "sphere", "block", "gaps, %", "patches, % of its pixels", "gaps covered, %", "all auxiliary spheres, %", "small stream, %"], rows)


def hidden(found):
    rows = [[scene, cell(100 * r["measured"]["layer_share_of_pixels"], 1), cell(100 * r["measured"]["gap_share"]["mean"]),
             cell(100 * r["measured"]["held_share_of_gaps"]["all"], 1), cell(100 * r["measured"]["held_share_of_gaps"]["worst_eye"], 1)]
            for scene, r in found.items()]
    return table(["scene", "layer, % of the sphere's pixels", "gaps, %", "gaps held, %", "of the worst eye, %"], rows)


def speed(result):
    """With what a bench said of its pictures, ours and the peer's, beside its time."""
    said = dict(note.split(": ", 1) for note in result["notes"] if ": " in note)
    rows = []
    for figure in result["figures"]:
        ours, peer = said.get(f"{figure['name']}/ours", "-"), said.get(f"{figure['name']}/{figure['peer']}")
        rows.append([figure["name"], figure["peer"], cell(figure["ms"], 3), "-" if figure["ratio"] is None else f"{figure['ratio']:.2f}",
                     f"{ours}; the peer's: {peer}" if peer else ours])
    return table(["figure", "peer", "ours, ms", "peer's time / ours", "pictures"], rows)


def depth_codes(found):
    """Each depth code within its share of the colour's bits: what it costs and what the eye loses beside lossless depth; `-`: that method did not play it."""
    methods = list(dict.fromkeys(method for result in found.values() for method in result["systems"][0]["scores"]))
    rows = []
    for scene, result in found.items():
        reference = result["systems"][0]["scores"]
        for system in result["systems"]:
            encoded = system["encoded"]
            lost = [both_scales({scale: lead(reference[method]["noise_free"]["right"][scale], system["scores"][method]["noise_free"]["right"][scale])
                                 for scale in results.SCALES}) if method in reference else "-" for method in methods]
            crf = ", ".join("-" if record["crf"] is None else f"{record['crf']:g}" for record in encoded)
            within = [record["trial"]["pixels_within_budget"] for record in encoded if "trial" in record]
            rows.append([scene, system["system"], encoded[0]["code"], results.depth_codec(system, encoded[0]), "half" if encoded[0]["scale"] == 2 else "whole", crf,
                         cell(100 * sum(record["share"] for record in encoded) / len(encoded), 1), cell(100 * sum(within) / len(within), 1) if within else "-", *lost])
    return table(["scene", "asked for", "code", "codec", "size", "depth's CRF by seed", "% of the colour's bits", "% of pixels within e", *(f"dB lost, {method}" for method in methods)], rows)


class Pages:
    """Files with markers: a table goes to the page that has its marker, else to the last."""

    def __init__(self, *files):
        self.texts = {file: file.read_text() if file.exists() else "# Tables\n" for file in files}

    def place(self, name, scene, text):
        marked = [file for file, page in self.texts.items() if f"<!-- table {name} {scene} -->" in page]
        file = marked[0] if marked else list(self.texts)[-1]
        self.texts[file] = place(self.texts[file], name, scene, text)

    def write(self):
        for file, text in self.texts.items():
            file.write_text(text)
            print(file)


def look_ups(result):
    """What budgets.py --look-ups found: gains over a mix of display values."""
    def gain(point, way, scale):
        return f"{point['noise_free_db'][way][scale] - point['noise_free_db']['display'][scale]:+.2f}"
    first = next(iter(result["scenes"].values()))[0]
    filters = [way for way in first["noise_free_db"] if way.startswith("prefilter")]
    rows = [[scene, point["sphere"] + (", coded" if point["coded"] else ""), *(f"{point['mean_light_percent'][way]:+.2f}" for way in ("display", "light")),
             f"{gain(point, 'light', 'linear')} ({gain(point, 'light', 'display')})", *(gain(point, way, "display") for way in filters)]
            for scene, points in result["scenes"].items() for point in points]
    return table(["scene", "sphere", "mean by display values, %", "mean by light, %", "light gains, dB", *(f"{way} gains, dB" for way in filters)], rows, labels=2)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=results.RESULTS)
    parser.add_argument("--page", type=pathlib.Path, default=results.RESULTS.parent / "reproject.md")
    options = parser.parse_args()
    pages = Pages(options.page, *(options.results / name for name in ("speed.md", "depth_codes.md", "tables.md")))
    found = results.load("accuracy", options.results)
    for head in HEAD_NAMES:
        pages.place(f"summary-{head}", "all", summary(found, head))
        pages.place(f"ladders-{head}", "all", ladders(found, head))
    pages.place("ahead", "all", ahead(found))
    pages.place("coded", "all", coded(found))
    if mirrored := {scene: result for scene, result in found.items() if results.tells_of_mirrors(result)}:
        pages.place("mirrors", "all", mirrors(mirrored))
    for kind, tabled in {"shift": shift, "model": model, "patches": patches, "hidden-layer": hidden}.items():
        if measured := results.load(kind, options.results):
            pages.place(kind, "all", tabled(measured))
    if (file := options.results / "budgets.json").exists() and (found_ways := json.loads(file.read_text()).get("look-ups")):
        pages.place("look-ups", "all", look_ups(found_ways))
    for name in ("speed", "speed-other-processor"):
        if (file := options.results / f"{name}.json").exists():
            pages.place(name, "all", speed(json.loads(file.read_text())))
    for scene, result in found.items():
        for head in HEAD_NAMES:
            pages.place(f"accuracy-{head}", scene, accuracy(result, head))
        if "rungs" in result:
            pages.place("rungs", scene, rungs(result))
    if codes := results.load("depth_codes", options.results):
        pages.place("depth-codes", "all", depth_codes(codes))
    pages.write()


if __name__ == "__main__":
    main()
