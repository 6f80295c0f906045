"""Where each method breaks, and whether its reliability map knows: every breaker of tests/stability over its knob.

A method falls at the first value, from harmless to hard, at which it is 1 or 3 dB below that value's ceiling: a sphere at each eye's own place, turned.
"""

import sys

from scene_work import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests/stability"))
import run as breaking  # noqa: E402

LOSSES_DB = (1, 3)


def run(work):
    preset = work.preset
    breakers = breaking.chosen(preset.breakers)
    folder = work.folder / "runs"
    folder.mkdir(exist_ok=True)
    found = breaking.sweep(work.steps.program, folder, breakers, preset.every_value)
    return {"breakers": {breaker.name: described(breaker, found[breaker.name]) for breaker in breakers}}


def described(breaker, by_value):
    methods = list(next(iter(by_value.values())))
    return {"knob": breaker.knob, "scene": breaker.scene, "found": by_value,
            "falls": {method: {f"{loss:g}": breaking.falls(breaker.values, by_value, method, loss) for loss in LOSSES_DB} for method in methods}}
