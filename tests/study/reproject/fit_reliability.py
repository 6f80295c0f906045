#!/usr/bin/env python3
"""Fits the reliability map (client/confidence) to rendered pairs, and measures how well it holds on scenes it has not seen.

    PYTHONPATH=build/release/package fit_reliability.py --bin build/release/bin --work FOLDER [--write]

FOLDER is what reliability_pairs.py filled. Every eye of every shot is reprojected from sources of the eye's own density and a third of
it, with the engine `eye-depth` and several fill chains, with exact and with coarse depth, and by rotation alone. Sources show direct light
without noise, or are path traced with 8 samples a pixel, as rendered and denoised; all of them also as a client has them from a stream,
their colours through H.264 (reliability_samples.py), by exact depth and by the depth that came with it. How visibly off a source is was
measured by references, as `encode` does; here every pixel has one. Every pixel gives its risks, their group and whether it is good (no
channel off by more than the tolerance). Pixels are left out where the truth's noise may be more than a quarter of the tolerance, and mirrors
and panes of the real scenes in direct light: what is reflected is black there.
For each group of pixels, from what is in direct light: logistic regression with weights that are not negative, scenes counting alike, then
a table that falls with the weighted sum (isotonic regression). What the source lost to noise, denoising and coding multiplies the
probability (kept_share) and has no weight. Depth that the bound takes for exact and coarser depth are groups of their own. Each scene in
turn is left out and judged by what the others give, and judged by the map as it is shipped: docs/results/reproject/reliability.json. --write
also fits to all scenes and writes client/confidence/coefficients.h.
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
from reliability_model import COEFFICIENTS, FEWEST_IN_BIN, REPOSITORY, calibration, fit_group, formatted, header, kept_share, shipped  # noqa: E402
from reliability_pairs import BREAKERS, DIRECT_LIGHT  # noqa: E402
from reliability_samples import KINDS, NO_STREAM, NOISE_SHARE, Samples  # noqa: E402
from kept import result_text  # noqa: E402
from steps import Failed, machine, run_as_program, write_whole  # noqa: E402

RESULTS = REPOSITORY / "docs/results/reproject/reliability.json"
# Few scenes show mirrors: what more risks say of those would be said of these few.
RISKS_OF_GROUP = {"mirrored": ("specular",)}
TURNED = RISK_GROUPS.index("turned")
UNCOVERED = [RISK_GROUPS.index(name) for name in ("seen", "small", "guessed")]
KIND_NAMES = [source if crf == NO_STREAM else f"{source}_{crf}" for source, crf in KINDS]
DIRECT_KINDS = [index for index, (source, _) in enumerate(KINDS) if source == DIRECT_LIGHT]
# Breakers are much alike: together they count as much as two scenes.
BREAKER_WEIGHT = 0.4


def fit(samples, scenes):
    """A model of each group of pixels, fitted to `scenes` in direct light."""
    models = []
    for index, group in enumerate(RISK_GROUPS):
        inside = (samples.group == index) & np.isin(samples.scene, scenes) & np.isin(samples.kind, DIRECT_KINDS)
        allowed = np.isin(RISKS, RISKS_OF_GROUP.get(group, RISKS))
        weight = weights(samples, inside)
        models.append(fit_group(np.where(allowed, samples.risks[inside], 0), samples.good[inside], kept_share(samples.lost[inside]), weight / weight.sum()))
    return models


def weights(samples, inside):
    """Scenes count alike, in each the sources, and of each source those that went through a codec and not."""
    kind = samples.scene[inside] * len(KINDS) + samples.kind[inside]
    count = np.bincount(kind, minlength=len(samples.scenes) * len(KINDS))
    of_scene = np.array([BREAKER_WEIGHT if name in BREAKERS else 1.0 for name in samples.scenes])
    shown = (count.reshape(-1, len(KINDS)) > 0).sum(axis=1)
    return (np.repeat(of_scene / np.maximum(shown, 1), len(KINDS)) / np.maximum(count, 1))[kind]


def judge(samples, models, scene):
    """Of one scene: the pixels with known depth by kind of source, those with exact depth, what was uncovered, and each group alone."""
    inside = samples.scene == scene
    group, risks, good, exact, kind, stands_for = (of[inside] for of in (samples.group, samples.risks, samples.good, samples.exact, samples.kind, samples.stands_for))
    predicted = np.zeros(inside.sum())
    for index, model in enumerate(models):
        predicted[group == index] = model.reliability(risks[group == index])
    predicted *= kept_share(samples.lost[inside])
    with_depth = group != TURNED
    parts = {"all": with_depth, "exact": with_depth & exact, "uncovered": np.isin(group, UNCOVERED)}
    parts |= {name: with_depth & (kind == index) for index, name in enumerate(KIND_NAMES)}
    parts |= {name: group == index for index, name in enumerate(RISK_GROUPS)}
    judged = {name: calibration(predicted[part], good[part], stands_for[part]) for name, part in parts.items()}
    for name in parts.keys() - {"all"}:  # whose bins no page shows
        del judged[name]["bins"]
    return judged


def errors(judged):
    return {kind: judged[kind]["expected_calibration_error"] for kind in KIND_NAMES}


def commit():
    done = subprocess.run(["git", "-C", REPOSITORY, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{REPOSITORY.name}: expected a git repository whose commit the figures can name, found: {done.stderr.strip()}")
    return done.stdout.strip()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder that reliability_pairs.py filled")
    parser.add_argument("--pixels-per-shot", type=int, default=3000, help="at most, of each group, density and kind of source")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS, help="where the figures go")
    parser.add_argument("--write", action="store_true", help=f"write {COEFFICIENTS.relative_to(REPOSITORY)} too")
    return parser.parse_args()


def main():
    options = arguments()
    samples = Samples(options.bin.resolve() / "equistream", options.work, options.seed, options.pixels_per_shot)
    everything = np.arange(len(samples.scenes))
    models = fit(samples, everything) if options.write else shipped()
    left_out, as_shipped = {}, {}
    for index, scene in enumerate(samples.scenes):
        left_out[scene] = {**samples.notes[scene], **judge(samples, fit(samples, everything[everything != index]), index)}
        as_shipped[scene] = errors(judge(samples, models, index))
        print(f"{scene} left out: good {left_out[scene]['all']['good']}, expected calibration errors {errors(left_out[scene])}, as shipped {as_shipped[scene]}", flush=True)
    words = ["--bin BIN --work WORK", f"--pixels-per-shot {options.pixels_per_shot}", f"--seed {options.seed}"]
    result = {"command": " ".join(["tests/study/reproject/fit_reliability.py", *words]),
              "made": time.strftime("%Y-%m-%d", time.gmtime()), "commit": commit(), "version": es.__version__, "machine": machine(),
              "tolerance_255": RELIABILITY_TOLERANCE, "noise_share": NOISE_SHARE, "fewest_in_bin": FEWEST_IN_BIN, "left_out": left_out,
              "shipped": as_shipped,
              "weights": {name: dict(zip(RISKS, (round(float(w), 4) for w in model.weights))) for name, model in zip(RISK_GROUPS, models)}}
    write_whole(options.out, result_text(result))
    print(options.out)
    if options.write:
        provenance = f"{sum(note['pixels'] for note in samples.notes.values())} pixels of {', '.join(samples.scenes)}."
        write_whole(COEFFICIENTS, formatted(header(models, provenance)))
        print(COEFFICIENTS)


if __name__ == "__main__":
    run_as_program(main)
