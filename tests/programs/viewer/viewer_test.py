"""`equistream view` on a display: what keys do, seen in pixels and held to what `play` makes of the same stream.

usage: viewer_test.py BIN_DIR
"""

import time

from viewing import *  # noqa: F403

SAME_DB = 40  # one geometry drawn by OpenGL for both; rasters of other sizes choose other samples at outlines


class Viewer(Viewing):
    def test_an_eye_sees_what_play_shows(self):
        self.assertGreater(psnr(self.by_geometry().picture(), self.played()), SAME_DB)
        self.assertLess(psnr(self.played(eye="right"), self.played()), SAME_DB)

    def test_the_keys_layouts_follow_each_other(self):
        viewer = self.by_geometry()
        left = viewer.picture()
        viewer.press("v")
        right = viewer.picture()
        self.assertGreater(psnr(right, self.played(eye="right")), SAME_DB)
        viewer.press("v")
        both = viewer.picture()
        for eye, half in (("left", both[:, : WIDTH // 2]), ("right", both[:, WIDTH // 2 :])):
            self.assertGreater(psnr(half, self.played(eye=eye, size=f"{WIDTH // 2}x{HEIGHT}")), SAME_DB)
        viewer.press("v")
        anaglyph = viewer.picture()
        self.assertGreater(psnr(anaglyph, self.played("--layout", "anaglyph", eye="both")), SAME_DB)
        viewer.press("v")
        headset = viewer.picture()
        self.assertTrue((headset[:3, :3] == 0).all())  # the lens' corners are dark
        self.assertLess(psnr(headset, both), 25)
        viewer.press("v")
        sphere = viewer.picture()
        self.assertTrue((sphere[0] < 30).all())  # 2:1 in 16:9: dark above
        viewer.press("v")
        self.assertEqual(psnr(viewer.picture(), left), float("inf"))

    def test_turning_and_coming_back(self):
        viewer = self.by_geometry()
        ahead = viewer.picture()
        viewer.hold("Right", 0.8)
        turned = viewer.picture()
        self.assertLess(psnr(turned, ahead), 30)
        self.assertTrue((turned.max(axis=2) > 0).mean() > 0.99)  # never a black border
        viewer.press("c")
        self.assertEqual(psnr(viewer.picture(), ahead), float("inf"))

    def test_the_mouse_drags_the_view(self):
        viewer = self.by_geometry()
        ahead = viewer.picture()
        self.display.tool("mousemove", 100, 90)
        self.display.tool("mousedown", 1)
        for x in range(100, 181, 10):
            self.display.tool("mousemove", x, 90)
        self.display.tool("mouseup", 1)
        # What the mouse held went with it: the view looks to the left now, and shows what was left of here farther right.
        wait_for(lambda: psnr(viewer.picture(), ahead) < 30, "a turned view")
        moved = viewer.resting_picture()
        shifts = [psnr(moved[60:120, 130:190], ahead[60:120, 130 - s : 190 - s]) for s in range(-96, 97, 4)]
        # 80 pixels of 320 at 90 degrees; a view that turns stretches what leaves its middle.
        self.assertAlmostEqual(list(range(-96, 97, 4))[int(np.argmax(shifts))], 80, delta=12)

    def test_what_stays_as_it_is_is_drawn_once(self):
        viewer = self.by_geometry("--json")
        time.sleep(2)
        still = self.report_of(viewer)
        self.assertEqual(still["frames"], 1)
        # Drawn when it comes up, and again where the display asks for that; two seconds have a hundred refreshes.
        self.assertLessEqual(still["refreshes"], 6)
        viewer = self.view("--json", "--method", "rotation", size="64x48")
        self.display.tool("keydown", "Left")
        seen = set()
        wait_for(lambda: seen.add(viewer.picture().tobytes()) or len(seen) >= 9, "nine views while it turns")
        self.display.tool("keyup", "Left")
        turning = self.report_of(viewer)
        self.assertEqual(turning["frames"], 1)
        self.assertGreater(turning["refreshes"], still["refreshes"] + 2)
        self.assertEqual(turning["decoder"], "software")  # there is no other here, and nobody complains

    def test_frames_are_drawn_as_they_come_with_a_still_head(self):
        viewer = self.by_geometry("--json", "--loop", "off", "--predict", "off", "--decode", "software", paused=False)
        time.sleep(2)  # of a source of 0.8 s
        report = self.report_of(viewer)
        self.assertGreater(report["frames"], 0)
        self.assertLessEqual(report["refreshes"], report["frames"] + 6)

    def test_a_picture_alone_is_read_once(self):
        folder = self.root / "alone"
        PROGRAMS.run("render", self.scene, "--frames", "0", "--fps", 5, "--size", "128x64", "--spp", 1, "--aovs", "none", "--out", folder)
        viewer = self.view("--json", "--method", "rotation", source=folder, paused=False)
        viewer.picture()
        time.sleep(2)  # ten times as long as it is shown
        self.assertEqual(self.report_of(viewer)["frames"], 1)

    def moving_stream(self, depth="none"):
        """The bundled scene whose bodies move by themselves, at three frames a second, and its head turned to them."""
        folder, stream = self.root / "moving_frames", self.root / f"moving_{depth}.mkv"
        if not folder.exists():
            type(self).moving_scene = PROGRAMS.scene("motion", self.root)
            PROGRAMS.run("render", self.moving_scene, "--frames", "0-3", "--fps", 3, "--size", "256x128", "--spp", 1, "--aovs", "depth,motion,ids", "--out", folder)
        if not stream.exists():
            PROGRAMS.run("encode", folder, "--out", stream, "--depth", depth, "--motion", "auto", "--preset", "ultrafast", "--progress", "none")
        return stream, self.moving_scene

    def test_what_moves_is_extrapolated_between_frames(self):
        stream, scene = self.moving_stream()
        self.expect_extrapolated(stream, "--scene", scene)

    def test_what_moves_is_extrapolated_by_the_streams_own_depth(self):
        self.expect_extrapolated(self.moving_stream("auto")[0])

    def expect_extrapolated(self, stream, *words):
        said = {}
        for limit_s in ("0.2", "0"):
            viewer = self.view(*words, "--extrapolate", limit_s, "--json", "--predict", "off", source=stream, paused=False, size="96x64")
            viewer.picture()
            time.sleep(3)
            said[limit_s] = self.report_of(viewer)
        self.assertEqual(said["0"]["moved_on_ms"], 0)
        self.assertGreater(said["0.2"]["moved_on_ms"], 20)
        # Refreshes beyond those that a new frame asks for.
        self.assertLessEqual(said["0"]["refreshes"], said["0"]["frames"] + 8)
        self.assertGreater(said["0.2"]["refreshes"], 1.5 * said["0.2"]["frames"] + 8)

    def test_motion_is_shown_in_colours(self):
        stream, scene = self.moving_stream()
        viewer = self.view("--scene", scene, "--overlay", "motion", source=stream, size="400x300")
        viewer.hold("Right", 3.1)  # the ball is behind
        seen = viewer.resting_picture()[:200, :330]
        colour = seen.max(axis=2) - seen.min(axis=2)
        self.assertGreater((colour > 60).sum(), 200)
        # All else is grey, so that nothing else has a hue.
        self.assertGreater((colour < 3).mean(), 0.6)
        viewer.press("o")
        self.assertLess(psnr(viewer.resting_picture()[:200, :330], seen), 30)
        viewer.close()  # and with it the keyboard
        legend = self.view("--scene", scene, "--overlay", "motion", source=stream, size="400x300").picture()[300 - 128 - 44 : 300 - 128 + 44, 400 - 64 - 44 : 400 - 64 + 44]
        right, up, left = legend[44, 80], legend[8, 44], legend[44, 8]
        self.assertTrue(right[0] > 200 and right[1:].max() < 60, right)
        self.assertTrue(left[0] < 60 and left[1:].min() > 180, left)
        self.assertTrue(up[1] > 180 and up[2] < 60, up)
        self.assertLess(legend[44, 44].max(), 30)

    def test_a_moving_head_sees_parallax_by_depth_alone(self):
        viewer = self.by_geometry()
        still = viewer.picture()
        viewer.press("m")
        turned_only = viewer.picture()
        viewer.hold("d", 1)
        self.assertEqual(psnr(viewer.picture(), turned_only), float("inf"))  # `rotation` knows of no place...
        viewer.press("m")
        self.assertLess(psnr(viewer.picture(), still), 30)  # ... `eye-depth` does

    def test_beyond_the_head_box_the_picture_fades(self):
        viewer = self.by_geometry("--method", "rotation")
        inside = viewer.picture()
        viewer.hold("w", 7)
        outside = viewer.picture()
        self.assertLess(outside.std(), 0.8 * inside.std())
        self.assertGreater(outside.mean(), 40)

    def test_frames_back_and_on(self):
        viewer = self.by_geometry()
        first = viewer.picture()
        viewer.press("period")
        second = wait_for(lambda: (lambda p: p if psnr(p, first) < 60 else None)(viewer.picture()), "the next frame")
        viewer.press("comma")
        wait_for(lambda: psnr(viewer.picture(), first) == float("inf") or None, "the frame before")
        viewer.press("period")
        wait_for(lambda: psnr(viewer.picture(), second) == float("inf") or None, "the next frame again")

    def test_it_plays_and_starts_again(self):
        viewer = self.by_geometry(paused=False)
        seen = set()
        wait_for(lambda: seen.add(viewer.picture().tobytes()) or len(seen) >= 3, "three different frames of a loop")

    def test_a_jump_past_the_end_starts_again(self):
        viewer = self.by_geometry(paused=False)
        viewer.press("shift+Right", "shift+Right", "shift+Right")
        seen = set()
        wait_for(lambda: seen.add(viewer.picture().tobytes()) or len(seen) >= 3, "three different frames after a jump")

    def test_overlays(self):
        viewer = self.by_geometry("--fill", "off")
        plain = viewer.picture()
        viewer.press("o")
        depth = viewer.picture()
        self.assertLess(psnr(depth, plain), 20)
        viewer.press("o")
        gaps = viewer.picture()
        open_gaps = (plain.max(axis=2) == 0) & (gaps[..., 0] > 150) & (gaps[..., 1:].max(axis=2) < 60)
        self.assertGreater(open_gaps.sum(), 20)  # black without the overlay, red in it
        viewer.press("o")
        self.assertLess(psnr(viewer.picture(), plain), 40)

    def test_a_split_shows_the_other_method_on_the_right(self):
        viewer = self.by_geometry()
        surface = viewer.picture()
        viewer.press("m")
        sphere = viewer.picture()
        viewer.press("m", "x")
        both = viewer.picture()
        middle = WIDTH // 2
        self.assertEqual(psnr(both[:, : middle - 2], surface[:, : middle - 2]), float("inf"))
        self.assertEqual(psnr(both[:, middle + 2 :], sphere[:, middle + 2 :]), float("inf"))

    def test_the_truth_is_shown_on_the_right(self):
        truth = self.root / "truth"
        PROGRAMS.run("render", self.scene, "--camera", "perspective", "--eye", "both", "--frames", "0-1", "--fps", 5, "--size", f"{WIDTH}x{HEIGHT}", "--spp", 4,
                     "--aovs", "none", "--out", truth)
        exposure = json.loads(self.scene.read_text()).get("exposure", 1)

        def true(eye, frame):
            return bytes_of(srgb(exposure * colour_of(read_frame(truth / eye / f"frame.{frame:04}.exr")))).astype(float)

        viewer = self.by_geometry("--truth", truth, "--json", size=None)  # the window is as large as the truth
        drawn, middle = viewer.picture(), WIDTH // 2

        def shows(eye, frame):
            seen = viewer.picture()
            return seen.shape == drawn.shape and np.abs(seen - true(eye, frame))[:, middle + 2 :].max() <= 1

        viewer.press("x")
        self.assertTrue(shows("left", 0))
        self.assertEqual(psnr(viewer.picture()[:, : middle - 2], drawn[:, : middle - 2]), float("inf"))
        self.assertAlmostEqual(self.report_of(viewer)["truth_psnr_db"], psnr(drawn, true("left", 0)), delta=0.01)
        viewer = self.by_geometry("--truth", truth, "--json", size=None)
        viewer.picture()
        viewer.press("x", "v")
        wait_for(lambda: shows("right", 0), "the right eye's truth")
        viewer.press("period")
        wait_for(lambda: shows("right", 1), "the next frame's truth")
        viewer.hold("d", 0.5)  # it is not of where the head is now
        self.assertFalse(shows("right", 1))
        viewer.press("c")
        wait_for(lambda: shows("right", 1), "the truth again")
        viewer.press("period", "period")  # there is none of frame 3
        wait_for(lambda: not shows("right", 1), "a frame without a truth")
        self.assertGreater(psnr(true("right", 0), true("left", 0)), 5)

    def test_help_times_and_the_status_line_are_on_the_screen(self):
        viewer = self.by_geometry(size="800x600")
        viewer.picture()
        before = viewer.screen()
        viewer.press("h")
        wait_for(lambda: np.abs(viewer.screen() - before)[:500, :400].mean() > 20, "help")
        viewer.press("h", "t")
        wait_for(lambda: np.abs(viewer.screen() - before)[:150, 450:].mean() > 20, "frame times")

    def test_all_keys_fit_into_a_small_window_that_is_drawn_once(self):
        viewer = self.by_geometry(size="640x300")
        viewer.picture()
        time.sleep(4.5)  # until what was written has gone
        before = shown = viewer.screen()
        pages = 0
        while True:
            viewer.press("h")
            wait_for(lambda: (viewer.screen() != shown).any(), "another page, or none")
            shown = wait_for(lambda: (lambda a, b: a if (a == b).all() else None)(viewer.screen(), viewer.screen()), "all of it")
            changed = np.abs(shown - before)[:300, :640].max(axis=2) > 0
            if not changed.any():
                break
            pages += 1
            # A whole panel: with a picture all around it, and its last line within.
            rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
            self.assertGreaterEqual(rows[0], 8)
            self.assertLess(rows[-1], 300 - 35)
            self.assertLess(columns[-1], 640 - 8)
            self.assertGreater(rows[-1], 100)
        self.assertIn(pages, range(2, 8))

    def test_the_times_name_the_decoder(self):
        heights = []
        for source in (self.stream, self.root / "frames"):  # decoded, and not
            viewer = self.by_geometry(source=source, size="640x400")
            viewer.picture()
            time.sleep(4.5)
            before = viewer.screen()
            viewer.press("t")
            time.sleep(2)
            changed = np.abs(viewer.screen() - before)[:335, 300:640].max(axis=2) > 0  # above the line at the bottom
            heights.append(np.flatnonzero(changed.any(axis=1))[-1])
            viewer.close()
        self.assertIn(heights[0] - heights[1], range(12, 24))  # a line


if __name__ == "__main__":
    unittest.main()
