"""The tables of docs/results/stream.md, from its JSON alone. A figure that was not measured is "-"."""

import itertools
import math
import statistics

import page_lines
from conditions import (AS_FINE_CRF, AS_SOON_S, LINES, LIVE_KINDS, LIVE_S, LIVE_SHARES, LIVE_WAYS, LOSSY_LINES, LOSSY_WAYS, SETTLED_S, TILED, WAYS,
                        recovery_s)
from pages import cell, place, table
from steps import write_whole

WHITE = 255
"""Of compare's pictures."""
NARROW_S, WIDE_S = (from_s for from_s, _ in LIVE_SHARES[1:])


def decibels(mean_square):
    return -10 * math.log10(mean_square)


def span(values, digits=0):
    """Of all seeds or runs; "-" where one of them has no figure."""
    if None in values:
        return "-"
    low, high = cell(min(values), digits), cell(max(values), digits)
    return low if low == high else f"{low} to {high}"


def line_share(rows):
    """Bytes that both ends put on the line, for each byte of the stream."""
    stream_bytes = sum(row["bytes"] for row in rows)
    if not stream_bytes or not all("sent_bytes" in row for row in rows):
        return "-"
    return cell(sum(sum(row["sent_bytes"]) for row in rows) / stream_bytes)


def line_rows(rows):
    """A line and a way each, of all seeds: how late spheres come, how wrong a viewer's pictures are, and what that is beside a line that loses nothing."""
    def of(line, way):
        return [row for row in rows if (row["line"], row["way"]) == (line, way) and row.get("late_ms")]

    def squares(found):
        return statistics.mean(row["mean_square"] for row in found) / WHITE ** 2

    whole = squares(of("nothing lost", "tcp"))
    for line in LINES:
        for way in WAYS:
            if not (found := of(line, way)):
                continue
            is_scored = all("mean_square" in row for row in found)
            late = [span([row["late_ms"][key] for row in found]) for key in ("median", "p95", "most")]
            error_db = decibels(squares(found)) if is_scored else None
            lost_db = round(decibels(whole) - error_db, 2) + 0.0 if is_scored else None
            age_ms = statistics.mean(row["age_ms"]["mean"] for row in found) if is_scored else None
            yield [line, way, cell(100 * sum(row["packets_lost"] for row in found) / sum(row["packets"] for row in found), 1), figures(found, "spheres"), *late, cell(error_db), cell(lost_db),
                   cell(age_ms, 0), line_share(found)]


def page_rows(rows):
    for line in page_lines.LINES:
        found = [row for row in rows if row["line"] == line and "shown" in row]
        if found:
            yield [line, cell(100 * sum(row["packets_lost"] for row in found) / sum(row["packets"] for row in found), 1), span([row["first_picture_ms"] for row in found]),
                   span([row["shown"] for row in found]), *(span([row["later_ms"][key] for row in found]) for key in ("median", "p95", "most")),
                   *(span([row["between_refreshes_ms"][key] for row in found]) for key in ("median", "most"))]


def viewer_rows(rows):
    for row in rows:
        yield [row["way"], str(row["viewers"]), *(span([late[key] for late in row["late_ms"]]) for key in ("median", "p95", "most"))]


def live_rows(rows):
    """A way and a part of the line each, of all seeds."""
    ends_s = [*(from_s for from_s, _ in LIVE_SHARES[1:]), LIVE_S]
    for kind, way in itertools.product(LIVE_KINDS, LIVE_WAYS):
        found = [row for row in rows if (row["sent"], row["way"]) == (kind, way)]
        for i, ((from_s, _), end_s) in enumerate(zip(LIVE_SHARES, ends_s, strict=True)):
            parts = [[sphere for sphere in row["spheres"] if from_s <= sphere["at_s"] < end_s] for row in found]
            if not all(parts):
                yield [kind, way, f"{from_s} s", *8 * ["-"]]
                continue
            settled = [[sphere for sphere in part if sphere["at_s"] >= from_s + SETTLED_S] or part[-1:] for part in parts]
            carried = [row["line"][i]["line_mbit_s"] for row in found]
            yield [kind, way, f"{from_s} s", "no limit" if carried[0] > 1e6 else span(carried, 2), span([len(part) for part in parts]),
                   span([statistics.median(sphere["later_s"] for sphere in part) for part in parts], 2),
                   span([longest_gap(row["spheres"], from_s, end_s) for row in found], 1),
                   span([max(sphere["later_s"] for sphere in part) for part in settled], 2),
                   span([statistics.mean(sphere["crf"] for sphere in part) for part in settled]),
                   windows_then(settled, found, "window_crf"), windows_then(settled, found, "window_pixels", is_share=True)]


