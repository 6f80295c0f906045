"""A farm's folder: its plan, what tasks leave there, and how far they are.

    plan.json  submit.sh  task.sh  template.json  logs/  parts/STEP/FIRST-LAST/
"""

import json
import os
import pathlib
import re

from gathered import FRAME
from steps import Refused, read_json, state_of, write_whole

FORMAT = "equistream farm 1"
LAST_FRAME = 999_999_999
CHUNK = re.compile(r"(\d+)-(\d+)")
PART = re.compile(r"frame\.(\d+)\.part")


def write_plan(folder, plan):
    write_whole(folder / "plan.json", json.dumps({"format": FORMAT, **plan}, indent=1) + "\n")


def read_plan(folder):
    file = pathlib.Path(folder) / "plan.json"
    if not file.exists():
        raise Refused(f"{file}: expected what equistream farm writes, found none")
    plan = read_json(file)
    if not isinstance(plan, dict) or plan.get("format") != FORMAT:
        raise Refused(f"{file}: expected {FORMAT}, found another format; plan it anew")
    counts = [step[key] for step in plan.get("steps", []) if isinstance(step, dict) for key in ("first", "last", "tasks") if key in step]
    if not all(isinstance(number, int) and 0 <= number <= LAST_FRAME for number in counts):
        raise Refused(f"{file}: expected frames and tasks from 0 to {LAST_FRAME}, found others; plan it anew")
    return plan


DAMAGED = (KeyError, TypeError, ValueError)
"""What reading a plan raises where something in it is missing, or is something else."""


def damage_told(folder, error):
    return f"{pathlib.Path(folder) / 'plan.json'}: expected what equistream farm writes, found {type(error).__name__} {error}; plan it anew"


def base_of(folder, plan):
    """Where commands run: as they were typed, relative to the folder, so that both may be mounted elsewhere."""
    return (pathlib.Path(folder).resolve() / plan["base"]).resolve()


def chunk_folder(folder, step, first, last):
    return pathlib.Path(folder) / "parts" / step["name"] / f"{first:06}-{last:06}"


def chunk_folders(folder, name):
    """Of all tasks of the step so far, also as it was divided before."""
    return sorted((pathlib.Path(folder) / "parts" / name).glob("*"))


def chunks_across(folder, name, first, last):
    """Folders of tasks that render some of these frames, but for the one that renders just these: the step was divided otherwise before."""
    found = {part: tuple(map(int, match.groups())) for part in chunk_folders(folder, name) if (match := CHUNK.fullmatch(part.name))}
    return [part for part, (begin, end) in found.items() if begin <= last and first <= end and (begin, end) != (first, last)]


def chunks(step):
    """Of a step that is divided by frames: the first and the last of each task."""
    return [(first, min(first + step["chunk"] - 1, step["last"])) for first in range(step["first"], step["last"] + 1, step["chunk"])]


def frames_in(folders):
    """{stream: numbers of the frames there}, of all these folders of renders together."""
    found = {}
    for folder in folders:
        for manifest in pathlib.Path(folder).glob("*/manifest.json"):
            numbers = found.setdefault(manifest.parent.name, set())
            numbers |= {int(found_number[1]) for file in manifest.parent.glob("frame.*.exr") if (found_number := FRAME.fullmatch(file.name))}
    return found


def frames_of_job(folder, name, out, folders):
    """As frames_in(folders), but for streams that lay in OUT before: those that no task of the step has rendered. Where no folder of a task is left, all of OUT is the job's."""
    ours = frames_in(chunk_folders(folder, name)) or frames_in([out])
    return {stream: numbers for stream, numbers in frames_in(folders).items() if stream in ours}


def frames_done(folder, plan, step):
    """Of a step that is divided by frames: how many are there in every stream, gathered or not."""
    out = base_of(folder, plan) / step["out"]
    found = frames_of_job(folder, step["name"], out, [out, *chunk_folders(folder, step["name"])])
    return min((sum(step["first"] <= number <= step["last"] for number in numbers) for numbers in found.values()), default=0)


