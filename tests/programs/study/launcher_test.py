#!/usr/bin/env python3
"""What starts `equistream study`, `fit` and `farm`, in environments that tell Python to do otherwise."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from steps import HERE

READS = "import pathlib, sys; print(sys.argv[-1], pathlib.Path(sys.argv[-1]).read_text())\n"


class Launcher(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def started(self, study, command, *words, **environment):
        """As the build makes the program."""
        text = (HERE / "launcher.in").read_text(encoding="utf-8")
        for key, value in {"python": sys.executable, "package_folder": self.folder, "study_folder": study, "command": command}.items():
            text = text.replace(f"@{key}@", str(value))
        program = self.folder / f"equistream-{command}"
        program.write_text(text, encoding="utf-8")
        done = subprocess.run(["sh", program, *words], cwd=self.folder, env={**os.environ, **environment}, capture_output=True, encoding="utf-8")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_text_is_utf8_in_any_locale(self):
        (self.folder / "reads.py").write_text(READS)
        (self.folder / "Möbel").write_text("Stühle", encoding="utf-8")
        self.assertEqual(self.started(self.folder, "reads", "Möbel", LC_ALL="C", PYTHONUTF8="0"), "Möbel Stühle\n")

    def test_commands_describe_themselves_where_python_is_told_to_leave_descriptions_out(self):
        for command in ("study", "fit", "farm"):
            self.assertIn(f"usage: equistream {command} ", self.started(HERE, command, "--help", PYTHONOPTIMIZE="2"))


if __name__ == "__main__":
    unittest.main()
