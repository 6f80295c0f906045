#!/usr/bin/env python3
"""Sweeps every breaker over its knob with every method and scores what both eyes see.

    PYTHONPATH=build/release/package run.py --bin build/release/bin --out FOLDER [--all] [--check] [BREAKER ...]

Without --all the hardest value of each knob. --check compares with thresholds.json: what got worse, methods or what their maps knew, or has none, fails.
FOLDER gets run.json and table.txt; redraw.py makes thresholds of a run with --all.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import shutil
import sys
import tempfile

try:
    import chains
    from breakers import BREAKERS
    from by_play import SCORES_OF
except ImportError as missing:
    sys.exit(f"run.py: expected equistream's package and tests/requirements.txt (PYTHONPATH=BUILD/package), found no {missing.name}")

HERE = pathlib.Path(__file__).resolve().parent
THRESHOLDS = HERE / "thresholds.json"
SCORES = {"psnr_db": "dB over all", "worst_percent_db": "dB of the worst 1 %", "gaps_db": "dB in gaps",
          "flagged_recall": "share of bad pixels that the map flags", "flagged_precision": "share of flagged pixels that are bad",
          "failing_recall": "share of failing pixels that the map flags"}
FEWEST_BAD = 0.005
"""Below so small a share of bad pixels a handful decides what the map knew of them."""
# Rendering waits for files and processes; two at once keep two cores busy.
AT_ONCE = 2


def value_text(value):
    return f"{value:g}"


def measure(program, folder, breaker, value, kept=None):
    """Figures of one value; those that `kept`, a folder, has are not measured again."""
    file = kept and kept / f"{breaker.name} {value_text(value)}.json"
    if file and file.exists():
        return json.loads(file.read_text())
    figures = measured(program, folder, breaker, value)
    if file:
        aside = file.with_name(f"{file.stem}.{os.getpid()}.unfinished")
        aside.write_text(json.dumps(figures))
        aside.replace(file)
    return figures


def measured(program, folder, breaker, value):
    with tempfile.TemporaryDirectory(prefix=f"{breaker.name.replace(' ', '-')}-{value:g}-", dir=folder) as work:
        if breaker in SCORES_OF:
            return SCORES_OF[breaker](program, breaker, value, pathlib.Path(work))
        return chains.scores(chains.Renders(program, breaker, value, work))


def sweep(program, folder, breakers, every_value, kept=None):
    """Breaker -> value -> method -> figures. What fails or interrupts one begins no others."""
    jobs = {(breaker.name, value_text(value)): (breaker, value)
            for breaker in breakers for value in (breaker.values if every_value else breaker.few)}
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        found = {}
        try:
            waiting = {key: pool.submit(measure, program, folder, *job, kept) for key, job in jobs.items()}
            for (breaker, value), result in waiting.items():
                found.setdefault(breaker, {})[value] = result.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return found


def fails_enough(figures):
    """Of a method: for what the map knew of failing pixels to say anything, more of them than a handful, and than chance has it."""
    return figures["failing_share"] >= max(FEWEST_BAD, 2 * figures["failing_by_chance"])


def falls(values, by_value, method, loss_db):
    """The first value, from harmless to hard, at which a method is this far below that value's ceiling."""
    for value in values:
        figures = by_value.get(value_text(value))
        if figures and figures[method]["psnr_db"] < figures[chains.CEILING]["psnr_db"] - loss_db:
            return value_text(value)
    return None


def every_figure(file):
    """(found, seed) of a run with --all, or of the study's stability/generated.json, which is one with seed 1."""
    run = json.loads(file.read_text())
    if not run.get("settings", run)["every_value"]:
        sys.exit(f"{file}: expected a run of every value, found one without --all")
    if "found" in run:
        return run["found"], run["seed"]
    return {name: breaker["found"] for name, breaker in run["breakers"].items()}, chains.SEED["render"]


