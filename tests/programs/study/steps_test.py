#!/usr/bin/env python3
"""Steps are skipped as long as what they would make is what is there, and no longer."""

import contextlib
import errno
import io
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from unittest import mock

from gathered import linked
from steps import Failed, Refused, Steps, machine, run_as_program, scene_files, write_whole

PATIENCE_S = 20
PROGRAM = '#!/bin/sh\ncp "$2" "$4" && echo run >> runs\n'
TOUCHES = '#!/bin/sh\ntouch "$4" && echo run >> runs\n'


def folder_with_program(test, text):
    """A work folder, gone after the test, and bin/equistream in it."""
    holder = tempfile.TemporaryDirectory()
    test.addCleanup(holder.cleanup)
    work = pathlib.Path(holder.name).resolve()
    program = work / "bin/equistream"
    program.parent.mkdir()
    program.write_text(text)
    program.chmod(0o755)
    return work, program


class Ends(unittest.TestCase):
    def ended(self, error):
        with contextlib.redirect_stderr(io.StringIO()) as said, self.assertRaises(SystemExit) as ended:
            run_as_program(mock.Mock(side_effect=error), "equistream study")
        return ended.exception.code, said.getvalue()

    def test_wrong_input_and_failed_work_have_the_statuses_of_other_commands(self):
        self.assertEqual(self.ended(Refused("no such scene")), (2, "equistream study: no such scene\n"))
        self.assertEqual(self.ended(Failed("no room")), ("equistream study: no room", ""))  # which Python prints, and ends with 1

    def test_an_interrupt_ends_a_shells_loop_too(self):
        script = "from steps import run_as_program\ndef main():\n    print('begun')\n    raise KeyboardInterrupt\nrun_as_program(main, 'equistream fit')"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (-signal.SIGINT, "begun\n"))
        self.assertEqual(done.stderr, "equistream fit: interrupted; run it again to go on\n")
        nobody, end = os.pipe()
        os.close(nobody)  # as where `2>&1 | tee log` has ended first
        self.assertEqual(subprocess.run([sys.executable, "-c", script], stdout=subprocess.DEVNULL, stderr=end).returncode, -signal.SIGINT)
        os.close(end)


