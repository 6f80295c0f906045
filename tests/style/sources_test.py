#!/usr/bin/env python3
"""Rules that no run on this machine would show to be broken.

Shaders say isnan() where a number may be unknown: `!(k >= 0.0)` is true of NaN by IEEE 754, and NVIDIA's compiler (driver 580.159) made `k < 0.0` of it, which
is not. Drivers on the CPU keep to IEEE. The test finds comparisons of names and numbers alone. And no C++ program reads the time of day, so that a clock that
jumps changes nothing.
"""

import pathlib
import re
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
NEGATED = re.compile(r"!\([\w.\[\]]+ [<>]=? [\w.]+\)")
TIME_OF_DAY = re.compile(r"\b(system_clock|gettimeofday|CLOCK_REALTIME|high_resolution_clock|last_write_time|std::time|time\(nullptr\)|timespec_get|localtime|gmtime|system_timer|deadline_timer)")


def files(folders, *patterns):
    return [file for folder in folders for pattern in patterns for file in (REPOSITORY / folder).rglob(pattern)]


def lines_with(pattern, found_in):
    return [f"{file.relative_to(REPOSITORY)}:{number}: {line.strip()}" for file in found_in for number, line in enumerate(file.read_text().splitlines(), 1)
            if pattern.search(line)]


class Sources(unittest.TestCase):
    def test_shaders_negate_no_comparison(self):
        shaders = files(("client", "plugin/formulas"), "*.glsl", "*.glsl.h")
        self.assertGreater(len(shaders), 50)
        self.assertTrue(NEGATED.search("if (!(k[i] >= 0.0))"))
        self.assertEqual(lines_with(NEGATED, shaders), [])

    def test_programs_read_no_time_of_day(self):
        sources = files(("client", "plugin", "host-adapters", "programs"), "*.cpp", "*.h")
        self.assertGreater(len(sources), 300)
        self.assertTrue(TIME_OF_DAY.search("std::chrono::system_clock::now()"))
        self.assertEqual(lines_with(TIME_OF_DAY, sources), [])


if __name__ == "__main__":
    unittest.main()