def table(found, breakers):
    lines = []
    for breaker in breakers:
        by_value = found[breaker.name]
        methods = list(next(iter(by_value.values())))
        lines += [f"{breaker.name}: {breaker.knob}; dB over all pixels of both eyes (worst 1 %)", "",
                  "".join(["value".rjust(8)] + [method.rjust(16) for method in methods])]
        for value, figures in by_value.items():
            cells = [f"{figures[m]['psnr_db']:.1f} ({figures[m]['worst_percent_db']:.1f})" for m in methods]
            lines.append("".join([value.rjust(8)] + [cell.rjust(16) for cell in cells]))
        for loss_db in (1, 3):
            firsts = [falls(breaker.values, by_value, m, loss_db) or "-" for m in methods]
            lines.append("".join([f"-{loss_db} dB at".rjust(8)] + [first.rjust(16) for first in firsts]))
        hardest = list(by_value.values())[-1]
        for score, words in (("flagged_recall", "of bad"), ("failing_recall", "of failing"), ("flagged_precision", "right")):
            known = [hardest[m].get(score) for m in methods]
            lines.append("".join(["flagged".rjust(8)] + [("-" if k is None else f"{100 * k:.0f} % {words}").rjust(16) for k in known]))
        lines.append("")
    return "\n".join(lines)


def checks_of(found):
    """What holds without any threshold: one line for each thing that does not."""
    wrong = []
    for method in chains.methods():
        # Moved by whole columns, the sphere has the same samples of everything.
        at = [figures[method]["psnr_db"] for value, figures in found.get("seam", {}).items()
              if (float(value) * chains.SPHERE_SIZE[0] / 360).is_integer()]
        if at and max(at) - min(at) > 0.3:
            wrong.append(f"seam, {method}: expected the same dB wherever the seam is, to 0.3, found {min(at)} to {max(at)}")
    return wrong


def losses(found, thresholds):
    """One line for each figure that fell below its threshold, and for each method that has none."""
    wrong = []
    for breaker, by_value in found.items():
        for value, by_method in by_value.items():
            for method, figures in by_method.items():
                least = thresholds.get(breaker, {}).get(value, {}).get(method)
                if least is None:
                    wrong.append(f"{breaker} {value}, {method}: expected a threshold, found none (redraw.py makes them)")
                    continue
                for score, bound in least.items():
                    if figures[score] is None or figures[score] < bound:
                        wrong.append(f"{breaker} {value}, {method}, {SCORES[score]}: expected at least {bound}, found {figures[score]}")
    return wrong


def every_breaker():
    return {breaker.name: breaker for breaker in (*BREAKERS, *SCORES_OF)}


def chosen(names):
    known = every_breaker()
    for name in names:
        if name not in known:
            sys.exit(f"run.py: expected a breaker of {', '.join(known)}, found '{name}'")
    return [known[name] for name in names] or list(known.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("breakers", nargs="*", help="all unless named")
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder for run.json and table.txt")
    parser.add_argument("--all", action="store_true", help="every value of each knob, not the hardest alone")
    parser.add_argument("--seed", type=int, default=1, help="of all renders (1)")
    parser.add_argument("--check", action="store_true", help="compare with thresholds.json")
    options = parser.parse_args()
    breakers = chosen(options.breakers)
    chains.SEED["render"] = options.seed
    options.out.mkdir(parents=True, exist_ok=True)
    work = pathlib.Path(tempfile.mkdtemp(prefix="equistream_stability_"))
    try:
        found = sweep(options.bin.resolve() / "equistream", work, breakers, options.all)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    knobs = {breaker.name: breaker.knob for breaker in breakers}
    (options.out / "run.json").write_text(json.dumps({"knobs": knobs, "seed": options.seed, "every_value": options.all, "found": found}, indent=1) + "\n")
    text = table(found, breakers)
    (options.out / "table.txt").write_text(text)
    print(text)
    if options.check:
        wrong = losses(found, json.loads(THRESHOLDS.read_text())["least"]) + checks_of(found)
        if wrong:
            sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
