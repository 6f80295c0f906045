#!/usr/bin/env python3
"""Writes the tables of docs/results/trust.md from docs/results/trust/*.json, which other programs measure; each table's text names its command.

    trust.py [PAGE]      the JSON lies in the folder beside it
"""

import collections
import json
import math
import pathlib
import statistics
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from pages import place, table  # noqa: E402
from steps import write_whole  # noqa: E402

PAGE = REPOSITORY / "docs/results/trust.md"


def share(part, whole):
    return f"{100 * part / whole:.0f} %" if whole else "-"


def fuzz(report):
    parsers = report["parsers"]
    rows = []
    for name, figures in report["targets"].items():
        lines = [report["lines"][file] for file in parsers[name]]
        reached, of = (sum(each[i] for each in lines) for i in (0, 1))
        rows.append([f"`{name}`", f"{figures['executions']:,}", f"{figures['seconds'] / 60:.0f}", "yes" if figures["found"] else "none", f"{reached:,} of {of:,}", share(reached, of)])
    reached, of = (sum(each[i] for each in report["lines"].values()) for i in (0, 1))
    rows.append(["all", f"{sum(each['executions'] for each in report['targets'].values()):,}", f"{sum(each['seconds'] for each in report['targets'].values()) / 60:.0f}",
                 "", f"{reached:,} of {of:,}", share(reached, of)])
    return table(["target", "executions", "minutes", "finds", "lines of its readers", "reached"], rows, 1)


def kills(report):
    rows = [[name, str(job["kills"]), f"{job['finished_files_checked']:,}", str(job["resumed_to_the_end"]), f"{job['seconds_uninterrupted']:.1f}"]
            for name, job in report["jobs"].items()]
    return table(["job", "kills", "finished files compared", "went on to the end", "seconds uninterrupted"], rows, 1)


def promises(report):
    def db(value):
        return "-" if value is None else f"{value:.2f}"

    rows = [[name, f"{each['wanted_db']}", db(each["promised_db"]), db(each["found_db"]), str(len(each['found_each'])), f"{db(min(each['found_each']))} to {db(max(each['found_each']))}", f"{each['found_db'] - each['promised_db']:+.2f}"]
            for name, scene in report["scenes"].items() for each in scene["promises"]]
    return table(["scene", "asked for, dB", "promised", "found", "seeds", "each alone", "difference"], rows, 1)


def mutations(report):
    folders = collections.defaultdict(collections.Counter)
    for change in (each for each in report["changes"] if each["verdict"] != "no program"):
        kind = "equivalent" if "equivalent" in change else change["verdict"].replace("in no test", "survived")
        folders["/".join(change["file"].split("/")[:2])][kind] += 1
        folders["all"][kind] += 1
    rows = [[folder, *(str(counts[kind]) for kind in ("found", "survived", "equivalent")), share(counts["found"], counts["found"] + counts["survived"])]
            for folder, counts in sorted(folders.items(), key=lambda item: (item[0] == "all", item[0]))]
    return table(["folder", "found", "survived", "cannot matter", "share found"], rows, 1)


def memory(report):
    rows = [[f"`{name}`", f"{each['seconds']:,.0f}", f"{each['samples']:,}", f"{each['resident_kb'] / 1000:.1f}", f"{each['growth_kb'] / 1000:+.1f}",
             str(each["descriptors"]), f"{each['descriptor_growth']:+}"] for name, each in report["programs"].items()]
    return table(["program", "seconds", "samples", "resident, MB", "growth, MB", "descriptors", "more of them"], rows, 1)


def pressure(report):
    rows = [[served, name, f"{each['blocks']:,}", f"{each['connections']:,}", f"{each['sent_mb']:.1f}", f"{round(100 * each['slower'], 2) + 0:.2f}", f"{each['latest_ms']:.1f}"]
            for served, kind in (("recorded", "pressures"), ("live", "live")) for name, each in report.get(kind, {}).items()]
    return table(["stream", "beside the viewer", "blocks of 32 KiB, or spheres", "connections", "sent, MB", "slower, %", "latest, ms later"], rows, 2)


def foreign(report):
    kinds = report["kinds"]
    rows = [[name, str(sum(row.get(said, 0) for said in ("read", "refused", "fault"))), *(str(row.get(what, 0)) for what in ("read", "right", "other", "refused", "fault"))]
            for name, row in kinds.items()]
    return table(["files", "in all", "read", "same by another reader", "otherwise", "refused in one line", "faults"], rows, 1)


def luxcore(report):
    rows = [["depth within the range of the nine pixels around", f"{100 * report['depth_between_neighbours']:.3f} %"], ["albedo within 0.01", f"{100 * report['albedo_alike']:.3f} %"],
            ["normals within 2.6 degrees", f"{100 * report['normals_alike']:.3f} %"], [f"hits and misses ({report['misses']:,}) alike", f"{100 * report['misses_alike']:.3f} %"],
            ["mean light, red, green, blue, of ours", ", ".join(f"{ratio:.4f}" for ratio in report["mean_light_ratio_rgb"])]]
    return table(["a sphere by LuxCore " + report["luxcore"], f"of {report['pixels']:,} pixels"], rows, 1)