def windows_then(parts, found, key, is_share=False):
    """Means over windows; as a share, in per cent of what the first one had."""
    means = []
    for part, row in zip(parts, found, strict=True):
        values = [sphere[key] for sphere in part if key in sphere]
        if not values:
            return "-"
        first = next(sphere[key] for sphere in row["spheres"] if key in sphere)
        means.append(statistics.mean(values) * (100 / first if is_share else 1))
    return span(means)


def longest_gap(spheres, from_s, end_s):
    """Without a new sphere, of that part of the time."""
    shown = [from_s, *(sphere["at_s"] for sphere in spheres if from_s <= sphere["at_s"] < end_s), end_s]
    return max(later - at for at, later in zip(shown, shown[1:]))


def live_line_rows(rows):
    """A stream, a line and a way each, of all seeds."""
    for kind in (*LIVE_KINDS, TILED):
        for line in LOSSY_LINES:
            for way in LOSSY_WAYS:
                found = [row for row in rows if (row["sent"], row["line"], row["way"]) == (kind, line, way)]
                if not found:
                    yield [kind, line, way, *10 * ["-"]]
                    continue
                is_whole = all(row.get("later_s") for row in found)
                later = [span([row["later_s"][key] for row in found], 2) if is_whole else "-" for key in ("median", "p95", "most")]
                yield [kind, line, way, figures(found, "spheres_per_s", 1), *later, figures(found, "longest_gap_s", 1), figures(found, "sent_mbit_s", 2), line_share(found),
                       figures(found, "crf"), figures(found, "window_crf"), "-" if kind == "sphere" else figures(found, "windows_per_sphere", 1)]


def figures(found, key, digits=0):
    return span([row.get(key) for row in found], digits)


def recovery_rows(found):
    """How long after the line is as before the spheres are."""
    silent = next(line for line in LINES if LINES[line].silent)
    for way in WAYS:
        rows = [row for row in found.get("lines", []) if (row["line"], row["way"]) == (silent, way)]
        if rows:
            yield [silent, way, figures(rows, "recovered_s", 2), "-"]
    for way in LIVE_WAYS:
        rows = [row["spheres"] for row in found.get("live", []) if (row["sent"], row["way"]) == ("sphere", way)]
        if rows:
            back = [span([back_s(spheres, key, more) for spheres in rows], 1) for key, more in (("later_s", AS_SOON_S), ("crf", AS_FINE_CRF))]
            yield [f"a tenth of the line for {WIDE_S - NARROW_S} s", way, *back]


def back_s(spheres, key, more):
    """Of a line that became narrow and wide again."""
    before = [sphere[key] for sphere in spheres if sphere["at_s"] < NARROW_S]
    return recovery_s([(sphere["at_s"], sphere[key]) for sphere in spheres], WIDE_S, statistics.median(before) + more) if before else None


