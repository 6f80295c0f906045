#!/usr/bin/env python3
"""Divides a render, an encode or a study among the machines of a farm: scripts for Slurm and a template of the Open Job Description.

    equistream farm [options] render SCENE ... --out FRAMES [-- encode FRAMES --out FILE ...]
    equistream farm [options] study ...
    equistream farm status FOLDER
"""

import argparse
import json
import pathlib
import shlex
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from farming import jobs, openjd, slurm, task  # noqa: E402
from farming.folder import DAMAGED, damage_told, read_plan, status, status_line, write_plan  # noqa: E402
from options import Parser, add_common, parse, typed_command  # noqa: E402
from steps import REPOSITORY, USAGE, Failed, Refused, provenance, run_as_program, write_whole  # noqa: E402

TASK = "task"


def at_least(low, kind):
    def number(text):
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= 1e9:
            raise argparse.ArgumentTypeError(f"expected a number from {low:g}, found '{text}'")
        return value
    return number


def parser_of():
    parser = Parser(prog="equistream farm", usage="equistream farm [options] JOB ... [-- JOB ...]", description=__doc__.splitlines()[0],
                    epilog="example: equistream farm render a.json --frames 0-99 --out frames -- encode frames --out a.mp4")
    parser.add_argument("job", metavar="JOB", nargs=argparse.REMAINDER,
                        help=f"the ordinary command line of {', '.join(jobs.COMMANDS)}; after --, more command lines, which wait for all before them; or status FOLDER: the progress of a farm")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("farm"), metavar="DIR",
                        help="folder for scripts, logs and unfinished work, on a file system that all machines share (default: farm)")
    parser.add_argument("--chunk", type=at_least(1, int), metavar="N", help="frames per task, unless frames are divided into parts (default: as many as take --minutes)")
    parser.add_argument("--parts", type=at_least(1, int), metavar="N", help="parts that each frame is divided into, by tiles; a task renders one part of all frames (default: 1; if a frame takes longer than --minutes, as many as keep a task within that)")
    parser.add_argument("--minutes", type=at_least(0.01, float), default=10.0, metavar="M", help="intended time of a task (default: 10)")
    parser.add_argument("--frame-seconds", type=at_least(0, float), metavar="S", help="seconds that one machine takes to render a frame (default: measured here, on the middle frame)")
    parser.add_argument("--retries", type=at_least(0, int), default=2, metavar="N", help="how often a task resumes after its program was killed or failed (default: 2)")
    parser.add_argument("--measured", type=pathlib.Path, metavar="DIR", help="earlier results, from which the times of a study are estimated (default: the repository's)")
    add_common(parser)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    return parser


def divided(parser, words):
    """Options of `farm` itself, and the words that begin with the job's command."""
    values = {name for action in parser._actions if action.nargs != 0 for name in action.option_strings}
    at = 0
    while at < len(words) and words[at].startswith("-") and words[at] != "--":
        at += 2 if words[at] in values else 1
    rest = words[at:]
    return words[:at], rest[1:] if rest[:1] == ["--"] else rest


def arguments():
    parser = parser_of()
    own, job = divided(parser, sys.argv[1:])
    options = parse(parser, "farm", own)
    options.job = job
    if not job:
        parser.error("expected a job, such as render SCENE --out FRAMES, found none")
    if job[0] not in (*jobs.COMMANDS, "status", TASK):
        parser.error(f"expected a job of {', '.join(jobs.COMMANDS)}, or status, found '{job[0]}'")
    return parser, options


def plan_before(folder):
    if not (folder / "plan.json").exists():
        return {}
    try:
        plan = read_plan(folder)
        return {"job": plan["job"], "minutes": plan.get("minutes"), "measured": dict(plan["measured"])}
    except (*DAMAGED, Failed):
        return {}  # it is planned anew


def write_farm(options):
    """The plan and what makes each system follow it; what is told of them. The same job may be planned anew: what is finished stays."""
    checked = jobs.checked_job(options)
    before = plan_before(options.out)
    if before and before["job"] != options.job:
        raise Refused(f"{options.out}: expected the farm of this job, found another's; --out names another folder")
    plan = jobs.plan_of(options, checked, before)
    folder = options.out.resolve()
    write_plan(folder, plan)
    for name, text in slurm.scripts(plan).items():
        write_whole(folder / name, text)
    write_whole(folder / "template.json", json.dumps(openjd.template(plan), indent=1) + "\n")
    return plan


def report(plan, options):
    if options.json:
        steps = [{key: step[key] for key in ("name", "tasks", "seconds")} for step in plan["steps"]]
        print(json.dumps({"folder": str(options.out), "steps": steps, "measured": plan["measured"], "frames": plan["frames"],
                          "command": typed_command("farm"), **provenance(options.bin, REPOSITORY)}, indent=1))
        return
    folder, last = str(options.out), plan["steps"][-1]["name"]
    out = shlex.quote(f"./{folder}" if folder.startswith("-") else folder)
    print("\n".join([*jobs.told(plan), "", f"written: {out}",
                     f"  Slurm:                 sh {out}/submit.sh [options of sbatch]",
                     f"  Open Job Description:  openjd run {out}/template.json --step {last} --run-dependencies",
                     f"  how far it is:         equistream farm status {out}"]))


def main():
    parser, options = arguments()
    command, words = options.job[0], options.job[1:]
    if command == TASK:
        sys.exit(task.run(options.bin, task.parsed(parser, words)))
    if command == "status":
        if len(words) > 1:
            parser.error(f"status: expected a folder, found {' '.join(words)}; options stand before status")
        folder = pathlib.Path(words[0]) if words else options.out
        try:
            found = list(status(folder, read_plan(folder)))
            print(json.dumps({"folder": str(folder), "steps": found}) if options.json else "\n".join(map(status_line, found)))
        except DAMAGED as error:
            parser.exit(USAGE, f"equistream farm: {damage_told(folder, error)}\n")
        return
    report(write_farm(options), options)


if __name__ == "__main__":
    run_as_program(main, "equistream farm")
