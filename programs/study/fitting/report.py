"""What `equistream fit` tells of what it measured, and its settings file: sections of each program, in the words of its options."""

import math

from render_list import DEPTH, WITH_MIRRORS, size_text
from steps import Steps, write_whole

from .work import base_width, density

KINDS = {"render": "rendering", "encode": "coding", "play": "playing", "compare": "comparing", "model": "models"}


def level_text(point):
    if point.low is None or point.high is None:
        return f"> {point.db:.2f}"
    return f"{point.db:.2f} [{point.low:.2f}, {point.high:.2f}]"


def aligned(rows):
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return ["  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:]))]).rstrip() for row in rows]


def tried(fit):
    rows = [["tried", "samples", "columns", "of 2 pi f", "CRF", "dB [95 %]", "bytes a frame"]]
    for point in fit.measure.tried.values():
        of_matching = f"{point.width / fit.asked.matching:.2f}" if point.width else ""
        rows.append([point.way.title, point.way.light.name, str(point.width or ""), of_matching, "none" if point.crf is None else str(point.crf), level_text(point),
                     f"{point.bytes:,.0f}" if point.bytes else ""])
    return aligned(rows)


def n_text(asked):
    return (f"n = 2 eyes x {asked.last - asked.first + 1} frames ({asked.first} to {asked.last}) of "
            f"{size_text(asked.eye)} at {asked.fov_deg:g} degrees, beside two truths of {asked.truth_samples} samples a pixel")


def depth_text(chosen):
    if chosen.depth_share:
        return f"streamed depth of share {chosen.depth_share:g}, mesh"
    return f"the client's model of {chosen.model_px:g} px" if chosen.model_px else "the whole scene's geometry"


def chosen_text(chosen, fit):
    window = chosen.point.way.window
    looked_at = f"a window of {window[0]:g}x{window[1]:g} degrees of " if window else ""
    return (f"{looked_at}{chosen.width}x{chosen.width // 2}, {chosen.light.title}, {fit.codec} CRF {chosen.crf}, {depth_text(chosen)}, {'mirrors and glass told of, ' if chosen.told else ''}fill {chosen.fill.passes}: "
            f"{level_text(chosen.point)} dB, {chosen.point.bytes:,.0f} bytes a frame" + (f" and {chosen.bytes_once:,} once" if chosen.bytes_once else ""))


def views_text(chosen, fit):
    """When not to use a sphere."""
    for way, point in fit.views:
        if point is None:
            best = max((point for point in fit.measure.tried.values() if point.way == way), key=lambda point: point.db)
            yield f"{way.title} instead: does not come to it, {best.db:.2f} dB at most (CRF {best.crf})"
            continue
        times = point.bytes / chosen.point.bytes
        verdict = "cheaper, as long as the head looks where the server thought it would" if times < 1 else "no cheaper"
        untold = " (its second eye's mirrors as painted on their surface)" if chosen.told and way.views == 1 else ""
        yield f"{way.title} instead{untold}: {point.bytes:,.0f} bytes a frame at CRF {point.crf}, {times:.2f} of the sphere's: {verdict}"


def times_text(work, began, now):
    """Of the steps that were made since, some of them beside each other."""
    spent = dict.fromkeys(KINDS, 0.0)
    for file in (work.folder / "steps").glob("*.json"):
        kind = file.name.split("-")[0].removesuffix(".json")
        if kind in spent and file.stat().st_mtime >= began:
            spent[kind] += (Steps.record_in(file) or {"wall_s": 0})["wall_s"]
    parts = [f"{KINDS[kind]} {seconds:.0f}" for kind, seconds in sorted(spent.items(), key=lambda item: -item[1]) if seconds >= 0.5]
    return f"took {now - began:.0f} s" + (f"; steps, some beside each other: {', '.join(parts)}" if parts else ": everything was there already")


def unreachable_text(best, fit):
    where = f"{best.width} columns ({best.width / fit.asked.matching:.2f} of 2 pi f), {'uncoded' if best.crf is None else f'CRF {best.crf}'}"
    text = f"--db {fit.level:g}: not to be had; the most found is {level_text(best)} dB, at {where}; {n_text(fit.asked)}"
    if fit.light.samples * 2 > fit.asked.max_samples:
        text += f"; these are the most samples a pixel that are tried (--most-spp {fit.asked.max_samples})"
    text += wider_text(best.way, fit) if best.crf is None else "; --widest tries wider spheres"
    return "; ".join([text, *(why for why in fit.why if why.startswith("denoised: not tried"))])


def wider_text(way, fit):
    """Where a line through the two widest uncoded spheres over the logarithm of the width comes to it."""
    points = sorted((point for point in fit.measure.tried.values() if point.crf is None and point.way == way), key=lambda point: point.width)[-2:]
    if len(points) < 2 or points[1].db <= points[0].db:
        return ""
    slope = (points[1].db - points[0].db) / math.log2(points[1].width / points[0].width)
    times = points[1].width / fit.asked.matching * 2 ** ((fit.level - points[1].db) / slope)
    return f"; it rises by {slope:.1f} dB for each doubling, and would come to it at about {times:.1f} of 2 pi f (--widest)"


def report(fit, chosen):
    reasons = [f"  - {line}" for line in (*fit.why, *views_text(chosen, fit))]
    return [*tried(fit), n_text(fit.asked), "", f"chosen: {chosen_text(chosen, fit)}", *reasons]


RENDERED = {"small": {"small": "right"}, "hidden": {"layers": "true"}, "patches": {"patches": "true"}}
"""Track -> what `render` makes it by."""


def section(name, values):
    return "\n".join([f"[{name}]", *(f"{key} = {value}" for key, value in values.items())])


def quoted(text):
    """As settings files have it (programs/cli/settings_text.h): in whichever quotes the text has not."""
    mark = "'" if '"' in str(text) else '"'
    return f"{mark}{text}{mark}"


def settings_text(remarks, sections):
    """`remarks` come on top; sections are {program: {option: value}}."""
    on_top = "\n".join(f"# {' '.join(remark.splitlines())}" for remark in remarks)
    return "\n\n".join([on_top, *(section(name, values) for name, values in sections.items() if values)]) + "\n"


def client_words(chosen):
    if chosen.depth_share:
        return {"method": "mesh"}
    return {"method": "eye-depth", "model" if chosen.model_px else "scene": quoted(chosen.geometry_file)}


def sections_of(chosen, asked, codec):
    """What each program needs to do as was measured; `chosen` is choice.py's."""
    track, window = chosen.fill.track, chosen.point.way.window
    columns = base_width(chosen.width) if window else chosen.width
    looked_at = {"window": quoted(f"gaze,{window[0]:g}x{window[1]:g}"), "density": density(chosen.width)} if window else {}
    sees = {"fill": quoted(chosen.fill.passes), "size": size_text(asked.eye), "fov": f"{asked.fov_deg:g}"}
    by_stream = {"depth": "auto", "depth-share": f"{chosen.depth_share:g}"} if chosen.depth_share else {"depth": "none"}
    return {"render": {"eye": "centre", "size": size_text((columns, columns // 2)), **looked_at, "spp": chosen.light.samples, **({"denoise": chosen.light.denoise} if chosen.light.denoise != "off" else {}), "aovs": quoted((WITH_MIRRORS if chosen.told else DEPTH)[1]), **RENDERED.get(track, {})},
            "encode": {"codec": codec, "crf": chosen.crf, "fill": track or "none", **by_stream, **({"mirrors": "always"} if chosen.told else {})},
            "model": {"error-px": f"{chosen.model_px:g}", "focal": f"{asked.focal_px:g}"} if chosen.model_px else {},
            "play": {**client_words(chosen), **({"depth": "stream"} if chosen.depth_share else {}), **sees},
            "view": {**client_words(chosen), **sees}}


def write_settings(file, remarks, sections):
    write_whole(file, settings_text(remarks, sections))
