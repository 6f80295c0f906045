"""Every `equistream` command of the documentation is parsed, and the pages for newcomers are run.

usage: commands_test.py BIN_DIR

Parsed: the command exists and each option stands in its --help. Run: RUN's shell blocks, one after the other in
an empty folder, with fewer pixels, samples and frames; what needs a window or never ends is parsed alone.
"""

import functools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from markdown import ROOT, blocks, commands, commands_of, pages

RUN = ("README.md", "docs/guide/tutorial.md")
NESTED = {"scene": {"generate", "info", "describe", "convert", "placements"}}
NOT_RUN = {"view", "serve"}
# Each program that is not part of every build.
ABSENT = {"mitsuba": "equistream-render-mitsuba"}


def help_of(*command):
    return subprocess.run([BIN / "equistream", *command, "--help"], text=True, capture_output=True, check=True).stdout


@functools.cache
def options_of(command):
    return set(re.findall(r"(?<![\w-])(--?[a-z][\w-]*)", help_of(*command)))


def places(words):
    """The commands whose options `words` may use: those of a host, of a farm's jobs or of what follows -- count, too."""
    name = words[1]
    if name in NESTED and len(words) > 2 and words[2] in NESTED[name]:
        return [(name, words[2]), (name,)]
    found = [(name,)]
    if "mitsuba" in words and (BIN / ABSENT["mitsuba"]).exists():
        found.append(("render", "--host", "mitsuba"))
    if name == "serve" and "--" in words:
        found += [("encode",), ("render",)]
    if name == "farm":
        found += [(job,) for job in ("render", "encode", "study") if job in words]
    return found


def fault(words):
    if words[1].startswith("-") or words[1] in ("COMMAND", "help"):
        return None
    if not (BIN / f"equistream-{words[1]}").exists() and words[1] != "render":
        return f"no command {words[1]}"
    known = set().union(*map(options_of, places(words)))
    used = [word.split("=")[0] for word in words[2:] if re.match(r"--?[a-z]", word)]
    unknown = [word for word in used if word not in known]
    return f"not among the options of {words[1]}: {', '.join(unknown)}" if unknown else None


def smaller(command):
    """The same command with next to nothing to render."""
    for pattern, small in ((r"(--size) \d{3,}x\d{3,}", r"\1 256x128"), (r"(--spp) \d+", r"\1 1"), (r"(--frames) \d+-\d+", r"\1 0-1"),
                           (r"(equistream model .*)", r"\1 --visibility-rays 65536 --rays 8192 --quantile 0.9"),
                           (r"(equistream (?:render|play) .*)", r"\1 --progress none")):
        command = re.sub(pattern, small, command)
    return command


class Documents(unittest.TestCase):
    def test_commands_are_known(self):
        faults, count = [], 0
        for page in pages():
            for words in commands((ROOT / page).read_text()):
                count += 1
                if found := fault(words):
                    faults.append(f"{page}: {' '.join(words)}: {found}")
        self.assertEqual([], faults, "\n" + "\n".join(faults))
        self.assertGreater(count, 40)

    def test_python_is_python(self):
        for page in pages():
            for language, block in blocks((ROOT / page).read_text()):
                if language == "python":
                    compile(block, str(page), "exec")

    def test_pages_run(self):
        for page in RUN:
            with self.subTest(page=page), tempfile.TemporaryDirectory() as folder:
                self.run_page(ROOT / page, folder)

    def run_page(self, page, folder):
        environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
        ran = 0
        for language, block in blocks(page.read_text()):
            for line in block.replace("\\\n", " ").splitlines() if language == "sh" else []:
                found = commands_of(line)
                if not found or any(words[1] in NOT_RUN for words in found):
                    continue
                done = subprocess.run(["bash", "-c", smaller(line)], cwd=folder, env=environment, text=True, capture_output=True)
                self.assertEqual(0, done.returncode, f"{page}: {line}\n{done.stdout}{done.stderr}")
                ran += 1
        self.assertGreater(ran, 3, page)

    def test_an_unknown_option_is_found(self):
        self.assertIn("--no-such", fault(["equistream", "info", "--no-such", "x"]))
        self.assertIn("no command", fault(["equistream", "sing"]))


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
