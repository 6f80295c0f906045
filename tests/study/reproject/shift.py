#!/usr/bin/env python3
"""How far random eyes of the head box see things displaced, by engine: docs/results/reproject/shift/SCENE.json.

    shift.py --bin build/release/bin [SCENE ...]

No renders are needed: measured_shift.cpp casts rays for the sphere's depth, the eyes' and the truth.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from renders import FRAMES, LEAN_M, REPOSITORY  # noqa: E402
from steps import Failed, machine, versions, write_whole  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=list(FRAMES), help=", ".join(FRAMES))
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/shift", help="folder for SCENE.json")
    parser.add_argument("--eyes", type=int, default=64)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engines", default="surface,gather,mesh,splat")
    options = parser.parse_args()
    program = options.bin.resolve() / "equistream_measured_shift"
    if not program.is_file():
        raise Failed(f"{program}: expected the built program, found nothing (give --bin)")
    for scene in options.scenes:
        words = [f"scenes/descriptions/{scene}.json", "--frame", str(FRAMES[scene]), "--lean", str(LEAN_M), "--eyes", str(options.eyes),
                 "--seed", str(options.seed), "--engines", options.engines]
        done = subprocess.run([program, *words], cwd=REPOSITORY, env=os.environ, capture_output=True, text=True)
        if done.returncode != 0:
            raise Failed(f"{' '.join([program.name, *words])}: exit {done.returncode}: {done.stderr.strip()}")
        result = {"scene": scene, "made": time.strftime("%Y-%m-%d", time.gmtime()), "command": " ".join([program.name, *words]),
                  "n": {"eyes": options.eyes, "seed": options.seed}, "engines": json.loads(done.stdout),
                  "versions": versions(options.bin.resolve() / "equistream", REPOSITORY), "machine": machine()}
        write_whole(options.out / f"{scene}.json", json.dumps(result, indent=1) + "\n")
        print(options.out / f"{scene}.json", flush=True)


if __name__ == "__main__":
    try:
        main()
    except Failed as failure:
        sys.exit(f"shift.py: {failure}")
