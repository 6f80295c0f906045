#!/usr/bin/env python3
"""Fits the reliability map (client/reliability) to rendered pairs, and measures how well it holds on scenes it has not seen.

    PYTHONPATH=build/release/package fit_reliability.py --bin build/release/bin --work FOLDER [--write]

FOLDER is what reliability_pairs.py filled. Every eye of every shot is reprojected at the source's own density, a half and a third of it,
with the engine `surface` and several fill ladders, with exact and with coarse depth, and by rotation alone; and as a client has it from a
stream, its colours through H.264 (decoded.py), by exact depth and by the depth that came with it. Every pixel gives its
risks, their group and whether it is good (no channel off by more than the tolerance). Pixels whose noise may be more than a quarter of the
tolerance are left out, and mirrors and panes of scenes with direct light only: what is reflected is black there.
For each group of pixels: logistic regression with weights that are not negative, scenes counting alike, then a table that falls with the
weighted sum (isotonic regression). It is fitted to pixels that went through no codec: the map does not know whether a picture was coded,
nor how coarsely. Depth that the bound takes for exact and coarser depth are groups of their own. Each scene in turn
is left out and judged by what the others give: docs/results/reproject/reliability.json; so are fits to coded pixels too (`mixed`: one for
both; `apart`: each its own), and what coefficients.h holds, which saw all scenes (`shipped`). --write also fits to all scenes and writes
client/reliability/coefficients.h.
"""

import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import textwrap
import time
from dataclasses import replace

import equistream as es
import numpy as np
from equistream.reprojection import ORIGINS, RELIABILITY_TOLERANCE, RISK_GROUPS, RISKS
from scipy.ndimage import uniform_filter
from scipy.optimize import isotonic_regression, minimize

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from decoded import decoded  # noqa: E402
from reliability_pairs import BREAKERS, RUN_FRAMES, RUN_SOURCE  # noqa: E402
from steps import Failed, machine, run_as_program, write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
COEFFICIENTS = REPOSITORY / "client/reliability/coefficients.h"
RESULTS = REPOSITORY / "docs/results/reproject/reliability.json"
COARSER = (1, 2, 3)
SMALLER = 4
# Two scenes show mirrors: what more than one risk says of those would be said of these two.
RISKS_OF_GROUP = {"mirrored": ("specular",)}
MIRRORED, NO_GROUP = RISK_GROUPS.index("mirrored"), 255
TURNED = RISK_GROUPS.index("turned")


# Of colours that went through no codec; of depth that came with those that did.
NO_STREAM, STREAMED = -1, None
CRFS = (16, 24)


class Chain:
    """A method, a fill ladder with what it fills from, the bits of the depth's w (0: exact), and the CRF of the stream it came by."""

    def __init__(self, method, fill, depth_bits, only_filled=False, crf=NO_STREAM):
        self.method, self.fill, self.depth_bits, self.crf = method, fill, depth_bits, crf
        self.only_filled = only_filled  # another chain has the same pixels of the source


# What `earlier` brings, the other eye's view with its depth, stands for patches and hidden layers too: all of them are looked up
# by depth, at the source's density, in a picture from elsewhere.
CHAINS = (Chain("surface", "small,pushpull", 0), Chain("surface", "pushpull", 0, only_filled=True),
          Chain("surface", "earlier", 0, only_filled=True), Chain("surface", "spread", 6), Chain("surface", "earlier,spread", 5),
          Chain("surface", "pushpull", 4), Chain("sphere", "none", 0),
          # What play does with a scene beside the stream, and with its depth track alone.
          *(Chain("surface", "earlier,pushpull", 0, crf=crf) for crf in CRFS), *(Chain("mesh", "pushpull", STREAMED, crf=crf) for crf in CRFS))
NOISE_SHARE = 1 / 4
ENTRIES_PER_UNIT, TABLE_SIZE = 16, 256
FEWEST_IN_BIN = 500
# What is judged apart, of all pixels with known depth.
PARTS = ("all", "uncoded", "exact", *(f"crf_{crf}" for crf in CRFS))
# Breakers are much alike: together they count as much as two scenes.
BREAKER_WEIGHT = 0.4
RIDGE = 1e-4


