#!/usr/bin/env python3
"""How the noise-free error of engines follows their error budget: docs/results/reproject/budgets.json (docs/decisions/0016).

    budgets.py --bin build/release/bin --work FOLDER [SCENE ...]

Spheres of two seeds and truths of two others are rendered into FOLDER, where frames that are done are kept. Needs the Python package
`equistream`.
"""

import argparse
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from results import EYES, REPOSITORY, keep  # noqa: E402
from steps import provenance, run_as_program  # noqa: E402

import equistream as es  # noqa: E402

FRAME, SPHERE, SPHERE_SPP, EYE, EYE_SPP, SEEDS = 10, "1920x960", 16, "640x360", 64, (1, 2)
ENGINES, BUDGETS_PX, FILL = ("mesh", "splat"), (0.25, 1, 2, 4, 8, 16), "pushpull"


class Budgets:
    def __init__(self, options, scene):
        self.program, self.scene, self.work = options.bin / "equistream", scene, options.work / scene
        for seed in SEEDS:
            self.render(f"sphere-{seed}", "--aovs", "depth", "--size", SPHERE, "--spp", SPHERE_SPP, "--seed", seed)
            self.render(f"truth-{seed}", "--camera", "perspective", "--eye", "both", "--size", EYE, "--spp", EYE_SPP, "--seed", 100 + seed)

    def render(self, name, *words):
        description = REPOSITORY / f"scenes/descriptions/{self.scene}.json"
        subprocess.run([str(word) for word in (self.program, "render", description, "--frames", f"{FRAME}-{FRAME}", *words, "--out", self.work / name)],
                       check=True)

    def differences(self, engine, seed):
        """Display values less the truth's, by eye."""
        frame = next(iter(es.Sequence(self.work / f"sphere-{seed}/centre")))
        to_display = es.DisplayTransform().to_display
        for eye in EYES:
            true = next(iter(es.Sequence(self.work / f"truth-{seed}/{eye}")))
            picture = engine(frame, true.info.camera, true.info.camera_pose)
            yield picture.rgb.astype(float) / 255 - to_display(np.ascontiguousarray(true["colour"][..., :3]))

    def noise_free_db(self, name, budget_px):
        """Noise of different seeds is independent: the mean product of their differences is the square of what they share."""
        engine = es.Reprojector(name, fill=FILL, error_budget_px=budget_px)
        first, second = (list(self.differences(engine, seed)) for seed in SEEDS)
        return {eye: round(float(-10 * np.log10(np.mean(a * b))), 3) for eye, a, b in zip(EYES, first, second)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["voxel-city", "sponza-crytek"])
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    parser.add_argument("--work", type=pathlib.Path, required=True, help="folder for renders; not in the repository")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/budgets.json")
    options = parser.parse_args()
    for scene in options.scenes:
        budgets = Budgets(options, scene)
        points = [{"engine": engine, "budget_px": budget, "noise_free_db": budgets.noise_free_db(engine, budget)}
                  for engine in ENGINES for budget in BUDGETS_PX]
        keep(options.out, scene, {
            "scene": scene, "command": f"tests/study/reproject/budgets.py --bin BIN --work FOLDER {scene}",
            **provenance(options.bin, REPOSITORY), "frame": FRAME, "sphere": SPHERE,
            "sphere_spp": SPHERE_SPP, "eye": EYE, "eye_spp": EYE_SPP, "seeds": SEEDS, "fill": FILL, "points": points})


if __name__ == "__main__":
    run_as_program(main)
