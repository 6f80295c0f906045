"""`equistream farm`: what it divides, what its tasks do, and that frames come out with the bytes of one render, also where programs are killed on the way.

usage: farm_test.py BIN_DIR [CLASS]

Slurm and OpenJd run the farm's own scripts in these systems: the first needs root and Debian's packages, the second openjd-cli of PyPI (EQUISTREAM_OPENJD names
its program). Where they are missing, the tests say so and are skipped.
"""

import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import slurm_here  # noqa: E402
from independent import wait_until  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from own_names import place  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
FARM = REPOSITORY / "programs/study/farm.py"
FRAMES = 10
SKIPPED = 77
ENVIRONMENT = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
RENDER = ("render", "scenes/motion.json", "--frames", f"0-{FRAMES - 1}", "--size", "160x80", "--aovs", "depth,ids", "--seed", "7")


class Farm(unittest.TestCase):
    """A folder with a scene, and what one uninterrupted render of it is."""
    render = (*RENDER, "--spp", "2")

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_farm_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.started("scene", "generate", "motion", "--out", "scenes").check_returncode()
        cls.started(*cls.render, "--out", "whole").check_returncode()

    @classmethod
    def started(cls, *words):
        return subprocess.run([str(word) for word in ("equistream", *words)], cwd=cls.root, env=ENVIRONMENT, capture_output=True, text=True)

    def farm(self, *words, status=0):
        done = self.started("farm", *words)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done

    def plan(self, folder="farm"):
        return json.loads((self.root / folder / "plan.json").read_text())

    def run_tasks(self, folder="farm"):
        for step in self.plan(folder)["steps"]:
            for number in range(step["tasks"]):
                self.farm("task", folder, step["name"], number)

    def assert_same_frames(self, folder, whole="whole"):
        expected, found = ({str(file.relative_to(self.root / name)): file.read_bytes() for file in (self.root / name).rglob("*.exr")} for name in (whole, folder))
        self.assertEqual(sorted(found), sorted(expected))
        other = [name for name in expected if found[name] != expected[name]]
        if other:
            kept = pathlib.Path(tempfile.mkdtemp(prefix="equistream_farm_failed_"))
            for name in (whole, folder):
                shutil.copytree(self.root / name, kept / name)
            self.fail(f"expected the bytes of the frames in {kept / whole}, found others of {', '.join(other)} in {kept / folder}")
        one, other = (json.loads((self.root / name / "centre/manifest.json").read_text()) for name in (whole, folder))
        self.assertEqual({**one, "command": None}, {**other, "command": None})


