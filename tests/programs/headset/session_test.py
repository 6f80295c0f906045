"""`equistream view --headset` in a runtime that records what it is given: sessions and how they end, spaces, time, the window beside it, and a server.

usage: session_test.py BIN_DIR RUNTIME_LIBRARY
"""

from worn import *  # noqa: F403
import live_server

HEAD = (0.1, 0.05, -0.1, *turn(40, (0, 1, 0)))


class Sessions(Worn):
    def test_frames_that_nobody_sees_have_no_picture(self):
        frames, log, result = self.worn([STILL, "idle", STILL, "untracked", STILL, "exit"])
        self.assertEqual(sorted(frames), [0, 2, 4])
        self.assertEqual(result.stderr, "")
        self.assertFalse(log.end["running"])

    def test_what_is_lost_ends_with_one_line(self):
        for end in ("loss", "instance-loss", "lost-call"):
            with self.subTest(end):
                _, log, result = self.worn([STILL, STILL, end], status=1)
                self.assertEqual(result.stderr, "equistream view: the headset was lost: its OpenXR runtime has ended the session\n")
                self.assertIsNotNone(log.end)

    def test_a_session_that_stopped_begins_again(self):
        frames, log, result = self.worn([STILL, "stop", HEAD, "stop", STILL, "exit"])
        self.assertEqual(sorted(frames), [0, 1, 2])
        self.assertEqual((log.end["begun_sessions"], log.end["running"], result.stderr), (3, False, ""))

    def test_who_closes_the_window_ends_it(self):
        viewer = WornViewer(self, [STILL, "until closed", "exit"], "--paused", "--method", "rotation")
        viewer.wait_for_frame(0)
        viewer.press("Escape")
        self.assertEqual(viewer.end(), (0, ""))
        self.assertEqual(viewer.log().broken, [])
        self.assertTrue(viewer.log().end["running"])

    def refused(self, environment):
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", self.stream, "--headset"]],
                                env={**self.display.environment, **environment}, capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (2, 1), result.stderr)
        return result.stderr

    def test_without_what_it_needs_there_is_one_line(self):
        self.assertIn("--headset: expected an OpenXR runtime", self.refused({"XR_RUNTIME_JSON": str(self.root / "none.json")}))
        for missing, said in (("no headset", "a headset, found"), ("no opengl", "an OpenXR runtime that OpenGL can draw for, found one without"),
                              ("no srgb", "a runtime with sRGB pictures of 8 bits a channel, found one without")):
            with self.subTest(missing):
                self.assertIn("--headset: expected " + said, self.refused(self.runtime_of(self.scripted([missing, STILL, "exit"]))))


    def test_the_loader_says_more_where_it_is_asked_to(self):
        nowhere = {"XR_RUNTIME_JSON": str(self.root / "none.json"), "XR_LOADER_DEBUG": "all"}
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", self.stream, "--headset"]],
                                env={**self.display.environment, **nowhere}, capture_output=True, text=True, timeout=PATIENCE_S)
        lines = (result.stdout + result.stderr).splitlines()
        self.assertEqual(result.returncode, 2)
        self.assertTrue(any("OpenXR-Loader" in line for line in lines), lines)
        self.assertTrue(any("--headset: expected an OpenXR runtime" in line for line in lines), lines)


class Spaces(Worn):
    def assert_at(self, frame, head):
        view = frame["views"][0]
        eye = np.array(head[:3]) + rotation(head[3:]) @ [-IPD_M / 2, 0, 0]
        self.assertLess(np.abs(np.array(view["orientation"]) - head[3:]).max(), 1e-5)
        self.assertLess(np.abs(np.array(view["position"]) - eye).max(), 1e-5)

    def test_a_key_centres_the_space_where_the_head_is(self):
        viewer = WornViewer(self, [HEAD, "until centred", "exit"], "--paused", "--method", "rotation")
        viewer.wait_for_frame(0)
        self.assert_at(viewer.log().frames[0], HEAD)
        viewer.press("c")
        wait_for(lambda: viewer.log().frames[-1]["views"][0]["orientation"][0] > 0.9999, "a head that looks ahead")
        viewer.go_on("centred")
        self.assertEqual(viewer.end(), (0, ""))
        self.assert_at(viewer.log().frames[-1], STILL)
        self.assertEqual(viewer.log().end["spaces"], 2)
        self.assertEqual(viewer.log().broken, [])

    def test_where_the_runtime_centres_its_space_ours_is_centred(self):
        # Said two frames before it is so.
        viewer = WornViewer(self, [HEAD, "until centred", HEAD, "recentre 2", HEAD, STILL, HEAD, "exit"], "--paused", "--method", "rotation")
        viewer.wait_for_frame(0)
        viewer.press("c")
        wait_for(lambda: viewer.log().frames[-1]["views"][0]["orientation"][0] > 0.9999, "a head that looks ahead")
        viewer.go_on("centred")
        self.assertEqual(viewer.end(), (0, ""))
        last = {frame["frame"]: frame for frame in viewer.log().frames}
        for number, head in ((1, STILL), (2, STILL), (3, STILL), (4, HEAD)):
            with self.subTest(frame=number):
                self.assert_at(last[number], head)