def smaller(image, factor):
    """Box filtered by a whole factor: what a coarser render of the same samples would be."""
    height, width = image.shape[0] // factor * factor, image.shape[1] // factor * factor
    return image[:height, :width].reshape(height // factor, factor, width // factor, factor, -1).mean(axis=(1, 3)).astype(np.float32)


def middle(plane, factor):
    """The middle one of an odd number of samples lies at the coarser pixel's centre; of an even number the nearest one does nearly."""
    return np.ascontiguousarray(plane[factor // 2::factor, factor // 2::factor])


def both_runs(folder, name, index):
    frames = [es.read_frame(next(folder.glob(f"{name}-{run}/*/frame.{index:04d}.exr"))) for run in (0, 1)]
    return frames, np.mean([frame["colour"][:, :, :3] for frame in frames], axis=0)


def noise_of(frames, exposure):
    """Standard deviation of the mean of two runs, display-referred, in 1/255, of the worst channel, over 5x5 pixels."""
    first, second = (255 * es.DisplayTransform().to_display(frame["colour"][:, :, :3], exposure).astype(float) for frame in frames)
    variance = uniform_filter(((first - second) / 2) ** 2, (5, 5, 0))
    return np.sqrt(np.maximum(variance.max(axis=2), 0))


def coding_step(depth_m, box_m, bits):
    """Of w = B / (r - B), for its largest value to be the last code; 0 for exact depth."""
    return float((box_m / np.maximum(depth_m - box_m, 1e-3)).max()) / (2 ** bits - 1) if bits else 0.0


def rounded(depth_m, box_m, step):
    if step == 0:
        return depth_m
    with np.errstate(divide="ignore"):
        w = np.round(box_m / np.maximum(depth_m - box_m, 1e-3) / step) * step
        return (box_m + box_m / w).astype(np.float32)


class Shot:
    """One source and its eyes."""

    def __init__(self, folder):
        frames, colour = both_runs(folder, "source", 0)
        self.info, self.colour, self.planes = frames[0].info, colour, frames[0]
        self.eyes = [both_runs(folder, "eyes", index) for index in (0, 1)]
        self.run = [es.read_frame(next(folder.glob(f"run/*/frame.{index:04d}.exr"))) for index in range(RUN_FRAMES)]

    def display(self, colour, info):
        return es.quantise_8bit(es.DisplayTransform().to_display(np.ascontiguousarray(colour, np.float32), info.exposure))

    def source(self, factor, eye):
        """For the leaning eye one that was not rendered for it: its head box has no lean."""
        camera = self.info.camera
        coarse = es.EquirectCamera(camera.width // factor, camera.height // factor, camera.longitudes, camera.latitudes)
        planes = {"colour": smaller(self.colour, factor), "depth": middle(self.planes["depth"], factor),
                  "specular": middle(self.planes["specular"], factor)}
        return es.Frame(es.frame_info(coarse, like=self.info, lean_m=self.info.lean_m if eye == 0 else 0.0), planes)

    def small(self, eye):
        """The other eye, made coarser: the paper's small stream, from another place and with other noise."""
        frames, colour = self.eyes[1 - eye]
        camera = frames[0].info.camera
        info = es.frame_info(es.PerspectiveCamera(camera.width // SMALLER, camera.height // SMALLER, camera.fov_x_rad), like=frames[0].info)
        # No pixel lies in the middle of an even number: depth comes from the nearest one.
        return es.Frame(info, {"colour": smaller(colour, SMALLER), "depth": middle(frames[0]["depth"], SMALLER)})

    def other(self, eye, factor):
        """The other eye's view at the source's density: what an earlier frame, a patch or a hidden layer shows."""
        frames, colour = self.eyes[1 - eye]
        camera = frames[0].info.camera
        info = es.frame_info(es.PerspectiveCamera(camera.width // factor, camera.height // factor, camera.fov_x_rad), like=frames[0].info)
        return es.Frame(info, {"colour": smaller(colour, factor), "depth": middle(frames[0]["depth"], factor)})

    def streamed(self, program, source, factor, crf):
        """The source from a stream of the frames around it; what is mirror is known as if no codec had been there."""
        run = [es.Frame(es.frame_info(source.info.camera, like=frame.info, lean_m=source.info.lean_m),
                        {"colour": smaller(frame["colour"][:, :, :3], factor), "depth": middle(frame["depth"], factor)}) for frame in self.run]
        run[RUN_SOURCE] = source
        found = decoded(program, run, RUN_SOURCE, crf)
        found.specular = source["specular"]
        return found

    def samples(self, program, mirrors_show):
        """(group, risks, good, exact, CRF) of the pixels of all eyes, densities and chains; and how many noise left out."""
        parts, left_out, counted = [], 0, 0
        for eye, (frames, colour) in enumerate(self.eyes):
            info = frames[0].info
            truth = 255 * es.DisplayTransform().to_display(np.ascontiguousarray(colour, np.float32), info.exposure).astype(float)
            noise = noise_of(frames, info.exposure)
            for factor in COARSER:
                source, small, other = self.source(factor, eye), self.small(eye), self.other(eye, factor)
                views = {NO_STREAM: (source, other)}
                for crf in CRFS:
                    views[crf] = self.streamed(program, source, factor, crf), decoded(program, [other], 0, crf)
                # The source has half as many samples; bilinear lookup averages 2.25 pixels or so, the filter factor^2.
                quiet = noise * np.sqrt(1 + 2 / 2.25 / factor ** 2) <= NOISE_SHARE * RELIABILITY_TOLERANCE
                for chain in CHAINS:
                    box_m = source.info.box_radius_m
                    main, earlier = views[chain.crf]
                    step = coding_step(source["depth"], box_m, chain.depth_bits)

                    def depth(camera, pose):
                        for frame in (source, small, frames[0]):
                            if frame.info.camera == camera and frame.info.camera_pose == pose:
                                return rounded(frame["depth"], box_m, step)
                        raise AssertionError("depth of an unknown view")

                    # Mirrors as the engine leaves them: those are what the group `mirrored` is fitted to. Looked up anew, as play does,
                    # they lie within the bound and count as any other pixel of the source.
                    by_track = chain.depth_bits is STREAMED
                    if chain.crf != NO_STREAM and not by_track:
                        main, earlier = replace(main, depth_m=source["depth"]), replace(earlier, depth_m=other["depth"])
                    picture = es.Reprojector(chain.method, fill=chain.fill, mirrors="surface")(
                        main, info.camera, info.camera_pose, depth=None if by_track else depth, risks=True,
                        small=small if "small" in chain.fill else None, earlier=[earlier] if "earlier" in chain.fill else (),
                        depth_tolerance_w=None if by_track else step / 2)
                    group = picture.risk_groups
                    wanted = group != NO_GROUP
                    if chain.only_filled:
                        wanted &= picture.origin != ORIGINS.index("source")
                    if not mirrors_show:
                        wanted &= group != MIRRORED
                    used = quiet & wanted
                    worst = np.abs(picture.rgb.astype(float) - truth).max(axis=2)
                    counted, left_out = counted + int(wanted.sum()), left_out + int((~quiet & wanted).sum())
                    parts.append((group[used], picture.risks[used], worst[used] <= RELIABILITY_TOLERANCE,
                                  np.full(used.sum(), chain.depth_bits == 0), np.full(used.sum(), chain.crf)))
        return tuple(np.concatenate(arrays) for arrays in zip(*parts)), left_out, counted


class GroupModel:
    """Weights of the risks and the table from their weighted sum to the share of good pixels."""

    def __init__(self, weights, table):
        self.weights, self.table = weights, table

    def reliability(self, risks):
        entry = np.minimum(risks @ self.weights * ENTRIES_PER_UNIT, TABLE_SIZE - 1).astype(int)
        return self.table[entry]


def fit_group(risks, good, weight):
    if len(risks) == 0:
        raise Failed("a group of pixels without any sample: expected shots of every kind (see reliability_pairs.py)")
    risks = risks.astype(np.float64)
    sign = np.where(good, 1.0, -1.0)

    def loss(parameters):
        logit = parameters[0] - risks @ parameters[1:]
        margin = -sign * logit
        value = np.sum(weight * np.logaddexp(0, margin)) + RIDGE * np.sum(parameters[1:] ** 2)
        slope = -weight * sign / (1 + np.exp(-np.clip(margin, -50, 50)))
        gradient = np.concatenate([[slope.sum()], -risks.T @ slope + 2 * RIDGE * parameters[1:]])
        return value, gradient

    start = np.concatenate([[3.0], np.where(risks.max(axis=0) > 0, 0.1, 0)])
    # No evidence, no weight.
    bounds = [(None, None)] + [(0, None if seen else 0) for seen in risks.max(axis=0) > 0]
    solved = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 200})
    weights = solved.x[1:].astype(np.float32)
    sums = risks @ weights.astype(np.float64)
    # The table's units would do for any scale of the sum; its last entry should be what hardly any pixel reaches.
    reach = np.quantile(sums, 0.999) or 1.0
    weights = np.float32(weights * (TABLE_SIZE / ENTRIES_PER_UNIT * 0.98 / reach))
    return GroupModel(weights, calibrated(risks @ weights.astype(np.float64), good, weight))


def calibrated(sums, good, weight):
    entry = np.minimum(sums * ENTRIES_PER_UNIT, TABLE_SIZE - 1).astype(int)
    mass = np.bincount(entry, weight, TABLE_SIZE)
    share = np.bincount(entry, weight * good, TABLE_SIZE) / np.maximum(mass, 1e-300)
    known = mass > 0
    falling = isotonic_regression(share[known], weights=mass[known], increasing=False).x
    # Between known entries straight lines; rounded as the header stores it.
    return np.round(np.interp(np.arange(TABLE_SIZE), np.flatnonzero(known), falling) * 255) / 255


class Samples:
    """All pixels, with their scene."""

    def __init__(self, program, work, rng, per_shot, path_traced=False):
        self.scenes, self.notes = [], {}
        parts = []
        for scene in sorted(folder for folder in work.iterdir() if folder.is_dir()):
            taken = left_out = counted = 0
            for folder in sorted(scene.glob("*-*")):
                last = {"eyes-0": 1, "eyes-1": 1, "source-0": 0, "source-1": 0, "run": RUN_FRAMES - 1}
                if not all(list(folder.glob(f"{name}/*/frame.{frame:04d}.exr")) for name, frame in last.items()):
                    continue
                (group, risks, good, exact, crf), noisy, seen = Shot(folder).samples(program, path_traced or scene.name in BREAKERS)
                share = np.minimum(1, per_shot / np.bincount(group, minlength=len(RISK_GROUPS)).clip(1))[group]
                chosen = rng.random(len(group)) < share
                parts.append((np.full(chosen.sum(), len(self.scenes)), group[chosen], risks[chosen], good[chosen], exact[chosen], crf[chosen],
                              1 / share[chosen]))
                taken, left_out, counted = taken + int(chosen.sum()), left_out + noisy, counted + seen
            if taken:
                self.scenes.append(scene.name)
                self.notes[scene.name] = {"pixels": taken, "left_out_for_noise": round(left_out / counted, 4)}
                print(f"{scene.name}: {taken} pixels, {100 * left_out / counted:.1f} % left out for their noise", flush=True)
        self.scene, self.group, self.risks, self.good, self.exact, self.crf, self.stands_for = (np.concatenate(arrays) for arrays in zip(*parts))

    def fit(self, scenes, streams=False):
        """To pixels that went through no codec, or to those that did."""
        wanted = (self.crf != NO_STREAM) == streams
        # Groups that streams were not asked for keep what the others say.
        return self.fit_to(wanted | ~np.isin(self.group, self.group[wanted]), scenes)

    def fit_to(self, wanted, scenes):
        models = []
        for group in range(len(RISK_GROUPS)):
            inside = (self.group == group) & np.isin(self.scene, scenes) & wanted
            count = np.bincount(self.scene[inside], minlength=len(self.scenes))
            of_scene = np.array([BREAKER_WEIGHT if name in BREAKERS else 1.0 for name in self.scenes])
            weight = (of_scene / np.maximum(count, 1))[self.scene[inside]]
            allowed = np.isin(RISKS, RISKS_OF_GROUP.get(RISK_GROUPS[group], RISKS))
            models.append(fit_group(np.where(allowed, self.risks[inside], 0), self.good[inside], weight / weight.sum()))
        return models

    def judge(self, models, scene, models_of_streams=None):
        """Bins of predicted reliability on one scene: all groups together and each alone."""
        inside = self.scene == scene
        predicted = np.zeros(inside.sum())
        group, risks, good, stands_for = self.group[inside], self.risks[inside], self.good[inside], self.stands_for[inside]
        exact, crf, with_depth = self.exact[inside], self.crf[inside], group != TURNED
        for chosen, part in ((models, crf == NO_STREAM), (models_of_streams or models, crf != NO_STREAM)):
            for index, model in enumerate(chosen):
                predicted[part & (group == index)] = model.reliability(risks[part & (group == index)])
        parts = {"all": with_depth, "uncoded": with_depth & (crf == NO_STREAM), "exact": with_depth & exact & (crf == NO_STREAM)}
        parts |= {f"crf_{each}": with_depth & (crf == each) for each in CRFS}
        judged = {name: calibration(predicted[part], good[part], stands_for[part]) for name, part in parts.items()}
        for index, name in enumerate(RISK_GROUPS):
            judged[name] = calibration(predicted[group == index], good[group == index], stands_for[group == index])
        return judged


def calibration(predicted, good, stands_for):
    """Ten bins of equal width; the expected calibration error weighs them by the pixels that their samples stand for."""
    entry = np.minimum(predicted * 10, 9).astype(int)
    bins, error, worst = [], 0.0, 0.0
    for index in range(10):
        inside = entry == index
        n = int(inside.sum())
        if n == 0:
            continue
        weight = stands_for[inside]
        mean, share = float(np.average(predicted[inside], weights=weight)), float(np.average(good[inside], weights=weight))
        error += weight.sum() / stands_for.sum() * abs(mean - share)
        if n >= FEWEST_IN_BIN:
            worst = max(worst, abs(mean - share))
        bins.append({"predicted": round(mean, 4), "measured": round(share, 4), "n": n, "share": round(float(weight.sum() / stands_for.sum()), 4)})
    flagged, bad = predicted < 0.5, ~good
    return {"n": len(good), "good": round(float(np.average(good, weights=stands_for)), 4) if len(good) else None,
            "expected_calibration_error": round(float(error), 4), "worst_bin": round(worst, 4), "bins": bins,
            "precision_below_half": ratio(flagged & bad, flagged, stands_for), "recall_below_half": ratio(flagged & bad, bad, stands_for)}


def ratio(part, whole, weight):
    return round(float(weight[part].sum() / weight[whole].sum()), 4) if whole.any() else None


def header(models, provenance):
    def numbers(values, form, per_line):
        words = [form.format(value) for value in values]
        return ",\n          ".join(", ".join(words[i:i + per_line]) for i in range(0, len(words), per_line))

    def group(name, model):
        weights = numbers((float(w) for w in model.weights), "{:.6e}f", 6)
        shares = numbers(np.round(model.table * 255).astype(int), "{}", 24)
        return f"    // {name}\n    Group{{{{{weights}}},\n          {{{shares}}}}},"

    groups = "\n".join(group(name, model) for name, model in zip(RISK_GROUPS, models))
    told = "\n".join(textwrap.wrap(provenance, 120, initial_indent="/// ", subsequent_indent="/// "))
    return f"""#pragma once
/// Written by tests/study/reproject/fit_reliability.py: change it by running that.
{told}
#include <equistream_client/reliability.h>

#include <array>
#include <cstdint>

namespace equistream::reliability_model {{

inline constexpr int table_size = {TABLE_SIZE};
inline constexpr float entries_per_unit = {ENTRIES_PER_UNIT};

/// Weights of the risks, and the measured share of good pixels (in 1/255) by their weighted sum.
struct Group {{
    std::array<float, risk_count> weights;
    std::array<std::uint8_t, table_size> share_255;
}};

// clang-format off
inline constexpr std::array<Group, risk_group_count> groups{{{{
{groups}
}}}};
// clang-format on

}}  // namespace equistream::reliability_model
"""


def formatted(text):
    """What clang-format would not change; where it is not installed the test of the repository's formatting says the same."""
    program = shutil.which("clang-format-14")
    if program is None:
        return text
    done = subprocess.run([program, "--assume-filename", COEFFICIENTS], input=text, capture_output=True, text=True, check=True)
    if done.stdout != text:
        raise Failed(f"{COEFFICIENTS.name}: expected text in clang-format's own form, found lines that it would change")
    return text


def shipped():
    """What coefficients.h holds."""
    groups = re.findall(r"Group\{\{([^{}]*)\},\s*\{([^{}]*)\}\}", COEFFICIENTS.read_text(), flags=re.S)
    return [GroupModel(np.array([word.strip().rstrip("f") for word in weights.split(",")], np.float32),
                       np.array([int(word) for word in shares.split(",")]) / 255) for weights, shares in groups]


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
    parser.add_argument("--path-traced", type=pathlib.Path, help="what reliability_pairs.py --path-traced filled: judged, not fitted to")
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
    left_out, other_fits = {}, {}
    models = shipped()
    for index, scene in enumerate(samples.scenes):
        others = everything[everything != index]
        uncoded = samples.fit(others)
        left_out[scene] = {**samples.notes[scene], **samples.judge(uncoded, index)}
        other_fits[scene] = {"shipped": errors(samples.judge(models, index)),
                             "mixed": errors(samples.judge(samples.fit_to(np.full(len(samples.scene), True), others), index)),
                             "apart": errors(samples.judge(uncoded, index, samples.fit(others, streams=True)))}
        print(f"{scene} left out: good {left_out[scene]['all']['good']}, expected calibration error {errors(left_out[scene])}, {other_fits[scene]}", flush=True)
    path_traced = {}
    if options.path_traced is not None:
        checks = Samples(program, options.path_traced, np.random.default_rng(options.seed), options.pixels_per_shot, path_traced=True)
        for index, scene in enumerate(checks.scenes):
            others = np.array([i for i, name in enumerate(samples.scenes) if name != scene])
            path_traced[scene] = {**checks.notes[scene], **checks.judge(samples.fit(others), index)}
    if options.write:
        models = samples.fit(everything)
    words = ["--bin BIN --work WORK", *(["--path-traced WORK2"] if path_traced else []), f"--pixels-per-shot {options.pixels_per_shot}", f"--seed {options.seed}"]
    result = {"command": " ".join(["tests/study/reproject/fit_reliability.py", *words]),
              "made": time.strftime("%Y-%m-%d", time.gmtime()), "commit": commit(), "version": es.__version__, "machine": machine(),
              "tolerance_255": RELIABILITY_TOLERANCE, "noise_share": NOISE_SHARE, "fewest_in_bin": FEWEST_IN_BIN, "left_out": left_out, "other_fits": other_fits,
              "path_traced": path_traced,
              "weights": {name: dict(zip(RISKS, (round(float(w), 4) for w in model.weights))) for name, model in zip(RISK_GROUPS, models)}}
    write_whole(options.out, json.dumps(result, indent=1) + "\n")
    print(options.out)
    if options.write:
        provenance = f"{sum(note['pixels'] for note in samples.notes.values())} pixels of {', '.join(samples.scenes)}."
        write_whole(COEFFICIENTS, formatted(header(models, provenance)))
        print(COEFFICIENTS)


if __name__ == "__main__":
    run_as_program(main)
