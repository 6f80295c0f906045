"""The noise-free error of `compare --second` (docs/compare.md), of one eye or of views together."""

import math


def decibels(mean_square):
    return -10 * math.log10(mean_square) if mean_square > 0 else None


def together(figures):
    """Of views as large as each other. One source's noise is in both eyes, so that intervals add rather than their squares."""
    pooled = {key: sum(figure[key] for figure in figures) / len(figures) for key in ("mean_square", "mean_square_low", "mean_square_high")}
    return {**pooled, "db": decibels(pooled["mean_square"]), "db_low": decibels(pooled["mean_square_high"]),
            "db_high": decibels(pooled["mean_square_low"]), "only_bounded": pooled["mean_square_low"] <= 0}


def gap_error(by_eye):
    """What lies in what the source did not see, and all of the error: linear mean squares of all eyes together. An eye without gaps says nothing of them."""
    eyes = by_eye.values()
    in_gaps = sum(eye["gaps"]["fraction"] * eye["gaps"]["noise_free"]["linear"]["mean_square"] for eye in eyes if "gaps" in eye)
    return max(0.0, in_gaps), sum(eye["noise_free"]["linear"]["mean_square"] for eye in eyes)
