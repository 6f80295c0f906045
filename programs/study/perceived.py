"""What numbers of single pictures do not say: FLIP (Andersson et al. 2020, by flip-evaluator) and flicker over time.

Flicker is the noise-free error (docs/compare.md) of the difference between one frame and the next: mean((dA1 - dT1)(dA2 - dT2)) of display values from 0 to
1, so that an error which stays, as blur does, counts nothing.
"""

import math

import equistream as es
import flip_evaluator
import numpy as np
from drawing import rgb
from found import decibels
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


def steps(folder):
    before = None
    for file in frames_of(folder):
        picture = display(file)
        if before is not None:
            yield picture - before
        before = picture


def flicker(runs):
    """Of one eye: [(views, truth), (views, truth)] of two seeds. Mean square, and in dB; nothing of a single frame, None dB where noise hides it."""
    products = [float(np.mean((a1 - t1) * (a2 - t2))) for a1, t1, a2, t2 in zip(*(steps(folder) for run in runs for folder in run))]
    if not products:
        return None
    mean = float(np.mean(products))
    return {"mean_square": mean, "db": decibels(mean)}


def perceived(folder, views, truths, focal_px):
    """Of both seeds' views and truths, by eye; FLIP against the truth of the other seed."""
    return {eye: {"flip": flip(folder / views[0] / eye, folder / truths[1] / eye, pixels_a_degree(focal_px)),
                  "flicker": flicker([(folder / view / eye, folder / truth / eye) for view, truth in zip(views, truths)])} for eye in EYES}
