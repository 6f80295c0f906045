"""The breakers: which scene, which knob, which of its values, and what is done to the pictures on the way."""

import dataclasses
from typing import Callable, Optional

import numpy as np


@dataclasses.dataclass(frozen=True)
class Breaker:
    name: str
    scene: str
    knob: str
    """What the values are, with their unit."""
    values: tuple
    """From harmless to hard."""
    few: tuple
    """Those of every test run: the hardest, and what a rule compares with it. The label slow has all."""
    setting: Optional[Callable] = None
    """Options of the scene for a value; nothing where the knob is not the scene's."""
    samples: int = 16
    max_bounces: int = 0
    source_samples: Optional[Callable] = None
    """Of the sphere for a value; a quarter of the truth's where the knob is not that."""
    damage: Optional[Callable] = None
    """Of a depth plane (depth_m, box_radius_m, value) -> (depth_m, tolerance of w)."""
    coding: Optional[Callable] = None
    """Options of `encode` for a value: the source's colour and depth come through a stream. The eye's own depth, which `eye-depth` and the
    paper's method take, and the small view's stay exact."""
    truth_head: Optional[Callable] = None
    """Where the head really is for a value: metres beside the scene's path, and degrees turned to the left."""
    believed_head: Optional[Callable] = None
    """Where the client takes it to be; nothing where it knows."""
    mirrors: bool = False
    """Pixels of mirrors and glass are looked up by virtual depth; otherwise methods are on their own."""


def knob(name):
    return lambda value, focal_px: [f"{name}={value:g}"]


def wires(value, focal_px):
    return [f"width_px={value:g}", f"focal_px={focal_px:g}"]


def at_arm_length(value, focal_px):
    return ["distance_m=0.4"]


def aside(value):
    """Right, up and ahead at once."""
    return (value * 0.8, value * 0.36, -value * 0.48), 0


def turned(value):
    return (0, 0, 0), value


def coarse(depth_m, box_radius_m, bits):
    """w = B / (r - B) in equal steps from 0 at infinity to its largest value; the nearest step is taken."""
    w = box_radius_m / np.maximum(depth_m - box_radius_m, 1e-9)
    largest = float(w.max())
    step = largest / (2 ** bits - 1)
    coded = np.round(w / step) * step
    with np.errstate(divide="ignore"):
        return (box_radius_m + box_radius_m / coded).astype(np.float32), step / 2


def coded(code):
    return lambda crf: ["--depth", code, "--depth-crf", crf, "--crf", 12]


BREAKERS = (
    Breaker("leaf", "leaf", "distance of the leaf from the left eye, m", (1, 0.5, 0.3, 0.2, 0.15, 0.1, 0.06, 0.04), (0.06,),
            knob("distance_m")),
    Breaker("near", "near", "distance of the ball, m", (1.5, 1, 0.6, 0.4, 0.3, 0.2, 0.15, 0.1), (0.1,), knob("distance_m")),
    Breaker("poles", "poles", "pitch of the head, degrees up and (below 0) down", (0, 30, -30, 45, -45, 60, -60, 75, -75, 85, -85, 90, -90),
            (90, -90), knob("pitch_deg")),
    Breaker("seam", "seam", "from the seam to the ball, degrees", (180, 90, 45, 10, 3, 0.3, 0), (90, 0), knob("offset_deg")),
    Breaker("wires", "wires", "width of a wire, pixels", (8, 4, 2, 1.5, 1, 0.7, 0.5, 0.25), (0.5,), wires),
    Breaker("mirror", "mirror", "from the mirror to what it reflects, m", (0.5, 0.7, 1, 1.5, 2, 2.5, 2.9), (2.9,), knob("behind_m"),
            max_bounces=2),
    Breaker("glass", "glass", "from the pane to what is behind it, m", (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2), (2,), knob("behind_m"),
            max_bounces=2, samples=64),
    Breaker("mirror image", "mirror", "from the mirror to what it reflects, m", (0.5, 0.7, 1, 1.5, 2, 2.5, 2.9), (2.9,),
            knob("behind_m"), max_bounces=2, mirrors=True),
    Breaker("pane image", "glass", "from the pane to what is behind it, m", (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2), (2,),
            knob("behind_m"), max_bounces=2, samples=64, mirrors=True),
    Breaker("coarse depth", "near", "bits of w", (12, 10, 8, 7, 6, 5, 4, 3, 2), (3,), at_arm_length, damage=coarse),
    Breaker("coded depth", "near", "CRF of the track of w in 10 bits", (0, 8, 16, 24, 32, 40, 51), (51,), at_arm_length, coding=coded("w10")),
    Breaker("inside", "inside", "of the head's centre in a block, m", (-0.2, -0.1, -0.05, -0.02, 0, 0.02, 0.05, 0.1), (0.05,), knob("depth_m")),
    Breaker("grazing", "grazing", "of the eyes above ground to the horizon, m", (1.6, 0.8, 0.4, 0.2, 0.1, 0.05, 0.02), (0.05,), knob("height_m")),
    Breaker("sky", "sky", "distance of a railing before the sky, m", (20, 5, 2, 1, 0.5, 0.3, 0.2, 0.1), (0.2,), knob("distance_m")),
    Breaker("beyond the box", "near", "of the head beside the sphere's centre, m; the box ends at 0", (0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8),
            (0.4,), at_arm_length, truth_head=aside, believed_head=aside),
    Breaker("fast head", "near", "by which the head's pose is told wrong, degrees", (0, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2), (1,), at_arm_length,
            truth_head=turned),
    Breaker("noise", "materials", "samples a pixel of the sphere", (64, 32, 16, 8, 4, 2, 1), (1,), max_bounces=4, samples=128, source_samples=int,
            mirrors=True),
    Breaker("packed depth", "near", "CRF of Pece's packing, 4:2:0", (0, 8, 16, 24, 32, 40, 51), (51,), at_arm_length, coding=coded("pece420")),
)