class SkippedSteps(unittest.TestCase):
    def setUp(self):
        self.work, self.program = folder_with_program(self, PROGRAM)
        (self.work / "given").mkdir()
        self.write("given/a", "1", at=1000)

    def write(self, name, text, at):
        (self.work / name).write_text(text)
        os.utime(self.work / name, (at, at))

    def run_step(self, *options, given="given/a", fresh=None):
        Steps(self.work, self.work / "bin", {}, {}).run("copy", "do", given, "--out", "made", *options, fresh=fresh)
        return (self.work / "runs").read_text().count("run")

    def test_the_same_is_not_done_twice(self):
        self.assertEqual([self.run_step(), self.run_step()], [1, 1])

    def test_several_programs_may_take_the_same_step_at_once(self):
        # Each waits until four are at it; where that does not come about, not for ever.
        self.program.write_text("#!/bin/sh\ni=0; while [ $(ls steps/*.unfinished | wc -l) -lt 4 -a $i -lt 300 ]; do i=$((i + 1)); sleep 0.1; done\nsleep 1; echo said\n")
        study = "import sys; from steps import Steps; Steps(sys.argv[1], sys.argv[1] + '/bin', {}, {}).run('scene', 'do')"
        studies = [subprocess.Popen([sys.executable, "-c", study, self.work], stderr=subprocess.PIPE, text=True) for _ in range(4)]
        for each in studies:
            said = each.communicate()[1]
            self.assertEqual(each.returncode, 0, said)
        self.assertEqual((self.work / "steps/scene.out").read_text(), "said\n")
        self.assertEqual(list(self.work.rglob("*.unfinished")), [])

    def test_what_a_killed_program_has_left_goes(self):
        self.program.write_text("#!/bin/sh\ntouch begun\nexec sleep 1000\n")
        study = [sys.executable, "-c", "import sys; from steps import Steps; Steps(sys.argv[1], sys.argv[1] + '/bin', {}, {}).run('scene', 'do')", self.work]
        killed = subprocess.Popen(study)
        end = time.monotonic() + PATIENCE_S
        while not (self.work / "begun").exists() and time.monotonic() < end:
            time.sleep(0.01)
        killed.kill()
        killed.wait()
        self.assertEqual(len(list(self.work.rglob("*.unfinished"))), 1)
        self.program.write_text("#!/bin/sh\necho said\n")
        subprocess.run(study, check=True)
        self.assertEqual(list(self.work.rglob("*.unfinished")), [])

    def test_another_command_program_or_input_is(self):
        self.assertEqual(self.run_step(), 1)
        self.assertEqual(self.run_step("--loud"), 2)
        self.program.write_text(PROGRAM + "# another\n")
        self.assertEqual(self.run_step("--loud"), 3)
        made = (self.work / "steps/copy.json").stat().st_mtime
        self.write("given/a", "2", at=made + 10)
        self.assertEqual(self.run_step("--loud"), 4)
        self.assertEqual((self.work / "made").read_text(), "2")

    def test_an_older_file_in_its_place_is_another_input(self):
        self.assertEqual(self.run_step(), 1)
        self.write("other", "2", at=900)
        os.replace(self.work / "other", self.work / "given/a")
        self.assertEqual(self.run_step(), 2)
        self.assertEqual((self.work / "made").read_text(), "2")
        self.program.write_text(TOUCHES)
        self.write("given/b", "3", at=950)
        self.assertEqual([self.run_step(given="given"), self.run_step(given="given")], [3, 3])
        a, b = self.work / "given/a", self.work / "given/b"
        for file, name in ((a, "c"), (b, "a"), (self.work / "given/c", "b")):
            file.rename(self.work / "given" / name)
        self.assertEqual(self.run_step(given="given"), 4, "files that changed places are others")

    def test_what_changes_while_a_program_runs_is_another_input(self):
        self.program.write_text(PROGRAM + '[ -e edited ] || { touch edited && printf 2 > "$2"; }\n')
        self.assertEqual([self.run_step(), self.run_step(), self.run_step()], [1, 2, 2])

    def test_files_behind_links_are_inputs(self):
        self.program.write_text(TOUCHES)
        (self.work / "both").mkdir()
        (self.work / "both/left").symlink_to("../given")
        self.assertEqual([self.run_step(given="both"), self.run_step(given="both")], [1, 1])
        self.write("given/a", "22", at=1000)
        self.assertEqual(self.run_step(given="both"), 2)

    def test_what_it_makes_is_no_input_by_whatever_word(self):
        self.program.write_text('#!/bin/sh\nmkdir -p scene pictures && date +%N > scene/a && cp scene/a pictures && echo run >> runs\n')
        steps = Steps(self.work, self.work / "bin", {}, {})
        for _ in range(2):
            steps.run("scene", "scene", "generate", "scene", "--out", "scene")
            steps.run("info", "info", "given/a", "--pictures", "pictures")
        self.assertEqual((self.work / "runs").read_text().count("run"), 2)

    def test_records_of_before_are_as_good_as_their_inputs_are_old(self):
        self.assertEqual(self.run_step(), 1)
        file = self.work / "steps/copy.json"
        file.write_text(json.dumps({key: value for key, value in json.loads(file.read_text()).items() if key != "inputs"}))
        self.assertEqual(self.run_step(), 1)
        self.write("given/a", "2", at=time.time() + 10)
        self.assertEqual(self.run_step(), 2)

    def test_another_scene_is_and_one_that_no_record_names_is_not(self):
        def runs(fresh, settings):
            for each in settings:
                Steps(self.work, self.work / "bin", {}, each).run("copy", "do", "given/a", "--out", "made", fresh=fresh)
                yield (self.work / "runs").read_text().count("run")

        for fresh in (None, "made"):
            for file in (self.work / "runs", self.work / "steps/copy.json"):
                file.unlink(missing_ok=True)
            self.assertEqual(list(runs(fresh, ({}, {"scene": "a"}, {"scene": "b"}))), [1, 1, 1])
            (self.work / "steps/copy.json").unlink()
            self.assertEqual(list(runs(fresh, ({"scene": "a"}, {"scene": "a"}, {"scene": "b"}, {"scene": "b"}))), [2, 2, 3, 3])

    def test_a_record_that_is_kept_is_of_the_inputs_as_they_are(self):
        """Of a render whose frames were there: it says again what it said when it made them."""
        self.program.write_text('#!/bin/sh\necho run >> runs\n[ -e made ] && echo \'{"frames_rendered": 0}\' || echo \'{"frames_rendered": 3}\'\ntouch made\n')
        steps = Steps(self.work, self.work / "bin", {}, {})

        def render():
            with steps.keeping("render", lambda report: json.loads(report)["frames_rendered"] > 0):
                steps.run("render", "render", "given/a", "--json", "--out", "made", fresh="made")
            return (self.work / "runs").read_text().count("run"), json.loads(steps.output_of("render"))["frames_rendered"]

        self.assertEqual([render(), render()], [(1, 3), (1, 3)])
        record = json.loads((self.work / "steps/render.json").read_text())
        self.write("given/a", "2", at=900)
        self.assertEqual([render(), render()], [(2, 3), (2, 3)])
        self.assertEqual({**json.loads((self.work / "steps/render.json").read_text()), "inputs": None}, {**record, "inputs": None})

    def test_half_of_what_it_said_is_nothing(self):
        self.program.write_text("#!/bin/sh\necho run >> runs\necho '{}'\n")
        steps = Steps(self.work, self.work / "bin", {}, {})
        for left in (None, "", "{"):
            if left is not None:
                (self.work / "steps/say.out").write_text(left)
            steps.run("say", "say", "--json")
            self.assertEqual(steps.output_of("say"), "{}\n")
        self.assertEqual((self.work / "runs").read_text().count("run"), 3)

    def test_again_means_all_but_renders(self):
        steps = Steps(self.work, self.work / "bin", {}, {})
        runs = []
        for since in (0, time.time() + 10, 0):
            steps.since = since
            for name, fresh in (("play", None), ("render", f"made-{since > 0}")):
                steps.run(name, "do", "given/a", "--out", f"{name}-made", fresh=fresh)
            runs.append((self.work / "runs").read_text().count("run"))
        self.assertEqual(runs, [2, 3, 3])

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

    def test_what_a_scene_consists_of_counts_for_its_description(self):
        scene = {"model": "room.glb", "camera": {"path": "walk.csv"}, "sky": {"image": "sky.exr"}, "moving": [{"path": "ball.csv"}, {"keys": []}]}
        files = ("room.glb", "walk.csv", "sky.exr", "ball.csv")
        for name in files:
            self.write(name, "", at=1000)
        self.write("room.json", json.dumps(scene), at=1000)
        self.assertEqual(set(scene_files(self.work / "room.json")), {self.work / name for name in ("room.json", *files)})
        for runs, name in enumerate(files, start=1):
            self.assertEqual([self.run_step(given="room.json"), self.run_step(given="room.json")], [runs, runs], name)
            os.utime(self.work / "steps/copy.json", (2000, 2000))
            self.write(name, "", at=2010)

    def test_what_is_gone_is_made_again(self):
        self.assertEqual(self.run_step(), 1)
        (self.work / "made").unlink()
        self.assertEqual([self.run_step(), self.run_step()], [2, 2])

    def test_one_that_ran_beside_others_is_not_timed(self):
        steps = Steps(self.work, self.work / "bin", {}, {})

        def copy(number, timed=False):
            return steps.run(f"copy-{number}", "do", "given/a", "--out", f"made-{number}", timed=timed)

        self.assertTrue(all(record["beside"] for record in steps.side_by_side(copy, (1, 2, 3))))
        self.assertIn("beside", copy(1))
        self.assertNotIn("beside", copy(1, timed=True))
        self.assertEqual((self.work / "runs").read_text().count("run"), 4)


    def test_one_that_fails_leaves_what_was_said_before(self):
        self.program.write_text('#!/bin/sh\n[ "$1" = do ] && echo said\n')
        steps = Steps(self.work, self.work / "bin", {}, {})
        steps.run("copy", "do")
        with self.assertRaises(Failed):
            steps.run("copy", "fail")
        self.assertEqual(steps.output_of("copy"), "said\n")


