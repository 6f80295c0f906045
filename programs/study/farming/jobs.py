"""What a farm is to do: the job's ordinary command lines, divided into steps of tasks.

A render is divided by frames, or where one frame takes too long by tiles; every other command is one task that waits for all before it. Frames that carry light
or patches on from the frame before are not divided. A study divides itself (plan.py).
"""

import json
import math
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import time

from options import Progress, not_utf8
from own_names import own_name
from steps import ENDS_WITH_PARENT, RESULTS, USAGE, Failed, Refused

COMMANDS = ("render", "encode", "play", "compare", "study")
DROPPED = {"--progress": 1, "--json": 0}
"""Options that tasks set themselves, with how many words each takes."""
PLACED = {"--out": 1, "--frames": 1}
REFUSED = ("--overwrite", "--follow", "--part", "--dry-run")
TRIED_SAMPLES = (1, 4)
"""A pixel, of the frame that is measured: what a sample takes is their difference."""
LIMIT = 2
"""Times what it is meant to take, and as many seconds more as a cluster may need to begin:"""
SLACK_S = 300
MOST_PARTS = 4096
TILE_SIDE = 32
"""Of the tiles that parts are of."""
STUDY_OPTIONS = ("--preset", "--scenes", "--out", "--work")
"""That a study's tasks are given; the others they set themselves."""


def split_at_dashes(words):
    lines = [[]]
    for word in words:
        if word == "--":
            lines.append([])
        else:
            lines[-1].append(word)
    return lines


def without(words, names):
    """The words but for these options and their values."""
    kept, at = [], 0
    while at < len(words):
        name, equals, _ = words[at].partition("=")
        if name in names:
            at += 1 + (0 if equals else names[name])
        else:
            kept.append(words[at])
            at += 1
    return kept


def checked_lines(words):
    if (found := not_utf8(words)) is not None:
        raise Refused(f"expected a job in UTF-8, as plan.json is, found '{found}'; rename what it names")
    lines = split_at_dashes(words)
    for line in lines:
        if not line or line[0] not in COMMANDS or (line[0] == "study" and len(lines) > 1):
            raise Refused(f"expected jobs of {', '.join(COMMANDS)} between --, a study alone, found '{shlex.join(line)}'")
        for word in line:
            if line[0] == "render" and word.partition("=")[0] in REFUSED:
                raise Refused(f"{word}: expected a render that goes on where it was, found an option that a farm's tasks cannot have")
    return lines


def program_of(options):
    return options.bin.resolve() / "equistream"


def asked_of(program, words):
    """What the command prints as JSON. Refused or Failed with what it says itself."""
    done = subprocess.run([*ENDS_WITH_PARENT, program, *words], capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or [f"{shlex.join(words)}: exit {done.returncode}"])[-1].removeprefix("equistream ")
        raise (Refused if done.returncode == USAGE else Failed)(said)
    return json.loads(done.stdout)


def measuring_prefix(folder):
    """Of a folder to measure in, a name of this process's own. What processes that were killed have left goes."""
    return own_name(folder, "measured-", "-[a-z0-9_]+", lambda left: shutil.rmtree(left, ignore_errors=True)) + "-"


