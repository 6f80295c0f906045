#!/usr/bin/env python3
"""Fits the reliability map (client/confidence) to rendered pairs, and measures how well it holds on scenes it has not seen.

    PYTHONPATH=build/release/package fit_reliability.py --bin build/release/bin --work FOLDER [--write]

FOLDER is what reliability_pairs.py filled. Every eye of every shot is reprojected at the source's own density, a half and a third of it,
with the engine `eye-depth` and several fill chains, with exact and with coarse depth, and by rotation alone; and as a client has it from a
stream, its colours through H.264 (reliability_samples.py), by exact depth and by the depth that came with it. Every pixel gives its
risks, their group and whether it is good (no channel off by more than the tolerance). Pixels whose noise may be more than a quarter of the
tolerance are left out, and mirrors and panes of scenes with direct light only: what is reflected is black there.
For each group of pixels: logistic regression with weights that are not negative, scenes counting alike, then a table that falls with the
weighted sum (isotonic regression). One map is fitted to pixels that went through no codec and to decoded ones; the risk `coding` tells them
apart. Depth that the bound takes for exact and coarser depth are groups of their own. Each scene in turn is left out and judged by what the
others give: docs/results/reproject/reliability.json; so is a fit to pixels without a codec alone (`uncoded_fit`). --write also fits to all scenes and writes client/confidence/coefficients.h.
"""

import argparse
import pathlib
import subprocess
import sys
import time

import equistream as es
import numpy as np
from equistream.reprojection import RELIABILITY_TOLERANCE, RISK_GROUPS, RISKS

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from reliability_model import COEFFICIENTS, FEWEST_IN_BIN, REPOSITORY, calibration, fit_group, formatted, header, shipped  # noqa: E402
from reliability_pairs import BREAKERS  # noqa: E402
from reliability_samples import CRFS, NO_STREAM, NOISE_SHARE, Samples  # noqa: E402
from kept import result_text  # noqa: E402
from steps import Failed, machine, run_as_program, write_whole  # noqa: E402

RESULTS = REPOSITORY / "docs/results/reproject/reliability.json"
# Two scenes show mirrors: what more than one risk says of those would be said of these two.
RISKS_OF_GROUP = {"mirrored": ("specular",)}
TURNED = RISK_GROUPS.index("turned")
# What is judged apart, of all pixels with known depth.
PARTS = ("all", "uncoded", "exact", *(f"crf_{crf}" for crf in CRFS))
# Breakers are much alike: together they count as much as two scenes.
BREAKER_WEIGHT = 0.4


def fit(samples, scenes, wanted=True):
    """A model of each group of pixels, fitted to what is `wanted` of `scenes`."""
    models = []
    for index, group in enumerate(RISK_GROUPS):
        inside = (samples.group == index) & np.isin(samples.scene, scenes) & wanted
        allowed = np.isin(RISKS, RISKS_OF_GROUP.get(group, RISKS))
        weight = weights(samples, inside)
        models.append(fit_group(np.where(allowed, samples.risks[inside], 0), samples.good[inside], weight / weight.sum()))
    return models


def weights(samples, inside):
    """Scenes count alike, and in each so do pixels of every CRF and those without."""
    kinds = (NO_STREAM, *CRFS)
    kind = samples.scene[inside] * len(kinds) + np.searchsorted(kinds, samples.crf[inside])
    count = np.bincount(kind, minlength=len(samples.scenes) * len(kinds))
    of_scene = np.array([BREAKER_WEIGHT if name in BREAKERS else 1.0 for name in samples.scenes])
    shown = (count.reshape(-1, len(kinds)) > 0).sum(axis=1)
    return (np.repeat(of_scene / np.maximum(shown, 1), len(kinds)) / np.maximum(count, 1))[kind]


def judge(samples, models, scene):
    """Bins of predicted reliability on one scene: all groups together and each alone."""
    inside = samples.scene == scene
    group, risks, good, stands_for = samples.group[inside], samples.risks[inside], samples.good[inside], samples.stands_for[inside]
    exact, crf, with_depth = samples.exact[inside], samples.crf[inside], group != TURNED
    predicted = np.zeros(inside.sum())
    for index, model in enumerate(models):
        predicted[group == index] = model.reliability(risks[group == index])
    parts = {"all": with_depth, "uncoded": with_depth & (crf == NO_STREAM), "exact": with_depth & exact & (crf == NO_STREAM)}
    parts |= {f"crf_{each}": with_depth & (crf == each) for each in CRFS}
    parts |= {name: group == index for index, name in enumerate(RISK_GROUPS)}
    return {name: calibration(predicted[part], good[part], stands_for[part]) for name, part in parts.items()}


def errors(judged):
    return {part: judged[part]["expected_calibration_error"] for part in PARTS}


def commit():
    done = subprocess.run(["git", "-C", REPOSITORY, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{REPOSITORY.name}: expected a git repository whose commit the figures can name, found: {done.stderr.strip()}")
    return done.stdout.strip()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder that reliability_pairs.py filled")
    parser.add_argument("--pixels-per-shot", type=int, default=40000, help="at most, of each group")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS, help="where the figures go")
    parser.add_argument("--write", action="store_true", help=f"write {COEFFICIENTS.relative_to(REPOSITORY)} too")
    return parser.parse_args()


def main():
    options = arguments()
    program = options.bin.resolve() / "equistream"
    samples = Samples(program, options.work, np.random.default_rng(options.seed), options.pixels_per_shot)
    everything = np.arange(len(samples.scenes))
    left_out, uncoded_fit = {}, {}
    for index, scene in enumerate(samples.scenes):
        others = everything[everything != index]
        left_out[scene] = {**samples.notes[scene], **judge(samples, fit(samples, others), index)}
        uncoded_fit[scene] = errors(judge(samples, fit(samples, others, samples.crf == NO_STREAM), index))
        print(f"{scene} left out: good {left_out[scene]['all']['good']}, expected calibration error {errors(left_out[scene])}, {uncoded_fit[scene]}", flush=True)
    models = fit(samples, everything) if options.write else shipped()
    words = ["--bin BIN --work WORK", f"--pixels-per-shot {options.pixels_per_shot}", f"--seed {options.seed}"]
    result = {"command": " ".join(["tests/study/reproject/fit_reliability.py", *words]),
              "made": time.strftime("%Y-%m-%d", time.gmtime()), "commit": commit(), "version": es.__version__, "machine": machine(),
              "tolerance_255": RELIABILITY_TOLERANCE, "noise_share": NOISE_SHARE, "fewest_in_bin": FEWEST_IN_BIN, "left_out": left_out, "uncoded_fit": uncoded_fit,
              "weights": {name: dict(zip(RISKS, (round(float(w), 4) for w in model.weights))) for name, model in zip(RISK_GROUPS, models)}}
    write_whole(options.out, result_text(result))
    print(options.out)
    if options.write:
        provenance = f"{sum(note['pixels'] for note in samples.notes.values())} pixels of {', '.join(samples.scenes)}."
        write_whole(COEFFICIENTS, formatted(header(models, provenance)))
        print(COEFFICIENTS)


if __name__ == "__main__":
    run_as_program(main)
