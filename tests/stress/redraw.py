#!/usr/bin/env python3
"""Thresholds from a run: what was measured, less a margin for other processors' rounding. The only way to change them.

    redraw.py FILE.json           (run.json of run.py --all, or the study's stability/generated.json; breakers that it was not asked for keep theirs)
"""

import json
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "programs/study"))
from kept import result_text  # noqa: E402
from run import FEWEST_BAD, THRESHOLDS, every_breaker, every_figure, fails_enough  # noqa: E402

# The worst pixels and the gaps are few: a handful that fall the other way moves them more.
MARGIN_DB = {"psnr_db": 0.3, "worst_percent_db": 0.8, "gaps_db": 1.5}
KEPT_SHARE = 0.8
"""Of what the map knew: what it must go on knowing."""


def minima_of(figures):
    """Score -> threshold."""
    least = {score: round(figures[score] - margin, 2) for score, margin in MARGIN_DB.items() if figures[score] is not None}
    is_bad = figures["bad_share"] >= FEWEST_BAD
    # Flags set at random are right as often as pixels are bad.
    for score, counts, chance in (("flagged_recall", is_bad, 0), ("flagged_precision", is_bad, figures["bad_share"]),
                                  ("failing_recall", "failing_share" in figures and fails_enough(figures), 0)):
        bound = math.floor(1000 * KEPT_SHARE * (figures.get(score) or 0)) / 1000
        if counts and bound > chance:
            least[score] = bound
    return least


def main():
    if len(sys.argv) != 2:
        sys.exit("redraw.py: expected a run.json of run.py --all or a generated.json, found " + (" ".join(sys.argv[1:]) or "nothing"))
    found, _ = every_figure(pathlib.Path(sys.argv[1]))
    least = {breaker: {value: {method: minima_of(figures) for method, figures in by_method.items()} for value, by_method in by_value.items()}
             for breaker, by_value in found.items()}
    if THRESHOLDS.exists():
        kept = json.loads(THRESHOLDS.read_text())["least"]
        least = {name: kept[name] for name in kept if name in every_breaker()} | least
    THRESHOLDS.write_text(result_text({"made_by": "redraw.py", "margin_db": MARGIN_DB, "kept_share": KEPT_SHARE, "least": least}, lines=3))
    print(THRESHOLDS)


if __name__ == "__main__":
    main()
