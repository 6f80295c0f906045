"""Curves of accuracy against bytes: Bjontegaard's averages between two of them, where one reaches another, and where more of something stops helping.

BD-rate is by PyPI's bjontegaard (Akima over log bytes, ITU-T's); only over the decibels that both curves have, where those are enough to say something.
"""

import math

import bjontegaard
import numpy as np
from scipy.interpolate import PchipInterpolator

FEWEST_POINTS = 4
LEAST_SHARED_DB, LEAST_SHARED_TIMES = 1, 2
"""Of accuracy, and of bytes, that both curves have."""


def curve(points):
    """(bytes, dB) by ascending bytes, without those that more bytes made no better: a curve must rise."""
    rising = []
    for count, db in sorted(points):
        if not rising or db > rising[-1][1]:
            rising.append((count, db))
    return rising


def shared(a, b, axis):
    """The range of bytes (0) or dB (1) that both curves have."""
    return max(a[0][axis], b[0][axis]), min(a[-1][axis], b[-1][axis])


def bd_rate_percent(anchor, tested):
    """How many per cent more bytes `tested` takes for the same dB; None without enough points, or where less than LEAST_SHARED_DB is on both curves."""
    a, b = curve(anchor), curve(tested)
    if min(len(a), len(b)) < FEWEST_POINTS:
        return None
    low, high = shared(a, b, 1)
    if high - low < LEAST_SHARED_DB:
        return None
    return float(bjontegaard.bd_rate(*zip(*a), *zip(*b), method="akima", require_matching_points=False, min_overlap=0))


def bd_db(anchor, tested):
    """How many dB more `tested` has for the same bytes; None without enough points, or where the most bytes that both curves have are less than LEAST_SHARED_TIMES the least."""
    a, b = curve(anchor), curve(tested)
    if min(len(a), len(b)) < FEWEST_POINTS:
        return None
    low, high = shared(a, b, 0)
    if high < LEAST_SHARED_TIMES * low:
        return None
    return float(bjontegaard.bd_psnr(*zip(*a), *zip(*b), method="akima", require_matching_points=False, min_overlap=0))


def bytes_for(points, db):
    """Of a curve, at this many dB; None where it does not come to them, however many bytes it takes, or has more at its fewest."""
    rising = curve(points)
    if len(rising) < 2 or not rising[0][1] <= db <= rising[-1][1]:
        return None
    return math.exp(float(PchipInterpolator([d for _, d in rising], np.log([count for count, _ in rising]))(db)))


def fewest_bytes(curves, db):
    """Of all curves, {name: points}, that come to this many dB: (bytes, name, at_most), the last where a curve has more even at its fewest; Nones where none does."""
    found = []
    for name, points in curves.items():
        if (count := bytes_for(points, db)) is not None:
            found.append((count, name, False))
        elif points and (least := min(points))[1] > db:
            found.append((least[0], name, True))
    return min(found, default=(None, None, None))


def crossing(xs, ys, level):
    """The least x at which y reaches `level`, on a log scale between the points; the first x where y has as much there; None where it never does. Ascending xs."""
    for i, (x, y) in enumerate(zip(xs, ys)):
        if y is None or y < level:
            continue
        if i == 0 or ys[i - 1] is None:
            return float(x)
        before_x, before_y = xs[i - 1], ys[i - 1]
        share = (level - before_y) / (y - before_y)
        return float(math.exp(math.log(before_x) + share * (math.log(x) - math.log(before_x))))
    return None


CLOSE_DB = 0.1


def cheapest_within(points, loss_db=CLOSE_DB):
    """The least cost whose accuracy, and that of everything dearer, is at most `loss_db` below the dearest's. (cost, dB) in any order."""
    dearest_first = sorted(points, reverse=True)
    found, level = dearest_first[0]
    for cost, db in dearest_first[1:]:
        if db < level - loss_db:
            break
        found = cost
    return found


def knee(points):
    """The point farthest above the chord from the cheapest to the dearest, both axes scaled to 1, costs by their logarithm (Satopaa et al. 2011)."""
    rising = sorted(points)
    (low, low_db), (high, high_db) = rising[0], rising[-1]
    best_db = max(db for _, db in rising)
    if len(rising) < 3 or best_db <= low_db:
        return rising[0][0]
    span, height = math.log(high / low), best_db - low_db
    return max(rising, key=lambda point: (point[1] - low_db) / height - math.log(point[0] / low) / span)[0]