def parts_done(folder, plan, step):
    """Of a step that is divided by tiles: how many parts of its frames wait, and how many of these are put together."""
    out, wanted = base_of(folder, plan) / step["out"], range(step["first"], step["last"] + 1)
    parts = out.glob(f"*/part-*-of-{step['tasks']}/frame.*.part")
    waiting = sum(1 for file in parts if (match := PART.fullmatch(file.name)) and int(match[1]) in wanted)
    return waiting, min((sum(number in wanted for number in numbers) for numbers in frames_in([out]).values()), default=0)


def status(folder, plan):
    """Of each step: {step, done, of, what}; of parts also how many wait to be put together."""
    for step in plan["steps"]:
        if step["kind"] == "frames":
            yield {"step": step["name"], "done": frames_done(folder, plan, step), "of": step["last"] - step["first"] + 1, "what": "frames"}
        elif step["kind"] == "parts":
            waiting, frames = parts_done(folder, plan, step)
            yield {"step": step["name"], "done": frames, "of": step["last"] - step["first"] + 1, "what": "frames", "parts_waiting": waiting}
        else:
            done = sum(is_done(folder, plan, step, number) for number in range(step["tasks"]))
            yield {"step": step["name"], "done": done, "of": step["tasks"], "what": "tasks"}


def status_line(found):
    waiting = f", and {found['parts_waiting']} parts of others" if "parts_waiting" in found else ""
    return f"{found['step']}: {found['done']} of {found['of']} {found['what']}{waiting}"


def done_file(folder, step, number):
    """What a task that is not divided by frames leaves when it has ended."""
    return pathlib.Path(folder) / "done" / f"{step['name']}-{number}"


def outs_of(words, base, option="--out"):
    """Where a command puts what it makes."""
    return [base / (word.partition("=")[2] or after) for word, after in zip(words, [*words[1:], ""]) if word.partition("=")[0] == option]


def write_done(file, told, frames):
    """`told` is what the task has done, of `frames` as frames_state() has them."""
    write_whole(file, f"{told}frames {frames}\n")


def read_done(file):
    """(told, frames); frames are None in what was written before they were."""
    text = file.read_text()
    match = re.fullmatch(r"(.*\n)frames ([0-9a-f]{16})\n", text, re.DOTALL)
    return match.groups() if match else (text, None)


def is_done(folder, plan, step, number):
    """Whether a task that is not divided by frames has ended, what it made is there, and the frames that it waits for are those that it took."""
    done, base = done_file(folder, step, number), base_of(folder, plan)
    if not done.exists():
        return False
    if not all(out.exists() for out in outs_of(step["words"], base)) or ("out" in step and not frames_of(base / step["out"])):
        return False
    _, frames = read_done(done)
    if frames is None:
        newest = max((file.stat().st_mtime for out in outs_before(base, plan, step) for file in frames_of(out)), default=0)
        return newest <= done.stat().st_mtime
    return frames == frames_state(folder, plan, step)


def outs_before(base, plan, step):
    return [base / other["out"] for other in plan["steps"] if other["name"] in step["after"] and "out" in other]


def frames_of(out):
    return list(out.glob("*/frame.*.exr"))


def read_by(base, words):
    """(what a word names, file) of all that a command reads, and does not make."""
    made = [*outs_of(words, base), *outs_of(words, base, "--difference")]
    for word in words[1:]:
        value = word.partition("=")[2] if word.startswith("--") else word
        named = base / value
        if not value or not named.exists():
            continue
        for file in named.rglob("frame.*") if named.is_dir() else [named]:
            if not any(file.is_relative_to(out) for out in made):
                yield named, file


def frames_state(folder, plan, step):
    """Of all frames that the step waits for, and of what a job that is one command reads: others, or the same made anew, have another."""
    base = base_of(folder, plan)
    found = [(out, file) for out in outs_before(base, plan, step) for file in frames_of(out)]
    if step["words"] and step["words"][0] in ("encode", "play", "compare"):
        found += read_by(base, step["words"])
    return state_of((f"{os.path.relpath(out, base)} {file.relative_to(out)}", file) for out, file in found)["state"]
