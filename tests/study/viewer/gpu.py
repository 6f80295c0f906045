#!/usr/bin/env python3
"""Keeps what a machine with a GPU measured: docs/results/viewer/gpu.json, and its tables in docs/results/viewer.md.

    gpu.py --machine WORDS NAME=FILE...

Each FILE is what `./bench FIGURES --benchmark_out=FILE --benchmark_out_format=json` wrote, whose medians are kept, the JSON of an `equistream render`, or what a
test program printed. NAME `opengl` makes the tables; the others are kept for the pages that quote them. Without files only the tables are made again.
"""

import argparse
import json
import pathlib
import re
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from kept import result_text  # noqa: E402
from pages import cell, place, table  # noqa: E402
from steps import Failed, run_as_program, write_whole  # noqa: E402

RESULT = REPOSITORY / "docs/results/viewer/gpu.json"
PAGE = REPOSITORY / "docs/results/viewer.md"
WAYS = {"ours": "the stream's own depth (mesh)", "geometry": "depth of the scene's geometry", "window": "window of 1,920x1,440 and base, mesh", "rotation": "rotation alone",
        "new_frame": "mesh, a new frame each time, copied", "new_frame_mapped": "the same, mapped", "gpu_copy": "a copy of both eyes' pixels"}
OF_RENDERS = ("command", "mitsuba_s", "render_s", "load_s", "paths_per_s", "shapes", "threads", "variant", "machine")


def medians(benchmarks):
    """Figure/side -> milliseconds, and the last repetition's label."""
    kept = {}
    for run in benchmarks:
        if run["time_unit"] != "ms":
            raise Failed(f"{run['run_name']}: expected milliseconds, found {run['time_unit']}")
        figure = kept.setdefault(re.sub(r"/(process_time|real_time|manual_time)", "", run["run_name"]), {})
        if run.get("label"):
            figure["label"] = run["label"]
        if run.get("aggregate_name") == "median":
            figure["ms"] = run["real_time"]
    return {name: figure for name, figure in kept.items() if "ms" in figure}


def failures(log):
    """Test -> what was expected, each kind once with how far off it was at most."""
    found, lines = {}, []
    for line in log.splitlines():
        lines = [] if line.startswith("[ RUN") else [*lines, line]
        if named := re.match(r"\[  FAILED  \] (\S+?)(, where .*)? \(\d+ ms\)", line):
            off = [re.search(r"\((\w+)[^)]*\).*actual: ([0-9.]+) vs ([0-9.]+)", each) for each in lines]
            found[named[1]] = sorted({(each[1], float(each[2]), float(each[3])) for each in off if each})
    return {"passed": len(re.findall(r"^\[       OK \]", log, re.M)), "failed": found}


def taken(name, file):
    text = file.read_text()
    if text.startswith(("Running main()", "==")):
        return failures(text)
    content = json.loads(text)
    if "benchmarks" in content:
        return medians(content["benchmarks"])
    if "paths_per_s" in content:
        return {key: content[key] for key in OF_RENDERS if key in content}
    raise Failed(f"{file}: expected google-benchmark's JSON or that of `equistream render` for {name}, found neither")


def stages(figure):
    return dict(re.findall(r"(\w+) ([0-9.]+)", figure.get("label", "").partition(" ms")[0]))


def refresh_rows(figures):
    for scene in sorted({re.match(r"gl_refresh_2160_(.*)/", name)[1] for name in figures if name.startswith("gl_refresh_2160_")}):
        for side, words in WAYS.items():
            figure = figures.get(f"gl_refresh_2160_{scene}/{side}")
            if figure is None:
                continue
            of = stages(figure)
            yield [scene, words, cell(figure["ms"], 1), *(cell(float(of[stage]), 1) if float(of.get(stage, 0)) >= 0.05 else "-" for stage in ("upload", "depth", "reproject", "fill"))]


def eye_rows(figures):
    for name in sorted(name for name in figures if re.match(r"gl_(eyes|depth|upload).*/", name) and not name.endswith("/ours")):
        figure, peer = name.rsplit("/", 1)
        ours_ms = figures[f"{figure}/ours"]["ms"]
        yield [figure, peer, cell(ours_ms, 2), cell(figures[name]["ms"] / ours_ms)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machine", help="what measured, in words")
    parser.add_argument("--commit", help="whose programs they were")
    parser.add_argument("files", nargs="*", metavar="NAME=FILE")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="whose tables are made")
    options = parser.parse_args()
    if options.files:
        if not options.machine:
            parser.error("--machine: expected words, found nothing")
        of = dict(word.split("=", 1) for word in options.files)
        write_whole(RESULT, result_text({"machine": options.machine, "commit": options.commit, **{name: taken(name, pathlib.Path(file)) for name, file in of.items()}}))
    result = json.loads(RESULT.read_text())
    page = options.page.read_text()
    page = place(page, "gpu-refresh", "all", table(["scene", "what is drawn", "all, ms", "upload", "depth", "reproject", "fill"], list(refresh_rows(result["opengl"]))))
    page = place(page, "gpu-peers", "all", table(["figure", "peer", "ours, ms", "peer / ours"], list(eye_rows(result["opengl"]))))
    write_whole(options.page, page)
    print(f"{options.page}: {len(result) - 2} measurements")


if __name__ == "__main__":
    run_as_program(main)