def measured_frame(program, line, render, folder, progress):
    """{seconds of a frame, of the start, bytes of a frame}: the middle one, rendered here with few samples and told from them."""
    words = without(line, {**DROPPED, **PLACED, "--spp": 1})
    middle = str((render["first_frame"] + render["last_frame"]) // 2)
    folder.mkdir(parents=True, exist_ok=True)
    took = {}
    with tempfile.TemporaryDirectory(prefix=measuring_prefix(folder), dir=folder) as out:
        for samples in sorted({min(render["spp"], each) for each in TRIED_SAMPLES}):
            progress.begin(f"renders frame {middle} with {samples} samples a pixel, to measure it", None)
            began = time.monotonic()
            report = asked_of(program, [*words, "--spp", str(samples), "--frames", middle, "--out", f"{out}/{samples}", "--json", "--progress", "none"])
            took[samples] = report["render_s"]
            start_s = time.monotonic() - began - report["render_s"]
            size = sum(file.stat().st_size for file in pathlib.Path(out, str(samples)).rglob("*.exr"))
    fewest, most = min(took), max(took)
    of_sample = max(0, (took[most] - took[fewest]) / (most - fewest)) if most > fewest else 0
    return {"frame_s": round(took[most] + of_sample * (render["spp"] - most), 3), "start_s": round(start_s, 3), "bytes": size}


def step(name, kind, after=(), words=(), tasks=1, seconds=None, processors=None, **more):
    """Programs of ours take all processors, and are timed so; what only links files takes one."""
    if processors is None:
        processors = 1 if kind == "gather" else len(os.sched_getaffinity(0))
    return {"name": name, "kind": kind, "after": list(after), "words": list(words), "tasks": tasks, "seconds": seconds, "limit": LIMIT * seconds + SLACK_S if seconds else None,
            "processors": processors, **more}


def divided(render, measured, options):
    """Frames a task, and parts that each frame is rendered in."""
    count = render["last_frame"] - render["first_frame"] + 1
    if not render["independent"]:
        if options.parts or options.chunk:
            raise Refused("expected independent frames for --chunk and --parts, found --accumulate or --patches, whose frames need the ones before")
        return count, 1
    parts = options.parts or 1
    if parts > 1 and options.chunk:
        raise Refused("--chunk: expected no --parts beside it, whose tasks are parts of all frames, found both")
    most = min(MOST_PARTS, math.ceil(render["width"] / TILE_SIDE) * math.ceil(render["height"] / TILE_SIDE))
    if parts > most:
        raise Refused(f"--parts: expected at most {most} for frames of {render['width']}x{render['height']}, found {parts}")
    if not options.parts and not options.chunk and render["in_parts"] and measured["frame_s"] > 60 * options.minutes:
        parts = min(most, math.ceil(count * measured["frame_s"] / (60 * options.minutes)))
    if parts > 1 and not render["in_parts"]:
        raise Refused("--parts: expected a host that renders by tiles, and no --window, found pictures that are rendered whole")
    if parts > 1:
        return count, parts  # a part's folder belongs to one program at a time
    return min(count, options.chunk or max(1, int(60 * options.minutes / max(measured["frame_s"], 1e-3)))), 1


def asked_for(render):
    """What the time of a frame hangs on, but for the scene's own contents."""
    return [render[key] for key in ("width", "height", "spp", "threads", "first_frame", "last_frame")]


def checked_render(line, program):
    """What the render says of itself."""
    render = asked_of(program, [*without(line, DROPPED), "--dry-run", "--json"])
    if set_elsewhere := render.get("is_set"):
        raise Refused(f"--settings: expected a render that goes on where it was, found {', '.join(set_elsewhere)}, which a farm's tasks cannot have")
    if "\ufffd" in render["out"]:  # stands in JSON for what is not UTF-8
        raise Refused(f"--settings: expected an out in UTF-8, as plan.json is, found '{render['out']}'; rename it")
    return render


def checked_job(options):
    """Pairs of a command line and, of a render, what it says of itself. Refused before anything is rendered."""
    return [(line, checked_render(line, program_of(options)) if line[0] == "render" else None) for line in checked_lines(options.job)]


def render_steps(name, line, render, options, after, measured_before):
    """The render, what puts its frames together, and what was measured: where it was before, it stays, and so do the tasks."""
    if options.frame_seconds is not None:
        measured = {"frame_s": options.frame_seconds, "start_s": 0.0, "bytes": None}
    elif measured_before and measured_before.get("of") == asked_for(render):
        measured = measured_before
    else:
        measured = {"of": asked_for(render)} | measured_frame(program_of(options), line, render, options.out.resolve(), Progress("farm", options.progress))
    chunk, parts = divided(render, measured, options)
    first, last = render["first_frame"], render["last_frame"]
    tasks = parts if parts > 1 else math.ceil((last - first + 1) / chunk)
    processors = render["threads"] or None
    seconds = round(measured["start_s"] + chunk * measured["frame_s"] / parts, 1)
    shared = {"says_threads": render["threads"] > 0, "tasks": tasks, "first": first, "last": last, "chunk": chunk, "out": render["out"], "seconds": seconds, "processors": processors}
    if parts > 1:
        words = without(line, {**DROPPED, "--frames": 1})
        whole = step(f"{name}-whole", "run", after=[name], words=[*words, "--frames", f"{first}-{last}", "--part", f"all/{parts}"], processors=processors, says_threads=render["threads"] > 0)
        return [step(name, "parts", after=after, words=words, **shared), whole], measured, last - first + 1
    gathered = step(f"{name}-whole", "gather", after=[name], of=name, first=first, last=last, out=render["out"], command=f"equistream {shlex.join(line)}")
    return [step(name, "frames", after=after, words=without(line, {**DROPPED, **PLACED}), **shared), gathered], measured, last - first + 1


def study_steps(line, options):
    import plan
    from study import arguments as study_arguments
    for word in without(line[1:], DROPPED):
        if word.startswith("-") and word.partition("=")[0] not in STUDY_OPTIONS:
            raise Refused(f"study: expected options of {', '.join(STUDY_OPTIONS)}, found {word}")
    study = study_arguments([*line[1:], "--bin", str(options.bin)])
    return plan.steps(study, options.measured or RESULTS, step)


def plan_of(options, checked, before):
    """`checked`: of checked_job(). `before`: job, minutes and measured of the plan of this job that lies there, or nothing."""
    measured_before = before["measured"] if before and before["minutes"] == options.minutes else {}
    steps, measured, frames, names = [], {}, 0, set()
    for number, (line, render) in enumerate(checked, start=1):
        name = line[0] if line[0] not in names else f"{line[0]}-{number}"
        names.add(name)
        if line[0] == "render":
            made, measured[name], count = render_steps(name, line, render, options, [each["name"] for each in steps], measured_before.get(name))
            frames += count
        elif line[0] == "study":
            made = study_steps(line, options)
        else:
            made = [step(name, "run", after=[each["name"] for each in steps], words=without(line, DROPPED))]
        steps += made
    folder = options.out.resolve()
    return {"name": re.sub(r"[^A-Za-z0-9._-]", "-", folder.name) or "farm", "job": options.job, "base": os.path.relpath(pathlib.Path.cwd(), folder),
            "retries": options.retries, "minutes": options.minutes, "frames": frames, "measured": measured, "steps": steps}


def hours(each):
    return (each["all_s"] if "all_s" in each else each["tasks"] * each["seconds"]) / 3600


def told(plan):
    """Lines: a row a step."""
    yield f"{'step':<16}{'tasks':>8}{'a task, s':>12}{'all, h':>10}   after"
    for each in plan["steps"]:
        times = f"{each['seconds']:>12.0f}{hours(each):>10.2f}" if each["seconds"] is not None else " " * 22
        yield f"{each['name']:<16}{each['tasks']:>8}{times}   {', '.join(each['after'])}".rstrip()
    for name, of in plan["measured"].items():
        size = f"; {of['bytes'] / 1e6:.1f} MB a frame" if of["bytes"] else ""
        yield f"{name}: {of['frame_s']:.3g} s a frame, {of['start_s']:.3g} s to start{size}, on this machine"