class OwnNames(unittest.TestCase):
    def test_what_others_on_machines_of_the_same_name_write_stays(self):
        ended = subprocess.run(["sh", "-c", "echo $$"], capture_output=True, text=True).stdout.strip()
        host, boot = socket.gethostname(), pathlib.Path("/proc/sys/kernel/random/boot_id").read_text()[:8]
        space = os.stat("/proc/self/ns/pid").st_ino
        ours = f"{host}-{boot}-{space}"
        others = (f"{host}-other-{space}-{ended}", f"{host}-{boot}-{space + 1}-{ended}", f"{ours}-1", f"{ours}x-{ended}")
        with tempfile.TemporaryDirectory() as folder:
            for name in (f"{ours}-{ended}", *others):
                pathlib.Path(folder, f"a.json.{name}.unfinished").touch()
            write_whole(pathlib.Path(folder, "a.json"), "{}")
            self.assertEqual(set(os.listdir(folder)), {"a.json", *(f"a.json.{name}.unfinished" for name in others)})

    def test_containers_where_a_process_has_the_same_number_have_other_names(self):
        """Both at once: what identifies a container that ended is used again."""
        words = ["unshare", "--user", "--map-root-user", "--pid", "--fork", sys.executable, "-c",
                 "import pathlib, sys; from steps import aside_of; print(aside_of(pathlib.Path('a')), flush=True); sys.stdin.read()"]
        containers = [subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for _ in range(2)]
        names = [each.stdout.readline().strip() for each in containers]
        errors = [each.communicate()[1] for each in containers]
        if any(error.startswith("unshare:") for error in errors):
            self.skipTest(f"no namespaces here: {errors}")
        self.assertTrue(all(name.endswith("-1.unfinished") for name in names), (names, errors))
        self.assertNotEqual(*names)


