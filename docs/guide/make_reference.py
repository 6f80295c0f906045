#!/usr/bin/env python3
"""Writes docs/guide/reference, a page for each command, from what the programs' --help prints.

    make_reference.py --bin build/release/bin [--check]

--check writes nothing and fails where a page is not what the programs print. Where Mitsuba's host was not built,
its page is left as it is.
"""

import argparse
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent / "reference"
sys.path.insert(0, str(HERE.parents[2] / "programs/manual"))
from help_text import LISTED, command_pages, help_of, options_of, sections, subcommands, value_and_default  # noqa: E402

GUIDE = {
    "render": "render.md", "render-mitsuba": "mitsuba.md", "encode": "encode.md", "serve": "serve.md", "play": "play.md", "view": "view.md",
    "compare": "study.md", "study": "study.md", "fit": "fit.md", "farm": "farm.md", "model": "encode.md", "import": "import.md", "export": "export.md", "scene": "render.md", "info": "troubleshooting.md",
    "doctor": "install.md",
}


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace("|", "\\|").replace("*", "\\*")


def cell(meaning):
    """Continued lines are one text, but the rows of a list stand below each other."""
    text = ""
    for part in meaning:
        listed = LISTED.match(part)
        text += f"<br>`{listed[1]}`: {escaped(listed[2])}" if listed else (" " if text else "") + escaped(part)
    return text


def table(lines):
    found = options_of(lines)
    if not any(option.name.startswith("-") or option.value for option in found):
        return ["| | |", "|---|---|", *(f"| `{option.name}` | {cell(option.meaning)} |" for option in found)]
    out = [f"| {'option' if any(option.name.startswith('-') for option in found) else 'argument'} | value | default | |", "|---|---|---|---|"]
    for option in found:
        kind, default = value_and_default(option.value)
        out.append(f"| `{option.name}` | {escaped(kind)} | {f'`{default}`' if default not in ('', 'required') else default} | {cell(option.meaning)} |")
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


def page(programs, name, command, purpose):
    text = help_of(programs, *command)
    out = [f"# equistream {' '.join(command)}", "", "<!-- made by docs/guide/make_reference.py -->", "",
           f"{purpose[0].upper()}{purpose[1:]}. How it is used: [guide](../{GUIDE[name]}).", "", *body(text)]
    for sub in subcommands(text):
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
    pages = command_pages(programs)
    wanted = {"README.md": index([(name, purpose) for name, _, purpose in pages])}
    for name, command, purpose in pages:
        if name != "render-mitsuba" or (programs / "equistream-render-mitsuba").exists():
            wanted[f"{name}.md"] = page(programs, name, command, purpose)
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
