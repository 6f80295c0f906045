"""Where each method falls below the ceiling, whether its map knew, and what a late server costs: sections of tables.md."""

from experiments.stability import CEILING, FEWEST_BAD, fails_enough
from pages import cell, table

N = "Both eyes of one frame and one seed for each value; late motion and lost packets: of every refresh of one run."

FAILING = ("Bad: off by more than 10 of 255. Failing: off by more than 10 beyond what the ceiling is off by within a pixel, so that what no sphere of so many columns has right does not count. "
           "Recall of failing where these are twice what chance has, the ceiling beside the method, and 0.5 %. Precision: how many of the flagged pixels are bad.")


def methods_of(breakers):
    names = dict.fromkeys(method for breaker in breakers.values() for method in breaker["falls"])
    return [name for name in names if name != CEILING]


def fall_text(falls, first):
    """The values at which a method is 1 and 3 dB below the ceiling; "start" where it is so at the `first` already."""
    return " / ".join({None: "-", first: "start"}.get(falls[loss], falls[loss]) for loss in ("1", "3")) if falls else ""


def fall_rows(breakers, methods):
    for name, breaker in breakers.items():
        values = list(breaker["found"])
        yield [name, breaker["knob"], f"{values[0]} to {values[-1]}", *(fall_text(breaker["falls"].get(method), values[0]) for method in methods)]


def known_text(figures):
    """In percent: recall of failing and of bad pixels, precision; - where too few are so, or nothing is flagged."""
    if figures is None:
        return ""
    is_bad = figures["bad_share"] >= FEWEST_BAD
    known = [figures[score] if counts else None for score, counts in (("failing_recall", fails_enough(figures)), ("flagged_recall", is_bad), ("flagged_precision", is_bad))]
    return " / ".join("-" if share is None else f"{100 * share:.0f}" for share in known) + f" of {100 * figures['failing_share']:.1f} and {100 * figures['bad_share']:.1f}"


def known_rows(breakers, methods):
    for name, breaker in breakers.items():
        value, figures = list(breaker["found"].items())[-1]
        yield [name, value, *(known_text(figures.get(method)) for method in methods)]


def latency_rows(sweeps, titles):
    for label, by_value in sweeps.items():
        for value, runs in by_value.items():
            found = {run["method"]: run for run in runs}
            first = runs[0]
            yield [label, value, *(f"{found[method]['psnr_db']:.1f} ({found[method]['worst_refresh_db']:.1f})" for method in titles), cell(first["age_ms"]["mean"], 0),
                   cell(first["unreprojected_error_deg"]["mean"]), cell(first["error_deg"]["mean"], 3)]


def parts(stability, latency):
    found = []
    for result in stability.values():
        breakers, methods = result["breakers"], methods_of(result["breakers"])
        found += ["## Where methods fall: the first value at which they are 1 dB / 3 dB below the ceiling", N, table(["breaker", "knob", "swept", *methods], list(fall_rows(breakers, methods)), labels=3),
                  "## What the reliability map knew at the last value: recall of failing / recall of bad / precision, %, of so many % failing and bad pixels", f"{N} {FAILING}", table(["breaker", "value", *methods], list(known_rows(breakers, methods)), labels=2)]
    for result in latency.values():
        n = result["n"]
        sent = ", ".join(f"{result['titles'][method]} {count / 1000:,.0f}" for method, count in result["bytes_a_second"].items())
        found += [f"## A late server: dB of all refreshes (of the worst), refreshes {n['refreshes']} at {n['refresh_hz']} Hz, both eyes", f"kB a second, of the tracks that each takes: {sent}.",
                  table(["network", "value", *result["titles"].values(), "age of frames, ms", "off as frames come, degrees", "off as foretold, degrees"],
                        list(latency_rows(result["sweeps"], result["titles"])))]
    return found
