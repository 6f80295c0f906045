#!/usr/bin/env python3
"""How far the figures of breakers hang on a seed: two runs of run.py with --all, each of a seed of its own; the study's is one with seed 1.

    two_seeds.py A.json B.json --bin build/release/bin --out FILE

For each breaker and method: whether it falls at the same value in both, else at neighbouring ones. And how far dB of the same value and method differ.
"""

import argparse
import pathlib
import statistics
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "programs/study")]
from kept import result_text  # noqa: E402
from chains import CEILING  # noqa: E402
from run import every_breaker, every_figure, falls, value_text  # noqa: E402
from steps import REPOSITORY, provenance, write_whole  # noqa: E402

LOSSES_DB = 1, 3
SCORES = {"psnr_db": 1, "worst_percent_db": 1, "gaps_db": 1, "flagged_recall": 100, "flagged_precision": 100}
"""And what each is multiplied by: dB, and points of a share."""


def falls_apart(breaker, one, other, method, loss_db):
    """How many values of the knob lie between where it falls in either run; a method that never falls, falls after the last."""
    order = [*map(value_text, breaker.values), None]
    first, second = (order.index(falls(breaker.values, found, method, loss_db)) for found in (one, other))
    return abs(first - second)


def compared(one, other):
    apart, differences = {loss: [] for loss in LOSSES_DB}, {score: [] for score in SCORES}
    moved = []
    for name, by_value in one.items():
        breaker = every_breaker()[name]
        for method in next(iter(by_value.values())):
            for loss in LOSSES_DB if method != CEILING else ():
                apart[loss].append(falls_apart(breaker, by_value, other[name], method, loss))
                if apart[loss][-1] > 0:
                    moved.append({"breaker": name, "method": method, "loss_db": loss, "values_apart": apart[loss][-1]})
            for value, by_method in by_value.items():
                for score, times in SCORES.items():
                    a, b = by_method[method].get(score), other[name][value][method].get(score)
                    if a is not None and b is not None:
                        differences[score].append(times * abs(a - b))
    return {"falls": {f"{loss:g}": {"in_all": len(each), "same_value": each.count(0), "next_value": each.count(1), "farther": sum(steps > 1 for steps in each)}
                      for loss, each in apart.items()},
            "differences": {score: {"count": len(each), "median": round(statistics.median(each), 3), "of_19_in_20": round(statistics.quantiles(each, n=20)[-1], 3),
                                    "largest": round(max(each), 3)} for score, each in differences.items()}, "moved": moved}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs=2, type=pathlib.Path, metavar="RUN.json")
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs that both ran")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    (first, seed), (second, other_seed) = map(every_figure, options.runs)
    if first.keys() != second.keys():
        sys.exit(f"two_seeds.py: expected runs of the same breakers, found {', '.join(sorted(first.keys() ^ second.keys()))} in one alone")
    if seed == other_seed:
        sys.exit(f"two_seeds.py: expected runs of two seeds, found both of {seed}")
    write_whole(options.out, result_text({**provenance(options.bin.resolve(), REPOSITORY), "seeds": [seed, other_seed], **compared(first, second)}))


if __name__ == "__main__":
    main()