class Machine(unittest.TestCase):
    def test_a_system_that_does_not_say_its_name_is_unknown(self):
        with mock.patch("platform.freedesktop_os_release", side_effect=FileNotFoundError(errno.ENOENT, "No such file", "/etc/os-release")):
            self.assertEqual(machine()["system"], "unknown")


def writes_half(file, content):
    """As on a full disk, which says no name."""
    with open(file, "wb") as out:
        out.write(content[:len(content) // 2])
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class FullDisk(unittest.TestCase):
    def test_it_is_said_of_which_file_and_no_half_of_it_stays(self):
        with tempfile.TemporaryDirectory() as folder:
            file, source = pathlib.Path(folder) / "a.json", pathlib.Path(folder) / "source"
            file.write_text("before")
            source.write_text("1234")

            def copies_half(source, target):
                with contextlib.suppress(OSError):
                    writes_half(target, source.read_bytes())
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(source), None, str(target))  # as the library does

            with mock.patch.object(pathlib.Path, "write_bytes", writes_half), self.assertRaises(OSError) as full:
                write_whole(file, "after")
            with mock.patch("os.link", side_effect=OSError(errno.EPERM, "no links")):
                with mock.patch("shutil.copyfile", copies_half), self.assertRaises(OSError) as copied:
                    linked(source, pathlib.Path(folder) / "b")
                with self.assertRaises(OSError) as missing:
                    linked(pathlib.Path(folder) / "none", pathlib.Path(folder) / "b")
            for error, name in ((full, "a.json"), (copied, "b")):
                self.assertEqual((error.exception.errno, error.exception.filename), (errno.ENOSPC, f"{folder}/{name}"))
            self.assertEqual(str(missing.exception.filename), f"{folder}/none")
            self.assertEqual(file.read_text(), "before")
            self.assertEqual(sorted(path.name for path in pathlib.Path(folder).iterdir()), ["a.json", "source"])


class BesideEachOther(unittest.TestCase):
    def setUp(self):
        work, _ = folder_with_program(self, f'#!/bin/sh\n[ "$1" = fail ] && exit 3\nexec sleep {10 * PATIENCE_S}\n')
        self.steps = Steps(work, work / "bin", {}, {})
        # Shells start what they run in the background with interrupts ignored.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))

    def ended(self, *words):
        """How steps of these words, and nothing after them, end, all at once."""
        began = time.monotonic()
        try:
            self.steps.side_by_side(lambda word: [self.steps.run(f"{word}-{i}", word) for i in range(2)], words)
        except (Failed, KeyboardInterrupt) as ended:
            self.assertLess(time.monotonic() - began, PATIENCE_S)
            self.assertEqual(self.steps.running, set())
            return ended
        self.fail("ended well")

    def test_results_come_in_order(self):
        self.assertEqual(self.steps.side_by_side(lambda one, other: one - other, (3, 2, 1), (0, 1, 2)), [3, 1, -1])

    def test_what_fails_ends_what_runs_beside_it(self):
        self.assertIn("exit 3", str(self.ended("wait", "fail")))

    def test_what_fails_ends_what_waits_for_its_turn(self):
        begun = []

        def fail(number):
            begun.append(number)
            time.sleep(0.05)
            raise Failed(str(number))

        with self.assertRaises(Failed):
            self.steps.side_by_side(fail, range(1000))
        self.assertLess(len(begun), 500)

    def test_what_interrupts_the_study_alone_ends_its_programs(self):
        def interrupt():
            while not self.steps.running:
                time.sleep(0.01)
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=interrupt, daemon=True).start()
        self.assertIsInstance(self.ended("wait", "wait2"), KeyboardInterrupt)

    def test_an_interrupt_before_all_are_begun_ends_those_that_run(self):
        def words():
            yield "wait"
            while not self.steps.running:
                time.sleep(0.01)
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            self.steps.side_by_side(lambda word: self.steps.run(word, word), words())
        self.assertEqual(self.steps.running, set())


class Killed(unittest.TestCase):
    def test_what_it_runs_ends_with_it(self):
        work, _ = folder_with_program(self, f"#!/bin/sh\necho $$ > started.new && mv started.new started\nexec sleep {10 * PATIENCE_S}\n")
        study = subprocess.Popen([sys.executable, "-c", "import sys; from steps import Steps; Steps(sys.argv[1], sys.argv[1] + '/bin', {}, {}).run('wait', 'do')", work],
                                 stderr=subprocess.DEVNULL)
        wait_until(lambda: (work / "started").exists())
        study.kill()
        study.wait()
        program = pathlib.Path("/proc") / (work / "started").read_text().strip()
        wait_until(lambda: not program.exists() or ") Z " in (program / "stat").read_text())


def wait_until(holds):
    deadline = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.01)


if __name__ == "__main__":
    unittest.main()
