#!/usr/bin/env python3
"""Writes the tables of docs/results/mitsuba.md, between its markers, from the JSON files that compare.py wrote, and from nothing else.

    report.py [--results docs/results/mitsuba/hosts] [--page docs/results/mitsuba.md]

A table NAME stands between `<!-- table NAME -->` and `<!-- end -->`; text around markers is left alone.
"""

import argparse
import json
import pathlib
import re

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
ORDER = ["kitchen", "san-miguel", "sibenik", "sponza-crytek", "voxel-city", "materials", "furnace", "motion", "sphere", "pavilion"]


def percent(value):
    return "-" if value is None else f"{100 * value:.3f}"


def level(value):
    return "-" if value is None else f"{value:.5f}"


def small(value):
    return "-" if value is None else f"{value:.1e}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|---|" + "--:|" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def geometry(results):
    rows = []
    for r in results:
        g = r["geometry"]
        rows.append([r["scene"], f"{g['same_object']:,}", percent(g["ids_agree"]["object"]), percent(g["depth_within_1e-4"]), small(g["depth"]["p99.9"]),
                     small(g["depth"]["worst"]), percent(g["backward_within_0.01_px"]), percent(g["forward_within_0.01_px"]),
                     percent(g["normal_within_0.1_deg"])])
    return table(["scene", "pixels of one object", "objects agree, %", "depth within 1e-4, %", "99.9 % within", "worst", "backward within 0.01 px, %",
                  "forward, %", "normals within 0.1 degree, %"], rows)


def colour(results):
    rows = []
    for r in results:
        c, s = r["colour"], r["settings"]
        rows.append([r["scene"], f"{s['seeds']} x {s['spp']}", f"{c['tests']:,}", small(c["p_threshold"]), small(c["least_p"]), str(c["failing"]),
                     level(c["mean_embedded"]), level(c["mean_mitsuba"]), percent(c["relative_rms_difference"]), percent(c["relative_rms_noise"])])
    return table(["scene", "seeds x samples", "tests", "p to fail", "least p", "failing", "mean, embedded", "mean, Mitsuba", "RMS difference, %",
                  "RMS noise, %"], rows)


TABLES = {"geometry": geometry, "colour": colour}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=REPOSITORY / "docs/results/mitsuba/hosts")
    parser.add_argument("--page", type=pathlib.Path, default=REPOSITORY / "docs/results/mitsuba.md")
    settings = parser.parse_args()
    results = [json.loads(file.read_text()) for file in settings.results.glob("*.json")]
    results.sort(key=lambda r: ORDER.index(r["scene"]) if r["scene"] in ORDER else len(ORDER))
    page = settings.page.read_text()
    for name, make in TABLES.items():
        pattern = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.S)
        if not pattern.search(page):
            raise SystemExit(f"report.py: {settings.page}: expected a table {name} between markers, found none")
        page = pattern.sub(lambda m: m.group(1) + make(results) + "\n" + m.group(2), page)
    settings.page.write_text(page)


if __name__ == "__main__":
    main()