def mitsuba_own(report):
    files = {"flat": "perspective", "sphere": "sphere", "defaults": "perspective, Mitsuba's default film",
             "planes_of_one_sample": "perspective, planes of one sample", "path_alone": "`path` alone"}
    found = [report["files"][name] for name in files]

    def row(name, text):
        return [name, *(text(each) if "pixels" in each else "-" for each in found)]

    def percent(key):
        return lambda each: f"{100 * each[key]:.3f} %"

    rows = [row("pixels", lambda each: f"{each['pixels']:,}"), row("depth within the range of the nine pixels around", percent("depth_between_neighbours")),
            row("median difference of depth", lambda each: f"{100 * each['depth_off_p50']:.3f} %"), row("albedo within 0.01", percent("albedo_alike")),
            row("normals within 2.6 degrees", percent("normals_alike")), row("ids alike", percent("ids_alike")), row("hits and misses alike", percent("misses_alike")),
            row("mean light, red, green, blue, of ours", lambda each: ", ".join(f"{ratio:.4f}" for ratio in each["mean_light_ratio_rgb"])),
            row("beside the sky, too near", lambda each: f"{each['beside_sky_too_near']:,} of {each['beside_sky']:,}"),
            ["colour as in Mitsuba's file", *(f"{100 * each['colour_equal']:.0f} %" for each in found)]]
    return table(["files by Mitsuba " + report["mitsuba"], *files.values()], rows, 1)


def places(report):
    """Whole errors in dB, uncoded and coded, at each place; and how far two systems lie apart there, which is what methods are chosen by."""
    rows = []
    for scene, found in report["scenes"].items():
        by_place = [{(entry["system"], entry["crf"]): entry["whole"] for entry in place["entries"]} for place in found["places"]]
        for system, crf in by_place[0]:
            each = [place[system, crf] for place in by_place]
            beside = [place[system, crf]["db"] - place["centre", crf]["db"] for place in by_place]
            half = max((figures["db_high"] - figures["db_low"]) / 2 for figures in each)
            rows.append([scene, system, "uncoded" if crf is None else f"CRF {crf:g}", *(f"{figures['db']:.2f}" for figures in each), f"{half:.2f}",
                         another([figures["db"] for figures in each]), *(f"{difference:+.2f}" for difference in beside), another(beside, "+")])
    return table(["scene", "system", "coding", "first place, dB", "second", "third", "known within", "a fourth place", "first, beside `centre`", "second", "third",
                  "a fourth place"], rows, 3)


def another(values, sign=""):
    """What another place would say in 19 cases of 20, if places are distributed normally: mean and half the prediction interval, by Student's t."""
    if max(values) == min(values):
        return ""
    quantile = {2: 12.706, 3: 4.303, 4: 3.182, 5: 2.776}[len(values)]
    half = quantile * statistics.stdev(values) * math.sqrt(1 + 1 / len(values))
    return f"{round(statistics.mean(values), 1) + 0:{sign}.1f} ± {half:.1f}"


def breakers(report):
    rows = [[f"falls by {loss} dB", f"{each['in_all']:,}", f"{each['same_value']:,}", f"{each['next_value']:,}", f"{each['farther']:,}"] for loss, each in report["falls"].items()]
    return table(["", "breakers and methods", "at the same value with both seeds", "at the next value", "farther apart"], rows, 1)


def differences(report):
    names = {"psnr_db": "dB over all", "worst_percent_db": "dB of the worst 1 %", "gaps_db": "dB in gaps", "flagged_recall": "bad pixels that the map flags, points",
             "flagged_precision": "flagged pixels that are bad, points"}
    rows = [[names[score], f"{each['count']:,}", f"{each['median']:.2f}", f"{each['of_19_in_20']:.2f}", f"{each['largest']:.2f}"] for score, each in report["differences"].items()]
    return table(["one seed beside the other", "figures", "median difference", "19 of 20 within", "largest"], rows, 1)


def light(report):
    ways = list(next(iter(report["scenes"].values())))
    return table(["scene", *ways], [[name, *(f"{scene[way]:.2f}" for way in ways)] for name, scene in report["scenes"].items()], 1)


FILES = {differences: breakers.__name__}
"""Of those that are not called as their file is."""


def main():
    file_of_page = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE
    page = file_of_page.read_text()
    for tabled in (fuzz, foreign, luxcore, mitsuba_own, kills, light, pressure, promises, mutations, memory, places, breakers, differences):
        file = file_of_page.with_suffix("") / f"{FILES.get(tabled, tabled.__name__)}.json"
        if file.exists():
            page = place(page, tabled.__name__, "all", tabled(json.loads(file.read_text())))
    write_whole(file_of_page, page)


if __name__ == "__main__":
    main()
