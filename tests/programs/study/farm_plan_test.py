#!/usr/bin/env python3
"""What `equistream farm` takes for a job, and what it writes, without the programs: its scripts run with others in place of Slurm."""

import contextlib
import io
import os
import pathlib
import re
import subprocess
import tempfile
import types
import unittest
from unittest import mock

from farm import report
from farming import jobs, slurm
from steps import Refused

PROGRAMS = {"equistream": "", "squeue": "", "sbatch": "pwd >> submissions; echo 7"}
PLAN = {"name": "farm", "measured": {}, "frames": 2, "steps": [jobs.step("render", "run", tasks=2)]}


class Submitted(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.root = pathlib.Path(holder.name).resolve()
        for name in ("tools", "here"):
            (self.root / name).mkdir()
        for name, text in PROGRAMS.items():
            (self.root / "tools" / name).write_text(f"#!/bin/sh\n{text}\n")
            (self.root / "tools" / name).chmod(0o755)

    def farm_in(self, folder):
        (self.root / folder).mkdir(parents=True)
        for name, text in slurm.scripts(PLAN).items():
            (self.root / folder / name).write_text(text)

    def told(self, out):
        """The line for Slurm that a user is told."""
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            report(PLAN, types.SimpleNamespace(json=False, out=pathlib.Path(out)))
        return re.search(r"Slurm: +(.*) \[options of sbatch\]", said.getvalue())[1]

    def submit(self, line, **environment):
        environment = {**os.environ, "PATH": f"{self.root}/tools:{os.environ['PATH']}", **environment}
        done = subprocess.run(["sh", "-c", line], cwd=self.root / "here", env=environment, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        return done.stdout

    def test_it_is_the_farm_here_and_none_that_cdpath_names(self):
        self.farm_in("here/farm")
        self.farm_in("others/farm")
        before = sorted(os.listdir(self.root / "others/farm"))
        said = self.submit(self.told("farm"), CDPATH=str(self.root / "others"))
        self.assertEqual(said, "submitted; squeue --me lists the jobs, logs/ has what they say\n")
        self.assertEqual((self.root / "here/farm/submissions").read_text(), f"{self.root}/here/farm\n")
        self.assertEqual(sorted(os.listdir(self.root / "others/farm")), before)

    def test_a_folder_may_begin_with_a_dash(self):
        self.farm_in("here/-ff")
        self.submit(self.told("-ff"))
        self.assertEqual((self.root / "here/-ff/submissions").read_text(), f"{self.root}/here/-ff\n")


class Names(unittest.TestCase):
    """Of bytes that JSON cannot have."""

    def test_words_are_refused(self):
        self.assertEqual(jobs.checked_lines(["encode", "Möbel"]), [["encode", "Möbel"]])
        with self.assertRaisesRegex(Refused, r"^expected a job in UTF-8, as plan\.json is, found 'd\\xff/frames'; rename what it names$"):
            jobs.checked_lines(["encode", "a", "--", "encode", os.fsdecode(b"d\xff/frames")])

    def test_a_settings_files_out_is_refused(self):
        for out in ("Möbel", "d\ufffd/frames"):
            with mock.patch.object(jobs, "asked_of", return_value={"out": out}):
                if out == "Möbel":
                    self.assertEqual(jobs.checked_render(["render", "a.json"], "equistream")["out"], out)
                else:
                    with self.assertRaisesRegex(Refused, r"^--settings: expected an out in UTF-8, as plan\.json is, found 'd\ufffd/frames'; rename it$"):
                        jobs.checked_render(["render", "a.json"], "equistream")


if __name__ == "__main__":
    unittest.main()
