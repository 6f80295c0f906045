#!/usr/bin/env python3
"""Writes the tables of docs/results/reproject.md, between its markers, from the JSON files of docs/results/reproject and nothing else.

    report.py [--results FOLDER] [--page FILE]
"""

import argparse
import pathlib
import sys

import results

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from pages import cell, noise_free_short, noise_free_text, place, table  # noqa: E402

HEAD_NAMES = {"stereo": "63 mm stereo", "moved": "head moved 0.25 m"}


def eyes_cell(entry, figure):
    return " / ".join("-" if figure(entry, eye) is None else noise_free_short(figure(entry, eye)) for eye in results.EYES)


def summary(found, head, kind="systems"):
    """Noise-free dB of each system, left / right, a column a scene."""
    systems = dict.fromkeys(entry["system"] for result in found.values() for entry in result.get(kind, []))
    rows = []
    for system in systems:
        entries = [results.find(result, kind, system, head) for result in found.values()]
        rows.append([results.NAMES.get(system, system)] + ["-" if entry is None else eyes_cell(entry, results.display_error) for entry in entries])
    return table(["system", *found], rows)


def ceiling_row(result, head):
    eyes = result["ceiling"][head]["eyes"]
    row = ["truth, another seed (ceiling)"]
    for eye in results.EYES:
        row += ["-", "-", cell(eyes[eye]["psnr_db"]), cell(eyes[eye]["ssim"], 4), cell(eyes[eye]["psnr_worst_percent_db"])]
    return [*row, "-", "-"]


def accuracy(result, head):
    columns = ("noise-free dB,", "in gaps,", "PSNR dB,", "SSIM,", "worst 1 % dB,")
    rows = [ceiling_row(result, head)]
    for entry in [e for kind in ("systems", "coded") for e in result.get(kind, []) if e["head"] == head]:
        row = [results.NAMES.get(entry["system"], entry["system"])]
        for eye in results.EYES:
            noisy = entry["against_other_seed"]["eyes"][eye]
            gap = results.gap_error(entry, eye)
            row += [noise_free_text(results.display_error(entry, eye)), "-" if gap is None else noise_free_short(gap),
                    cell(noisy["psnr_db"]), cell(noisy["ssim"], 4), cell(noisy["psnr_worst_percent_db"])]
        gaps = entry["against_other_seed"]["eyes"]["right"].get("gaps")
        rows.append([*row, cell(100 * gaps["fraction"]) if gaps else "-", cell(results.client_ms(entry), 1)])
    return table(["system"] + [f"{column} {eye}" for eye in results.EYES for column in columns] + ["gaps %, right", "client ms"], rows)


def coded(found):
    rows = []
    for scene, result in found.items():
        for head in HEAD_NAMES:
            for system in ("paper-coded", "ours-coded"):
                entry = results.find(result, "coded", system, head)
                if entry:
                    rows.append([scene, f"{results.NAMES[system]}, {HEAD_NAMES[head]}", ", ".join(str(r["crf"]) for r in entry["encoded"]),
                                 f"{results.coded_bytes(entry):,.0f}", eyes_cell(entry, results.display_error), eyes_cell(entry, results.gap_error)])
    return table(["scene", "system", "CRF by seed", "bytes a frame", "noise-free dB, left / right", "in gaps, left / right"], rows)


def rungs(result):
    rows = []
    for entry in result.get("rungs", []):
        gaps = entry["played"][0]["eyes"]
        filled = ", ".join(f"{rung} {100 * (gaps['left']['filled'][rung] + gaps['right']['filled'][rung]) / 2:.2f} %" for rung in gaps["left"]["filled"])
        rows.append([HEAD_NAMES[entry["head"]], entry["fill"], eyes_cell(entry, results.display_error), eyes_cell(entry, results.gap_error), filled or "-"])
    return table(["head", "fill", "noise-free dB, left / right", "in gaps, left / right", "filled, of all pixels (mean of the eyes)"], rows)


def shift(found):
    rows = []
    for scene, result in found.items():
        for entry in result["engines"]:
            rows.append([scene, entry["engine"], cell(100 * entry["coloured"]["pixels"] / entry["pixels"], 1),
                         cell(100 * entry["sampled"]["pixels"] / entry["coloured"]["pixels"], 1), cell(100 * entry["sampled"]["within_budget"], 3),
                         cell(entry["sampled"]["p999_px"], 3), cell(100 * entry["coloured"]["within_budget"], 2)])
    return table(["scene", "engine", "coloured %", "of these sampled %", "sampled within e, %", "sampled, 99.9 % of shifts below px", "all coloured within e, %"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=results.RESULTS)
    parser.add_argument("--page", type=pathlib.Path, default=results.RESULTS.parent / "reproject.md")
    options = parser.parse_args()
    page = options.page.read_text() if options.page.exists() else "# Reprojection against the path-traced eye\n"
    found = results.load("accuracy", options.results)
    for head in HEAD_NAMES:
        page = place(page, f"summary-{head}", "all", summary(found, head))
    page = place(page, "coded", "all", coded(found))
    if shifts := results.load("shift", options.results):
        page = place(page, "shift", "all", shift(shifts))
    for scene, result in found.items():
        for head in HEAD_NAMES:
            page = place(page, f"accuracy-{head}", scene, accuracy(result, head))
        if "rungs" in result:
            page = place(page, "rungs", scene, rungs(result))
    options.page.write_text(page)
    print(options.page)


if __name__ == "__main__":
    main()
