#!/usr/bin/env python3
"""Steps are skipped as long as what they would make is what is there, and no longer."""

import os
import pathlib
import tempfile
import unittest

from steps import Steps

PROGRAM = '#!/bin/sh\ncp "$2" "$4" && echo run >> runs\n'


class SkippedSteps(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.work = pathlib.Path(holder.name).resolve()
        (self.work / "bin").mkdir()
        (self.work / "given").mkdir()
        self.program = self.work / "bin/equistream"
        self.program.write_text(PROGRAM)
        self.program.chmod(0o755)
        self.write("given/a", "1", at=1000)

    def write(self, name, text, at):
        (self.work / name).write_text(text)
        os.utime(self.work / name, (at, at))

    def run_step(self, *options, given="given/a", fresh=None):
        Steps(self.work, self.work / "bin", {}, {}).run("copy", "do", given, "--out", "made", *options, fresh=fresh)
        return (self.work / "runs").read_text().count("run")

    def test_the_same_is_not_done_twice(self):
        self.assertEqual([self.run_step(), self.run_step()], [1, 1])

    def test_another_command_program_or_input_is(self):
        self.assertEqual(self.run_step(), 1)
        self.assertEqual(self.run_step("--loud"), 2)
        self.program.write_text(PROGRAM + "# another\n")
        self.assertEqual(self.run_step("--loud"), 3)
        made = (self.work / "steps/copy.json").stat().st_mtime
        self.write("given/a", "2", at=made + 10)
        self.assertEqual(self.run_step("--loud"), 4)
        self.assertEqual((self.work / "made").read_text(), "2")

    def test_inputs_elsewhere_count_too_and_programs_not_for_renders(self):
        with tempfile.TemporaryDirectory() as elsewhere:
            scene = pathlib.Path(elsewhere) / "scene"
            scene.write_text("1")
            os.utime(scene, (1000, 1000))
            self.assertEqual(self.run_step(given=scene, fresh="made"), 1)
            self.program.write_text(PROGRAM + "# another\n")
            self.assertEqual(self.run_step(given=scene, fresh="made"), 1)
            made = (self.work / "steps/copy.json").stat().st_mtime
            os.utime(scene, (made + 10, made + 10))
            self.assertEqual(self.run_step(given=scene, fresh="made"), 2)


if __name__ == "__main__":
    unittest.main()
