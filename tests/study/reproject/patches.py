#!/usr/bin/env python3
"""How much of what eyes uncover patches show, for how many pixels: docs/results/reproject/patches.json.

    patches.py --bin build/release/bin [--sizes 960x480,1920x960] [SCENE ...]

equistream_gap_coverage does the measuring: 64 random eyes, uniform in the head box and turned at random, of other seeds than the
planner's places; gaps are those of the `eye-depth` engine with exact depth, filled by the client's own `patches` pass. Beside the
patches: all their auxiliary spheres whole, which no choice of patches can exceed, and the small stream's pass. A result that is
there for the same command is kept.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from renders import FRAMES, REPOSITORY, scene_parser  # noqa: E402
from results import RESULTS, keep, load  # noqa: E402
from steps import measured_json, provenance, run_as_program  # noqa: E402

SEED, EYES = 20, 64
FILE = RESULTS / "patches.json"


def measure(options, scene):
    def write():
        keep(FILE, scene, {"seed": SEED, "n": EYES, "results": results})

    found = load("patches").get(scene, {"results": []})["results"]
    results = [result for result in found if result["frame"] == FRAMES[scene]]
    for size in options.sizes.split(","):
        for side in options.sides.split(","):
            words = [f"scenes/descriptions/{scene}.json", "--frame", str(FRAMES[scene]), "--sphere-size", size, "--side", side,
                     "--eyes", str(EYES), "--seed", str(SEED), "--budgets", options.budgets]
            command = "equistream_gap_coverage " + " ".join(words)
            if any(result["command"] == command for result in results):
                continue
            print(command, flush=True)
            measured = measured_json(options.bin / "equistream_gap_coverage", words, REPOSITORY)
            results.append({"command": command, **measured, **provenance(options.bin, REPOSITORY)})
            write()
    if len(results) != len(found):
        write()  # those of another frame are gone


def main():
    parser = scene_parser(__doc__)
    parser.add_argument("--sizes", default="960x480,1920x960", help="of the sphere (default: %(default)s)")
    parser.add_argument("--sides", default="16,8", help="of a patch, pixels (default: %(default)s)")
    parser.add_argument("--budgets", default="2.5,5,10,15,20", help="percent of the sphere's pixels (default: %(default)s)")
    options = parser.parse_args()
    for scene in options.scenes:
        measure(options, scene)


if __name__ == "__main__":
    run_as_program(main)
