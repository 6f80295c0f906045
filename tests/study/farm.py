#!/usr/bin/env python3
"""What a farm's pieces take on this machine, and what follows for up to 10,000 workers.

usage: farm.py --bin build/release/bin --out docs/results/farm.json [--work FOLDER]

Processor seconds are measured, over the cores: what other work beside does not stretch. Predictions are the formulas of predicted() on measured numbers, and nothing else; they
take workers like this machine, and a shared file system without a limit. With root and Slurm's packages, tasks of a Slurm on this machine are timed too.
"""

import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "programs/study"), str(TESTS.parent / "programs/study")]
import slurm_here  # noqa: E402
from gathered import gather  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

CORES = len(os.sched_getaffinity(0))
FIRST, FRAMES, SIZE = 30, 4, "960x480"
SAMPLES = (1, 4)
PARTS = 4
DEPTH_CRF = 18
GATHERED, TASKS = 1000, 100
WORKERS = (1, 10, 100, 1000, 10000)
SEQUENCE, TASK_S = 10000, 600
"""Frames of the sequence, and what a task is meant to take, of the predictions."""
ASKED_SAMPLES = (8, 64, 512)
GIGABYTE = 1e9


def timed(work, *words):
    """(processor seconds over the cores, wall seconds) of a program that must end well."""
    began = time.monotonic()
    process = subprocess.Popen([str(word) for word in words], cwd=work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, words))}: status {process.returncode}")
    return (usage.ru_utime + usage.ru_stime) / CORES, time.monotonic() - began


def bytes_of(folder, pattern):
    return sum(file.stat().st_size for file in folder.rglob(pattern))


def rendered(program, work):
    """Of a frame: its start, what is the same with any samples, a sample a pixel; bytes as frames and as parts; putting parts together."""
    render = (program, "render", "pavilion.json", "--layers", "--size", SIZE, "--aovs", "depth", "--progress", "none")
    all_frames = ("--frames", f"{FIRST}-{FIRST + FRAMES - 1}")
    seconds = {}
    for samples, count in zip(SAMPLES, (2, FRAMES)):
        words = (*render, "--spp", samples, "--frames", f"{FIRST}-{FIRST + count - 1}", "--out", f"frames-{samples}")
        took = timed(work, *words)[0]
        start_s = min(timed(work, *words)[0] for _ in range(3))  # all is finished and kept
        seconds[samples] = (took - start_s) / count
    few, many = SAMPLES
    sample_s = (seconds[many] - seconds[few]) / (many - few)
    one = (*render, "--spp", many, "--frames", FIRST, "--out", "parts")
    for part in range(1, PARTS + 1):
        timed(work, *one, "--part", f"{part}/{PARTS}")
    part_bytes = bytes_of(work / "parts", "*.part")
    together_s = timed(work, *one, "--part", f"all/{PARTS}")[0] - start_s
    as_one = all((work / "parts" / file).read_bytes() == (work / f"frames-{many}" / file).read_bytes() for file in (f"centre/frame.{FIRST:04}.exr", f"hidden/frame.{FIRST:04}.exr"))
    whole = bytes_of(work / f"frames-{many}", "*.exr") / FRAMES
    scene = bytes_of(work, "pavilion.*")
    farm = (program, "farm", "--chunk", FRAMES, "--frame-seconds", 1, *render[1:-2], "--spp", many, *all_frames, "--out", "whole")
    timed(work, *farm)
    timed(work, program, "farm", "task", "farm", "render", 0)
    task_s = min(timed(work, program, "farm", "task", "farm", "render", 0)[0] for _ in range(3)) - start_s
    return {"start_s": start_s, "frame_s": seconds[few] - few * sample_s, "sample_s": sample_s, "task_s": max(0, task_s),
            "frame_bytes": whole, "scene_bytes": scene, "part_bytes": part_bytes,
            "put_together_s": together_s, "same_bytes": as_one}


def encoded(program, work):
    """Of a frame of colour, depth and the hidden layer, without what the beginning takes: half as many frames are taken off. No trials, which look at eight frames of any sequence."""
    half = FRAMES // 2

    def encode(count):
        return min(timed(work, program, "encode", f"frames-{SAMPLES[1]}", "--depth", "w12", "--depth-crf", DEPTH_CRF, "--frames", f"{FIRST}-{FIRST + count - 1}",
                         "--progress", "none", "--out", "walk.mp4")[0] for _ in range(3))

    return {"encode_s": (encode(FRAMES) - encode(half)) / (FRAMES - half)}


def gathered(work):
    """Of a frame that is linked into place, here."""
    frame = next((work / f"frames-{SAMPLES[1]}/centre").glob("frame.*.exr"))
    manifest = json.loads((frame.parent / "manifest.json").read_text())
    for number in range(GATHERED):
        folder = work / f"chunks/{number:06}/centre"
        folder.mkdir(parents=True)
        os.link(frame, folder / f"frame.{number:04}.exr")
        (folder / "manifest.json").write_text(json.dumps({**manifest, "first_frame": {**manifest["first_frame"], "index": number}}))
    began = time.process_time()
    gather((work / "chunks").glob("*"), work / "gathered")
    return {"gather_s": (time.process_time() - began) / GATHERED}


