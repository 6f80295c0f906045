"""Where each method falls below the ceiling, whether its map knew, and what a late server costs: sections of tables.md."""

from experiments.stability import CEILING, FEWEST_BAD, fails_enough
from pages import cell, table

N = "Both eyes of one frame and one seed for each value; late motion and lost packets: of every refresh of one run."

FAILING = ("Bad: off by more than 10 of 255. Failing: off by more than 10 beyond what the ceiling is off by within a pixel, so that what no sphere of so many columns has right does not count. "
           "Recall of failing at values where these are twice what chance has, the ceiling beside the method, and 0.5 %. Precision: how many of the flagged pixels are bad. "
           "Each share is that of the pixels of all these values together.")


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


def pooled(pairs):
    """The share of all pixels together, of (share, how many pixels) at each value; None of no pixels."""
    pixels = sum(count for _, count in pairs)
    return sum(share * count for share, count in pairs) / pixels if pixels else None


def known_over(swept):
    """Of a method's figures at each value: recall of failing pixels (at each value too) and of bad ones, and precision."""
    failing = [(figures["failing_recall"], figures["failing_share"]) for figures in swept if fails_enough(figures)]
    bad = [(figures["flagged_recall"], figures["bad_share"]) for figures in swept if figures["bad_share"] >= FEWEST_BAD]
    flagged = [(figures["flagged_precision"], figures["flagged_recall"] * figures["bad_share"] / figures["flagged_precision"])
               for figures in swept if figures["bad_share"] >= FEWEST_BAD and figures["flagged_precision"]]
    return pooled(failing), [recall for recall, _ in failing], pooled(bad), pooled(flagged)


def known_text(swept):
    """In percent; - where too few pixels are so, or nothing is flagged."""
    if not swept:
        return ""
    recall, at_each, *others = known_over(swept)
    failing = "-" if recall is None else f"{100 * recall:.0f} ({100 * min(at_each):.0f} to {100 * max(at_each):.0f})"
    return " / ".join([failing, *("-" if share is None else f"{100 * share:.0f}" for share in others)])


def known_rows(breakers, methods):
    for name, breaker in breakers.items():
        yield [name, *(known_text([figures[method] for figures in breaker["found"].values() if method in figures]) for method in methods)]


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
                  "## What the reliability map knew over the whole knob: recall of failing (at the values) / recall of bad / precision, %", f"{N} {FAILING}", table(["breaker", *methods], list(known_rows(breakers, methods)), labels=1)]
    for result in latency.values():
        n = result["n"]
        sent = ", ".join(f"{result['titles'][method]} {count / 1000:,.0f}" for method, count in result["bytes_a_second"].items())
        found += [f"## A late server: dB of all refreshes (of the worst), refreshes {n['refreshes']} at {n['refresh_hz']} Hz, both eyes", f"kB a second, of the tracks that each takes: {sent}.",
                  table(["network", "value", *result["titles"].values(), "age of frames, ms", "off as frames come, degrees", "off as foretold, degrees"],
                        list(latency_rows(result["sweeps"], result["titles"])))]
    return found