class Divided(Farm):
    def tearDown(self):
        for name in ("farm", "frames"):
            shutil.rmtree(self.root / name, ignore_errors=True)

    def test_by_frames(self):
        said = self.farm("--chunk", 4, "--frame-seconds", 3, *self.render, "--out", "frames", "--", "encode", "frames", "--out", "frames.mp4").stdout
        self.assertRegex(said, r"render +3 +12 +0\.01")
        steps = self.plan()["steps"]
        self.assertEqual([(step["name"], step["tasks"], step["after"]) for step in steps],
                         [("render", 3, []), ("render-whole", 1, ["render"]), ("encode", 1, ["render", "render-whole"])])
        self.farm("task", "farm", "render", 2)
        self.assertIn("render: 2 of 10 frames", self.farm("status", "farm").stdout)
        refused = self.farm("task", "farm", "render-whole", status=1).stderr
        self.assertRegex(refused, r"frames/centre: expected frames 0 to 9, found no 0 and others; run the tasks of render again")
        self.run_tasks()
        self.assert_same_frames("frames")
        self.assertEqual(json.loads((self.root / "frames/centre/manifest.json").read_text())["command"], " ".join(["equistream", *self.render, "--out", "frames"]))
        self.assertTrue((self.root / "frames.mp4").exists())
        self.assertEqual(self.farm("status", "farm").stdout.split("\n")[:3], ["render: 10 of 10 frames", "render-whole: 1 of 1 tasks", "encode: 1 of 1 tasks"])

    def test_divided_otherwise_finished_frames_are_kept(self):
        for chunk, number, expected in ((5, 0, "5 frames rendered, 0 kept"), (10, 0, "5 frames rendered, 5 kept"), (4, 2, "0 frames rendered, 2 kept")):
            self.farm("--chunk", chunk, "--frame-seconds", 1, *self.render, "--out", "frames")
            self.assertIn(expected, self.farm("task", "farm", "render", number).stdout)
        self.assertIn("render: 10 of 10 frames", self.farm("status", "farm").stdout)
        self.run_tasks()
        self.assert_same_frames("frames")

    def test_frames_of_other_settings_from_another_division_are_told(self):
        self.farm("--chunk", 5, "--frame-seconds", 1, *self.render, "--out", "frames")
        self.farm("task", "farm", "render", 0)
        manifest = self.root / "farm/parts/render/000000-000004/centre/manifest.json"
        manifest.write_text(json.dumps({**json.loads(manifest.read_text()), "fingerprint": "0"}))  # as of another build
        self.farm("--chunk", 10, "--frame-seconds", 1, *self.render, "--out", "frames")
        self.assertIn("expected fingerprint 0 as in the frames there", self.farm("task", "farm", "render", 0, status=1).stderr)

    def test_another_eyes_frames_are_not_the_jobs_and_geometry_is(self):
        self.started(*RENDER[:2], "--frames", "0", *RENDER[4:], "--spp", "1", "--eye", "left", "--out", "frames").check_returncode()
        self.farm("--chunk", 5, "--frame-seconds", 3, *self.render, "--out", "frames")
        for number in range(2):
            self.farm("task", "farm", "render", number)
        (self.root / "farm/parts/render/000000-000004/scene.json").write_text("as Mitsuba's host writes it")
        self.farm("task", "farm", "render-whole")
        self.assertIn("render: 10 of 10 frames", self.farm("status", "farm").stdout)
        self.assertEqual((self.root / "frames/scene.json").read_text(), "as Mitsuba's host writes it")
        self.assertEqual(len(list((self.root / "frames/left").glob("*.exr"))), 1)

    def test_frames_of_other_settings_where_the_job_puts_its_own_are_told_by_the_first_task(self):
        self.farm("--chunk", 5, "--frame-seconds", 3, *self.render, "--out", "frames")
        self.started(*RENDER[:2], "--frames", "0", *RENDER[4:], "--spp", "1", "--out", "frames").check_returncode()
        self.assertRegex(self.farm("task", "farm", "render", 1, status=1).stderr,
                         r"000005-000009/centre/manifest.json: expected the settings and the build of the renderer of .*frames/centre/manifest.json, found others")

    def test_a_play_that_is_done_again_replaces_its_own_video_and_no_other(self):
        job = ("play", "whole", "--method", "rotation", "--size", "64x64", "--frames", "0", "--out", "eyes.mp4")
        self.addCleanup((self.root / "eyes.mp4").unlink, missing_ok=True)
        self.farm(*job)
        self.farm("task", "farm", "play", 0)
        (self.root / "farm/done/play-0").unlink()  # as where the machine was lost in between
        self.farm("task", "farm", "play", 0)
        shutil.rmtree(self.root / "farm")
        self.farm(*job)
        self.assertIn("expected the name of a new video, or --overwrite", self.farm("task", "farm", "play", 0, status=1).stderr)

    def test_by_tiles(self):
        """With what is made of whole pictures: hidden layers are padded, references lie elsewhere in every frame, tiles have other samples."""
        several = (*RENDER[:2], "--frames", "0-1", *RENDER[4:6], "--spp", "3", "--layers", "--aovs", "all,reference,guides", "--samples", "angle")
        self.started(*several, "--out", "layered").check_returncode()
        self.farm("--parts", 3, "--frame-seconds", 1, *several, "--out", "frames")
        self.assertEqual([(step["name"], step["tasks"]) for step in self.plan()["steps"]], [("render", 3), ("render-whole", 1)])
        self.run_tasks()
        self.assert_same_frames("frames", "layered")
        self.assertEqual(list((self.root / "frames").rglob("*.part")), [], "what was put together is kept once")
        self.assertIn("0 frames rendered, 4 kept", self.farm("task", "farm", "render", 0).stdout)

    def test_frames_beside_those_of_a_job_in_parts_are_not_counted(self):
        words = (*RENDER[:2], *RENDER[4:], "--spp", "1")
        self.started(*words, "--frames", "0-1", "--out", "frames").check_returncode()
        self.started(*words, "--frames", "0-1", "--part", "1/2", "--out", "frames").check_returncode()
        self.farm("--parts", 3, "--frame-seconds", 1, *words, "--frames", "2-3", "--out", "frames")
        self.started(*words, "--frames", "1-2", "--part", "1/3", "--out", "frames").check_returncode()
        self.assertIn("render: 0 of 2 frames, and 1 parts of others", self.farm("status", "farm").stdout)
        self.run_tasks()
        self.assertIn("render: 2 of 2 frames", self.farm("status", "farm").stdout)

    def test_parts_of_several_frames_at_once(self):
        several = (*RENDER[:2], "--frames", "0-3", *RENDER[4:], "--spp", "1")
        self.started(*several, "--out", "four").check_returncode()
        self.farm("--parts", 3, "--frame-seconds", 1, *several, "--out", "frames")
        tasks = [subprocess.Popen(["equistream", "farm", "task", "farm", "render", str(number)], cwd=self.root, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                 for number in range(self.plan()["steps"][0]["tasks"])]
        for task in tasks:
            said = task.communicate()[0]
            self.assertEqual(task.returncode, 0, said)
        self.farm("task", "farm", "render-whole")
        self.assert_same_frames("frames", "four")

    def test_a_finished_encode_is_done_again_once_its_file_is_gone_or_its_frames_are_new(self):
        self.farm("--frame-seconds", 1, *self.render, "--out", "frames", "--", "encode", "whole", "--out", "frames.mp4")
        video, frame = self.root / "frames.mp4", self.root / "frames/centre/frame.0000.exr"
        frame.parent.mkdir(parents=True)

        def is_encoded():
            before = video.stat().st_mtime_ns if video.exists() else 0
            said = self.farm("task", "farm", "encode").stdout
            is_new = video.stat().st_mtime_ns != before
            self.assertEqual("done before" in said, not is_new, said)
            return is_new

        self.assertEqual([is_encoded(), is_encoded()], [True, False])
        video.unlink()
        self.assertEqual([is_encoded(), is_encoded()], [True, False])
        for written in (None, (1000, 1000)):  # an older frame in its place is another one, too
            frame.touch()
            if written:
                os.utime(frame, written)
            self.assertIn("encode: 0 of 1 tasks", self.farm("status", "farm").stdout)
            self.assertEqual([is_encoded(), is_encoded()], [True, False])
        done = self.root / "farm/done/encode-0"
        done.write_text(done.read_text().splitlines()[0] + "\n")  # as it was written before frames were noted
        self.assertFalse(is_encoded())
        os.utime(done, (900, 900))
        self.assertTrue(is_encoded())
        self.assertEqual(json.loads(self.farm("--json", "status", "farm").stdout)["steps"][-1], {"step": "encode", "done": 1, "of": 1, "what": "tasks"})

    def test_what_a_job_reads_counts_whoever_made_it(self):
        shutil.copytree(self.root / "whole", self.root / "copied")
        self.farm("encode", "copied", "--out", "copied.mp4")

        def is_encoded():
            return "done before" not in self.farm("task", "farm", "encode").stdout

        self.assertEqual([is_encoded(), is_encoded()], [True, False])
        (self.root / "copied/centre/frame.0000.exr").touch()
        self.assertIn("encode: 0 of 1 tasks", self.farm("status", "farm").stdout)
        self.assertEqual([is_encoded(), is_encoded()], [True, False])

    def test_pictures_that_a_job_makes_are_not_read_by_it(self):
        shutil.copytree(self.root / "whole", self.root / "scored")
        views = self.root / "scored/centre"
        self.farm("compare", "scored/centre", "whole/centre", "--difference", "scored/centre/difference", "--out", "scores.json")
        said = [self.farm("task", "farm", "compare").stdout for _ in range(2)]
        self.assertTrue(list((views / "difference").rglob("frame.*.png")))
        self.assertEqual(["done before" in each for each in said], [False, True])

    def test_a_settings_file_counts_as_the_command_line_does(self):
        (self.root / "own.ini").write_text("[render]\nthreads = 1\n")
        self.farm("--frame-seconds", 1, *self.render, "--settings", "own.ini", "--out", "frames")
        self.assertEqual(self.plan()["steps"][0]["processors"], 1)
        (self.root / "own.ini").write_text("[render]\noverwrite = true\n")
        refused = self.farm("--out", "other", "--frame-seconds", 1, *self.render, "--settings", "own.ini", "--out", "frames", status=2).stderr
        self.assertEqual(refused, "equistream farm: --settings: expected a render that goes on where it was, found overwrite, which a farm's tasks cannot have\n")

    def test_a_render_waits_for_what_is_before_it(self):
        self.farm("--frame-seconds", 1, *self.render, "--out", "a", "--", *self.render, "--out", "b")
        self.assertEqual({step["name"]: step["after"] for step in self.plan()["steps"]},
                         {"render": [], "render-whole": ["render"], "render-2": ["render", "render-whole"], "render-2-whole": ["render-2"]})

    def test_a_part_that_is_missing_or_changed_is_refused(self):
        words = (*RENDER[:2], "--frames", "0", *RENDER[4:], "--spp", "1", "--out", "frames")
        self.started(*words, "--part", "1/2").check_returncode()
        refused = self.started(*words, "--part", "all/2")
        self.assertIn("frames/centre/part-2-of-2/frame.0000.part: expected part 2 of the frame, found No such file", refused.stderr)
        self.started(*words, "--part", "2/2").check_returncode()
        file = self.root / "frames/centre/part-2-of-2/frame.0000.part"
        good = file.read_bytes()
        for name, bad in (("cut", good[:-1]), ("changed", good[:-1] + bytes([good[-1] ^ 1])), ("of another part", (file.parents[1] / "part-1-of-2" / file.name).read_bytes()), ("empty", b""),
                          ("longer", good + b"x"), ("huge", good * 3)):
            with self.subTest(name):
                file.write_bytes(bad)
                refused = self.started(*words, "--part", "all/2")
                self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (2, 1), refused.stderr)
                self.assertIn("frame.0000.part: expected", refused.stderr)
                self.assertFalse((self.root / "frames/centre/frame.0000.exr").exists())
                self.assertIn("1 frames rendered, 0 kept", self.started(*words, "--part", "2/2").stdout)
                self.assertEqual(file.read_bytes(), good)
        self.started(*words, "--part", "all/2").check_returncode()
        refused = self.started(*("8" if word == "7" else word for word in words), "--part", "1/2")
        self.assertIn("frames/centre/manifest.json: expected seed 7 as in the frames there, found 8", refused.stderr)

    def test_what_tasks_take_is_measured(self):
        self.farm("--minutes", "0.1", *self.render, "--out", "frames", "--json")
        plan = self.plan()
        measured, render = plan["measured"]["render"], plan["steps"][0]
        self.assertGreater(measured["frame_s"], 0)
        self.assertGreater(measured["bytes"], 1000)
        self.assertEqual(render["chunk"], min(FRAMES, max(1, int(6 / measured["frame_s"]))))
        self.assertGreater(render["limit"], render["seconds"])
        self.farm("--minutes", "0.1", *self.render, "--out", "frames", "--json")
        self.assertEqual(self.plan()["measured"]["render"], measured, "or its tasks would be others, and what is finished rendered again")
        ours = '{"format": "equistream farm 1"'
        for damaged in ("", "{", ours + "}", '{"format": "equistream farm 2"}', ours + ', "steps": [{"first": -1}]}'):
            with self.subTest(damaged):
                (self.root / "farm/plan.json").write_text(damaged)
                self.farm("--frame-seconds", 1, *self.render, "--out", "frames")
                self.assertEqual(self.plan()["steps"][0]["name"], "render", "a damaged plan makes way")

    def test_what_a_killed_measurement_has_left_goes(self):
        host, ended = socket.gethostname(), subprocess.run(["sh", "-c", "echo $$"], capture_output=True, text=True).stdout.strip()
        names = {f"measured-{place()}-{ended}-ab_9": False, f"measured-{place()}-{os.getpid()}-ab_9": True, f"measured-{place()}x-{ended}-ab_9": True,
                 f"measured-{place()}-x-{ended}-ab_9": True, f"measured-{host}-{ended}-ab_9": True}
        for name in names:
            (self.root / "farm" / name / "1").mkdir(parents=True)
        self.farm(*self.render, "--out", "frames")
        self.assertEqual({folder.name for folder in (self.root / "farm").glob("measured-*")}, {name for name, stays in names.items() if stays})

    def test_a_measurement_ends_with_a_killed_farm(self):
        programs = self.root / "waiting"
        programs.mkdir(exist_ok=True)
        (programs / "equistream").write_text("#!/bin/sh\necho $$ > started.new && mv started.new started\nexec sleep 1000\n")
        (programs / "equistream").chmod(0o755)
        farm = subprocess.Popen([sys.executable, "-B", FARM, "--bin", programs, *self.render, "--out", "frames"], cwd=self.root)
        wait_until(lambda: (self.root / "started").exists(), "the measurement", 20)
        farm.kill()
        farm.wait()
        process = pathlib.Path("/proc") / (self.root / "started").read_text().strip()
        wait_until(lambda: not process.exists() or ") Z " in (process / "stat").read_text(), "its end", 20)

    def test_a_frame_that_takes_too_long_is_divided(self):
        self.farm("--minutes", 10, "--frame-seconds", 1500, *self.render, "--out", "frames")
        self.assertEqual([(step["tasks"], step["kind"]) for step in self.plan()["steps"]], [(15, "parts"), (1, "run")], "25 of 10 minutes, but no more than tiles")
        self.assertIn("submit render --array=0-14 ", (self.root / "farm/submit.sh").read_text())

    def test_frames_that_hang_on_others_are_one_task(self):
        self.farm("--frame-seconds", 600, *self.render, "--accumulate", "4", "--out", "frames")
        self.assertEqual(self.plan()["steps"][0]["tasks"], 1)
        refused = self.farm("--out", "other", "--chunk", 2, "--frame-seconds", 1, *self.render, "--accumulate", "4", "--out", "frames", status=2)
        self.assertIn("expected independent frames for --chunk and --parts, found --accumulate", refused.stderr)

    def test_a_killed_program_goes_on(self):
        """By a program in place of the dispatcher that is killed the first two times; the third, it renders."""
        self.farm("--chunk", FRAMES, "--frame-seconds", 1, *self.render, "--out", "frames")
        programs = self.root / "programs"
        programs.mkdir()
        (programs / "equistream").write_text(f'#!/bin/sh\necho again >> {self.root}/tries\n[ $(wc -l < {self.root}/tries) -lt 3 ] && kill -9 $$\nexec {BIN}/equistream "$@"\n')
        (programs / "equistream").chmod(0o755)
        done = subprocess.run([sys.executable, "-B", FARM, "--bin", programs, "task", "farm", "render", "0"], cwd=self.root, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr.count("killed by signal 9; it goes on"), 2, done.stderr)

    def test_mistakes_are_told_in_a_line(self):
        for words, expected in ((("render", "scenes/motion.json", "--out", "frames", "--sizes", "8x8"), "--sizes: no such option; did you mean --size?"),
                                (("render", "scenes/motion.json", "--frames", "90-99", "--out", "frames"), "expected frames within the path's 0-30"),
                                (("render", "none.json", "--out", "frames"), "none.json"),
                                ((*self.render, "--overwrite", "--out", "frames"), "--overwrite: expected a render that goes on where it was"),
                                (("view", "a.mp4"), "expected a job of render, encode, play, compare, study, or status, found 'view'"),
                                ((*self.render, "--out", "frames", "--", "farm"), "expected jobs of"), (("--chunks", "2", *self.render), "did you mean --chunk?"),
                                (("study", "--out", "study", "--again"), "study: expected options of --preset, --scenes, --out, --work, found --again"),
                                (("--chunk", "2", "--parts", "2", "--frame-seconds", "1", *self.render, "--out", "frames"), "--chunk: expected no --parts beside it"),
                                (("--parts", "70000", "--frame-seconds", "1", *self.render, "--out", "frames"), "--parts: expected at most"),
                                (("status", "nowhere"), "nowhere/plan.json: expected what equistream farm writes, found none"),
                                (("task", "nowhere", "render", "0"), "nowhere/plan.json: expected"), ((), "expected a job")):
            with self.subTest(" ".join(words)):
                done = self.started("farm", *words)
                self.assertEqual(done.returncode, 1 if words[:1] == ("task",) else 2)
                self.assertIn(expected, done.stderr)
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)

    def test_a_damaged_plan_is_told_in_a_line(self):
        self.farm("--frame-seconds", 3, *self.render, "--out", "frames")
        file = self.root / "farm/plan.json"
        file.write_text(file.read_text().replace('"chunk"', '"chunks"'))
        refused = self.farm("task", "farm", "render", 0, status=2).stderr
        self.assertRegex(refused, r"^equistream farm: farm/plan.json: expected what equistream farm writes, found KeyError 'chunk'; plan it anew\n$")
        whole = file.read_text()
        for key, bad in (("first", 10 ** 12), ("last", "9"), ("tasks", -1)):
            plan = json.loads(whole)
            plan["steps"][0][key] = bad
            file.write_text(json.dumps(plan))
            self.assertRegex(self.farm("status", "farm", status=2).stderr, r"^equistream farm: farm/plan.json: expected frames and tasks from 0 to 999999999, found others; plan it anew\n$")
        file.write_text('{"format": "equistream farm 1"}')
        self.assertRegex(self.farm("status", "farm", status=2).stderr, r"^equistream farm: farm/plan.json: expected what .* KeyError 'steps'; plan it anew\n$")

    def test_another_job_is_not_mixed_in(self):
        self.farm("--chunk", 4, "--frame-seconds", 3, *self.render, "--out", "frames")
        self.assertIn("expected the farm of this job", self.farm("--frame-seconds", 3, *self.render, "--out", "others", status=2).stderr)
        self.assertIn("render: scene is required", self.farm("render", "--out", "others", status=2).stderr)

    def test_a_machine_without_slurm_is_told_so(self):
        self.farm("--frame-seconds", 3, *self.render, "--out", "frames")
        tools = self.root / "tools"
        tools.mkdir()
        for tool in ("dirname", "mkdir"):
            (tools / tool).symlink_to(shutil.which(tool))
        (tools / "equistream").symlink_to(BIN / "equistream")
        done = subprocess.run([shutil.which("sh"), self.root / "farm/submit.sh"], env={"PATH": str(tools)}, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (1, "submit.sh: expected Slurm (squeue and sbatch in PATH), found none\n"))


