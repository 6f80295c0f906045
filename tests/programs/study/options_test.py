#!/usr/bin/env python3
"""Settings files, and what is said of steps: how many, and how long they still take. What `study` and `fit` say they need of PyPI is what they import, in the
versions that are tested; what is missing is named with the way to get it.
"""

import ast
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

import options
import steps
from steps import HERE, Failed


def made():
    parser = options.Parser(prog="equistream study")
    parser.add_argument("--preset", choices=("smoke", "small"), default="smoke")
    parser.add_argument("--again", action="store_true")
    options.add_common(parser)
    return parser


class Settings(unittest.TestCase):
    def parsed(self, text, *words):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.ini"
            file.write_text(text)
            return options.parse(made(), "study", ["--settings", str(file), *words])

    def refused(self, text):
        said = io.StringIO()
        with contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as ended:
            self.parsed(text)
        self.assertEqual(ended.exception.code, 2)
        return said.getvalue().splitlines()[-1]

    def test_options_of_the_command_are_read_and_the_command_line_wins(self):
        text = '# ours\npreset = "small"\n[render]\nspp = 4\n[study]\nagain = true\n'
        found = self.parsed(text)
        self.assertEqual((found.preset, found.again), ("small", True))
        self.assertEqual(self.parsed(text, "--preset", "smoke").preset, "smoke")
        self.assertFalse(self.parsed("again = false\n").again)

    def test_remarks_and_quotes_are_no_part_of_values(self):
        for value, expected in (('"small" # both', "small"), ("small ; note", "small ; note"), ("'small'", "small"), ("small#1", "small#1"), ('"take #2"', "take #2"), ("# none", "")):
            self.assertEqual(options.without_remark(value), expected)
        self.assertEqual(self.parsed("\ufeffpreset = small # ours\n").preset, "small")
        self.assertEqual(self.parsed("[render]\nspp = 4\n[study] # ours\npreset = small\n").preset, "small")
        self.assertIn("a.ini:1: expected a section such as [study], found '[study'", self.refused("[study\n"))

    def test_what_is_not_known_is_refused_with_its_line(self):
        self.assertRegex(self.refused("\nspp = 4\n"), r"a\.ini:2: expected option = value with an option of equistream study, found 'spp = 4'")
        self.assertIn("a.ini:1: expected true or false, found 'perhaps'", self.refused("again = perhaps\n"))
        self.assertIn("invalid choice: 'paper'", self.refused("preset = paper\n"))


class Mistakes(unittest.TestCase):
    def refused(self, *words):
        said = io.StringIO()
        with contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as ended:
            options.parse(made(), "study", list(words))
        self.assertEqual(ended.exception.code, 2)
        self.assertEqual(len(said.getvalue().splitlines()), 1, said.getvalue())
        return said.getvalue()

    def test_an_unknown_option_is_told_what_it_may_have_been(self):
        self.assertIn("equistream study: --presets: no such option; did you mean --preset?", self.refused("--presets", "smoke"))
        self.assertIn("--agian: no such option; did you mean --again?", self.refused("--agian"))
        self.assertIn("--frobnicate: no such option (--help lists the options)", self.refused("--frobnicate=3"))
        self.assertIn("invalid choice: 'huge'", self.refused("--preset", "huge"))


class Steps(unittest.TestCase):
    def said(self, style, total, count, each_s=10):
        out, now = io.StringIO(), [0.0]
        progress = options.Progress("study", style, total, out, lambda: now[0])
        for number in range(count):
            progress.begin(f"step-{number}", f"equistream play {number}")
            now[0] += each_s
        return out.getvalue().splitlines()

    def test_a_line_says_which_of_how_many_and_what_is_left(self):
        lines = self.said("auto", 36, 12)
        self.assertEqual(lines[0], "step 1 of 36: equistream play 0")
        self.assertEqual(lines[11], "step 12 of 36, about 4 minutes left: equistream play 11")

    def test_without_a_total_nothing_is_guessed(self):
        self.assertEqual(self.said("auto", None, 5)[4], "step 5: equistream play 4")

    def test_more_steps_than_expected_are_as_many_as_there_are(self):
        self.assertEqual(self.said("auto", 3, 5)[4].split(":")[0], "step 5 of 5")
        self.assertIsNone(json.loads(self.said("json", 3, 5)[4])["seconds_left"])

    def test_json_has_the_keys_of_other_commands_and_none_says_nothing(self):
        last = json.loads(self.said("json", 36, 12)[11])
        self.assertEqual(last, {"what": "study", "done": 11, "total": 36, "note": "equistream play 11", "seconds": 110.0, "seconds_left": 250.0})
        self.assertEqual(self.said("none", 36, 12), [])

    def test_where_standard_error_is_closed_the_output_is_left_alone(self):
        said = io.StringIO()
        with mock.patch.object(sys, "stderr", None), contextlib.redirect_stdout(said):
            for style in ("auto", "json"):
                options.Progress("farm", style).begin("render", "equistream render a.json")
        self.assertEqual(said.getvalue(), "")


REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
OURS = {file.stem for folder in (HERE, REPOSITORY / "tests/stress") for file in folder.glob("*.py")} | {folder.name for folder in HERE.iterdir() if folder.is_dir()}


def imported(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name.split(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


class Needed(unittest.TestCase):
    def test_all_that_is_imported_is_named_and_nothing_else(self):
        files = [*HERE.rglob("*.py"), *(file for file in (REPOSITORY / "tests/stress").glob("*.py") if not file.stem.endswith("_test"))]
        found = {name for file in files for name in imported(file)} - OURS - set(sys.stdlib_module_names) - {"equistream"}
        self.assertEqual(found, {steps.MODULES.get(name, name) for name in steps.packages()})

    def test_versions_are_those_of_the_tests(self):
        tested = (REPOSITORY / "tests/requirements.txt").read_text().splitlines()
        self.assertEqual([pinned for pinned in steps.packages().values() if pinned not in tested], [])

    def test_what_is_missing_is_named_with_the_way_to_get_it(self):
        with mock.patch.object(steps, "is_missing", lambda module: module == "PIL"):
            with self.assertRaisesRegex(Failed, r"found no pillow; to get them: .*pip install .*pillow==.*EQUISTREAM_PYTHON="):
                steps.expect_packages("study")


if __name__ == "__main__":
    unittest.main()
