"""Where each method breaks, and whether its reliability map knows: every breaker of tests/stress over its knob.

A method falls at the first value, from harmless to hard, at which it is 1 or 3 dB below that value's ceiling: a sphere at each eye's own place, turned.
"""

import shutil
import sys

from own_names import own_name
from scene_work import STRESS
from steps import Failed, digest

sys.path.insert(0, str(STRESS))
import run as breaking  # noqa: E402

LOSSES_DB = (1, 3)
CEILING, FEWEST_BAD, fails_enough = breaking.chains.CEILING, breaking.FEWEST_BAD, breaking.fails_enough


def run(work):
    preset = work.preset
    breakers = breaking.chosen(preset.breakers)
    # Of these programs and this code, so that what was interrupted goes on and nothing older is taken for it.
    made_by = f"{digest(work.steps.program.parent)[:12]}-{digest(STRESS, '*.py')[:12]}"
    own = own_name(work.folder, "runs.", r"\.unfinished", lambda left: shutil.rmtree(left, ignore_errors=True))
    folder, kept = work.folder / f"{own}.unfinished", work.folder / "values" / made_by
    for needed in (folder, kept):
        needed.mkdir(parents=True, exist_ok=True)
    try:
        found = breaking.sweep(work.steps.program, folder, breakers, preset.every_value, kept)
    except RuntimeError as error:
        raise Failed(str(error)) from None
    shutil.rmtree(folder, ignore_errors=True)
    return {"n": {"frames": 1, "seeds": 1}, "breakers": {breaker.name: described(breaker, found[breaker.name]) for breaker in breakers}}


def described(breaker, by_value):
    methods = list(next(iter(by_value.values())))
    return {"knob": breaker.knob, "scene": breaker.scene, "found": by_value,
            "falls": {method: {f"{loss:g}": breaking.falls(breaker.values, by_value, method, loss) for loss in LOSSES_DB} for method in methods}}