class InSystems(Farm):
    """The farm's own scripts, in the system that they are for, with a render killed in the middle."""
    render = (*RENDER, "--spp", "16")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.started("encode", "whole", "--out", "whole.mp4").check_returncode()

    def setUp(self):
        self.farm("--chunk", 3, "--frame-seconds", 1, *self.render, "--out", "frames", "--", "encode", "frames", "--out", "frames.mp4")

    def renders_of(self, first):
        """Processes that render the chunk from this frame on."""
        found = []
        for folder in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if words[0].startswith(b"equistream render") and any(word.startswith(str(self.root).encode()) and f"parts/render/{first:06}-".encode() in word for word in words):
                found.append(int(folder.name))
        return found

    def in_the_middle(self, first, patience_s=300):
        """Waits until the chunk from this frame on has a frame, and not all; its render."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            there = list((self.root / "farm/parts/render").glob(f"{first:06}-*/centre/frame.*.exr"))
            renders = self.renders_of(first)
            self.assertLess(len(there), 3, "the chunk was done before it could be killed")
            if there and renders:
                return renders[0]
            time.sleep(0.01)
        self.fail(f"expected a render of frames from {first} on")

    def assert_all_is_the_same(self):
        self.assert_same_frames("frames")
        self.assertEqual((self.root / "frames.mp4").read_bytes(), (self.root / "whole.mp4").read_bytes())


@unittest.skipIf(slurm_here.missing(), slurm_here.missing())
class Slurm(InSystems):
    def test_the_farm(self):
        with tempfile.TemporaryDirectory(prefix="equistream_slurm_") as folder, slurm_here.Slurm(folder) as slurm:
            slurm.run("sh", self.root / "farm/submit.sh", PATH=ENVIRONMENT["PATH"])
            refused = subprocess.run(["sh", self.root / "farm/submit.sh"], env={**slurm.environment, "PATH": ENVIRONMENT["PATH"]}, capture_output=True, text=True)
            self.assertEqual(refused.returncode, 1, refused.stdout)
            self.assertRegex(refused.stderr, r"^submit.sh: expected no job of this farm in the queue, found \d+( \d+)*; wait, or scancel them first\n$")
            os.kill(self.in_the_middle(3), signal.SIGKILL)
            self.in_the_middle(6)
            task = next(job for job, name, *_ in slurm.jobs() if job.endswith("_2"))
            slurm.run("scontrol", "requeue", task)
            slurm.until(lambda: any(job[0] == task and job[2] == "PENDING" for job in slurm.jobs()), "the task back in the queue")
            slurm.run("scontrol", "update", f"JobId={task}", "StartTime=now")  # else it waits for two minutes
            slurm.until(lambda: not slurm.jobs(), "an empty queue", 300)
        logs = {file.name: file.read_text() for file in (self.root / "farm/logs").iterdir()}
        told = "\n".join(logs.values())
        self.assertEqual(told.count("killed by signal 9; it goes on"), 1, told)
        requeued = next(text for name, text in logs.items() if name.endswith("_2.log"))
        self.assertRegex(requeued, r"[1-3] of 3 frames are finished and kept")
        self.assertRegex(told, r"100 %, centre frame 9")
        self.assert_all_is_the_same()


OPENJD = os.environ.get("EQUISTREAM_OPENJD") or shutil.which("openjd")


@unittest.skipUnless(OPENJD, "no openjd here (pip install openjd-cli==0.8.0; EQUISTREAM_OPENJD names it)")
class OpenJd(InSystems):
    def test_the_farm(self):
        template = self.root / "farm/template.json"
        checked = subprocess.run([OPENJD, "check", template], capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        with open(self.root / "said", "w") as said:
            job = subprocess.Popen([OPENJD, "run", template, "--step", "encode", "--run-dependencies"], cwd="/", env=ENVIRONMENT, stdout=said, stderr=said)
            try:
                os.kill(self.in_the_middle(3), signal.SIGKILL)
                status = job.wait(600)
            finally:
                job.kill()
        told = (self.root / "said").read_text()
        self.assertEqual(status, 0, told)
        self.assertEqual(told.count("killed by signal 9; it goes on"), 1, told)
        self.assertIn("openjd_progress: 100.0", told)
        self.assertRegex(told, r"openjd_status: centre frame 8")
        self.assert_all_is_the_same()


if __name__ == "__main__":
    ran = unittest.main(exit=False).result
    for _, why in ran.skipped:
        print(f"skipped: {why}")
    sys.exit(SKIPPED if ran.wasSuccessful() and 0 < len(ran.skipped) >= ran.testsRun else not ran.wasSuccessful())
