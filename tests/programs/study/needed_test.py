#!/usr/bin/env python3
"""What `study` and `fit` say they need of PyPI is what they import, in the versions that are tested; what is missing is named with the way to get it."""

import ast
import pathlib
import sys
import unittest
from unittest import mock

import needed
from steps import HERE, Failed

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
        self.assertEqual(found, {needed.MODULES.get(name, name) for name in needed.packages()})

    def test_versions_are_those_of_the_tests(self):
        tested = (REPOSITORY / "tests/requirements.txt").read_text().splitlines()
        self.assertEqual([pinned for pinned in needed.packages().values() if pinned not in tested], [])

    def test_what_is_missing_is_named_with_the_way_to_get_it(self):
        with mock.patch.object(needed, "is_missing", lambda module: module == "PIL"):
            with self.assertRaisesRegex(Failed, r"found no pillow; to get them: .*pip install .*pillow==.*EQUISTREAM_PYTHON="):
                needed.expect_packages("study")


if __name__ == "__main__":
    unittest.main()
