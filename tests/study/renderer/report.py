#!/usr/bin/env python3
"""Writes the tables of docs/results/renderer.md, between its markers, from the JSON files of docs/results/renderer and nothing else.

    report.py [--results FOLDER] [--page FILE]

A table NAME stands between `<!-- table NAME all -->` and `<!-- end -->`; text around markers is left alone.
"""

import argparse
import json
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from pages import cell, place, table  # noqa: E402

RESULTS = pathlib.Path(__file__).resolve().parents[3] / "docs/results/renderer"


def profile_table(result):
    head = ["scene", "triangles", "load s", "BVH s", "peak MiB", "M paths/s", "M rays/s", "tracing s", "shading and textures s", "film s"]
    rows = []
    for entry in result["scenes"]:
        report = entry["report"]
        cpu_s = report["cpu_s"]
        tracing = cpu_s["camera_rays"] + cpu_s["path_rays"] + cpu_s["shadow_rays"]
        rows.append([entry["scene"], f"{report['triangles']:,}", cell(report["load_s"]), cell(report["bvh_s"]), cell(report["peak_memory_mib"], 0),
                     cell(report["paths_per_s"] / 1e6), cell(report["rays_per_s"] / 1e6), cell(tracing), cell(cpu_s["shading_and_textures"]),
                     cell(cpu_s["film"])])
    return table(head, rows, labels=1)


def noise_table(result):
    """Ratios are before over after; the means' difference is in its own standard errors."""
    head = ["scene", "CPU s before", "after", "variance, linear", "display", "speed, linear", "display", "means, sigma", "learning s", "KiB"]
    rows = []
    for entry in result["scenes"]:
        before, after = entry["before"], entry["after"]
        slower = after["cpu_s"] / before["cpu_s"]
        ratios = {space: {kind: before[space][kind] / after[space][kind] for kind in ("mean", "median")} for space in ("linear", "display")}
        sigma = (after["mean"] - before["mean"]) / math.hypot(before["standard_error"], after["standard_error"])
        learned = after["sky_openings"]
        rows.append([entry["scene"], cell(before["cpu_s"]), cell(after["cpu_s"]),
                     *(f"{r['mean']:.2f} ({r['median']:.2f})" for r in ratios.values()),
                     *(f"{r['mean'] / slower:.2f} ({r['median'] / slower:.2f})" for r in ratios.values()),
                     f"{sigma:+.1f}", cell(learned["learn_s"]), cell(learned["mib"] * 1024, 0)])
    return table(head, rows, labels=1)


def checks_text(file):
    result = json.loads(file.read_text())
    lines = [f"$ {result['command']}"]
    for test, printed in result["printed"].items():
        lines += ["", f"{test}: passed", *("  " + line for line in printed)]
    return "```\n" + "\n".join(lines) + "\n```"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=RESULTS)
    parser.add_argument("--page", type=pathlib.Path, default=RESULTS.with_suffix(".md"))
    options = parser.parse_args()
    page = place(options.page.read_text(), "profile", "all", profile_table(json.loads((options.results / "profile.json").read_text())))
    page = place(page, "noise", "all", noise_table(json.loads((options.results / "noise.json").read_text())))
    page = place(page, "checks", "all", checks_text(options.results / "checks.json"))
    options.page.write_text(page)
    print(options.page)


if __name__ == "__main__":
    main()
