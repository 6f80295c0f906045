"""Programs that are killed (SIGKILL) at random moments: what is finished stays, nothing broken has a finished name, and the same
command run again ends in the bytes of a run that nothing interrupted.

usage: kills_test.py BIN_DIR [--kills N] [--jobs NAMES] [--seed N] [--report FILE]   (all else is unittest's)

FILE has each job as it was tried last, and of what versions. Killed live servers are held to what their viewers got: each run has other spheres.
"""

import argparse
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import OpenEXR

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from steps import provenance, write_whole  # noqa: E402

ARGUMENTS = argparse.ArgumentParser(description=__doc__)
ARGUMENTS.add_argument("bin", type=pathlib.Path)
ARGUMENTS.add_argument("--kills", type=int, default=4, help="of each job")
ARGUMENTS.add_argument("--jobs", default="", help="names between commas; default: all")
ARGUMENTS.add_argument("--seed", type=int, default=1)
ARGUMENTS.add_argument("--report", type=pathlib.Path)
TOLD, sys.argv[1:] = ARGUMENTS.parse_known_args()
RANDOM = random.Random(TOLD.seed)
TIMES = "machine", "milliseconds", "made", "wall_s", "cpu_s", "took_s", "measuring_cpu_s", "peak_memory_mib", "state"
"""Of reports and of the study's records, whose `state` is by when inputs were written. Records also say whether a killed run had begun the step."""
PICTURE, PAUSE = b"\x1f\x43\xb6\x75", b"\xec\x80"
"""Of a live stream: how each picture begins, and what a viewer alone is sent where none comes."""


def start(*words, stdout=subprocess.DEVNULL):
    return subprocess.Popen([TOLD.bin / "equistream", *map(str, words)], stdout=stdout, stderr=subprocess.PIPE, text=True)


def run(*words):
    process = start(*words)
    _, told = process.communicate(timeout=500)
    assert process.returncode == 0, told


def is_unfinished(path):
    return any(name.endswith((".part", ".aside", ".unfinished")) or ".tmp" in name for name in path.parts)


def unfinished(folder):
    return [str(path) for path in folder.rglob("*") if is_unfinished(path.relative_to(folder))]


def finished_files(folder):
    """All that have a name that says so, also while others come and go."""
    paths = (pathlib.Path(place, name) for place, _, names in os.walk(folder) for name in names if not name.startswith("."))
    return sorted(path for path in paths if not is_unfinished(path.relative_to(folder)) and path.suffix not in (".lock", ".log", ".out"))


