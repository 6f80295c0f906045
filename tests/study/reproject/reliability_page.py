#!/usr/bin/env python3
"""Writes the tables of docs/results/reproject/reliability.md, between its markers, from reliability.json beside it and nothing else."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from pages import cell, place, table  # noqa: E402

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "docs/results/reproject"


def percent(value, digits=1):
    return "-" if value is None else cell(100 * value, digits)


GROUPS = ("source", "coarse", "seen", "small", "guessed", "turned", "mirrored")


def share_off(judged):
    return percent(judged["expected_calibration_error"]) if judged["n"] else "-"


def scenes_table(left_out):
    """All kinds of source together."""
    rows = []
    for scene, judged in left_out.items():
        of = judged["all"]
        rows.append([scene, f"{of['n']:,}", percent(judged["left_out_for_noise"]), cell(judged["truth_off_references"]["mean_255"], 1), percent(of["good"]), share_off(of), share_off(judged["exact"]), percent(of["worst_bin"]),
                     percent(of["precision_below_half"]), percent(of["recall_below_half"]), percent(of["recall_at_60_percent"]),
                     percent(judged["uncovered"]["recall_at_60_percent"])])
    return table(["scene left out", "pixels", "too noisy %", "truth off by, of 255", "good %", "ECE, points", "ECE, exact depth", "worst bin", "precision %", "recall %", "recall at 60 %",
                  "recall at 60 %, uncovered"], rows)


KINDS = {"direct": "direct light", "direct_16": "CRF 16", "direct_24": "CRF 24", "rendered": "8 samples", "rendered_16": "CRF 16", "rendered_24": "CRF 24",
         "denoised": "denoised", "denoised_16": "CRF 16", "denoised_24": "CRF 24"}


def kinds_table(left_out, shipped):
    """ECE in points by kind of source: with the scene left out, and of the map as it is shipped."""
    rows = [[scene, *(f"{percent(judged[kind]['expected_calibration_error'])} / {percent(shipped[scene][kind])}" for kind in KINDS)] for scene, judged in left_out.items()]
    return table(["scene", *KINDS.values()], rows, 1)


def groups_table(left_out):
    """ECE in points (pixels) of each group alone."""
    rows = [[scene, *(f"{share_off(judged[group])} ({judged[group]['n']:,})" if judged[group]["n"] >= 100 else "-" for group in GROUPS)]
            for scene, judged in left_out.items()]
    return table(["scene left out", *GROUPS], rows)


def bins_table(left_out):
    """Predicted : measured, in per cent, of pixels with known depth."""
    rows = []
    for scene, judged in left_out.items():
        by_tenth = {min(int(entry["predicted"] * 10), 9): entry for entry in judged["all"]["bins"]}
        rows.append([scene] + ["-" if i not in by_tenth or by_tenth[i]["n"] < 100 else f"{100 * by_tenth[i]['predicted']:.0f} : {100 * by_tenth[i]['measured']:.0f}"
                               for i in range(10)])
    return table(["scene left out"] + [f"{10 * i}-{10 * (i + 1)}" for i in range(10)], rows)


def weights_table(weights):
    risks = list(next(iter(weights.values())))
    return table(["risk", *weights], [[risk] + [cell(weights[group][risk]) for group in weights] for risk in risks])


def main(folder=FOLDER):
    result = json.loads((folder / "reliability.json").read_text())
    file = folder / "reliability.md"
    page = file.read_text()
    left_out = result["left_out"]
    for name, text in (("scenes", scenes_table(left_out)), ("kinds", kinds_table(left_out, result["shipped"])), ("groups", groups_table(left_out)), ("bins", bins_table(left_out)),
                       ("weights", weights_table(result["weights"])),
                       ("made", f"`{result['command']}`, {result['made']}, commit {result['commit']}, {result['machine']['cpu']}, {result['machine']['cores']} cores.")):
        page = place(page, "reliability-" + name, "all", text)
    file.write_text(page)
    print(file)


if __name__ == "__main__":
    main(*map(pathlib.Path, sys.argv[1:]))