def fault_rows(found):
    def times(what, key):
        return span([run[key] for run in found[what]], 2)

    cut = found["line cut without a word"]
    yield ["a server is killed, and started again 2 s later", "`view` is connected again, from that start on", times("server killed, back after 2 s", "back_to_connected_s")]
    yield ["a viewer is killed", "the server notices", times("viewer killed", "noticed_s")]
    yield ["a line is cut without a word", f"the viewer ends: {cut['it_says']}", cell(cut["viewer_gives_up_s"])]
    yield ["a line is cut without a word", f"the server drops the viewer: {cut['server_says']}", cell(cut["server_gives_up_s"])]
    runs, said = found.get("stream of a later version"), found.get("messages of a later version")
    yield ["a stream has a later version", f"`view` ends: {'; '.join(dict.fromkeys(run['it_says'] for run in runs))}" if runs else "-",
           times("stream of a later version", "ended_s") if runs else "-"]
    yield ["a viewer's messages have a later version, but for the last one",
           f"the server hears {said['poses_heard']} of {said['messages']}, and sends {said['spheres']} spheres meanwhile" if said else "-", "-"]


STAGES = {"pose": "at the server: a pose waits until a sphere is ordered", "render": "the sphere is rendered", "hand_over": "its file is written", "wait": "the encoder is not free yet",
          "encode": "it is coded", "all": "from a pose's coming to bytes that can be sent", "pose to picture": "from a pose's sending to both eyes' pictures"}
VIEWER_STAGES = {"decode_ms": "decoding", "render_ms": "both eyes", "playout_delay_ms": "the play-out delay"}


def pose_rows(found):
    rows = [[words, *(cell(found["stages_ms"][name][key], 1) for key in ("p50", "p99"))] for name, words in STAGES.items()]
    return [*rows[:-1], *(viewer_stage(found[key], words) for key, words in VIEWER_STAGES.items()), rows[-1]]


def viewer_stage(times, words):
    """`times`: of each picture, or their mean alone."""
    if isinstance(times, dict):
        return [f"at the viewer: {words}", *(cell(times[key], 1) for key in ("p50", "p99"))]
    return [f"at the viewer, on average: {words}", cell(times, 1), "-"]


def write_page(found, page):
    text = page.read_text()
    if "lines" in found:
        text = place(text, "lines", "stream", table(["line", "by", "packets lost, %", "spheres", "they come late, median, ms", "95 %", "the latest", "whole error, dB",
                                                    "lost to the viewer, dB", "age of what is seen, ms", "line's bytes / stream's"], line_rows(found["lines"])))
    if "lines" in found or "live" in found:
        text = place(text, "recovery", "stream", table(["after", "by", "as soon as before, s", "as fine as before, s"], recovery_rows(found)))
    if "page" in found:
        text = place(text, "page", "stream", table(["line", "packets lost, %", "first picture, ms", "spheres shown", "later, median, ms", "95 %", "the latest",
                                                    "between refreshes, median, ms", "at most"], page_rows(found["page"]), 1))
    if "drawing" in found:
        rows = [[row["size"], str(row["eyes"]), *(cell(row[key], 1) for key in ("median", "p95", "most"))] for row in found["drawing"]["times_ms"]]
        text = place(text, "drawing", "stream", table(["picture", "eyes", "milliseconds, median", "95 %", "the longest"], rows, 1))
    if "viewers" in found:
        text = place(text, "viewers", "stream", table(["by", "viewers", "spheres come late, median, ms", "95 %", "the latest"], viewer_rows(found["viewers"])))
    if "live" in found:
        text = place(text, "live", "stream", table(["sent", "by", "from", "the line carries, Mbit/s", "spheres", "later, median, s", "longest without one, s",
                                                    f"latest after {SETTLED_S} s", "CRF then", "CRF of the window", "its pixels, %"], live_rows(found["live"]), 3))
    if "live_lines" in found:
        text = place(text, "live_lines", "stream", table(["sent", "line", "by", "spheres a second", "later, median, s", "95 %", "the latest", "longest without one, s",
                                                          "on the line, Mbit/s", "line's bytes / stream's", "CRF", "CRF of windows or tiles", "windows or tiles a sphere"],
                                                         live_line_rows(found["live_lines"]), 3))
    if "pose" in found:
        text = place(text, "pose", "stream", table(["stage", "median, ms", "99 %, ms"], pose_rows(found["pose"]), 1))
    if "faults" in found:
        text = place(text, "faults", "stream", table(["what happens", "what follows", "after, s"], fault_rows(found["faults"])))
    write_whole(page, text)