def finished(folder):
    """Their bytes."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in finished_files(folder)}


def is_at_work(place):
    """Whether a program runs whose words name the place."""
    return any(str(place).encode() in words_of(process) for process in pathlib.Path("/proc").glob("[0-9]*"))


def words_of(process):
    try:
        return (process / "cmdline").read_bytes()
    except OSError:
        return b""


def children_of(process):
    """Their folders in /proc."""
    found = []
    for file in pathlib.Path(f"/proc/{process}/task").glob("*/children"):
        try:
            found += [pathlib.Path("/proc") / child for child in file.read_text().split()]
        except OSError:  # the thread has gone
            pass
    return found


def without_times(name, data):
    """Reports say how long things took; all else of them must be the same."""
    if not name.endswith(".json"):
        return data
    def stripped(value):
        if isinstance(value, dict):
            return {key: stripped(item) for key, item in value.items() if key not in (*TIMES, "resumed") and not key.endswith("_ms")}
        return [stripped(item) for item in value] if isinstance(value, list) else value
    return stripped(json.loads(data))


class Killed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_kills_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        os.environ["TMPDIR"] = str(cls.root)  # killed programs leave their temporary folders

    def assert_same(self, file, data, expected, when):
        if without_times(file, data) == without_times(file, expected):
            return
        first = next((i for i, (a, b) in enumerate(zip(data, expected, strict=False)) if a != b), min(len(data), len(expected)))
        self.fail(f"{when}: {file} differs from byte {first} on: {data[first - 20 : first + 20]} for {expected[first - 20 : first + 20]}")

    def place_of(self, name):
        if TOLD.jobs and name not in TOLD.jobs.split(","):
            self.skipTest("another job was asked for")
        self.made = provenance(TOLD.bin, REPOSITORY)
        place = self.root / name
        place.mkdir()
        return place

    def report(self, name, kills, found, to_the_end, duration_s):
        """So far: a run that is stopped has told what it tried, and other jobs may be tried beside it."""
        if not TOLD.report:
            return
        report = json.loads(TOLD.report.read_text()) if TOLD.report.exists() else {"jobs": {}}
        report["jobs"][name] = {"kills": kills, "finished_files_checked": found, "resumed_to_the_end": to_the_end, "seconds_uninterrupted": round(duration_s, 2), "seed": TOLD.seed,
                                **self.made}
        write_whole(TOLD.report, json.dumps(report, indent=1) + "\n")

    def survives(self, name, words, out_name="out", resumes=True, out_option="--out"):
        """Kills the job again and again. `resumes`: it goes on with what the killed run has finished; else it begins anew."""
        place = self.place_of(name)
        words = [*words, out_option, place / out_name]
        begun = time.monotonic()
        run(*words)
        duration_s = time.monotonic() - begun
        expected = finished(place)
        self.assertTrue(expected)
        shutil.rmtree(place)
        kills = found = anew = 0
        while kills < TOLD.kills:
            place.mkdir(exist_ok=True)
            kept = finished(place)
            process = start(*words)
            time.sleep(RANDOM.uniform(0, 1.1 * duration_s))
            process.send_signal(signal.SIGKILL)
            _, told = process.communicate()
            kills += process.returncode == -signal.SIGKILL
            if process.returncode != -signal.SIGKILL:
                self.assertEqual(process.returncode, 0, told)
            left = finished(place)
            for file, data in left.items():
                self.assertIn(file, expected.keys())
                beside = [other for other in left if pathlib.Path(other).parent == pathlib.Path(file).parent and other != file]
                if file.endswith("manifest.json") and not beside or file.endswith("report.json"):
                    continue  # both mark a folder as their program's, and say the rest once there is something to say it of
                self.assert_same(file, data, expected[file], f"{name} after a kill")
            if resumes:
                self.assertLessEqual(kept.keys(), left.keys(), f"{name}: what was finished is gone")
            found += len(left)
            is_over = left.keys() == expected.keys()
            if is_over or RANDOM.random() < 0.3:
                if not is_over:
                    run(*words)
                self.assert_is_over(place, expected, name)
                anew += 1
                shutil.rmtree(place)
            self.report(name, kills, found, anew, duration_s)
        shutil.rmtree(place, ignore_errors=True)
        self.kill_halfway(place, words, expected, None if resumes else duration_s / 2)
        run(*words)
        self.assert_is_over(place, expected, name)
        self.report(name, kills + 1, found, anew + 1, duration_s)

    def assert_is_over(self, place, expected, name):
        again = finished(place)
        self.assertEqual(again.keys(), expected.keys())
        self.assertEqual(unfinished(place), [])
        for file, data in again.items():
            self.assert_same(file, data, expected[file], f"{name} after it was resumed")

    def kill_halfway(self, place, words, expected, after_s):
        """After this time, or else once half of the files are finished; anew where that was too late."""
        for _ in range(10):
            place.mkdir()
            process, begun = start(*words), time.monotonic()
            while process.poll() is None and (time.monotonic() - begun < after_s if after_s else 2 * len(finished_files(place)) < len(expected)):
                time.sleep(0.02)
            process.kill()
            process.communicate()
            if process.returncode == -signal.SIGKILL and finished(place).keys() < expected.keys():
                return
            shutil.rmtree(place)
        self.fail("it was over each time before it was killed")


class Kills(Killed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene, cls.frames, cls.foreign = cls.root / "scene" / "motion.json", cls.root / "frames", cls.root / "foreign"
        run("scene", "generate", "motion", "--out", cls.scene.parent)
        run("render", cls.scene, "--frames", "0-5", "--size", "192x96", "--spp", 4, "--aovs", "depth", "--out", cls.frames)
        cls.foreign.mkdir()
        for index, source in enumerate(sorted((cls.frames / "centre").glob("*.exr"))):
            with OpenEXR.File(str(source)) as file:
                channels = file.parts[0].channels
                rgb = np.stack([channels[c].pixels for c in "RGB"], axis=-1) if "R" in channels else channels["RGBA"].pixels[..., :3]
            OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": np.ascontiguousarray(rgb, np.float32)}).write(
                str(cls.foreign / f"shot.{index + 1:04d}.exr")
            )

    def test_render(self):
        self.survives("render", ["render", self.scene, "--frames", "0-7", "--size", "192x96", "--spp", 8, "--aovs", "depth,motion"])

    def test_render_mitsuba(self):
        if not (TOLD.bin / "equistream-render-mitsuba").exists():
            self.skipTest("built without Mitsuba")
        self.survives("mitsuba", ["render", self.scene, "--host", "mitsuba", "--frames", "0-3", "--size", "96x48", "--spp", 4])

    def test_conversion_ends_with_a_killed_render(self):
        """The program that converts a scene for Mitsuba is stopped and its render killed. When it may go on, it must end."""
        if not (TOLD.bin / "equistream-render-mitsuba").exists():
            self.skipTest("built without Mitsuba")
        place = self.place_of("conversion")
        process = start("render", self.scene, "--host", "mitsuba", "--frames", 0, "--size", "96x48", "--spp", 1, "--out", place / "out")
        converter = None
        while converter is None and process.poll() is None:
            # Until its program begins, a child has its parent's words, and its standard error.
            converter = next((child for child in children_of(process.pid) if words_of(child).split(b"\0")[1:2] == [b"convert"]), None)
        self.assertIsNotNone(converter, "nothing was converted")
        os.kill(int(converter.name), signal.SIGSTOP)
        self.addCleanup(lambda: converter.exists() and os.kill(int(converter.name), signal.SIGCONT))
        while "T" != re.search(r"State:\s+(\w)", (converter / "status").read_text())[1]:
            time.sleep(0.001)
        process.kill()
        process.communicate()
        waiting = int(re.search(r"ShdPnd:\s+(\w+)", (converter / "status").read_text())[1], 16)
        self.assertTrue(waiting & 1 << signal.SIGTERM - 1, "it is not told to end")
        os.kill(int(converter.name), signal.SIGCONT)
        deadline = time.monotonic() + 60
        while is_at_work(place):
            self.assertLess(time.monotonic(), deadline, "it goes on")
            time.sleep(0.01)

    def test_render_accumulated(self):
        self.survives("accumulate", ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", 4, "--accumulate", 8])

    def test_render_patches(self):
        self.survives("patches", ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", 2, "--patches", "--layers", "--small", "right"])

    def test_render_window(self):
        self.survives("window", ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", 2, "--window", "gaze,90x60"])

    def test_encode(self):
        self.survives("encode", ["encode", self.frames, "--depth", "auto"], "walk.mp4", resumes=False)

    def test_import(self):
        self.survives("import", ["import", self.foreign / "shot.####.exr"])

    def test_play(self):
        self.survives("play", ["play", self.frames, "--method", "rotation", "--size", "96x64"], resumes=False)

    def test_model(self):
        self.survives(
            "model", ["model", self.scene, "--rays", 20000, "--visibility-rays", 200000, "--quantile", 0.9], "model.json", resumes=False
        )

    def served(self, out, kill_after_s=3600.0):
        """A viewer takes some pictures, then the server is told to end, if it is not killed before. Its status, and what the viewer got."""
        process, got, is_told = start("serve", self.scene, "--listen", "tcp://127.0.0.1:0", "--size", "128x64", "--spp", 1, "--out", out, stdout=subprocess.PIPE), b"", False
        killer = threading.Timer(kill_after_s, process.kill)
        killer.start()
        try:
            if address := process.stdout.readline():
                with socket.create_connection(("127.0.0.1", int(address.rsplit(":", 1)[1]))) as viewer:
                    while block := viewer.recv(1 << 16):
                        got += block
                        if got.count(PICTURE) >= 40 and not is_told:
                            process.terminate()
                            is_told = True
        except OSError:  # it was killed
            pass
        _, told = process.communicate(timeout=500)
        killer.cancel()
        self.assertIn(process.returncode, (0, -signal.SIGKILL), told)
        return process.returncode, got.replace(PAUSE, b"")

    def assert_holds(self, file, got, is_whole):
        """All that the viewer got, for programs to read."""
        stream = self.root / "compared.mkv"
        stream.write_bytes(file.read_bytes())
        self.assertTrue(stream.read_bytes().replace(PAUSE, b"").startswith(got), f"{file.name} lacks what a viewer got")
        said = json.loads(subprocess.run([TOLD.bin / "equistream", "info", stream, "--frames", "--json"], capture_output=True, text=True, check=True).stdout)
        self.assertTrue(said["whole"] or not is_whole, said["truncation"])
        for track in said["tracks"]:  # the first picture of a group begins twice, once for each track
            self.assertGreaterEqual(2 * len(track["frames"]) + 2, got.count(PICTURE))

    def test_serve(self):
        place, begun = self.place_of("serve"), time.monotonic()
        out, part = place / "all.mkv", place / "all.mkv.part"
        self.served(out)
        duration_s = time.monotonic() - begun
        kills = found = to_the_end = 0
        while kills < TOLD.kills:
            before = out.read_bytes()
            status, got = self.served(out, RANDOM.uniform(0, 1.1 * duration_s))
            kills += status != 0
            if out.read_bytes() != before:
                self.assert_holds(out, got, is_whole=True)
                self.assertEqual(unfinished(place), [])
                to_the_end += 1
            else:
                self.assertNotEqual(status, 0)
                if PICTURE in got:
                    self.assert_holds(part, got, is_whole=False)
                    found += 1
            deadline = time.monotonic() + 60
            while is_at_work(self.root):
                self.assertLess(time.monotonic(), deadline, "its renderer goes on")
                time.sleep(0.05)
            self.report("serve", kills, found, to_the_end, duration_s)
        self.assertEqual(self.served(out)[0], 0)
        self.assertEqual(unfinished(place), [])


class Studies(Killed):
    def test_study(self):
        """An experiment whose values are kept one by one, and its charts."""
        self.survives("study", ["study", "--preset", "smoke", "--experiments", "stability"])

    def test_study_job(self):
        """What a farm renders of it: steps with records."""
        plan = self.root / "plan"
        plan.mkdir()
        (plan / "study-smoke.jobs.json").write_text(json.dumps([{"scene": "motion", "render": "truth-21", "first": 0, "last": 1, "seconds": 1}]))
        self.survives("study-job", ["study", "--preset", "smoke", "--job", 0, "--out", plan], "work", out_option="--work")


if __name__ == "__main__":
    unittest.main()
