"""Every command that writes, against every way in which writing fails: a full disk, a limit on files' sizes (ulimit -f), a read-only folder, another run at
work in the same place. And whatever a scene names that is no file. A command ends with one line and the right exit status, no broken file has a finished
name, what was finished before keeps its bytes, and the same command later ends in the bytes of a run that nothing disturbed.

usage: faults_test.py BIN_DIR   (the folder of the built programs)

Mounting needs rights. Where users may have them in a namespace of their own the test takes one; elsewhere what mounts is skipped.
"""

import contextlib
import functools
import json
import os
import pathlib
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import typing
import unittest

from kills_test import PICTURE, TOLD, finished, unfinished, without_times

FULL, LIMITED, READ_ONLY = "No space left on device", "File too large", "Read-only file system"
MOST_MEMORY_MIB = 1300
"""Of any command here. One that reads a device without an end soon has more."""


class Job(typing.NamedTuple):
    """A command, all but its --out."""

    words: list
    out: str = "out"
    keeps: bool = True
    """Whether a run that replaces an earlier one leaves it as it was until it has something better. Views of play make way at once."""
    replaces: tuple = ()
    """Options with which a run takes the place of one that is whole."""
    goes_on: tuple = ()
    """Options with which a run goes on where another was stopped, if it needs any."""
    is_kept_in_part: bool = True
    """Whether a disk that has room for some of it gets that."""


OVERWRITE = ("--overwrite",)
JOBS = {
    "render": Job(["render", "SCENE", "--frames", "0-2", "--size", "128x64", "--spp", 1, "--aovs", "depth"], replaces=OVERWRITE),
    "import": Job(["import", "FRAMES/centre"], replaces=OVERWRITE),
    "encode": Job(["encode", "FRAMES", "--preset", "ultrafast", "--crf", 1, "--gop", 1], "a.mkv"),
    "encode to MP4": Job(["encode", "FRAMES", "--preset", "ultrafast", "--crf", 1, "--gop", 1], "a.mp4"),
    "play": Job(["play", "FRAMES", "--method", "rotation", "--size", "64x36"], keeps=False),
    "play to a video": Job(["play", "FRAMES", "--method", "rotation", "--size", "128x72"], "eyes.mp4", replaces=OVERWRITE),
    "export": Job(["export", "FRAMES"], replaces=OVERWRITE, goes_on=OVERWRITE),
    "model": Job(["model", "SCENE", "--rays", 20000, "--visibility-rays", 20000, "--quantile", 0.9], "model.json", is_kept_in_part=False),
}


