"""From a handful of measurements to the least that has the accuracy wanted. How things are measured, nobody here knows.

Accuracy is taken to fall with the CRF and to rise with the width; bytes for one accuracy to have one valley over the width.
"""

import math
import statistics

from scipy.interpolate import PchipInterpolator
from scipy.stats import t as student

BEST_CRF, WORST_CRF = 4, 44
DB_A_CRF = 0.4
"""How much a step of the CRF is thought to lose before two were measured."""
CLOSE_DB = 0.1
"""What is not worth paying for."""
FEWEST_SEEDS, MEAN_DB = 3, 0.15
"""A mean over seeds is taken from so many on, and known where half of its 95 % interval is no wider."""


def last_holding(values, holds, start=0):
    """The last of `values` that holds, where each holds if the next does; None where the first does not. Looks at values[start] first."""
    if not holds(values[start]):
        return next((value for value in reversed(values[:start]) if holds(value)), None)
    while start + 1 < len(values) and holds(values[start + 1]):
        start += 1
    return values[start]


def highest(value_at, start, step, close, ends):
    """(level, value_at(level)) of the highest level that has a value, to within `close`. Where a level has none, no higher one has. Looks at `start` first,
    then goes on in growing steps. None where the lowest has none."""
    low, high = ends
    good, level = None, min(max(start, low), high)
    bad = None
    while True:
        value = value_at(level)
        if value is None:
            bad = level
        else:
            good = level, value
        if (bad is None and level == high) or (good is None and level == low):
            return good
        if good and bad is not None:
            if bad - good[0] <= close:
                return good
            level = (good[0] + bad) / 2
        else:
            level = min(high, level + step) if good else max(low, level - step)
            step *= 2


def guess(known, level):
    """The CRF at which a smooth curve through those measured meets the level; beyond them, the line through the two nearest. None where that does not fall."""
    falling = sorted({db: crf for crf, db in known.items()}.items())
    if len(falling) > 2 and falling[0][0] <= level <= falling[-1][0]:
        return math.floor(float(PchipInterpolator(*zip(*falling))(level)) + 0.5)
    near = sorted(known, key=lambda crf: abs(known[crf] - level))
    slope = (known[near[0]] - known[near[1]]) / (near[1] - near[0]) if len(near) > 1 else DB_A_CRF
    return math.floor(near[0] + (known[near[0]] - level) / slope) if slope > 0 else None


def coarsest_crf(db_of, level, start):
    """The largest CRF that keeps `level`, or one that keeps less than CLOSE_DB more than that; None where even the best does not."""
    known, good, bad = {}, BEST_CRF - 1, WORST_CRF + 1
    crf = start
    while True:
        known[crf] = db_of(crf)
        if known[crf] >= level:
            good = crf
            if known[crf] < level + CLOSE_DB:
                break
        else:
            bad = crf
        if bad - good <= 1:
            break
        crf, middle = guess(known, level), (good + bad) // 2
        is_open = good not in known or bad not in known
        crf = middle if crf is None or not (is_open or good <= crf <= bad) else min(max(crf, good + 1), bad - 1)
    return good if good in known else None


def cheapest(values, best_at):
    """Of best_at(value), which is (cost, what costs it) or None where there is none, the cheapest: from the first value on, until costs rise."""
    found = None
    for value in values:
        here = best_at(value)
        if here is None:
            continue
        if found is not None and here[0] >= found[0]:
            break
        found = here
    return found


def mean_is_known(levels):
    """Of one thing's, by seeds: whether more of them are not needed. None: the truths' noise hides the level, and no more seeds will tell."""
    count = len(levels)
    if count < FEWEST_SEEDS:
        return False
    return None in levels or float(student.ppf(0.975, count - 1)) * statistics.stdev(levels) / math.sqrt(count) <= MEAN_DB


def is_worth(gain_db, times, times_by_coding):
    """Whether what makes streams `times` as large gains accuracy that finer coding does not have for less; None: finer coding does not have it at all."""
    return gain_db >= CLOSE_DB and (times_by_coding is None or times < times_by_coding)


def max_gain_db(share):
    """By mending what makes up this share of the error."""
    return -10 * math.log10(1 - share) if share < 1 else math.inf


def cheapest_over(frames, each):
    """Of {name: (bytes once, bytes a frame)} the name that sends least over so many frames."""
    return min(each, key=lambda name: each[name][0] + frames * each[name][1])
