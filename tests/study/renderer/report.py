#!/usr/bin/env python3
"""Writes the tables of docs/results/renderer.md, between its markers, from the JSON files of docs/results/renderer and nothing else.

    report.py [--results FOLDER] [--page FILE]

A table NAME stands between `<!-- table NAME all -->` and `<!-- end -->`; text around markers is left alone.
"""

import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from pages import cell, place, table  # noqa: E402

RESULTS = pathlib.Path(__file__).resolve().parents[3] / "docs/results/renderer"


def profile_table(files):
    head = ["scene", "triangles", "load s", "BVH s", "peak MiB", "M paths/s", "M rays/s", "tracing s", "shading and textures s", "film s"]
    rows = []
    for file in files:
        report = json.loads(file.read_text())["report"]
        cpu_s = report["cpu_s"]
        tracing = cpu_s["camera_rays"] + cpu_s["path_rays"] + cpu_s["shadow_rays"]
        rows.append([file.stem, f"{report['triangles']:,}", cell(report["load_s"]), cell(report["bvh_s"]), cell(report["peak_memory_mib"], 0),
                     cell(report["paths_per_s"] / 1e6), cell(report["rays_per_s"] / 1e6), cell(tracing), cell(cpu_s["shading_and_textures"]),
                     cell(cpu_s["film"])])
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
    page = place(options.page.read_text(), "profile", "all", profile_table(sorted((options.results / "profile").glob("*.json"))))
    page = place(page, "checks", "all", checks_text(options.results / "checks.json"))
    options.page.write_text(page)
    print(options.page)


if __name__ == "__main__":
    main()
