#!/usr/bin/env python3
"""How errors follow the engines' error budget: docs/results/reproject/budgets.json, and the tables of docs/decisions/0016.

    budgets.py --bin build/release/bin --work FOLDER [SCENE ...]
    budgets.py --bin build/release/bin --breakers COMMIT=RUN.json COMMIT=RUN.json

The first gives noise-free errors. Spheres of two seeds and truths of two others are rendered into FOLDER, where frames that are done are
kept. The second compares two runs of tests/stress/run.py --all, before and after. Needs the Python package `equistream`.
"""

import argparse
import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from results import EYES, REPOSITORY, keep  # noqa: E402
from pages import place, table  # noqa: E402
from steps import Failed, provenance, run_as_program  # noqa: E402

import equistream as es  # noqa: E402

FRAME, SPHERE, SPHERE_SPP, EYE, EYE_SPP, SEEDS = 10, "1920x960", 16, "640x360", 64, (1, 2)
RESULTS = REPOSITORY / "docs/results/reproject/budgets.json"
PAGE = REPOSITORY / "docs/decisions/0016-defaults.md"
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


def breaker_points(before, after):
    """For each breaker and engine, means over its values: dB gained, per cent of pixels that fail and that the map misses."""
    for breaker, by_value in before.items():
        for engine in ENGINES:
            pairs = [(by_value[value][engine], after[breaker][value][engine]) for value in by_value]
            failing = [[100 * figures["failing_share"] for figures in pair] for pair in pairs]
            missed = [[share * (1 - (figures["failing_recall"] or 0)) for share, figures in zip(shares, pair)]
                      for shares, pair in zip(failing, pairs)]
            gains = [b["psnr_db"] - a["psnr_db"] for a, b in pairs]
            yield {"breaker": breaker, "engine": engine, "gain_db": round(float(np.mean(gains)), 2), "least_gain_db": round(min(gains), 2),
                   **{name: [round(float(mean), 2) for mean in np.mean(values, axis=0)]
                      for name, values in (("failing_percent", failing), ("missed_percent", missed))}}


def draw(results):
    """Both tables of the decision."""
    scenes = [name for name in results if name != "breakers"]
    found = {(scene, point["engine"], point["budget_px"]): point["noise_free_db"] for scene in scenes for point in results[scene]["points"]}
    rows = [[f"{budget:g}", *(", ".join(f"{found[scene, engine, budget][eye]:.2f}" for eye in EYES) for scene in scenes for engine in ENGINES)]
            for budget in BUDGETS_PX]
    page = place(PAGE.read_text(), "budgets", "all", table(["budget, px", *(f"{scene}, `{engine}`" for scene in scenes for engine in ENGINES)], rows, labels=1))
    by_breaker = {}
    for point in results["breakers"]["points"]:
        by_breaker.setdefault(point["breaker"], []).extend(
            [f"{point['gain_db']:+.2f} ({point['least_gain_db']:+.2f})",
             *(", ".join(f"{percent:.2f}" for percent in point[name]) for name in ("failing_percent", "missed_percent"))])
    heads = ["breaker", *(head for engine in ENGINES for head in (f"`{engine}`: gain, dB (least)", "failing, %", "missed, %"))]
    PAGE.write_text(place(page, "breakers", "all", table(heads, [[breaker, *cells] for breaker, cells in by_breaker.items()], labels=1)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["voxel-city", "sponza-crytek"])
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders; not in the repository")
    parser.add_argument("--breakers", nargs=2, metavar="COMMIT=RUN.json", help="runs of all breakers, before and after")
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS)
    options = parser.parse_args()
    if options.breakers:
        commits, files = zip(*(run.split("=", 1) for run in options.breakers))
        before, after = (json.loads(pathlib.Path(file).read_text())["found"] for file in files)
        keep(options.out, "breakers", {"command": "tests/study/reproject/budgets.py --bin BIN --breakers BEFORE=RUN.json AFTER=RUN.json",
                                       **provenance(options.bin, REPOSITORY), "commits": commits, "points": list(breaker_points(before, after))})
    elif options.work is None:
        raise Failed("budgets.py: expected --work FOLDER or --breakers, found neither")
    for scene in [] if options.breakers else options.scenes:
        budgets = Budgets(options, scene)
        points = [{"engine": engine, "budget_px": budget, "noise_free_db": budgets.noise_free_db(engine, budget)}
                  for engine in ENGINES for budget in BUDGETS_PX]
        keep(options.out, scene, {
            "scene": scene, "command": f"tests/study/reproject/budgets.py --bin BIN --work FOLDER {scene}",
            **provenance(options.bin, REPOSITORY), "frame": FRAME, "sphere": SPHERE,
            "sphere_spp": SPHERE_SPP, "eye": EYE, "eye_spp": EYE_SPP, "seeds": SEEDS, "fill": FILL, "points": points})
    if options.out == RESULTS:
        draw(json.loads(RESULTS.read_text()))


if __name__ == "__main__":
    run_as_program(main)
