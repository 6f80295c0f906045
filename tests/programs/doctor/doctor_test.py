"""`equistream doctor` where things are there, hidden, broken, and where libraries crash or hang.

usage: doctor_test.py BIN_DIR HOSTILE_LIBRARY
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

LIMIT_S = 60
LIBRARY = pathlib.Path(sys.argv.pop(2))
BIN = pathlib.Path(sys.argv.pop(1))
CHECKS = ["programs", "hosts", "video", "processor", "opengl", "display", "hardware", "headset", "mitsuba", "denoiser", "network", "scenes", "python"]
COPIED = ("equistream", "equistream-doctor", "equistream-probe")


def doctor(*words, folder=BIN, **environment):
    changed = {name: value for name, value in {**os.environ, **environment}.items() if value is not None}
    limit = () if "--limit" in words else ("--limit", str(LIMIT_S))
    return subprocess.run([folder / "equistream", "doctor", *limit, *words], env=changed, text=True, capture_output=True, timeout=600)


class Doctor(unittest.TestCase):
    def found(self, *words, code=0, **options):
        done = doctor("--json", *words, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        report = json.loads(done.stdout)
        self.assertEqual([check["name"] for check in report["checks"]], CHECKS)
        self.assertEqual(report["is_ready"], code == 0)
        for check in report["checks"]:
            self.assertTrue(check["found"], check)
            self.assertNotIn("\n", check["found"])
            self.assertTrue(check["state"] == "ok" or check["to_get_it"], check)
        return {check["name"]: check for check in report["checks"]}

    def test_a_build_has_what_its_core_commands_need(self):
        found = self.found()
        for name in ("programs", "hosts", "video", "processor"):
            self.assertEqual(found[name]["state"], "ok", found[name])
        video = found["video"]["details"]
        self.assertTrue(all(video[codec][f"encodes_{bits}_bits"] and video[codec]["decoder"] for codec in ("H.264", "H.265") for bits in (8, 10)), video)
        flags = pathlib.Path("/proc/cpuinfo").read_text()
        if "avx2" in flags:
            self.assertGreaterEqual(found["processor"]["details"]["vector_bits"], 256)
        has_mitsuba = (BIN / "equistream-render-mitsuba").exists()
        self.assertEqual("mitsuba" in found["hosts"]["details"]["hosts"], has_mitsuba)
        self.assertEqual(found["mitsuba"]["state"], "ok" if has_mitsuba else "missing", found["mitsuba"])

    def test_the_table_has_a_row_a_check_and_says_what_is_missing(self):
        done = doctor(DISPLAY=None, EQUISTREAM_SCENES=None)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = done.stdout.splitlines()
        first_words = [line.split()[0] for line in lines if line[:1].strip()]
        self.assertEqual(first_words[:len(CHECKS) + 1], [*CHECKS, "The"])
        self.assertLessEqual(max(map(len, lines)), 101)
        row = next(i for i, line in enumerate(lines) if line.startswith("display"))
        self.assertEqual(lines[row].split(), ["display", "missing", "DISPLAY", "is", "not", "set"])
        self.assertIn("needed by: view", lines[row + 1])
        self.assertIn("to get it: ", lines[row + 2])
        self.assertIn("display", " ".join(lines[lines.index("") + 1:]))  # what is missing may take two lines

    def test_the_table_is_as_wide_as_the_terminal(self):
        lines = doctor(COLUMNS="60").stdout.splitlines()
        self.assertGreater(len(lines), len(CHECKS))
        for line in lines:  # a word may be longer
            self.assertTrue(len(line) <= 60 or len(line.split()[-1]) > 40 - len("needed by: "), line)

    def test_hidden_things_are_missing_and_core_commands_need_none_of_them(self):
        with tempfile.TemporaryDirectory() as empty:
            found = self.found(DISPLAY=":77", EQUISTREAM_SCENES=empty, EQUISTREAM_OIDN=f"{empty}/none.so", XR_RUNTIME_JSON=f"{empty}/none.json",
                               __EGL_VENDOR_LIBRARY_DIRS=empty, EQUISTREAM_PYTHON=f"{empty}/python3")
        for name, mention in (("opengl", "found none"), ("display", ":77"), ("headset", "XR_ERROR"), ("denoiser", "none.so"), ("scenes", "holds no .glb"),
                              ("python", "python3")):
            self.assertEqual(found[name]["state"], "missing", found[name])
            self.assertIn(mention, found[name]["found"])

    def test_scenes_beside_a_folder_that_may_not_be_read_are_listed(self):
        if os.geteuid() == 0:
            self.skipTest("root may read everything")
        names = [f"room-{i}" for i in range(20)]
        with tempfile.TemporaryDirectory() as folder:
            for name in names[:10] + ["lost+found"] + names[10:]:
                path = pathlib.Path(folder) / name
                path.with_suffix(".glb").touch() if name in names else path.mkdir(mode=0)
            found = self.found(EQUISTREAM_SCENES=folder)["scenes"]
        self.assertEqual((found["state"], found["details"]["models"]), ("ok", sorted(names)))

    def test_a_crash_and_a_hang_are_findings(self):
        crashed = self.found(EQUISTREAM_OIDN=str(LIBRARY), EQUISTREAM_TEST_DEED="crash")["denoiser"]
        self.assertEqual(crashed["state"], "broken")
        self.assertIn("crashed (Aborted)", crashed["found"])
        with tempfile.TemporaryDirectory() as folder:
            begin = time.monotonic()
            hung = self.alone(pathlib.Path(folder), "--limit", "1", EQUISTREAM_OIDN=str(LIBRARY), EQUISTREAM_TEST_DEED="hang")["denoiser"]
            self.assertLess(time.monotonic() - begin, 60)
        self.assertEqual((hung["state"], hung["found"]), ("broken", "no answer within 1 s"))

    def alone(self, folder, *words, **environment):
        """In a folder with nothing else of ours: core commands are missing."""
        for name in COPIED:
            shutil.copy(BIN / name, folder)
        return self.found(*words, code=1, folder=folder, **environment)

    def test_a_missing_program_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            found = self.alone(pathlib.Path(folder))
            self.assertIn("equistream-encode: No such file", found["programs"]["found"])
            self.assertEqual((found["hosts"]["state"], found["mitsuba"]["state"], found["python"]["state"]), ("missing", "missing", "broken"))
            self.assertIn("pip install mitsuba==", found["mitsuba"]["to_get_it"])
            done = doctor(folder=pathlib.Path(folder))
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr, "equistream doctor: the core commands lack programs and hosts\n")

    def test_a_program_that_does_not_start_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "equistream-encode").write_text("#!/bin/sh\necho error while loading shared libraries >&2\nexit 127\n")
            (pathlib.Path(folder) / "equistream-encode").chmod(0o755)
            found = self.alone(pathlib.Path(folder))
            self.assertIn("encode: failed with status 127: error while loading", found["programs"]["found"])

    def test_a_limit_must_be_a_time(self):
        done = doctor("--limit", "0")
        self.assertEqual((done.returncode, len(done.stderr.splitlines())), (2, 1))


if __name__ == "__main__":
    unittest.main()
