"""What `study` and `fit` take as every command does: --settings, --json and --progress, and how far they are."""

import argparse
import difflib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import threading
import time

MAX_SETTINGS_BYTES = 1 << 20
FEWEST = 3
"""Steps, before what is left is told."""
TRUE, FALSE = ("true", "on", "yes", "1"), ("false", "off", "no", "0")


class Version(argparse.Action):
    """The commands are of one version, which the dispatcher says."""

    def __call__(self, parser, *_):
        words = sys.argv[1:]
        parser.exit(subprocess.run([pathlib.Path(words[words.index("--bin") + 1]) / "equistream", "--version"]).returncode)


def add_common(parser):
    parser.add_argument("--version", action=Version, nargs=0, help="display the version and exit")
    parser.add_argument("--settings", type=pathlib.Path, metavar="FILE", help="read options from a file: lines of option = value (the command line wins)")
    parser.add_argument("--json", action="store_true", help="report as JSON on standard output")
    parser.add_argument("--progress", choices=("auto", "json", "none"), default="auto", help="auto: a line a step on standard error; json: the same as JSON; none: nothing")


def without_remark(value):
    """Nor quotes; as the other commands read it (programs/cli/settings_text.h)."""
    if value[:1] in ('"', "'") and (end := value.find(value[0], 1)) > 0:
        return value[1:end]
    return re.split(r"(?:^|\s)#", value)[0].strip()


def words_of(parser, file, section):
    """A settings file's lines as words of the command line; those in a [section] of another command are passed over."""
    try:
        with file.open("rb") as opened:
            read = opened.read(MAX_SETTINGS_BYTES + 1)  # of a device without an end no more
        if len(read) > MAX_SETTINGS_BYTES:
            parser.error(f"argument --settings: {file}: expected a file of at most 1 MiB, found more bytes")
        lines = read.decode("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        parser.error(f"argument --settings: {file}: expected a text file, found {getattr(error, 'strerror', None) or 'other bytes'}")
    known = {name.lstrip("-"): action for action in parser._actions for name in action.option_strings if action.dest not in ("help", "version", "settings")}
    words, here = [], section
    for number, line in enumerate(lines, start=1):
        line = line.strip()
        bare = without_remark(line)
        if line.startswith("["):
            if not bare.endswith("]"):
                parser.error(f"argument --settings: {file}:{number}: expected a section such as [{section}], found '{line}'")
            here = bare[1:-1].strip()
        elif line and line[0] not in "#;" and here == section:
            key, equals, value = (part.strip() for part in line.partition("="))
            value = without_remark(value)
            if not equals or key not in known:
                parser.error(f"argument --settings: {file}:{number}: expected option = value with an option of equistream {section}, found '{line}'")
            if known[key].nargs != 0:
                words.append(f"--{key}={value}")
            elif value.lower() in TRUE:
                words.append(f"--{key}")
            elif value.lower() not in FALSE:
                parser.error(f"argument --settings: {file}:{number}: expected true or false, found '{value}'")
    return words


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as the other commands do, and takes no part of an option's name for the whole."""

    def __init__(self, **settings):
        super().__init__(allow_abbrev=False, **settings)

    def error(self, message):
        self.exit(2, f"{self.prog}: {message} (--help lists the options)\n")

    def options(self):
        return [name for action in self._actions for name in action.option_strings if name.startswith("--") and action.help != argparse.SUPPRESS]


def parse(parser, section, words=None):
    """Of the command line, and of the settings file that it names."""
    words = sys.argv[1:] if words is None else list(words)
    early = Parser(prog=parser.prog, add_help=False)
    early.add_argument("--settings", type=pathlib.Path)
    named = early.parse_known_args(words)[0].settings
    known = {name for action in parser._actions for name in action.option_strings}
    for name in (word.partition("=")[0] for word in words):
        if name.startswith("--") and len(name) > 2 and name not in known:
            near = difflib.get_close_matches(name, parser.options(), n=1, cutoff=0.75)
            parser.error(f"{name}: no such option" + (f"; did you mean {near[0]}?" if near else ""))
    return parser.parse_args((words_of(parser, named, section) if named else []) + words)


def typed_command(name):
    """The whole command line. Where programs are is not typed: the dispatcher says it."""
    words = sys.argv[1:]
    at = words.index("--bin") if "--bin" in words else len(words)
    return shlex.join(["equistream", name, *words[:at], *words[at + 2:]])


def not_utf8(words):
    """The first of these words that has other bytes, those as \\xNN; None where all are."""
    return next((spelled for word in words if (spelled := os.fsencode(word).decode(errors="backslashreplace")) != word), None)


def minutes_text(seconds):
    if seconds < 90:
        return f"{max(1, round(seconds / 10)) * 10} seconds"
    return f"{round(seconds / 60)} minutes" if seconds < 5400 else f"{seconds / 3600:.1f} hours"


class Progress:
    """Steps that were done, of `total` where somebody knows. Steps beside each other may tell of themselves."""

    def __init__(self, what, style="auto", total=None, out=None, clock=time.monotonic):
        self.what, self.total, self.out, self.clock = what, total, out or sys.stderr, clock
        self.style = style if self.out else "none"  # standard error may be closed: print() would take the output
        self.done, self.began, self.lock = 0, clock(), threading.Lock()

    def left_s(self):
        """By what the steps before took, each; None where the total is unknown or was too low, or too few were done to tell."""
        if not self.total or not FEWEST <= self.done < self.total:
            return None
        return (self.clock() - self.began) * (self.total - self.done) / self.done

    def expect(self, count):
        """So many steps more, about."""
        self.total = self.done + count

    def begin(self, name, command):
        """A step: `command` is what it runs, or says that it was done before."""
        with self.lock:
            left_s, number = self.left_s(), self.done + 1
            self.done = number
            total = max(self.total, number) if self.total else None
            if self.style == "json":
                print(json.dumps({"what": self.what, "done": number - 1, "total": total, "note": command or name, "seconds": round(self.clock() - self.began, 3),
                                  "seconds_left": None if left_s is None else round(left_s, 1)}), file=self.out, flush=True)
            elif self.style == "auto":
                place = f"step {number}" + (f" of {total}" if total else "") + (f", about {minutes_text(left_s)} left" if left_s else "")
                print(f"{place}: {command or name}", file=self.out, flush=True)
