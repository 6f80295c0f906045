#!/usr/bin/env python3
"""Keeps what ./bench prints of the client, with the machine and the version: docs/results/reproject/speed.json.

    speed.py --bin build/release/bin

To be run on a machine that does nothing else.
"""

import argparse
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from renders import REPOSITORY  # noqa: E402
from steps import Failed, provenance, run_as_program, write_whole  # noqa: E402

FIGURES = "rotate|two_eyes|fill_1080p|play|depth_|reliability|surface|splat|mesh|gather"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/speed.json")
    options = parser.parse_args()
    command = [options.bin.resolve() / "equistream_bench", f"--benchmark_filter={FIGURES}"]
    made = provenance(options.bin, REPOSITORY)
    done = subprocess.run(command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise Failed(f"equistream_bench: exit {done.returncode}: {done.stderr.strip()}")
    figures = []
    for line in done.stdout.splitlines():
        name, value, unit, ratio, peer = line.split()
        figures.append({"name": name, unit: float(value), "ratio": None if ratio == "-" else float(ratio), "peer": peer})
    peers_alone = sorted({figure["name"] for figure in figures if "/" in figure["name"]})
    if peers_alone:
        raise Failed(f"equistream_bench: expected ours beside every peer, found alone: {', '.join(peers_alone)}")
    notes = [line[2:] for line in done.stderr.splitlines() if line.startswith("# ")]
    result = {"command": f"./bench '{FIGURES}'", "notes": notes, "figures": figures, **made}
    write_whole(options.out, json.dumps(result, indent=1) + "\n")
    print(f"{options.out}: {len(figures)} figures")


if __name__ == "__main__":
    run_as_program(main)
