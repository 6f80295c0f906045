#!/usr/bin/env python3
"""How far random eyes of the head box see things displaced, by engine: docs/results/reproject/shift/SCENE.json.

    shift.py --bin build/release/bin [SCENE ...]

No renders are needed: measured_shift.cpp casts rays for the sphere's depth, the eyes' and the truth.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from renders import FRAMES, LEAN_M, REPOSITORY, scene_parser  # noqa: E402
from steps import measured_json, provenance, run_as_program, write_whole  # noqa: E402


def main():
    parser = scene_parser(__doc__)
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/shift", help="folder for SCENE.json")
    parser.add_argument("--eyes", type=int, default=64)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engines", default="surface,gather,mesh,splat")
    options = parser.parse_args()
    program = options.bin / "equistream_measured_shift"
    for scene in options.scenes:
        words = [f"scenes/descriptions/{scene}.json", "--frame", str(FRAMES[scene]), "--lean", str(LEAN_M), "--eyes", str(options.eyes),
                 "--seed", str(options.seed), "--engines", options.engines]
        result = {"scene": scene, "command": " ".join([program.name, *words]), "n": {"eyes": options.eyes, "seed": options.seed},
                  "engines": measured_json(program, words, REPOSITORY), **provenance(options.bin, REPOSITORY)}
        write_whole(options.out / f"{scene}.json", json.dumps(result, indent=1) + "\n")
        print(options.out / f"{scene}.json", flush=True)


if __name__ == "__main__":
    run_as_program(main)
