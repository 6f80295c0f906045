"""One task of a farm: its command, run until it is done, with progress as the farm's system wants it."""

import argparse
import json
import os
import pathlib
import shlex
import signal
import subprocess
import sys

from farming.folder import (DAMAGED, base_of, chunk_folder, chunk_folders, chunks, chunks_across, damage_told, done_file, frames_of_job, frames_state, is_done,
                            outs_of, read_done, read_plan, write_done)
from gathered import gather, require_one_render, take_over
from options import minutes_text
from steps import ENDS_WITH_PARENT, USAGE, Failed, write_whole

VIDEOS = ".mp4", ".mkv"
"""What plays write as one file."""

FROM_THE_START = ("encode", "play", "compare")
"""Commands that would do all their work again; the others keep what is finished."""


def parsed(parser, words):
    of_task = argparse.ArgumentParser(prog="equistream farm task", add_help=False)
    of_task.add_argument("folder", type=pathlib.Path)
    of_task.add_argument("step")
    of_task.add_argument("number", type=int, nargs="?", default=0)
    of_task.add_argument("--system", choices=REPORTS, default="slurm")
    of_task.error = parser.error
    return of_task.parse_args(words)


# -- progress, as each system wants it

class Lines:
    """For a log."""

    def step(self, fraction, note):
        print(f"{'' if fraction is None else f'{100 * fraction:.0f} %, '}{note}", flush=True)

    def failed(self, message):
        print(f"equistream farm: {message}", file=sys.stderr, flush=True)


class OpenJd(Lines):
    def step(self, fraction, note):
        if fraction is not None:
            print(f"openjd_progress: {100 * fraction:.1f}", flush=True)
        print(f"openjd_status: {note}", flush=True)

    def failed(self, message):
        print(f"openjd_fail: {message}", flush=True)


REPORTS = {"slurm": Lines, "openjd": OpenJd}


def tell(line, report):
    """A line that the command wrote on its standard error: progress in JSON, or a message."""
    try:
        told = json.loads(line)
        total, left = told["total"], told["seconds_left"]
        report.step(min(1, told["done"] / total) if total else None, told["note"] + (f", about {minutes_text(left)} left" if left else ""))
    except (ValueError, KeyError, TypeError):
        print(line.rstrip("\n"), file=sys.stderr, flush=True)


# -- the work itself

def processors_of(step):
    """Threads of a render: as many as Slurm gives the task, where the job does not say."""
    given = os.environ.get("SLURM_CPUS_PER_TASK")
    return ["--threads", given] if given and step["words"][0] == "render" and not step["says_threads"] else []


def words_of(step, number, folder):
    """Of the command that a task runs."""
    words = [*step["words"], *processors_of(step)]
    if step["kind"] == "frames":
        first, last = chunks(step)[number]
        return [*words, "--frames", f"{first}-{last}", "--out", str(chunk_folder(folder.resolve(), step, first, last))]
    if step["kind"] == "parts":
        return [*words, "--frames", f"{step['first']}-{step['last']}", "--part", f"{number + 1}/{step['tasks']}"]
    return [*words, *(step["each"][number] if "each" in step else [])] + ([step["numbered"], str(number)] if "numbered" in step else [])


class Runner:
    def __init__(self, program, base, report):
        self.program, self.base, self.report = program, base, report
        self.child, self.stopped = None, False
        signal.signal(signal.SIGTERM, self.stop)

    def stop(self, *_):
        """The system wants the machine back: the command ends with whole frames."""
        self.stopped = True
        if self.child:
            self.child.terminate()

    def once(self, words):
        """The command's exit status; below 0: the signal that ended it."""
        self.child = subprocess.Popen([*ENDS_WITH_PARENT, str(self.program), *words, "--progress", "json"], cwd=self.base, stderr=subprocess.PIPE, text=True, errors="replace")
        if self.stopped:
            self.child.terminate()
        for line in self.child.stderr:
            tell(line, self.report)
        return self.child.wait()

    def until_done(self, words, retries):
        for left in range(retries, -1, -1):
            status = self.once(words)
            if status == 0:
                return
            why = f"killed by signal {-status}" if status < 0 else f"exit {status}"
            if self.stopped or status == USAGE or not left:
                break
            print(f"equistream farm: {why}; it goes on, {left - 1} more tries after this", file=sys.stderr, flush=True)
        raise Failed(f"equistream {shlex.join(words)}: {'stopped' if self.stopped else why}; the same task goes on where it was")


