"""How different pictures look side by side: FLIP (Andersson et al. 2020, by flip-evaluator)."""

import math

import equistream as es
import flip_evaluator
import numpy as np
from drawing import rgb
from render_list import EYES

FLIP_PICTURES = 2
"""Of each eye: the first frames."""


def pixels_a_degree(focal_px):
    """In a view's middle."""
    return focal_px * math.radians(1)


def display(file):
    """0 to 1, as the display shows it."""
    if file.suffix != ".exr":
        return rgb(file).astype(np.float32) / 255
    frame = es.read_frame(file, "colour")
    return es.to_display(frame["colour"], frame.info.exposure).astype(np.float32) / 255


def frames_of(folder):
    return sorted(file for file in folder.iterdir() if file.name.startswith("frame.") and file.suffix in (".png", ".exr"))


def flip(views, truth, density):
    """Mean over the pixels of the pictures, 0 where they look the same, by an eye that sees `density` pixels a degree."""
    pairs = list(zip(frames_of(views), frames_of(truth), strict=True))[:FLIP_PICTURES]
    found = [flip_evaluator.evaluate(display(true), display(view), "LDR", applyMagma=False, parameters={"ppd": density})[1] for view, true in pairs]
    return float(np.mean(found))


def perceived(folder, views, truths, focal_px):
    """Of the first seed's views and the other's truth, by eye."""
    return {eye: {"flip": flip(folder / views[0] / eye, folder / truths[1] / eye, pixels_a_degree(focal_px))} for eye in EYES}
