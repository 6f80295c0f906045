"""What the programs' --help says, in parts: for the pages of the guide, the man pages and the completion of words."""

import collections
import os
import re
import subprocess
import sys

Option = collections.namedtuple("Option", "name value meaning")
"""`name` as it is printed, "-h,--help"; `value` what stands behind it; `meaning` a list of lines."""


def help_of(programs, *command):
    done = subprocess.run([programs / "equistream", *command, "--help"], text=True, capture_output=True, env={**os.environ, "COLUMNS": "100"})
    if done.returncode:
        sys.exit(f"equistream {' '.join(command)} --help: expected status 0, found {done.returncode}\n{done.stderr}")
    return done.stdout


def version_of(programs):
    return subprocess.run([programs / "equistream", "--version"], text=True, capture_output=True, check=True).stdout.strip()


def commands(programs):
    """Names and what each is for, as `equistream --help` lists them."""
    return re.findall(r"^  ([a-z]+) {2,}(.+)$", help_of(programs), re.M)


def command_pages(programs):
    """(page, words of the command, what it is for), each command and what `render` is with another host."""
    found = [(name, (name,), purpose) for name, purpose in commands(programs)]
    at = [name for name, _, _ in found].index("render") + 1
    return [*found[:at], ("render-mitsuba", ("render", "--host", "mitsuba"), "the same with Mitsuba 3"), *found[at:]]


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


def subcommands(text):
    return [option.name for title, lines in sections(text) if title == "Subcommands" for option in options_of(lines)]


def rows(lines):
    """Pairs of an option with its value, and its meaning; a list of values inside a meaning stays a line each."""
    found = []
    for line in lines:
        if match := re.match(r" {2}(\S.*?)(?: {2,}(\S.*))?$", line):
            found.append([match[1], [match[2]] if match[2] else []])
        elif line.strip() and found:
            found[-1][1].append(line.strip())
    return [(name, meaning) for name, meaning in found]


def options_of(lines):
    return [Option(*re.match(r"(-\S+, -\S+|\S+) ?(.*)$", name).groups(), meaning) for name, meaning in rows(lines)]


LISTED = re.compile(r"([a-z][a-z-]*(?:=\S+)?) {2,}(.*)")
"""A row of a list in a meaning: KEY=VALUE or a word, and what it is."""

KINDS = {"TEXT": "", "FLOAT": "number", "INT": "whole number", "UINT": "whole number", "FILE": "file", "DIR": "folder"}
RULES = re.compile(r"\s*\b(REQUIRED|Excludes: \S+)")


def value_and_default(value):
    """What CLI11 prints behind an option's name, such as `FLOAT:FLOAT in [0 - 1]=0.063`, as two cells."""
    default = "required" if re.search(r"\bREQUIRED\b", value) else ""
    value = RULES.sub("", value)
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


def choices(value):
    """The words of a fixed set that the value is one of; empty where it may be another."""
    found = re.search(r"\{([^}]*)\}", value)
    return found[1].split(",") if found else []


def takes_value(value):
    return bool(RULES.sub("", value))
