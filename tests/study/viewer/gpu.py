#!/usr/bin/env python3
"""Keeps what a machine with a GPU measured: docs/results/viewer/gpu.json, and its tables in viewer.md, denoise.md and mitsuba.md.

    gpu.py --machine WORDS --commit WORDS NAME=FILE...

Each FILE is what `./bench FIGURES --benchmark_out=FILE --benchmark_out_format=json` wrote, whose medians are kept, the JSON of an `equistream render`, or what a
test program printed; an entry of the same NAME is replaced. Without files only the tables are made again.
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
RESULTS = REPOSITORY / "docs/results"
RENDERS = {"sponza_cuda": "Mitsuba, cuda_ad_rgb", "sponza_cuda_64": "Mitsuba, cuda_ad_rgb", "sponza_cuda_window": "Mitsuba, cuda_ad_rgb, a window of 120x90 degrees at 1920 columns around",
           "sponza_embree": "Embree", "sponza_small_cuda": "Mitsuba, cuda_ad_rgb", "sponza_small_scalar": "Mitsuba, scalar_rgb",
           "pavilion_cuda": "Mitsuba, cuda_ad_rgb"}
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


def denoise_rows(result):
    for columns in (1920, 3840):
        for quality in ("fast", "balanced"):
            name = f"denoise_{columns}_{quality}"
            yield [f"{columns:,}", quality, *(cell(result[of][f"{name}/{side}"]["ms"], 0 if side == "ours" else 1) for of, side in
                                              (("denoise_cuda", "ours"), ("denoise_cuda", "library"), ("denoise_cuda_before", "ours"), ("denoise_cpu_before", "ours"), ("denoise_cpu_before", "library")))]


def render_rows(result):
    for name, host in RENDERS.items():
        run = result[name]
        words = run["command"].split()
        of = {option: words[words.index(option) + 1] for option in ("--size", "--spp", "--frames")}
        first, _, last = of["--frames"].partition("-")
        frames = int(last or first) - int(first) + 1  # a window and its base are one
        scene = next(word for word in words if word.endswith(".json"))
        yield [pathlib.Path(scene).stem, host, of["--size"], of["--spp"], str(run["machine"]["threads"]), cell(run["render_s"] / frames, 1), cell(run["paths_per_s"] / 1e6, 3)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machine", help="what measured, in words")
    parser.add_argument("--commit", help="whose programs they were")
    parser.add_argument("files", nargs="*", metavar="NAME=FILE")
    parser.add_argument("--results", type=pathlib.Path, default=RESULTS, help="folder of the pages whose tables are made")
    options = parser.parse_args()
    if options.files:
        if not (options.machine and options.commit):
            parser.error("--machine, --commit: expected words for both, found nothing")
        kept = json.loads(RESULT.read_text())
        for name, file in (word.split("=", 1) for word in options.files):
            kept[name] = taken(name, pathlib.Path(file))
            kept["measured"][name] = {"machine": options.machine, "commit": options.commit}
        write_whole(RESULT, result_text(kept))
    result = json.loads(RESULT.read_text())
    tables = {
        "viewer.md": {"gpu-refresh": table(["scene", "what is drawn", "all, ms", "upload", "depth", "reproject", "fill"], list(refresh_rows(result["opengl"]))),
                      "gpu-peers": table(["figure", "peer", "ours, ms", "peer / ours"], list(eye_rows(result["opengl"])))},
        "denoise.md": {"gpu": table(["columns", "quality", "ours, H100", "library, H100", "ours, H100, before", "ours, 16 cores, before", "library, 16 cores"], list(denoise_rows(result)))},
        "mitsuba.md": {"gpu": table(["scene", "host", "size", "samples", "cores", "seconds a frame", "million paths a second"], list(render_rows(result)))},
    }
    for name, of_page in tables.items():
        page = (options.results / name).read_text()
        for marker, text in of_page.items():
            page = place(page, marker, "all", text)
        write_whole(options.results / name, page)
    print(f"{options.results}: {len(result) - 1} measurements")


if __name__ == "__main__":
    run_as_program(main)