def with_overwrite(words, base, begun, told):
    """A play that is done again replaces its own video, and no other's: nothing stood there when it first began."""
    outs = outs_of(words, base)
    if "--overwrite" in words or not outs or outs[-1].suffix not in VIDEOS:
        return words
    if not outs[-1].is_file():
        write_whole(begun, told)
    return [*words, "--overwrite"] if begun.exists() and begun.read_text() == told else words


def take_over_frames(step, number, folder):
    """What is finished of the task's frames where the step was divided otherwise before."""
    first, last = chunks(step)[number]
    for part in chunks_across(folder, step["name"], first, last):
        take_over(part, chunk_folder(folder, step, first, last), first, last)


def gather_frames(step, folder, base):
    """All that the step's tasks rendered, in the folder that the job names. Failed where a frame is missing."""
    out = base / step["out"]
    gather(chunk_folders(folder, step["of"]), out, step["command"])
    first, last = step["first"], step["last"]
    found = frames_of_job(folder, step["of"], out, [out])
    for stream, numbers in found.items():
        if missing := last - first + 1 - sum(first <= number <= last for number in numbers):
            lowest = next(number for number in range(first, last + 1) if number not in numbers)
            others = " and others" if missing > 1 else ""
            raise Failed(f"{out / stream}: expected frames {first} to {last}, found no {lowest}{others}; run the tasks of {step['of']} again")
    if not found:
        raise Failed(f"{out}: expected what the tasks of {step['of']} rendered, found nothing; run them again")


def run(programs, asked):
    """Returns the exit status."""
    report = REPORTS[asked.system]()
    try:
        plan = read_plan(asked.folder)
        step = next((step for step in plan["steps"] if step["name"] == asked.step), None)
        if step is None or not 0 <= asked.number < step["tasks"]:
            raise Failed(f"{asked.folder}/plan.json: expected task {asked.number} of a step '{asked.step}', found none")
        base, done = base_of(asked.folder, plan), done_file(asked.folder, step, asked.number)
        words = [] if step["kind"] == "gather" else words_of(step, asked.number, asked.folder)
        told = shlex.join(words) + "\n"
        from_the_start = bool(words) and words[0] in FROM_THE_START
        frames = frames_state(asked.folder, plan, step) if from_the_start else None
        if from_the_start and is_done(asked.folder, plan, step, asked.number) and read_done(done)[0] == told:
            report.step(1, f"done before; remove {done} to do it again")
            return 0
        if step["kind"] == "gather":
            gather_frames(step, asked.folder, base)
        else:
            if step["kind"] == "frames":
                take_over_frames(step, asked.number, asked.folder)
            if words[0] == "play":
                words = with_overwrite(words, base, done.with_name(done.name + ".begun"), told)
            Runner(programs.resolve() / "equistream", base, report).until_done(words, plan["retries"])
        if step["kind"] == "frames":
            # Now, and not when all is rendered.
            require_one_render(chunk_folder(asked.folder, step, *chunks(step)[asked.number]), base / step["out"])
        if step["kind"] not in ("frames", "parts"):
            # Others put the frames together themselves.
            write_done(done, told, frames or frames_state(asked.folder, plan, step))
        report.step(1, "done")
        return 0
    except (Failed, OSError) as failure:
        report.failed(str(failure))
        return 1
    except DAMAGED as error:
        report.failed(damage_told(asked.folder, error))
        return USAGE
