#!/usr/bin/env python3
"""Writes docs/guide/reference, a page for each command, from what the programs' --help prints.

    make_reference.py --bin build/release/bin [--check]

--check writes nothing and fails where a page is not what the programs print. Where Mitsuba's host was not built,
its page is left as it is.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent / "reference"
FURTHER = {"render-mitsuba": ("render", "--host", "mitsuba"), "scene": ("scene",)}
SUBCOMMANDS = {"scene": ("generate", "info", "convert", "placements")}
GUIDE = {
    "render": "render.md", "render-mitsuba": "mitsuba.md", "encode": "encode.md", "serve": "serve.md", "play": "play.md", "view": "view.md",
    "compare": "study.md", "study": "study.md", "fit": "fit.md", "model": "encode.md", "import": "import.md", "scene": "render.md", "info": "troubleshooting.md",
}


def help_of(programs, *command):
    done = subprocess.run([programs / "equistream", *command, "--help"], text=True, capture_output=True, env={**os.environ, "COLUMNS": "100"})
    if done.returncode:
        sys.exit(f"equistream {' '.join(command)} --help: expected status 0, found {done.returncode}\n{done.stderr}")
    return done.stdout


def commands(programs):
    """Names and what each is for, as `equistream --help` lists them."""
    return re.findall(r"^  ([a-z]+) {2,}(.+)$", help_of(programs), re.M)


def sections(text):
    """What stands above the first heading, then pairs of a heading and its lines."""
    found = [("", [])]
    for line in text.splitlines():
        if re.match(r"(Positionals|Options|Subcommands|positional arguments|options|Example|For [^:]*|OPTIONS|POSITIONALS):\s*$", line, re.I):
            found.append((line.strip().rstrip(":"), []))
        elif match := re.match(r"(example|Exit status): (.*)", line):
            found.append((match[1], [match[2]]))
        else:
            found[-1][1].append(line)
    return found


def rows(lines):
    """Pairs of an option with its value, and its meaning; a list of values inside a meaning stays a line each."""
    found = []
    for line in lines:
        if match := re.match(r" {2}(\S.*?)(?: {2,}(\S.*))?$", line):
            found.append([match[1], [match[2]] if match[2] else []])
        elif line.strip() and found:
            found[-1][1].append(line.strip())
    return [(name, meaning) for name, meaning in found]


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace("|", "\\|").replace("*", "\\*")


def cell(meaning):
    """Continued lines are one text, but those of a list of KEY=VALUE, which stand below each other."""
    text = ""
    for part in meaning:
        listed = re.match(r"([a-z-]+=\S+) {2,}(.*)", part)
        text += f"<br>`{listed[1]}`: {escaped(listed[2])}" if listed else (" " if text else "") + escaped(part)
    return text


KINDS = {"TEXT": "", "FLOAT": "number", "INT": "whole number", "UINT": "whole number", "FILE": "file", "DIR": "folder"}


def value_and_default(value):
    """What CLI11 prints behind an option's name, such as `FLOAT:FLOAT in [0 - 1]=0.063`, as two cells."""
    default = "required" if re.search(r"\bREQUIRED\b", value) else ""
    value = re.sub(r"\s*\b(REQUIRED|Excludes: \S+)", "", value)
    if match := re.match(r"([^=]*?)=(\S*)$", value):
        value, default = match[1], match[2]
    if match := re.match(r"(\w+):(?:\w+ in )?(.*)$", value):
        kind, limits = match.groups()
        if choices := re.match(r"\{(.*)\}$", limits):
            value = ", ".join(choices[1].split(","))
        elif span := re.match(r"\[(\S+) - (\S+)\]$", limits):
            value = f"{KINDS.get(kind, kind)}, {span[1]} to {span[2]}"
        else:
            value = KINDS.get(limits, limits)
    if choices := re.match(r"\{(.*)\}$", value):
        value = ", ".join(choices[1].split(","))
    value = " ".join(KINDS.get(word, word) for word in value.split()).strip()
    return value.replace("...", "one or more"), default


def table(lines):
    found = [(*re.match(r"(-\S+, -\S+|\S+) ?(.*)$", name).groups(), cell(meaning)) for name, meaning in rows(lines)]
    if not any(name.startswith("-") for name, _, _ in found) and not any(value for _, value, _ in found):
        return ["| | |", "|---|---|", *(f"| `{name}` | {meaning} |" for name, _, meaning in found)]
    out = ["| option | value | default | |" if any(name.startswith("-") for name, _, _ in found) else "| argument | value | default | |", "|---|---|---|---|"]
    for name, value, meaning in found:
        kind, default = value_and_default(value)
        out.append(f"| `{name}` | {escaped(kind)} | {f'`{default}`' if default not in ('', 'required') else default} | {meaning} |")
    return out


def body(text):
    out = []
    for title, lines in sections(text):
        lines = [line for line in lines if not re.match(r"usage:", line, re.I)] if title else lines
        kept = [line for line in lines if line.strip()]
        if not kept:
            continue
        if not title:
            first = re.search(r"^usage:.*?(?=^\S|\Z)", "\n".join(kept), re.I | re.M | re.S)
            usage = " ".join(first[0].split()) if first else ""
            prose = "\n".join(kept).replace(first[0] if first else "", "").strip()
            out += [escaped(prose), "", "```", usage.removeprefix("Usage: ").removeprefix("usage: "), "```", ""]
        elif title.lower() == "example":
            out += ["**Example**", "", "```sh", *(line.strip() for line in kept), "```", ""]
        elif title == "Exit status":
            out += [f"Exit status: {kept[0]}", ""]
        else:
            out += [f"**{title[0].upper()}{title[1:]}**", "", *table(kept), ""]
    return out


def page(programs, name, purpose):
    command = FURTHER.get(name, (name,))
    out = [f"# equistream {' '.join(command)}", "", "<!-- made by docs/guide/make_reference.py -->", "",
           f"{purpose[0].upper()}{purpose[1:]}. How it is used: [guide](../{GUIDE[name]}).", "", *body(help_of(programs, *command))]
    for sub in SUBCOMMANDS.get(name, ()):
        out += [f"## equistream {name} {sub}", "", *body(help_of(programs, name, sub))]
    return "\n".join(out).rstrip() + "\n"


def index(found):
    lines = [f"- [{name}]({name}.md): {purpose}" for name, purpose in found]
    return "\n".join(["# Commands", "", "<!-- made by docs/guide/make_reference.py -->", "", *lines]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the built programs")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    programs = options.bin.resolve()
    found = commands(programs)
    mitsuba = ("render-mitsuba", "the same with Mitsuba 3")
    at = [name for name, _ in found].index("render") + 1
    listed = [*found[:at], mitsuba, *found[at:]]
    wanted = {"README.md": index(listed)}
    for name, purpose in listed:
        if name != "render-mitsuba" or (programs / "equistream-render-mitsuba").exists():
            wanted[f"{name}.md"] = page(programs, name, purpose)
    there = {path.name for path in HERE.glob("*.md")} - {"render-mitsuba.md"}
    stale = [name for name, text in wanted.items() if not (HERE / name).exists() or (HERE / name).read_text() != text]
    gone = sorted(there - set(wanted))
    if options.check:
        if stale or gone:
            sys.exit(f"docs/guide/reference: {', '.join(stale + gone)}: not what the programs' --help prints now.\n"
                     "Run docs/guide/make_reference.py --bin BIN and commit what it writes.")
        return
    HERE.mkdir(exist_ok=True)
    for name in stale:
        (HERE / name).write_text(wanted[name])
    for name in gone:
        (HERE / name).unlink()


if __name__ == "__main__":
    main()
