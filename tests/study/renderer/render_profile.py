#!/usr/bin/env python3
"""Where the renderer's time goes: one 960x480 sphere of each real scene, and what `render --json` says (docs/results/renderer/profile/SCENE.json).

    render_profile.py --bin build/release/bin [--out FOLDER]          with nothing else running
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from kept import result_text  # noqa: E402
from steps import machine, versions, write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
FRAMES = {"sponza-crytek": 60, "san-miguel": 0}


def profile(program, scene, frame):
    description = f"scenes/descriptions/{scene}.json"
    words = ["render", description, "--size", "960x480", "--spp", "16", "--frames", str(frame), "--eye", "left", "--aovs", "none", "--json",
             "--progress", "none", "--out"]
    with tempfile.TemporaryDirectory(prefix="equistream_profile_") as folder:
        out = subprocess.run([program, *words, f"{folder}/frames"], cwd=REPOSITORY, check=True, capture_output=True, text=True).stdout
    return {"scene": scene, "command": " ".join(["equistream", *words, "OUT"]), "seed": 1, "versions": versions(program, REPOSITORY),
            "machine": machine(), "report": json.loads(out)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/renderer/profile")
    options = parser.parse_args()
    for scene, frame in FRAMES.items():
        file = options.out / f"{scene}.json"
        write_whole(file, result_text(profile(options.bin.resolve() / "equistream", scene, frame)))
        print(file)


if __name__ == "__main__":
    main()
