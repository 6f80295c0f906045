"""Picking points of a result of experiments/related.py, and their curves."""

from found import db

ANCHOR, DEFAULT_SEARCH = "e", "hex 16"
"""Layout and motion search that the others are put beside."""
SECOND_EYE = {"direct": "coded itself", "together": "in one stream with the first eye", "difference": "as a difference from what is reprojected"}
"""Ways to send it; the first is what the others are put beside."""


def of(points, **wanted):
    return [point for point in points if all(point[key] == value for key, value in wanted.items())]


def curve(points, eye):
    """(bytes a frame, dB) of what was coded."""
    return [(point["bytes_a_frame"], level) for point in points if point["crf"] is not None and (level := db(point, eye)) is not None]


def beside(points, keys, key, value):
    """(point, the point with `value` for `key` that has the same `keys`)."""
    for point in points:
        yield point, next(other for other in of(points, **{name: point[name] for name in keys}) if other[key] == value)
