"""The model of client/confidence: how it is fitted to pixels, judged by others and written as its coefficients.h."""

import pathlib
import re
import shutil
import subprocess
import textwrap

import numpy as np
from equistream.reprojection import RISK_GROUPS
from scipy.optimize import isotonic_regression, minimize

from steps import Failed

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
COEFFICIENTS = REPOSITORY / "client/confidence/coefficients.h"
ENTRIES_PER_UNIT, TABLE_SIZE = 16, 256
FEWEST_IN_BIN = 500
RIDGE = 1e-4
LOSS_CURVE = 0.3  # of risks.glsl.h


class GroupModel:
    """Weights of the risks and the table from their weighted sum to the share of good pixels."""

    def __init__(self, weights, table):
        self.weights, self.table = weights, table

    def reliability(self, risks):
        entry = np.minimum(risks @ self.weights * ENTRIES_PER_UNIT, TABLE_SIZE - 1).astype(int)
        return self.table[entry]


def kept_share(lost):
    """risks.glsl.h"""
    return (1 - lost) * (1 - LOSS_CURVE * lost)


def fit_group(risks, good, kept, weight):
    """Of pixels that would be good with some probability by their risks, and `kept` times as often by what the source lost."""
    if len(risks) == 0:
        raise Failed("a group of pixels without any sample: expected shots of every kind (see reliability_pairs.py)")
    risks = risks.astype(np.float64)

    def loss(parameters):
        probability = 1 / (1 + np.exp(np.clip(risks @ parameters[1:] - parameters[0], -50, 50)))
        fails = np.maximum(1 - kept * probability, 1e-12)
        value = -np.sum(weight * np.log(np.where(good, kept * probability, fails))) + RIDGE * np.sum(parameters[1:] ** 2)
        slope = weight * (1 - probability) * np.where(good, -1, kept * probability / fails)
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
    return GroupModel(weights, calibrated(risks @ weights.astype(np.float64), good, kept * weight, weight))


def calibrated(sums, good, kept_weight, weight):
    entry = np.minimum(sums * ENTRIES_PER_UNIT, TABLE_SIZE - 1).astype(int)
    mass = np.bincount(entry, kept_weight, TABLE_SIZE)
    share = np.minimum(np.bincount(entry, weight * good, TABLE_SIZE) / np.maximum(mass, 1e-300), 1)
    known = mass > 0
    falling = isotonic_regression(share[known], weights=mass[known], increasing=False).x
    # Between known entries straight lines; rounded as the header stores it.
    return np.round(np.interp(np.arange(TABLE_SIZE), np.flatnonzero(known), falling) * 255) / 255


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
            "precision_below_half": ratio(flagged & bad, flagged, stands_for), "recall_below_half": ratio(flagged & bad, bad, stands_for),
            "recall_at_60_percent": recall_at(0.6, predicted, bad, stands_for)}


def recall_at(precision, predicted, bad, stands_for):
    """The largest share of bad pixels that any threshold flags while so many of the flagged are bad; nothing where none is bad."""
    if not bad.any():
        return None
    order = np.argsort(predicted, kind="stable")
    flagged, found = np.cumsum(stands_for[order]), np.cumsum((stands_for * bad)[order])
    last = np.append(np.diff(predicted[order]) > 0, True)  # pixels of one prediction are flagged together
    precise = last & (found >= precision * flagged)
    return round(float((found[precise] / found[-1]).max(initial=0)), 4)


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
#include "reliability.h"

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
