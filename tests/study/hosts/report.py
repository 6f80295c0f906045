#!/usr/bin/env python3
"""Writes the tables of docs/results/mitsuba.md, between its markers, from the JSON files of docs/results/mitsuba, and from nothing else.

    report.py [--results docs/results/mitsuba] [--page docs/results/mitsuba.md]

hosts.json is compare.py's, near-plane.json near_plane.py's, documentation/ documentation_scene.py's, time.json tests/hosts/time_ratio.py's.

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
    return table(["scene", "seeds x samples", "tests", "p to fail", "least p", "failing", "mean, default", "mean, Mitsuba", "RMS difference, %",
                  "RMS noise, %"], rows)


def hosts_tables(folder):
    results = list(json.loads((folder / "hosts.json").read_text()).values())
    results.sort(key=lambda r: ORDER.index(r["scene"]) if r["scene"] in ORDER else len(ORDER))
    return {"geometry": geometry(results), "colour": colour(results)}


def near_plane(folder):
    rows = []
    for name, where in json.loads((folder / "near-plane.json").read_text())["of"].items():
        inside, edges, misses = where["inside_surfaces"], where["edges"], where["misses"]
        rows.append([name, small(inside["median_error_m"]), percent(inside["share_within_1e-4"]), small(edges["worst_error_m"]),
                     percent(edges["share_within_1e-4"]), misses["value"][0]])
    return {"near-plane": table(["depth of", "inside surfaces: median error, m", "within 1e-4, %", "edges: worst error, m", "within 1e-4, %",
                                 "a miss is"], rows)}


METHODS = {"surface": "played with the exported geometry's depth", "sphere": "played with rotation only"}


def noise_free(eye):
    figures = eye["noise_free"]["display"]
    return f"{figures['db']:.2f} [{figures['db_low']:.2f}, {figures['db_high']:.2f}]"


def documentation(folder):
    rows = []
    for file in sorted((folder / "documentation").glob("*.json")):
        result = json.loads(file.read_text())
        for method, score in result["systems"].items():
            eyes = score["eyes"]
            rows.append([result["scene"], METHODS[method], *(noise_free(eyes[e]) for e in ("left", "right")),
                         *(f"{eyes[e]['psnr_db']:.2f}" for e in ("left", "right"))])
        ceiling = result["ceiling"]["eyes"]
        rows.append([result["scene"], "truth, another seed (ceiling)", "-", "-", *(f"{ceiling[e]['psnr_db']:.2f}" for e in ("left", "right"))])
    return {"documentation": table(["scene", "eyes", "noise-free dB, left", "right", "PSNR dB, left", "right"], rows)}


def times(folder):
    rows = []
    for variant, cases in json.loads((folder / "time.json").read_text())["variants"].items():
        for name, case in cases.items():
            low, high = case["ratio_interval_95"]
            rows.append([variant, name, f"{case['ratio']:.3f} [{low:.3f}, {high:.3f}]", f"{case['processor_ratio']:.3f}"])
    return {"time": table(["variant", "sensor, integrator", "time a path, ratio [95 %]", "processor time a path, ratio"], rows)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=REPOSITORY / "docs/results/mitsuba")
    parser.add_argument("--page", type=pathlib.Path, default=REPOSITORY / "docs/results/mitsuba.md")
    settings = parser.parse_args()
    page = settings.page.read_text()
    for tables in (hosts_tables, near_plane, documentation, times):
        for name, text in tables(settings.results).items():
            pattern = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.S)
            if not pattern.search(page):
                raise SystemExit(f"report.py: {settings.page}: expected a table {name} between markers, found none")
            page = pattern.sub(lambda m: m.group(1) + text + "\n" + m.group(2), page)
    settings.page.write_text(page)


if __name__ == "__main__":
    main()
