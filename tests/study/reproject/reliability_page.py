#!/usr/bin/env python3
"""Writes the tables of docs/results/reproject/reliability.md, between its markers, from reliability.json and confidence.json beside it and nothing else."""

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
    """Of pixels that went through no codec."""
    rows = []
    for scene, judged in left_out.items():
        of = judged["uncoded"]
        rows.append([scene, f"{of['n']:,}", percent(judged["left_out_for_noise"]), percent(of["good"]), share_off(of), share_off(judged["exact"]),
                     percent(of["worst_bin"]), percent(of["precision_below_half"]), percent(of["recall_below_half"])])
    return table(["scene left out", "pixels", "too noisy %", "good %", "ECE, points", "ECE, exact depth", "worst bin", "precision %", "recall %"], rows)


def coded_table(left_out):
    """ECE in points, and predicted -> measured share of good pixels, with and without a codec."""
    def told(judged):
        predicted = sum(entry["predicted"] * entry["share"] for entry in judged["bins"])
        return f"{share_off(judged)} ({100 * predicted:.0f} : {100 * judged['good']:.0f})"

    parts = {"uncoded": "no codec", "crf_16": "CRF 16", "crf_24": "CRF 24"}
    return table(["scene left out", *parts.values()], [[scene, *(told(judged[part]) for part in parts)] for scene, judged in left_out.items()])


def fits_table(left_out, uncoded_fit):
    """ECE in points by what a map was fitted to."""
    parts = {"uncoded": "no codec", "crf_16": "CRF 16", "crf_24": "CRF 24"}
    rows = [[scene, *(error for part in parts for error in (percent(uncoded_fit[scene][part]), share_off(judged[part])))]
            for scene, judged in left_out.items()]
    return table(["scene left out", *(f"{name}, {fitted}" for name in parts.values() for fitted in ("uncoded fit", "one map"))], rows)


def groups_table(left_out):
    """ECE in points (pixels) of each group alone."""
    rows = [[scene, *(f"{share_off(judged[group])} ({judged[group]['n']:,})" if judged[group]["n"] >= 100 else "-" for group in GROUPS)]
            for scene, judged in left_out.items()]
    return table(["scene left out", *GROUPS], rows)


def bins_table(left_out):
    """Predicted -> measured, in per cent, of pixels with known depth that went through no codec."""
    rows = []
    for scene, judged in left_out.items():
        by_tenth = {min(int(entry["predicted"] * 10), 9): entry for entry in judged["uncoded"]["bins"]}
        rows.append([scene] + ["-" if i not in by_tenth or by_tenth[i]["n"] < 100 else f"{100 * by_tenth[i]['predicted']:.0f} : {100 * by_tenth[i]['measured']:.0f}"
                               for i in range(10)])
    return table(["scene left out"] + [f"{10 * i}-{10 * (i + 1)}" for i in range(10)], rows)


def weights_table(weights):
    risks = list(next(iter(weights.values())))
    return table(["risk", *weights], [[risk] + [cell(weights[group][risk]) for group in weights] for risk in risks])


def path_traced_table(scenes):
    """ECE in points by references, and by coding alone where that is told, by kind of source."""
    kinds = {"clean": "clean", "rendered": "8 samples", "rendered_16": "CRF 16", "rendered_24": "CRF 24", "denoised": "denoised", "denoised_16": "denoised, CRF 16",
             "denoised_24": "denoised, CRF 24"}

    def points(kind, told):
        by_references, by_coding = (percent(told[telling]["expected_calibration_error"]) for telling in ("by references", "by coding"))
        return by_references if kind == "clean" else f"{by_references} / {by_coding}"

    return table(["scene", *kinds.values()], [[name, *(points(kind, scene["kinds"][kind]) for kind in kinds)] for name, scene in scenes.items()], 1)


def uncovered_table(scenes):
    rows = []
    for name, scene in scenes.items():
        of = scene["uncovered"]
        rows.append([name, f"{scene['shots']}", percent(scene["left_out_for_noise"]), f"{scene['truth_off_references']['mean_255']:.1f}", f"{of['n']:,}", percent(1 - of["good"]), share_off(of),
                     percent(of["recall_at_60_percent"]), percent(of["precision_below_half"]), percent(of["recall_below_half"])])
    return table(["scene", "shots", "too noisy %", "truth off by, of 255", "uncovered pixels", "bad %", "ECE, points", "recall at 60 %", "precision below one half %", "recall below one half %"],
                 rows, 1)


def made(result):
    commit = result.get("commit") or result["versions"]["commit"]
    return f"`{result['command']}`, {result['made']}, commit {commit}, {result['machine']['cpu']}, {result['machine']['cores']} cores."


def main(folder=FOLDER):
    result, seen = (json.loads((folder / f"{name}.json").read_text()) for name in ("reliability", "confidence"))
    file = folder / "reliability.md"
    page = file.read_text()
    left_out = result["left_out"]
    for name, text in (("scenes", scenes_table(left_out)), ("coded", coded_table(left_out)), ("fits", fits_table(left_out, result["uncoded_fit"])),
                       ("groups", groups_table(left_out)), ("bins", bins_table(left_out)),
                       ("path-traced", path_traced_table(seen["scenes"])), ("uncovered", uncovered_table(seen["scenes"])), ("path-traced-made", made(seen)),
                       ("weights", weights_table(result["weights"])),
                       ("made", made(result))):
        page = place(page, "reliability-" + name, "all", text)
    file.write_text(page)
    print(file)


if __name__ == "__main__":
    main(*map(pathlib.Path, sys.argv[1:]))
