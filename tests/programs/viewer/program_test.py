"""`equistream view` as a program: what it opens and refuses, what it keeps, and how it ends.

usage: program_test.py BIN_DIR
"""

import os
import signal
import subprocess
import time

from viewing import *  # noqa: F403


class Program(Viewing):
    def test_recordings(self):
        viewer = self.by_geometry(paused=False)
        viewer.picture()
        viewer.press("r", "shift+r")
        wait_for((self.out / "recording.0001" / "frame.0002.png").exists, "three pictures of a recording")
        viewer.hold("Left", 0.5)
        viewer.press("r", "shift+r")
        path = self.out / "head.0001.csv"
        wait_for(path.exists, path)
        viewer.press("Escape")
        self.assertEqual(viewer.end(), (0, ""))
        times = np.atleast_1d(np.loadtxt(path, delimiter=",", skiprows=1, usecols=0))
        self.assertLess(times[-1], 1)  # of a source of four frames
        self.assertTrue((np.diff(times) > 0).all())
        PROGRAMS.run("play", self.stream, "--scene", self.scene, "--head", path, "--size", "64x48", "--frames", "0", "--progress", "none", "--out",
                     self.out / "eyes")

    def test_a_recorded_path_jumps_as_the_picture_does(self):
        viewer = self.view("--method", "rotation")
        first = viewer.picture()
        paths = []
        for key, presses in (("period", 3), ("shift+Right", 1)):
            viewer.press("shift+r")
            for _ in range(presses):
                before = viewer.picture()
                viewer.press(key)
                wait_for(lambda: (viewer.picture() != before).any(), f"another frame after {key}")
            viewer.press("shift+r", "Home")
            wait_for(lambda: (viewer.picture() == first).all(), "the first frame")
            paths.append(np.loadtxt(self.out / f"head.{len(paths) + 1:04}.csv", delimiter=",", skiprows=1))
        stepped, jumped = paths
        np.testing.assert_allclose(stepped[:, 0], [0, 0.2, 0.4, 0.6], atol=1e-3)
        self.assertGreater(np.abs(stepped[3, 1:4] - stepped[0, 1:4]).max(), 0.01)
        np.testing.assert_allclose(jumped, stepped[[0, 3]], atol=1e-3)

    def test_resizing_and_hiding(self):
        viewer = self.by_geometry()
        viewer.picture()
        self.display.tool("windowsize", "--sync", viewer.window, 200, 150)
        wait_for(lambda: viewer.picture().shape == (150, 200, 3), "a smaller picture")
        self.display.tool("windowunmap", viewer.window)
        self.display.tool("windowmap", "--sync", viewer.window)
        self.display.tool("windowfocus", viewer.window)
        self.assertEqual(viewer.picture().shape, (150, 200, 3))

    def test_nothing_is_drawn_while_it_is_minimised(self):
        viewer = self.view(paused=False)
        viewer.picture()
        viewer.press("r")
        recorded = self.out / "recording.0001"

        def count():
            return len(list(recorded.glob("*.png")))

        wait_for(lambda: recorded.exists() and count() > 2, "a recording")
        self.display.set_iconic(viewer.window, True)
        time.sleep(1)
        before = count()
        time.sleep(1)
        self.assertEqual(count(), before)
        self.display.set_iconic(viewer.window, False)
        wait_for(lambda: count() > before + 2, "more of the recording")
        viewer.press("Escape")
        self.assertEqual(viewer.end(), (0, ""))

    def test_every_key_of_the_table(self):
        names = {"space": "space", ",": "comma", ".": "period", "[": "bracketleft", "]": "bracketright", "-": "minus", "=": "equal", "home": "Home", "left": "Left", "right": "Right",
                 "up": "Up", "down": "Down"}
        lines = [line for line in PROGRAMS.run("view", "--keys").splitlines() if line.startswith("  ")]
        keys = [line[2:14].strip() for line in lines]
        self.assertEqual(len(keys), len(set(keys)))
        self.assertGreater(len(keys), 30)
        viewer = self.by_geometry(paused=False)
        for key in keys:
            if key in ("escape", "F11", "ctrl o"):  # which has what comes after it typed
                continue
            *shift, plain = key.split(" ")
            viewer.press("+".join([*shift, names.get(plain, plain)]))
        viewer.press("Escape")
        self.assertEqual(viewer.end(), (0, ""))

    def test_ordinary_video_turns(self):
        video = self.root / "ordinary.mp4"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "lavfi", "-i", "testsrc2=size=256x128:rate=25:duration=1", "-pix_fmt", "yuv420p", video], check=True)
        viewer = self.view(source=video)
        ahead = viewer.picture()
        viewer.hold("Left", 0.8)
        self.assertLess(psnr(viewer.picture(), ahead), 30)

    def test_of_ordinary_stereo_video_each_eye_sees_its_own(self):
        eyes = [f"{source}=size=256x128:rate=25:duration=0.4" for source in ("testsrc2", "smptebars")]
        seen = {}
        for name, stack, mode in (("left", None, None), ("right", None, None), ("top-bottom", "vstack", "top_bottom"), ("beside", "hstack", "left_right")):
            video = self.root / f"{name}.mkv"
            sources = [word for eye in ([eyes[name == "right"]] if stack is None else eyes) for word in ("-f", "lavfi", "-i", eye)]
            words = [] if stack is None else ["-filter_complex", stack, "-metadata:s:v", f"stereo_mode={mode}"]
            subprocess.run(["ffmpeg", "-v", "error", "-y", *sources, *words, "-pix_fmt", "yuv420p", "-c:v", "libx264", "-qp", "8", video], check=True)
            for layout in ("left", "right") if stack else ("left",):
                viewer = self.view("--size", "400x300", "--layout", layout, source=video, size=None)
                seen[name, layout] = viewer.picture()
                viewer.close()
            if stack:
                viewer = self.view("--size", "800x300", "--layout", "sbs", source=video, size=None)
                both = viewer.picture()
                viewer.close()
                seen[name, "sbs"] = both[:260, :400], both[:260, 400:]
        self.assertLess(psnr(seen["left", "left"], seen["right", "left"]), 20)
        for name in ("top-bottom", "beside"):
            for k, eye in enumerate(("left", "right")):
                self.assertGreater(psnr(seen[name, eye], seen[eye, "left"]), 35, f"{name}, {eye}")
                self.assertGreater(psnr(seen[name, "sbs"][k], seen[eye, "left"][:260]), 35, f"{name}, {eye} of both")

    def test_frames_of_two_seconds_are_stepped_through(self):
        folder, slow = self.root / "slow", self.root / "slow.mkv"
        PROGRAMS.run("render", self.scene, "--frames", "0-2", "--fps", 0.5, "--size", "128x64", "--spp", 1, "--aovs", "none", "--out", folder)
        PROGRAMS.run("encode", folder, "--out", slow, "--depth", "none", "--preset", "ultrafast", "--progress", "none")
        viewer = self.view(source=slow)
        seen = [viewer.picture()]

        def press_until_it_changes(key):
            viewer.press(key)
            return wait_for(lambda: (lambda p: p if (p != seen[-1]).any() else None)(viewer.picture()), f"another frame after {key}")

        for key in ("period", "period"):
            seen.append(press_until_it_changes(key))
        self.assertTrue((press_until_it_changes("comma") == seen[1]).all())
        seen.append(seen[1])
        self.assertTrue((press_until_it_changes("shift+Left") == seen[0]).all())
        seen.append(seen[0])
        self.assertTrue((press_until_it_changes("shift+Right") == seen[1]).all())

    def test_the_wheel_zooms_and_a_key_takes_it_back(self):
        viewer = self.view("--method", "rotation")
        first = viewer.picture()
        for _ in range(3):
            self.display.tool("click", 4)
        wait_for(lambda: psnr(viewer.picture(), first) < 30, "a larger picture")
        viewer.press("c")
        wait_for(lambda: (viewer.picture() == first).all(), "the first picture")

    def test_a_key_of_a_jump_does_not_turn_the_head_when_shift_is_let_go_first(self):
        viewer = self.view("--method", "rotation")
        first = viewer.picture()
        for what, key in (("keydown", "shift"), ("keydown", "Left"), ("keyup", "shift")):
            self.display.tool(what, key)
        time.sleep(0.5)
        self.display.tool("keyup", "Left")
        self.assertTrue((viewer.resting_picture() == first).all())
        viewer.hold("Left", 0.5)
        self.assertFalse((viewer.resting_picture() == first).all())

    def test_a_signal_ends_it_and_loses_nothing(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            viewer = self.view("--json", paused=False)
            viewer.press("shift+r")
            viewer.picture()
            time.sleep(0.5)
            viewer.process.send_signal(number)
            self.assertEqual(viewer.end(), (0, ""))
            self.assertGreater(json.loads(viewer.printed)["frames"], 0)
            self.assertTrue((self.out / "head.0001.csv").exists())

    def test_it_ends_by_itself(self):
        self.assert_ends_after_a_second(lambda: self.by_geometry("--seconds", "1"))

    def test_without_a_source_it_ends_by_itself_too(self):
        self.assert_ends_after_a_second(lambda: self.view("--seconds", "1", source=""))

    def assert_ends_after_a_second(self, start):
        begun = time.monotonic()
        viewer = start()
        shown = time.monotonic()
        self.assertEqual(viewer.end(), (0, ""))
        self.assertGreater(time.monotonic() - begun, 1)
        self.assertLess(time.monotonic() - shown, 30)

    def refused(self, environment, *words):
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", *words]], env=environment, capture_output=True, text=True)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
        return result.stderr

    def test_what_cannot_be_shown_is_said_in_one_line(self):
        here = self.display.environment
        self.assertIn("no-such", self.refused(here, self.root / "no-such.mkv"))
        self.assertIn("DISPLAY", self.refused({**here, "DISPLAY": ""}, self.stream))
        self.assertIn("OpenGL 4.5", self.refused({**here, "MESA_GL_VERSION_OVERRIDE": "3.3"}, self.stream))
        self.assertIn("--layout: expected left, right, sbs", self.refused(here, self.stream, "--layout", "upside-down"))
        self.assertIn("--predict: expected auto, off or milliseconds", self.refused(here, self.stream, "--predict", "soon"))
        self.assertIn("--decode: expected software, auto", self.refused(here, self.stream, "--decode", "hardware"))
        self.assertIn("expected views in left/ or right/", self.refused(here, self.stream, "--truth", self.root / "frames"))
        self.assertIn("--extrapolate: expected 0 to 1 s", self.refused(here, self.stream, "--extrapolate", "2"))
        self.assertIn("--fov", self.refused(here, self.stream, "--fov", "5"))
        self.assertIn("--method: expected rotation, proxy-sphere, eye-depth, mesh, splat or mesh-plain, found 'warp'", self.refused(here, self.stream, "--method", "warp"))
        self.assertIn("--method splat: expected a method of the viewer, found one of play only", self.refused(here, self.stream, "--method", "splat"))
        for option in ("--scene", "--model"):
            refusal = self.refused(here, self.stream, option, self.scene, "--method", "mesh")
            self.assertIn("--method mesh: expected no --scene or --model (--method eye-depth uses them)", refusal)
            self.assertIn(f"found {option} {self.scene}", refusal)
        other = PROGRAMS.scene("motion", self.root)
        self.assertIn(f"{other}: expected the scene 'pavilion' that", self.refused(here, self.stream, "--scene", other))
        empty = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self.assertIn("a display", self.refused(empty, self.stream))


if __name__ == "__main__":
    unittest.main()
