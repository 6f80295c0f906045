#!/usr/bin/env python3
"""Runs the golden tests and keeps what they print: orientation, depth, motion, furnace and metrics (docs/results/renderer/checks.json).

    checks.py [--build build/release] [--out FILE]
"""

import argparse
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from kept import result_text  # noqa: E402
from steps import machine, versions, write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
TESTS = r"^golden\.(depth|motion|furnace|metrics|orientation)$"
# unittest's dots stand before what a test prints.
FIGURES = re.compile(r"\d+: \.*([^.\s].*: .*\d.*)")
NOT_FIGURES = re.compile(r"\d+: Test (command|timeout)")
PASSED = re.compile(r"\d+/\d+ Test\s+#\d+: (\S+) \.+\s+(\S+)")


def printed(build):
    """{test: the lines it printed}; a test that fails ends the run."""
    run = subprocess.run(["ctest", "--test-dir", str(build), "-V", "-R", TESTS], capture_output=True, text=True)
    lines, figures = [], {}
    for line in run.stdout.splitlines():
        if verdict := PASSED.search(line):
            figures[verdict[1]] = lines
            if verdict[2] != "Passed":
                sys.exit(f"checks.py: {verdict[1]}: expected it to pass, found {verdict[2]}")
            lines = []
        elif not NOT_FIGURES.match(line) and (said := FIGURES.match(line)):
            lines.append(said[1])
    if run.returncode != 0 or not figures:
        sys.exit(f"checks.py: {build}: expected golden tests that pass, found ctest's exit {run.returncode} and {len(figures)} tests")
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=REPOSITORY / "build/release")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/renderer/checks.json")
    options = parser.parse_args()
    result = {"command": f"./test -V -R '{TESTS}'", "versions": versions(options.build / "bin/equistream", REPOSITORY), "machine": machine(),
              "printed": printed(options.build)}
    write_whole(options.out, result_text(result))
    print(options.out)


if __name__ == "__main__":
    main()