def scheduled():
    """Of a Slurm on this machine: what a task that does nothing takes it, and an array to be submitted."""
    if why := slurm_here.missing():
        print(f"left out: Slurm: {why}", file=sys.stderr)
        return {}
    with tempfile.TemporaryDirectory(prefix="equistream_slurm_") as folder, slurm_here.Slurm(folder) as slurm:
        began = time.monotonic()
        slurm.run("sbatch", "--array=0-999", "--hold", "--output=/dev/null", "--wrap", "true")
        submit_s = time.monotonic() - began
        began = time.monotonic()
        slurm.run("sbatch", "--wait", f"--array=0-{TASKS - 1}", "--output=/dev/null", "--wrap", "true")
        return {"submit_1000_s": submit_s, "scheduler_task_s": (time.monotonic() - began) / TASKS}


def by_workers(found, frame_s, workers):
    """Seconds of each stage of the sequence, and bytes a second of all workers together. Tasks are shorter where there are more workers than tasks."""
    chunk = max(1, min(int(TASK_S / frame_s), SEQUENCE // workers))
    tasks = math.ceil(SEQUENCE / chunk)
    start_s = found["start_s"] + found["task_s"]
    task_s = start_s + chunk * frame_s
    render_s = math.ceil(tasks / workers) * task_s
    bytes_s = min(workers, tasks) * (chunk * found["frame_bytes"] + found["scene_bytes"]) / task_s
    return {"workers": workers, "chunk": chunk, "tasks": tasks, "task_s": task_s, "start_up_percent": 100 * start_s / task_s, "render_s": render_s, "gather_s": SEQUENCE * found["gather_s"],
            "encode_s": SEQUENCE * found["encode_s"], "bytes_a_second": bytes_s, **({"scheduler_s": tasks * found["scheduler_task_s"]} if "scheduler_task_s" in found else {})}


def predicted(found, samples):
    """Of the sequence with so many samples a pixel. Which stage takes as long as rendering from how many workers on is told for each by itself."""
    frame_s = found["frame_s"] + samples * found["sample_s"]
    of_task = by_workers(found, frame_s, 1)
    limits = {"encoder": frame_s / found["encode_s"], "gathering": frame_s / found["gather_s"],
              "file_system_of_1_GB_a_second": GIGABYTE * of_task["task_s"] / (of_task["chunk"] * found["frame_bytes"] + found["scene_bytes"])}
    if "scheduler_task_s" in found:
        limits["scheduler"] = of_task["task_s"] / found["scheduler_task_s"]
    return {"samples": samples, "frame_s": frame_s, "by_workers": [by_workers(found, frame_s, workers) for workers in WORKERS], "saturated_by_workers": limits}


def table(result):
    """Of the predictions, in Markdown."""
    yield "| samples a pixel | workers | frames a task | start-up | rendering | scheduling | gathering | encoding | written and read |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for of in result["predicted"]:
        for row in of["by_workers"]:
            yield (f"| {of['samples']} | {row['workers']:,} | {row['chunk']} | {row['start_up_percent']:.0f} % | {clock(row['render_s'])} | {clock(row['scheduler_s']) if 'scheduler_s' in row else '?'} | {clock(row['gather_s'])} | {clock(row['encode_s'])} "
                   f"| {row['bytes_a_second'] / 1e6:,.{0 if row['bytes_a_second'] > 1e7 else 2}f} MB/s |")


def clock(seconds):
    return f"{seconds / 3600:.3g} h" if seconds >= 3600 else f"{seconds / 60:.3g} min" if seconds >= 60 else f"{seconds:.2g} s"


def rounded(value):
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: rounded(each) for key, each in value.items()}
    return [rounded(each) for each in value] if isinstance(value, list) else value


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, help="folder for frames; default: one that is removed")
    asked = parser.parse_args()
    program = asked.bin.resolve() / "equistream"
    with tempfile.TemporaryDirectory(prefix="equistream_farm_", dir=asked.work) as folder:
        work = pathlib.Path(folder)
        timed(work, program, "scene", "generate", "pavilion", "--out", ".")
        found = rendered(program, work) | encoded(program, work) | gathered(work)
        shutil.rmtree(work / "chunks")
    found |= scheduled()
    result = {"command": "tests/study/farm.py --bin build/release/bin --out docs/results/farm.json", **provenance(asked.bin.resolve(), TESTS.parent),
              "settings": {"scene": "pavilion", "size": SIZE, "options": "--layers --aovs depth", "samples": SAMPLES, "parts": PARTS,
                           "sequence": SEQUENCE, "task_is_meant_to_take_s": TASK_S},
              "measured": found, "predicted": [predicted(found, samples) for samples in ASKED_SAMPLES]}
    write_whole(asked.out, json.dumps(rounded(result), indent=1) + "\n")
    print("\n".join(table(result)))


if __name__ == "__main__":
    main()
