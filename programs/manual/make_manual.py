#!/usr/bin/env python3
"""Writes what is installed beside the programs, out of their --help: man pages and the completion of words in bash.

    make_manual.py --bin build/release/bin --out build/release/share
"""

import argparse
import pathlib
import re
import shutil

from help_text import LISTED, choices, command_pages, help_of, options_of, sections, subcommands, takes_value, value_and_default, version_of

COMPLETION = pathlib.Path(__file__).with_name("completion.bash")


def roff(text):
    """As it stands, for groff."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^(?=[.'])", r"\\&", text, flags=re.M)


def paragraph(lines):
    """Continued lines are one text, but the rows of a list stand below each other."""
    out = []
    for line in lines:
        if out and LISTED.match(line):
            out.append(".br")
        out.append(roff(line))
    return out


def described(option):
    value, default = value_and_default(option.value)
    head = f"\\fB{roff(option.name)}\\fR" + (f" \\fI{roff(value)}\\fR" if value else "")
    said = {"": [], "required": ["Required."]}.get(default, [f"Default: {roff(default)}."])
    meaning = paragraph(option.meaning)
    if said and meaning and meaning[-1][-1] not in ".)":
        meaning[-1] += "."
    return [".TP", head, *meaning, *said]


def body(text, heading):
    """The parts of one --help; `heading` is the macro that parts of a subcommand stand under."""
    out = []
    for title, lines in sections(text):
        kept = [line for line in lines if line.strip()]
        if title and title.lower() not in ("example", "exit status"):
            kept = [line for line in kept if not re.match(r"usage:", line, re.I)]
        if not kept:
            continue
        if not title:
            usage = re.search(r"^usage:.*?(?=^\S|\Z)", "\n".join(kept), re.I | re.M | re.S)
            prose = "\n".join(kept).replace(usage[0] if usage else "", "").strip()
            if usage:
                out += [f"{heading} SYNOPSIS" if heading == ".SH" else ".PP", roff(re.sub(r"^usage: ", "", " ".join(usage[0].split()), flags=re.I))]
            out += [f"{heading} DESCRIPTION" if heading == ".SH" else ".PP", *map(roff, prose.splitlines())]
        elif title.lower() == "example":
            out += [f"{heading} EXAMPLE", ".EX", *(roff(line.strip()) for line in kept), ".EE"]
        elif title == "Exit status":
            out += [f"{heading} EXIT STATUS", roff(kept[0])]
        else:
            out += [f"{heading} {title.upper()}"]
            for option in options_of(kept):
                out += described(option)
    return out


def page(name, purpose, version, parts):
    return "\n".join([f'.TH {roff(name.upper())} 1 "" "{version}" "equistream"', ".SH NAME", f"{roff(name)} \\- {roff(purpose)}", *parts]) + "\n"


def manual(programs, version, pages):
    """{page: its text}."""
    listed = [line for name, _, purpose in pages for line in (".TP", f"\\fBequistream\\-{roff(name)}\\fR(1)", roff(purpose))]
    found = {"equistream": page("equistream", "stream path-traced scenes to a headset", version, [
        ".SH SYNOPSIS", "\\fBequistream\\fR \\fICOMMAND\\fR [\\fIoptions\\fR]", ".br", "\\fBequistream help\\fR [\\fICOMMAND\\fR]", ".br",
        "\\fBequistream \\-\\-version\\fR", ".SH COMMANDS", *listed,
        ".SH EXIT STATUS", "0 done, 1 failed, 2 bad usage or input."])}
    for name, command, purpose in pages:
        text = help_of(programs, *command)
        parts = body(text, ".SH")
        for sub in subcommands(text):
            parts += [f".SH {roff(f'equistream {name} {sub}'.upper())}", *body(help_of(programs, name, sub), ".SS")]
        found[f"equistream-{name}"] = page(f"equistream-{name}", purpose, version, [*parts, ".SH SEE ALSO", "\\fBequistream\\fR(1)"])
    return found


def completed(text):
    """Options with "=" behind those that take a value, and {option: the words that it may be followed by}."""
    words, values = [], {}
    for title, lines in sections(text):
        if title.lower() in ("", "example", "exit status", "subcommands"):
            continue
        for option in options_of(line for line in lines if not re.match(r"usage:", line, re.I)):
            for name in re.findall(r"--?[A-Za-z][\w-]*", option.name):
                if name.startswith("--"):
                    words.append(name + ("=" if takes_value(option.value) else ""))
                if found := choices(option.value):
                    values[name] = found
    return words, values


def completion(programs, pages):
    """The script: ours, with a branch for each command."""
    options, values, subs = [], [], []
    for name, command, _ in pages:
        text = help_of(programs, *command)
        helps = {" ".join(command): text, **{f"{name} {sub}": help_of(programs, name, sub) for sub in subcommands(text)}}
        if subcommands(text):
            subs.append(f"    {name}) echo {' '.join(subcommands(text))} ;;")
        for key, one in helps.items():
            words, fixed = completed(one)
            for _, other, _ in pages:  # `render --host mitsuba` is a page of its own, which `render` leads to
                if len(other) == 3 and (key, other[1] in fixed) == (other[0], True):
                    fixed[other[1]].append(other[2])
            options.append(f'    "{key}") echo "{" ".join(words)}" ;;')
            values += [f'    "{key} {option}") echo "{" ".join(known)}" ;;' for option, known in fixed.items()]
    names = " ".join(name for name, command, _ in pages if len(command) == 1)
    filled = COMPLETION.read_text()
    for mark, text in (("@COMMANDS@", names), ("@SUBCOMMANDS@", "\n".join(subs)), ("@OPTIONS@", "\n".join(options)), ("@VALUES@", "\n".join(values))):
        filled = filled.replace(mark, text)
    return filled


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the built programs")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="share/ beside it")
    options = parser.parse_args()
    programs = options.bin.resolve()
    version = version_of(programs)
    pages = [one for one in command_pages(programs) if one[0] != "render-mitsuba" or (programs / "equistream-render-mitsuba").exists()]
    folder = options.out / "man/man1"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, text in manual(programs, version, pages).items():
        (folder / f"{name}.1").write_text(text)
    completions = options.out / "bash-completion/completions"
    completions.mkdir(parents=True, exist_ok=True)
    (completions / "equistream").write_text(completion(programs, pages))


if __name__ == "__main__":
    main()
