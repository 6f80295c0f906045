"""`equistream view --headset` in a runtime that records what it is given: held to the window and to `play`.

usage: headset_test.py BIN_DIR RUNTIME_LIBRARY
"""

import copy
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "viewer")]
from display import PATIENCE_S, Display, ViewerProcess, psnr, wait_for  # noqa: E402
from independent import *  # noqa: E402,F403

RUNTIME = sys.argv.pop(2)
PROGRAMS = Programs(sys.argv.pop(1))
STILL = (0, 0, 0, 1, 0, 0, 0)
IPD_M = 0.064  # the runtime's


def turn(degrees, axis):
    half = np.radians(degrees) / 2
    return np.array([np.cos(half), *(np.sin(half) * np.array(axis))])


class Headset(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_headset_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        description = json.loads(cls.scene.read_text())
        description["head_box"] = {"lean_m": 0.4}
        cls.scene.write_text(json.dumps(description))
        folder = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0", "--size", "512x256", "--spp", 1, "--aovs", "depth", "--out", folder)
        cls.stream = cls.root / "walk.mkv"
        PROGRAMS.run("encode", folder, "--out", cls.stream, "--depth", "none", "--crf", "8", "--preset", "ultrafast", "--progress", "none")
        cls.manifest = cls.root / "runtime.json"
        cls.manifest.write_text(json.dumps({"file_format_version": "1.0.0", "runtime": {"library_path": RUNTIME}}))
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()
        shutil.rmtree(cls.root, ignore_errors=True)

    def worn(self, heads, *words, end="exit", status=0):
        """The viewer with a head that goes along `heads`; its log, by frame, and what it said."""
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        script = ["idle" if head is None else " ".join(f"{x:.9g}" for x in head) for head in heads]
        (folder / "script.txt").write_text("\n".join([*script, end]) + "\n")
        environment = {**self.display.environment, "XR_RUNTIME_JSON": str(self.manifest), "EQUISTREAM_FAKE_XR": str(folder)}
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", self.stream, "--headset", "--paused", "--scene", self.scene, "--out",
                                                  folder, *words]], env=environment, capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(result.returncode, status, result.stderr)
        log = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
        self.assertEqual([line["broken"] for line in log if "broken" in line], [])
        frames = {line["frame"]: line for line in log if "frame" in line}
        for number, frame in frames.items():
            for eye, view in enumerate(frame["views"]):
                view["picture"] = np.asarray(Image.open(folder / f"frame.{number:04}.{eye}.ppm")).astype(float)
        return frames, log, result.stderr

    def covering(self, frame, view):
        """Size and field of view of the symmetric picture that a view is part of, and where in it."""
        width, height = frame["swapchain"][0] // 2, frame["swapchain"][1]
        left, right, up, down = np.tan(view["fov"])
        focal = view["rect"][2] / (right - left)
        column, bottom, columns, rows = view["rect"]
        column %= width
        self.assertAlmostEqual(focal, rows / (up - down), delta=1e-3 * focal)  # square pixels
        self.assertAlmostEqual(column - width / 2, focal * left, delta=0.01)
        self.assertAlmostEqual(bottom - height / 2, focal * down, delta=0.01)
        place = np.s_[height - bottom - rows : height - bottom, column : column + columns]
        return (width, height), 2 * np.degrees(np.arctan(width / 2 / focal)), place

    def test_a_head_at_rest_sees_what_the_window_shows(self):
        frames, _, _ = self.worn([STILL, STILL])
        frame = frames[1]
        (width, height), fov, _ = self.covering(frame, frame["views"][0])
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", pathlib.Path(tempfile.mkdtemp(dir=self.root)), self.stream, "--paused", "--scene",
                               self.scene, "--layout", "sbs", "--size", f"{2 * width}x{height}", "--fov", f"{fov:.9g}", "--ipd", IPD_M)
        self.addCleanup(viewer.close)
        both = viewer.picture()
        self.assertEqual(both.shape, (height, 2 * width, 3))
        for eye, view in enumerate(frame["views"]):
            _, _, place = self.covering(frame, view)
            half = both[:, eye * width : (eye + 1) * width]
            self.assertGreaterEqual(psnr(view["picture"], half[place]), 50)
        self.assertLess(psnr(frame["views"][0]["picture"][:200, :200], frame["views"][1]["picture"][:200, :200]), 30)

    def play_of(self, head, frame, method):
        """Both eyes' covering pictures, as `play` makes them of the same head."""
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        (width, height), fov, _ = self.covering(frame, frame["views"][0])
        rows = ["time_s,x_m,y_m,z_m,qw,qx,qy,qz", ",".join(f"{x:.9g}" for x in (0, *head))]
        (out / "head.csv").write_text("\n".join(rows) + "\n")
        PROGRAMS.run("play", self.stream, "--scene", self.scene, "--depth", "gl", "--method", method, "--size", f"{width}x{height}", "--fov", f"{fov:.9g}", "--ipd",
                     IPD_M, "--head", out / "head.csv", "--progress", "none", "--out", out)
        return [np.asarray(Image.open(out / eye / "frame.0000.png").convert("RGB")).astype(float) for eye in ("left", "right")]

    def test_eyes_are_where_the_head_path_has_them(self):
        heads = [(0.1, 0.05, -0.1, *turn(25, (0, 1, 0))), (-0.12, 0, 0.08, *turn(-20, (1, 0, 0)))]
        for method, least_db in (("sphere", 50), ("surface", 40)):
            frames, _, _ = self.worn(heads, "--method", method)
            for number, head in enumerate(heads):
                played = self.play_of(self.in_the_world(head), frames[number], method)
                for eye, view in enumerate(frames[number]["views"]):
                    _, _, place = self.covering(frames[number], view)
                    with self.subTest(method=method, head=number, eye=eye):
                        self.assertGreaterEqual(psnr(view["picture"], played[eye][place]), least_db)
        self.assertLess(psnr(frames[0]["views"][0]["picture"], frames[1]["views"][0]["picture"]), 25)

    def in_the_world(self, head):
        """A head in the headset's space, which is centred where the frame's own head is."""
        middle = json.loads(PROGRAMS.run("info", self.stream, "--json"))["tracks"][0]["first_frame"]["head"]
        (a, *u), (b, *v) = middle["orientation_wxyz"], head[3:]
        u, v = np.array(u), np.array(v)
        position = np.array(middle["position_m"]) + rotation(middle["orientation_wxyz"]) @ np.array(head[:3])
        return (*position, a * b - u @ v, *(a * v + b * u + np.cross(u, v)))

    def test_frames_that_nobody_sees_have_no_picture(self):
        frames, log, said = self.worn([STILL, None, STILL])
        self.assertEqual(sorted(frames), [0, 2])
        self.assertEqual(said, "")
        self.assertFalse(log[-1]["running"])

    def test_a_lost_session_ends_with_one_line(self):
        _, log, said = self.worn([STILL, STILL], end="loss", status=1)
        self.assertEqual(said, "equistream view: the headset was lost: its runtime ends\n")
        self.assertTrue(log[-1]["end"])

    def test_a_key_centres_the_space_where_the_head_is(self):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        head = (0.1, 0.05, -0.1, *turn(40, (0, 1, 0)))
        (folder / "script.txt").write_text("\n".join([" ".join(f"{x:.9g}" for x in head), "until centred", "exit"]) + "\n")
        worn = copy.copy(self.display)
        worn.environment = {**self.display.environment, "XR_RUNTIME_JSON": str(self.manifest), "EQUISTREAM_FAKE_XR": str(folder)}
        viewer = ViewerProcess(worn, PROGRAMS.folder / "equistream", folder, self.stream, "--headset", "--paused", "--method", "sphere")
        self.addCleanup(viewer.close)

        def frames():
            """Of whole lines alone: the runtime writes on."""
            whole = (folder / "log.jsonl").read_text().rpartition("\n")[0]
            return [frame for frame in map(json.loads, whole.splitlines()) if "views" in frame]

        wait_for(lambda: (folder / "log.jsonl").exists() and len(frames()) > 0, "a frame before the key")
        viewer.press("c")
        wait_for(lambda: frames()[-1]["views"][0]["orientation"][0] > 0.9999, "a head that looks ahead")
        (folder / "centred").touch()
        self.assertEqual(viewer.end(), (0, ""))
        log = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
        first, last = log[0]["views"][0], frames()[-1]["views"][0]
        self.assertLess(np.abs(np.array(first["orientation"]) - head[3:]).max(), 1e-5)
        self.assertLess(np.abs(np.array(last["orientation"]) - (1, 0, 0, 0)).max(), 1e-5)
        self.assertLess(np.abs(np.array(last["position"]) - (-IPD_M / 2, 0, 0)).max(), 1e-5)
        self.assertEqual(log[-1]["spaces"], 2)

    def refused(self, environment):
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", self.stream, "--headset"]],
                                env={**self.display.environment, **environment}, capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
        return result.stderr

    def test_without_a_runtime_or_a_headset_there_is_one_line(self):
        self.assertIn("--headset: expected an OpenXR runtime", self.refused({"XR_RUNTIME_JSON": str(self.root / "none.json")}))
        folder = self.root / "no-headset"
        folder.mkdir()
        (folder / "script.txt").write_text("no headset\n")
        self.assertIn("--headset: expected a headset", self.refused({"XR_RUNTIME_JSON": str(self.manifest), "EQUISTREAM_FAKE_XR": str(folder)}))


if __name__ == "__main__":
    unittest.main()
