#!/usr/bin/env python3
"""Whether programs that run for long grow: memory and descriptors while a long walk is rendered, coded and played, and while one is served and looked at.

usage: memory.py BIN_DIR --report FILE [--frames 10000] [--minutes 0]

    --minutes: so long a recorded stream is served over and over, and a viewer looks at it on a display without a screen; 0: not

Each program's resident memory and open descriptors are looked at twice a second. *Growth* is the median of the last tenth less that of the second: what a
program needs, it has by then. It fails where one grows by more than ALLOWED of its memory, or by a descriptor. What another run found of other programs stays in the report.
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "programs"), str(TESTS / "programs/viewer"), str(TESTS.parent / "programs/study")]
from steps import provenance, write_whole  # noqa: E402

EVERY_S, ALLOWED = 0.5, 0.02
WALK = ("--size", "128x64", "--spp", 1)
EYES = ("--size", "160x90")


def looked_at(process):
    """(resident kB, descriptors) of a process; None once it has gone."""
    try:
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        resident = re.search(r"VmRSS:\s+(\d+) kB", status)
        return (int(resident[1]), len(list(pathlib.Path(f"/proc/{process.pid}/fd").iterdir()))) if resident else None
    except OSError:
        return None


def grown(samples):
    """Of (resident kB, descriptors) in a row."""
    tenth = max(1, len(samples) // 10)
    early, late = samples[tenth:2 * tenth] or samples[:1], samples[-tenth:]
    kb, descriptors = ([statistics.median(sample[i] for sample in part) for part in (early, late)] for i in (0, 1))
    return {"samples": len(samples), "resident_kb": int(kb[1]), "growth_kb": int(kb[1] - kb[0]), "descriptors": int(descriptors[1]), "descriptor_growth": int(descriptors[1] - descriptors[0])}


def watched(words):
    """What a program takes from its start to its end."""
    began, samples = time.time(), []
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL)
    while process.poll() is None:
        if (sample := looked_at(process)) is not None:
            samples.append(sample)
        time.sleep(EVERY_S)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, words[:2]))}: status {process.returncode}")
    return {**grown(samples), "seconds": round(time.time() - began, 1)}


def walk(program, work, frames):
    """render, encode and play of a head that goes to and fro."""
    rows = [f"{second},{0.2 * (second % 2)},1.6,0,1,0,0,0" for second in range(frames // 30 + 2)]
    (work / "walk.csv").write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "\n".join(rows) + "\n")
    subprocess.run([program, "scene", "generate", "pavilion", "--out", work], check=True, capture_output=True)
    scene = work / "pavilion.json"
    quiet = ("--progress", "none")
    yield "render", watched([program, "render", scene, *WALK, "--aovs", "depth", "--path", work / "walk.csv", "--frames", f"0-{frames - 1}", *quiet, "--out", work / "frames"])
    yield "encode", watched([program, "encode", work / "frames", "--depth", "auto", *quiet, "--out", work / "walk.mkv"])
    yield "play", watched([program, "play", work / "walk.mkv", *EYES, *quiet, "--out", work / "eyes.mp4"])


def served(program, stream, minutes):
    """serve and view, side by side."""
    from display import Display
    display = Display()
    server = subprocess.Popen([program, "serve", stream, "--listen", "tcp://127.0.0.1:0", "--loop", "--json", "--progress", "none"], stdout=subprocess.PIPE, text=True)
    try:
        address = json.loads(server.stdout.readline())["listening"]
        viewer = subprocess.Popen([program, "view", address, "--size", "320x180", "--seconds", str(60 * minutes), "--json"], env=display.environment, stdout=subprocess.DEVNULL)
        of_server, of_viewer = [], []
        while viewer.poll() is None:
            for process, samples in ((server, of_server), (viewer, of_viewer)):
                if (sample := looked_at(process)) is not None:
                    samples.append(sample)
            time.sleep(EVERY_S)
        if viewer.returncode != 0 or server.poll() is not None:
            raise RuntimeError(f"view: status {viewer.returncode}; serve: {'still there' if server.poll() is None else server.returncode}")
        yield "serve", {**grown(of_server), "seconds": 60 * minutes}
        yield "view", {**grown(of_viewer), "seconds": 60 * minutes}
    finally:
        server.kill()
        display.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--report", type=pathlib.Path, required=True)
    parser.add_argument("--frames", type=int, default=10000)
    parser.add_argument("--minutes", type=float, default=0)
    asked = parser.parse_args()
    program = asked.bin.resolve() / "equistream"
    found = provenance(asked.bin.resolve(), TESTS.parent)
    report = (json.loads(asked.report.read_text()) if asked.report.exists() else {"programs": {}}) | {"frames": asked.frames, **found}
    measured = []
    with tempfile.TemporaryDirectory(prefix="equistream_memory_") as folder:
        work = pathlib.Path(folder)
        parts = [walk(program, work, asked.frames)] + ([served(program, work / "walk.mkv", asked.minutes)] if asked.minutes else [])
        for part in parts:
            for name, figures in part:
                measured.append(figures)
                report["programs"][name] = {**figures, "commit": found["versions"]["commit"]}
                print(name, figures, flush=True)
                write_whole(asked.report, json.dumps(report, indent=1) + "\n")
    return any(each["growth_kb"] > ALLOWED * each["resident_kb"] or each["descriptor_growth"] > 0 for each in measured)


if __name__ == "__main__":
    sys.exit(main())
