#!/usr/bin/env python3
"""Writes the tables of docs/results/reproject.md and of the pages beside its JSON (tables.md, speed.md, depth_codes.md), between their
markers, from the JSON files of docs/results/reproject and nothing else. A table without a marker is added to tables.md.

    report.py [--results FOLDER] [--page FILE]
"""

import argparse
import json
import pathlib
import sys

import results

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from found import only_bounded  # noqa: E402
from pages import both_scales, cell, place, table  # noqa: E402


def lead(better, worse):
    """By how many dB the one of two noise-free figures is ahead of the other; `?` where the interval of either reaches zero error."""
    if better["db"] is None or worse["db"] is None:
        return "?"
    text = f"{better['db'] - worse['db']:+.2f}"
    return (text if float(text) else text[1:]) + ("?" if only_bounded(better) or only_bounded(worse) else "")


def shift(found):
    def share(part, digits=3, within="within_budget"):
        return cell(100 * part[within], digits) if within in part else "-"

    def of(part, whole):
        return cell(100 * part["pixels"] / whole, 1) if whole else "-"

    rows = []
    for scene, result in found.items():
        for run, entry in [(run, entry) for run in result["runs"] for entry in run["engines"] if entry["engine"] not in results.GONE]:
            coloured, smooth, sampled = entry["coloured"], entry["smooth"], entry["sampled"]
            eyes = f"{run['n']['eyes']} of {run['size']}" + (", the client's model" if "model" in run else "")
            rows.append([scene, eyes, results.ENGINES.get(entry["engine"], entry["engine"]), of(coloured, entry["pixels"]), share(coloured, 2), of(smooth, coloured["pixels"]), share(smooth),
                         share(entry.get("added", {})), of(sampled, coloured["pixels"]), share(sampled), share(sampled, within="within_twice_budget"),
                         cell(sampled["p999_px"], 3) if sampled["pixels"] else "-"])
    return table(["scene", "eyes", "engine", "coloured %", "within e, %", "of the coloured smooth %", "within e, %", "added within e, %",
                  "of the coloured sampled %", "within e, %", "within 2 e, %", "99.9 % of their shifts below px"], rows)


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
            rows.append([scene, system["system"], encoded[0]["code"], encoded[0]["codec"], "half" if encoded[0]["scale"] == 2 else "whole", crf,
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
    for kind, tabled in {"shift": shift, "patches": patches, "hidden-layer": hidden}.items():
        if measured := results.load(kind, options.results):
            pages.place(kind, "all", tabled(measured))
    if (file := options.results / "budgets.json").exists() and (found_ways := json.loads(file.read_text()).get("look-ups")):
        pages.place("look-ups", "all", look_ups(found_ways))
    for name in ("speed", "speed-other-processor"):
        if (file := options.results / f"{name}.json").exists():
            pages.place(name, "all", speed(json.loads(file.read_text())))
    if codes := results.load("depth_codes", options.results):
        pages.place("depth-codes", "all", depth_codes(codes))
    pages.write()


if __name__ == "__main__":
    main()
