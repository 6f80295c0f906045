#!/usr/bin/env python3
"""Where the renderer's time goes: one 960x480 sphere of each real scene, and what `render --json` says (docs/results/renderer/profile.json).

    render_profile.py --bin build/release/bin [--out FOLDER]          with nothing else running
    render_profile.py --bin build/release/bin --before BIN [...]      noise instead: variance between seeds, of two builds (noise.json)

The second needs the Python package on PYTHONPATH.
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
NOISY = ("sibenik", "kitchen", "sponza-crytek", "san-miguel", "voxel-city")
SEEDS = 4


def profile(program, scene, frame):
    description = f"scenes/descriptions/{scene}.json"
    words = ["render", description, "--size", "960x480", "--spp", "16", "--frames", str(frame), "--eye", "left", "--aovs", "none", "--json",
             "--progress", "none", "--out"]
    with tempfile.TemporaryDirectory(prefix="equistream_profile_") as folder:
        out = subprocess.run([program, *words, f"{folder}/frames"], cwd=REPOSITORY, check=True, capture_output=True, text=True).stdout
    return {"scene": scene, "command": " ".join(["equistream", *words, "OUT"]), "seed": 1, "versions": versions(program, REPOSITORY),
            "machine": machine(), "report": json.loads(out)}


def rendered(program, words, seed):
    """Radiance times exposure, and what `render --json` says."""
    import equistream as es

    with tempfile.TemporaryDirectory(prefix="equistream_profile_") as folder:
        run = subprocess.run([program, *words, "--seed", str(seed), "--out", f"{folder}/frames"], cwd=REPOSITORY, check=True, capture_output=True,
                             text=True)
        frame = es.read_frame(f"{folder}/frames/centre/frame.0000.exr")
    return frame["colour"][..., :3].astype("f8") * frame.info.exposure, json.loads(run.stdout)


def spread(pictures, display):
    """Mean and median over the pixels of the variance between seeds, on values in [0, 1]."""
    import numpy as np

    values = np.stack([display(picture) for picture in pictures]) if display else np.clip(pictures, 0, 1)
    variance = values.var(axis=0, ddof=1).mean(axis=-1)
    return {"mean": float(variance.mean()), "median": float(np.median(variance))}


def noise(programs, scene):
    import equistream as es
    import numpy as np

    words = ["render", f"scenes/descriptions/{scene}.json", "--size", "480x240", "--spp", "32", "--frames", "0", "--eye", "centre", "--aovs", "none",
             "--json", "--progress", "none"]
    runs = {name: [] for name in programs}
    for seed in range(1, SEEDS + 1):  # by turns, so that what else the machine does falls on all alike
        for number, (name, program) in enumerate(programs.items()):
            runs[name].append(rendered(program, words, seed + 100 * number))
    transform = es.DisplayTransform()
    result = {"scene": scene, "command": " ".join(["equistream", *words, "--seed", "SEED", "--out", "OUT"]), "seeds": SEEDS}
    for name, made in runs.items():
        pictures = np.stack([picture for picture, _ in made])
        means = pictures.mean(axis=(1, 2, 3))
        result[name] = {"cpu_s": float(np.mean([sum(report["cpu_s"].values()) for _, report in made])), "mean": float(means.mean()),
                        "standard_error": float(means.std(ddof=1) / SEEDS ** 0.5), "linear": spread(pictures, None),
                        "display": spread(pictures.astype("f4"), transform.to_display)}
        if "sky_openings" in made[0][1]:
            result[name]["sky_openings"] = made[0][1]["sky_openings"]
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--before", type=pathlib.Path, help="folder of another build's programs: compares noise")
    parser.add_argument("--scenes", nargs="+", help="which of them")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/renderer")
    options = parser.parse_args()
    program = options.bin.resolve() / "equistream"
    if options.before:
        programs = {"before": options.before.resolve() / "equistream", "after": program}
        result = {"versions": versions(program, REPOSITORY), "machine": machine(),
                  "scenes": [noise(programs, scene) for scene in options.scenes or NOISY]}
    else:
        result = {"scenes": [profile(program, scene, FRAMES[scene]) for scene in options.scenes or FRAMES]}
    file = options.out / ("noise.json" if options.before else "profile.json")
    write_whole(file, result_text(result))
    print(file)


if __name__ == "__main__":
    main()