def limit_to(size):
    """For a program before it starts."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_faults_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.place, cls.scene, cls.frames = cls.root / "place", cls.root / "scene/motion.json", cls.root / "frames"
        cls.stream = cls.place / "all.mkv"
        cls.place.mkdir()
        for words, out in ((["scene", "generate", "motion"], cls.scene.parent), (JOBS["render"].words, cls.frames)):
            made = cls.run_command(words, out)
            assert made.returncode == 0, made.stderr

    @classmethod
    def command(cls, words, out, *more):
        named = [str(word).replace("SCENE", str(cls.scene)).replace("FRAMES", str(cls.frames)) for word in (*words, *more)]
        return [TOLD.bin / "equistream", *named, "--out", out]

    @classmethod
    def run_command(cls, words, out, *more, **options):
        return subprocess.run(cls.command(words, out, *more), capture_output=True, text=True, timeout=60, **options)

    @classmethod
    def clear(cls):
        for path in cls.place.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    def setUp(self):
        self.addCleanup(self.clear)

    @classmethod
    @functools.cache
    def whole(cls, name):
        """What the job makes where nothing disturbs it. It is run in the place of the others, which files name."""
        cls.clear()
        made = cls.run_command(JOBS[name].words, cls.place / JOBS[name].out)
        assert made.returncode == 0, made.stderr
        files = finished(cls.place)
        cls.clear()
        return files

    def do(self, job, *more, **options):
        return self.run_command(job.words, self.place / job.out, *more, **options)

    def assert_refused(self, result, code, *mentions):
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(lines), 1, result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), lines[0])

    def assert_done(self, result):
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def assert_whole(self, name, more=()):
        """All of the job is there, as if nothing had happened. `more`: options it was run with, which reports tell."""
        found, expected = finished(self.place), self.whole(name)
        self.assertEqual(found.keys(), expected.keys())
        self.assertEqual(unfinished(self.place), [])
        for file, data in found.items():
            if more and file.endswith(".json"):
                continue
            self.assertEqual(without_times(file, data), without_times(file, expected[file]), file)

    def assert_nothing_broken(self, name, line):
        """What was made by a run that failed is whole. A stream that is not has another name, which the run's line tells, and is readable."""
        left, expected = finished(self.place), self.whole(name)
        for file, data in left.items():
            if file.endswith(("manifest.json", "report.json")):
                json.loads(data)  # it tells of what there is
            else:
                self.assertEqual(data, expected[file], file)
        parts = unfinished(self.place)
        self.assertEqual([part for part in parts if f"kept in {part}" not in line], [])
        for part in parts:
            told = subprocess.run([TOLD.bin / "equistream", "info", part], capture_output=True, text=True)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertIn("not whole", told.stdout)
        return [file for file in left if not file.endswith(".json")] + parts

    def stopped(self, name, cause, fault, some_is_kept):
        """The job with a fault in an empty place, then without it. `fault`: a context that gives options to run with."""
        job = JOBS[name]
        with fault as options:
            result = self.do(job, **options)
        self.assert_refused(result, 1, (self.place / job.out).with_suffix(""), cause)
        made = self.assert_nothing_broken(name, result.stderr)
        self.assertEqual(bool(made), some_is_kept, made)
        again = self.do(job, *job.goes_on)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assert_whole(name)

    def stopped_over_earlier(self, name, cause, fault):
        """The same in the place of what is whole."""
        job, before = JOBS[name], finished(self.place)
        with fault as options:
            result = self.do(job, *job.replaces, **options)
        self.assert_refused(result, 1, (self.place / job.out).with_suffix(""), cause)
        self.assertEqual(finished(self.place), before)
        self.assert_done(self.do(job, *job.replaces))
        self.assert_whole(name, job.replaces)

    @contextlib.contextmanager
    def own_disk(self):
        """A small file system, where all is written to."""
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", self.place], stderr=subprocess.DEVNULL)
        if os.geteuid() != 0 or mounted.returncode != 0:
            self.skipTest("this machine lets nobody mount a small file system")
        try:
            yield
        finally:
            subprocess.run(["umount", self.place], check=True)

    @contextlib.contextmanager
    def filled(self, room=0):
        """All of that disk but so many bytes."""
        status, filler = os.statvfs(self.place), self.place / ".filler"
        filler.write_bytes(bytes(max(0, status.f_bavail * status.f_frsize - room)))
        try:
            yield {}
        finally:
            filler.unlink()

    def remount(self, how):
        subprocess.run(["mount", "-o", f"remount,{how}", self.place], check=True)

    def test_a_full_disk(self):
        for name, job in JOBS.items():
            needed = sum(map(len, self.whole(name).values()))
            with self.subTest(name), self.own_disk():
                for share in (0, 0.6):  # of the room it needs
                    self.clear()
                    self.stopped(name, FULL, self.filled(int(share * needed)), some_is_kept=share > 0 and job.is_kept_in_part)
                if job.keeps:
                    self.stopped_over_earlier(name, FULL, self.filled())

    def test_a_limit_on_the_size_of_files(self):
        """Half of the largest file's, of a model the smallest one's. The signal of that limit (SIGXFSZ) ends nobody."""
        for name in JOBS:
            chosen = min if name == "model" else max  # see there
            size = chosen(map(len, self.whole(name).values())) // 2
            limited = contextlib.nullcontext({"preexec_fn": functools.partial(limit_to, size)})
            with self.subTest(name):
                self.clear()
                self.stopped(name, LIMITED, limited, some_is_kept=JOBS[name].out.endswith((".mkv", ".mp4")))
                if JOBS[name].keeps:
                    self.stopped_over_earlier(name, LIMITED, limited)

    def test_a_video_of_each_eye(self):
        """Where both fail, neither gets its finished name."""
        job = Job(["play", "FRAMES", "--method", "rotation", "--size", "128x72", "--format", "mp4"])

        def videos():
            return {file.name: file.read_bytes() for file in self.place.rglob("*.mp4")}

        self.assert_done(self.do(job))
        whole = videos()
        self.assertEqual(whole.keys(), {"left.mp4", "right.mp4"})
        self.clear()
        self.assert_refused(self.do(job, preexec_fn=functools.partial(limit_to, max(map(len, whole.values())) // 2)), 1, self.place / job.out, LIMITED)
        self.assertEqual(videos(), {})
        self.assert_done(self.do(job))
        self.assertEqual(videos(), whole)

    def test_a_read_only_folder(self):
        for name, job in JOBS.items():
            with self.subTest(name), self.own_disk():
                self.remount("ro")
                self.assert_refused(self.do(job), 2, self.place, READ_ONLY)
                self.assertEqual(list(self.place.iterdir()), [])
                self.remount("rw")
                self.assert_done(self.do(job))
                before = finished(self.place)
                self.remount("ro")
                self.assert_refused(self.do(job, *job.replaces), 2, self.place, READ_ONLY)
                self.assertEqual(finished(self.place), before)

    def all_files(self):
        found = {}
        for path in self.place.rglob("*"):
            with contextlib.suppress(FileNotFoundError, IsADirectoryError):  # others come and go
                found[path] = path.read_bytes()
        return found

    def begun(self, name):
        """A run that has begun to write, and was stopped. Anew where it was over before that."""
        job = JOBS[name]
        for _ in range(20):
            self.clear()
            process = subprocess.Popen(self.command(job.words, self.place / job.out), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            while process.poll() is None and not any(map(len, self.all_files().values())):
                time.sleep(0.001)
            process.send_signal(signal.SIGSTOP)
            os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
            if process.poll() is None and finished(self.place).keys() < self.whole(name).keys():
                return process
            process.kill()
            process.communicate()
        self.fail("it was over each time before it was stopped")

    def test_two_runs_at_once(self):
        for name in JOBS:
            with self.subTest(name):
                self.whole(name)
                job, first = JOBS[name], self.begun(name)
                try:
                    there = self.all_files()
                    for more in {(), job.replaces}:
                        self.assert_refused(self.do(job, *more), 2, self.place / job.out, "no other process")
                    self.assertEqual(self.all_files(), there)
                finally:
                    first.send_signal(signal.SIGCONT)
                    _, told = first.communicate(timeout=60)
                self.assertEqual((first.returncode, told), (0, ""))
                self.assert_whole(name)

    @contextlib.contextmanager
    def served(self, **options):
        """A live server that writes what it sends, and its first viewer."""
        words = ["serve", "SCENE", "--listen", "tcp://127.0.0.1:0", "--size", "128x64", "--spp", 1, "--crf", 1, "--progress", "none"]
        process = subprocess.Popen(self.command(words, self.stream), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
        killer = threading.Timer(60, process.kill)
        killer.start()
        try:
            with socket.create_connection(("127.0.0.1", int(process.stdout.readline().rsplit(":", 1)[1]))) as viewer:
                yield process, viewer
        finally:
            killer.cancel()
            process.kill()
            process.communicate()

    def served_until(self, process, viewer, pictures=None):
        """Tells the server to end once the viewer has so many pictures, if it does not end by itself."""
        got, is_told = b"", False
        while block := viewer.recv(1 << 16):
            got += block
            if pictures and got.count(PICTURE) >= pictures and not is_told:
                process.terminate()
                is_told = True
        _, told = process.communicate(timeout=60)
        return subprocess.CompletedProcess((), process.returncode, "", told)

    def info_of(self, stream):
        return json.loads(subprocess.run([TOLD.bin / "equistream", "info", stream, "--json"], capture_output=True, check=True).stdout)

    def assert_served_whole(self):
        with self.served() as (process, viewer):
            self.assert_done(self.served_until(process, viewer, 3))
        self.assertEqual(list(self.place.iterdir()), [self.stream])
        self.assertTrue(self.info_of(self.stream)["whole"])

    def serve_stopped(self, cause, fault):
        self.assert_served_whole()
        before, part = finished(self.place), f"{self.stream}.part"
        with fault as options, self.served(**options) as (process, viewer):
            self.assert_refused(self.served_until(process, viewer), 1, self.stream, cause, f"kept in {part}")
        self.assertEqual(finished(self.place), before)
        self.assertFalse(self.info_of(part)["whole"])
        self.assert_served_whole()

    def test_serve(self):
        """What it sends differs each time. The limit lets frames be written, which a renderer hands over in files, and stops the stream of many."""
        self.serve_stopped(LIMITED, contextlib.nullcontext({"preexec_fn": functools.partial(limit_to, 70_000)}))
        self.clear()
        with self.served() as (process, viewer):
            viewer.recv(1, socket.MSG_PEEK)
            with self.served() as (second, other):
                self.assert_refused(self.served_until(second, other), 2, self.stream, "no other process")
            self.assert_done(self.served_until(process, viewer, 2))
        self.assertTrue(self.info_of(self.stream)["whole"])
        self.clear()
        with self.own_disk():
            self.serve_stopped(FULL, self.filled(40_000))
            self.remount("ro")
            self.assert_refused(self.run_command(["serve", "SCENE", "--listen", "tcp://127.0.0.1:0"], self.stream), 2, self.stream, READ_ONLY)

    def test_settings_without_an_end(self):
        """Of a program and of a script."""
        for command in ("render", "study"):
            with self.subTest(command):
                told = subprocess.run([TOLD.bin / "equistream", command, "--settings", "/dev/zero", "--out", self.place], capture_output=True, text=True,
                                      timeout=60, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30)))
                self.assertEqual(told.returncode, 2, told.stderr)
                self.assertIn("/dev/zero: expected a file of at most 1 MiB", told.stderr.splitlines()[-1])

    def test_a_scene_that_names_no_file(self):
        """A named pipe that nobody fills, a folder, and a device without an end."""
        scene, described = self.place / "scene.json", json.loads(self.scene.read_text())
        glb = self.scene.with_suffix(".glb").read_bytes()
        end = 20 + int.from_bytes(glb[12:16], "little")
        model = json.loads(glb[20:end])
        model["buffers"][0]["uri"] = "motion.bin"
        (self.place / "motion.bin").write_bytes(glb[end + 8:])
        (self.place / "motion.glb").write_bytes(glb)
        render = ["render", scene, "--frames", 0, "--size", "64x32", "--spp", 1]
        commands = [render, ["model", scene], ["play", "FRAMES", "--scene", scene], ["serve", scene, "--listen", "tcp://127.0.0.1:0"]]

        def refused(named, words, **changes):
            scene.write_text(json.dumps(described | changes))
            begun, out = time.monotonic(), self.place / ("none.json" if words[0] == "model" else "none.mkv")
            self.assert_refused(self.run_command(words, out), 2, named)
            self.assertLess(time.monotonic() - begun, 20)
            self.assertFalse(out.exists())

        for kind, make in (("pipe", os.mkfifo), ("folder", os.mkdir), ("zero", lambda path: os.symlink("/dev/zero", path))):
            for extension in ("glb", "obj", "png", "exr", "bin", "csv", "json"):
                make(self.place / f"{kind}.{extension}")
            with self.subTest(kind):
                for words in commands:
                    refused(f"{kind}.glb", words, model=f"{kind}.glb")
                refused(f"{kind}.obj", render, model=f"{kind}.obj")
                refused(f"{kind}.exr", render, sky={"image": f"{kind}.exr"})
                refused(f"{kind}.csv", render, camera={"path": f"{kind}.csv"})
                refused(f"{kind}.json", ["render", self.place / f"{kind}.json"])
                for part, extension in ("buffers", "bin"), ("images", "png"):
                    parts = [{key: each[key] for key in each if key != "bufferView"} | {"uri": f"{kind}.{extension}"} for each in model[part]]
                    (self.place / "named.gltf").write_text(json.dumps(model | {part: parts}))
                    refused(f"{kind}.{extension}", render, model="named.gltf")
        refused("/dev/zero", render, model="/dev/zero")
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024, MOST_MEMORY_MIB)


if __name__ == "__main__":
    namespace = ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--user", "--map-root-user"])]
    if "EQUISTREAM_OWN_MOUNTS" not in os.environ and shutil.which("unshare") and subprocess.run([*namespace, "true"], capture_output=True).returncode == 0:
        os.execvpe("unshare", [*namespace, *sys.orig_argv], os.environ | {"EQUISTREAM_OWN_MOUNTS": "1"})
    unittest.main()