class Time(Worn):
    def test_frames_are_for_when_they_are_seen(self):
        for script, latency_ms in ((["lead-ms 40"], 40), ([], 1e3 / 90)):
            _, _, result = self.worn([*script, STILL, STILL, "exit"], "--json")
            self.assertAlmostEqual(json.loads(result.stdout)["latency_ms"], latency_ms, delta=1e-3)
            self.assertGreater(float(json.loads(result.stdout)["panel"]["speed"]["refreshes"].split()[0]), 0)

    def test_what_moves_is_extrapolated_until_it_is_seen(self):
        scene = PROGRAMS.scene("motion", self.root)
        folder, stream = self.root / "moving_frames", self.root / "moving.mkv"
        PROGRAMS.run("render", scene, "--frames", "0-3", "--fps", 3, "--size", "256x128", "--spp", 1, "--aovs", "depth,motion,ids", "--out", folder)
        PROGRAMS.run("encode", folder, "--out", stream, "--depth", "none", "--motion", "auto", "--preset", "ultrafast", "--progress", "none")
        server = live_server.LiveServer(PROGRAMS.folder / "equistream", stream, self.scripted([]), "--loop")
        self.addCleanup(server.close)
        viewer = WornViewer(self, ["lead-ms 10000", STILL, "until extrapolated", "exit"], "--scene", scene, "--extrapolate", "1", "--json", source=server.url)
        wait_for(lambda: (viewer.folder / "log.jsonl").exists() and len(viewer.log().frames) >= 5, "frames of the headset")
        viewer.go_on("extrapolated")
        self.assertEqual(viewer.end(), (0, ""))
        report = json.loads(viewer.printed)
        self.assertAlmostEqual(report["latency_ms"], 10000, delta=1)
        self.assertGreaterEqual(report["moved_on_ms"], 999)  # as far as it may

    def test_what_is_kept_is_written_between_frames(self):
        viewer = WornViewer(self, [STILL, "until recorded", "exit"], "--paused", "--method", "rotation")
        viewer.wait_for_frame(0)
        viewer.press("r")
        wait_for((viewer.folder / "recording.0001" / "frame.0005.png").exists, "a recording")
        viewer.go_on("recorded")
        self.assertEqual(viewer.end(), (0, ""))
        written = [frame["pictures"] for frame in viewer.log().frames]
        self.assertGreater(written[-1][1], 4)
        self.assertEqual([begin for begin, _ in written], [end for _, end in written])


class Window(Worn):
    def assert_is_alive(self, viewer):
        ahead = viewer.picture()
        viewer.press("v", "v")
        wait_for(lambda: psnr(viewer.picture(), ahead) < 30, "both eyes")
        self.display.tool("windowsize", "--sync", viewer.window, 200, 150)
        wait_for(lambda: viewer.picture().shape == (150, 200, 3), "a smaller picture")

    def test_it_goes_on_while_the_session_does_not(self):
        viewer = WornViewer(self, [HEAD, "stop again", HEAD, "exit"], "--paused", "--scene", self.scene)
        viewer.wait_for_frame(0)
        self.assert_is_alive(viewer)
        viewer.go_on("again")
        self.assertEqual(viewer.end(), (0, ""))
        self.assertEqual(len(viewer.log().frames), 2)

    def test_it_goes_on_while_nobody_looks(self):
        for nobody in ("idle", "untracked"):
            viewer = WornViewer(self, [nobody, "until worn", HEAD, "until seen", "exit"], "--paused", "--scene", self.scene, "--size", "320x180")
            self.assert_is_alive(viewer)
            viewer.go_on("worn")
            viewer.wait_for_frame(1)
            # What the left eye sees, whatever the window's layout.
            worn = wait_for(lambda: (lambda a, b: a if psnr(a, b) == float("inf") else None)(viewer.picture(), viewer.picture()), "the mirror")
            self.assertEqual(worn.shape, (150, 200, 3))
            viewer.go_on("seen")
            self.assertEqual(viewer.end(), (0, ""))
            left = Image.open(viewer.folder / "frame.0001.0.ppm")
            mirrored = left.transform((200, 150), Image.AFFINE, (left.width / 200, 0, 0, 0, left.height / 150, 0), Image.BILINEAR)
            self.assertGreater(psnr(worn, np.asarray(mirrored).astype(float)), 30)


class Server(Worn):
    def test_a_wearer_who_walks_leads_it(self):
        description = json.loads(self.scene.read_text())
        first = description["camera"]["keys"][0]
        description["camera"]["keys"] = [first]
        scene = self.scene.with_name("standing.json")
        scene.write_text(json.dumps(description))
        server = live_server.LiveServer(PROGRAMS.folder / "equistream", scene, self.scripted([]), "--size", "128x64", "--spp", 1, "--json")
        self.addCleanup(server.close)
        walked = (0.2, 0.05, -0.1, *turn(15, (0, 1, 0)))
        viewer = WornViewer(self, [STILL, "until walking", walked, "until followed", "exit"], "--method", "rotation", source=server.url)
        viewer.wait_for_frame(0)
        watcher = live_server.Viewer(server)
        watcher.wait_for_more(2)
        folder = self.scripted([])

        def place():
            watcher.wait_for_more(1)
            return live_server.Received(PROGRAMS, watcher.bytes, folder).frames[-1]

        head = place()["head"]
        np.testing.assert_allclose(head["position_m"], first["position_m"], atol=1e-9)
        viewer.go_on("walking")
        there = np.array(head["position_m"]) + rotation(head["orientation_wxyz"]) @ walked[:3]
        wait_for(lambda: np.allclose(place()["camera_pose"]["position_m"], there, atol=1e-5, rtol=0), f"a sphere at {there}")
        viewer.go_on("followed")
        self.assertEqual(viewer.end(), (0, ""))
        status, printed = server.end()
        # One who stands still sends nothing, and no head twice.
        self.assertEqual((status, json.loads(printed)["live"]["poses"]), (0, 1))


if __name__ == "__main__":
    unittest.main()
