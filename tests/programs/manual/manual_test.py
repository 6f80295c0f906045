"""Man pages without groff's warnings, completion in bash, `equistream help`, and one version everywhere.

usage: manual_test.py BIN_DIR SOURCE_DIR
"""

import datetime
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop(2))
BIN = pathlib.Path(sys.argv.pop(1))
SHARE = BIN.parent / "share"
COMMANDS = ["render", "encode", "serve", "play", "view", "compare", "import", "export", "info", "model", "scene", "farm", "study", "fit", "doctor"]
COMPLETE = r"""
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_equistream
printf '%s\n' "${COMPREPLY[@]}"
"""


def equistream(*words):
    return subprocess.run([BIN / "equistream", *words], text=True, capture_output=True)


def completed(*words):
    script = SHARE / "bash-completion/completions/equistream"
    done = subprocess.run(["bash", "--norc", "-c", COMPLETE, "bash", script, *words], text=True, capture_output=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
    return done.stdout.split()


def plain(text):
    """Without what makes terminals show it bold."""
    return re.sub(r".\x08", "", re.sub(r"\x1b\[[\d;]*m", "", text))


class Pages(unittest.TestCase):
    def test_each_command_has_one(self):
        pages = {page.stem for page in (SHARE / "man/man1").iterdir()} - {"equistream-render-mitsuba"}
        self.assertEqual(pages, {"equistream", *(f"equistream-{name}" for name in COMMANDS)})

    def test_each_option_is_on_its_page(self):
        for name in COMMANDS:
            page = (SHARE / f"man/man1/equistream-{name}.1").read_text().replace("\\-", "-")
            for option in re.findall(r"^  (?:-\w,? ?)?(--[a-z][\w-]*)", equistream(name, "--help").stdout, re.M):
                self.assertRegex(page, rf"(?m)^\\fB.*{option}\b", name)

    @unittest.skipUnless(shutil.which("groff"), "left out: man pages as groff reads them (no groff; apt-get install groff)")
    def test_groff_warns_of_nothing(self):
        for page in (SHARE / "man/man1").iterdir():
            done = subprocess.run(["groff", "-man", "-ww", "-Tutf8", page], text=True, capture_output=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page)
            for part in ("NAME", "SYNOPSIS", "OPTIONS" if page.stem != "equistream" else "COMMANDS"):
                self.assertIn(part, plain(done.stdout), page)


class Completion(unittest.TestCase):
    def test_commands(self):
        self.assertEqual(completed("equistream", "pl"), ["play"])
        self.assertLessEqual({*COMMANDS, "help", "--version"}, set(completed("equistream", "")))
        self.assertEqual(completed("equistream", "help", "enc"), ["encode"])

    def test_options(self):
        self.assertEqual(completed("equistream", "encode", "frames", "--cod"), ["--codec"])
        self.assertIn("--exposure", completed("equistream", "play", "x.mp4", "--"))
        self.assertEqual(completed("equistream", "encode", "--out", "x"), [])  # bash's own: a file

    def test_values(self):
        self.assertEqual(completed("equistream", "encode", "frames", "--codec", ""), ["h264", "h265"])
        self.assertEqual(completed("equistream", "view", "x.mp4", "--layout", "=", "s"), ["sbs", "sphere"])
        self.assertEqual(completed("equistream", "study", "--preset", "p"), ["paper"])
        self.assertEqual(completed("equistream", "render", "--host", ""), hosts())

    def test_subcommands(self):
        self.assertEqual(completed("equistream", "scene", ""), ["generate", "info", "describe", "convert", "placements"])
        self.assertEqual(completed("equistream", "encode", ""), [])  # a folder
        self.assertIn("--knob", completed("equistream", "scene", "generate", "--"))
        self.assertEqual(completed("equistream", "scene", "convert", "--camera", ""), ["perspective", "equirect"])

    def test_another_host_has_its_own_options(self):
        offered = completed("equistream", "render", "--host", "mitsuba", "x.xml", "--v")
        self.assertEqual(offered, ["--version", "--variant"] if "mitsuba" in hosts() else ["--version"])


def hosts():
    return ["embree"] + ["mitsuba"] * (BIN / "equistream-render-mitsuba").exists()


class Help(unittest.TestCase):
    def test_of_a_command_is_its_own(self):
        for words in (("encode",), ("scene", "generate"), ("fit",)):
            self.assertEqual(equistream("help", *words).stdout, equistream(*words, "--help").stdout)

    def test_of_all(self):
        listed = equistream("help")
        self.assertEqual((listed.returncode, listed.stdout), (0, equistream("--help").stdout))
        self.assertEqual(re.findall(r"^  ([a-z]+)", listed.stdout, re.M), COMMANDS)

    def test_of_what_there_is_not(self):
        done = equistream("help", "encod")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("did you mean encode?", done.stderr)

    @unittest.skipUnless(shutil.which("man") and shutil.which("script"), "left out: help on a terminal (no man or script)")
    def test_on_a_terminal_is_the_man_page(self):
        shown = subprocess.run(["script", "-qec", f"MANPAGER=cat {BIN}/equistream help encode", "/dev/null"], text=True, capture_output=True).stdout
        self.assertIn("EXIT STATUS", plain(shown))


class Version(unittest.TestCase):
    def test_is_one(self):
        version = re.search(r"project\(equistream VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]
        self.assertEqual(equistream("--version").stdout, f"equistream {version}\n")
        self.assertEqual(equistream("encode", "--version").stdout, f"equistream {version}\n")
        for command in ("farm", "fit", "study"):  # these are in Python
            self.assertEqual(equistream(command, "--version").stdout, f"equistream {version}\n")
        headings = re.findall(r"^## (.*)$", (SOURCE / "CHANGELOG.md").read_text(), re.M)
        citation = dict(re.findall(r"^(version|date-released): (.*)$", (SOURCE / "CITATION.cff").read_text(), re.M))
        self.assertEqual(citation["version"], version)
        self.assertEqual(headings[0], f"{version} ({citation.get('date-released', 'unreleased')})")
        if "date-released" in citation:
            datetime.date.fromisoformat(citation["date-released"])


if __name__ == "__main__":
    unittest.main()
