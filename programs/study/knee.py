"""Where more of something stops helping."""

import math

CLOSE_DB = 0.1


def least_within(points, loss_db=CLOSE_DB):
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
