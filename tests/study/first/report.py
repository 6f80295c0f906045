#!/usr/bin/env python3
"""Writes the tables of docs/results/first.md, between its markers, from the JSON files of docs/results and nothing else.

    report.py [--results FOLDER] [--page FILE]

FOLDER holds run.py's SCENE.json; render_profile.py's profile/SCENE.json and checks.py's checks.json lie beside it. A table NAME of scene SCENE stands
between `<!-- table NAME SCENE -->` and `<!-- end -->` (profile and checks: SCENE is `all`); text around markers is left alone. Where the page
has no marker for a table yet, the table is added at the end.
"""

import argparse
import json
import pathlib
import sys

import results

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from pages import cell, noise_free_text, place, table  # noqa: E402


def noise_free_cell(entry, eye, scale="display"):
    return noise_free_text(entry["noise_free"]["eyes"][eye][scale])


def system_cell(entry):
    return f"{results.SYSTEM_NAMES[entry['system']]}, {results.METHOD_NAMES[entry['method']]}"


def accuracy(result):
    head = ["system", "coding"] + [f"{figure} {eye}" for eye in ("left", "right")
                                   for figure in ("noise-free dB,", "PSNR dB,", "SSIM,")] + ["worst 1 % dB, right", "gaps %, right"]
    rows = [["truth, another seed (ceiling)", "-"]]
    for eye in ("left", "right"):
        ceiling = result["ceiling"]["eyes"][eye]
        rows[0] += ["-", cell(ceiling["psnr_db"]), cell(ceiling["ssim"], 4)]
    rows[0] += [cell(result["ceiling"]["eyes"]["right"]["psnr_worst_percent_db"]), "-"]
    for entry in result["systems"]:
        row = [system_cell(entry), results.coding_name(entry)]
        noisy = entry["against_other_seed"]
        for eye in ("left", "right"):
            row += [noise_free_cell(entry, eye), cell(results.psnr(noisy, eye)), cell(results.mean_of(noisy, eye, "ssim"), 4)]
        gaps = entry["played"][0]["gap_fraction"]["right"]
        row += [cell(results.mean_of(noisy, "right", "psnr_worst_percent_db")), cell(100 * gaps)]
        rows.append(row)
    return table(head, rows)


def linear(result):
    rows = [[system_cell(entry), results.coding_name(entry), noise_free_cell(entry, "left", "linear"), noise_free_cell(entry, "right", "linear")]
            for entry in result["systems"]]
    return table(["system", "coding", "noise-free dB, linear, left", "noise-free dB, linear, right"], rows)


def stage_cell(entry, stage):
    """The mean where only that means something, else p50 / p95 / p99."""
    times = results.stage_times(entry, stage)
    if times is None:
        return "-"
    if stage in results.STAGE_FIGURES:
        return cell(times[results.STAGE_FIGURES[stage]])
    return " / ".join(cell(times[percentile]) for percentile in ("p50", "p95", "p99"))


def cost(result):
    head = ["system", "coding", "bytes a frame", "main", "small"] + [f"{stage} ms" for stage in results.CLIENT_STAGES] + ["all ms"]
    rows = []
    for entry in result["systems"]:
        total = results.bytes_per_frame(entry)
        row = [system_cell(entry), results.coding_name(entry), cell(total, 0)]
        for track in ("main", "small"):
            runs = [run["bytes"].get(track, 0) / run["frames"] for run in entry["played"] if "bytes" in run]
            row.append(cell(sum(runs) / len(runs), 0) if runs else "-")
        row += [stage_cell(entry, stage) for stage in results.CLIENT_STAGES] + [cell(results.client_ms(entry))]
        rows.append(row)
    return table(head, rows)


def renders(result):
    rows = []
    for render in result["renders"]:
        wall = "resumed" if render["resumed"] else cell(render["wall_s"], 1)
        rows.append([render["name"], str(render["seed"]), wall, cell(render["load_s"] + render["bvh_s"]), cell(render["peak_memory_mib"], 0),
                     cell(render["paths_per_s"] / 1e6, 3), cell(render["rays_per_s"] / 1e6, 3)])
    wall = [render["wall_s"] for render in result["renders"] if not render["resumed"]]
    rows.append(["all", "", cell(sum(wall), 1), "", "", "", ""])
    return table(["render", "seed", "wall s", "load and BVH s", "peak MiB", "M paths/s", "M rays/s"], rows)


def commands(result):
    """One of each kind, as they were run."""
    entry = result["systems"][-1]
    lines = [result["renders"][0]["command"], result["renders"][2]["command"]]
    coded = next((e for e in result["systems"] if e["codec"] != "none"), entry)
    lines += [coded["played"][0].get("encode_command", ""), coded["played"][0]["command"], coded["against_other_seed"][0]["command"],
              coded["noise_free"]["command"]]
    return "```\n" + "\n".join(line for line in lines if line) + "\n```"


TABLES = {"accuracy": accuracy, "linear": linear, "cost": cost, "renders": renders, "commands": commands}


def summary(all_results, codec="h264", crf=16):
    """Noise-free dB of each system and method, left / right, a column a scene."""
    rows = {}
    for column, result in enumerate(all_results):
        for entry in result["systems"]:
            if (entry["codec"], entry["crf"]) == (codec, crf):
                shown = [entry["noise_free"]["eyes"][eye]["display"]["db"] for eye in ("left", "right")]
                rows.setdefault(system_cell(entry), ["-"] * len(all_results))[column] = " / ".join(cell(db, 1) for db in shown)
    return table(["system"] + [result["scene"] for result in all_results], [[name, *cells] for name, cells in rows.items()])


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
    return table(head, rows)


def checks_text(file):
    result = json.loads(file.read_text())
    lines = [f"$ {result['command']}"]
    for test, printed in result["printed"].items():
        lines += ["", f"{test}: passed", *("  " + line for line in printed)]
    return "```\n" + "\n".join(lines) + "\n```"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=pathlib.Path, default=results.RESULTS)
    parser.add_argument("--page", type=pathlib.Path, default=results.RESULTS.parent / "first.md")
    options = parser.parse_args()
    page = options.page.read_text() if options.page.exists() else "# The first experiment\n"
    found = results.load(options.results)
    page = place(page, "summary", "all", summary(found))
    for result in found:
        for name, make in TABLES.items():
            page = place(page, name, result["scene"], make(result))
    beside = options.results.parent
    if profiles := sorted((beside / "profile").glob("*.json"), reverse=True):
        page = place(page, "profile", "all", profile_table(profiles))
    if (beside / "checks.json").exists():
        page = place(page, "checks", "all", checks_text(beside / "checks.json"))
    options.page.write_text(page)
    print(options.page)


if __name__ == "__main__":
    main()
