"""The face of `equistream view` on a display: menus, panel, timeline and what it keeps, by real clicks and keys.

usage: face_test.py BIN_DIR
"""

import socket
import time

from viewing import *  # noqa: F403
from display import PATIENCE_S
from drop import Dragging

# Of a window of this size at 96 dots per inch: the middle of the bar of time, which is as wide as the window but for these margins.
BIG = (640, 480)
BAR_Y, BAR_LEFT = BIG[1] - 40, 8


class Face(Viewing):
    def big(self, *words, **more):
        return self.view("--method", "rotation", *words, size="{}x{}".format(*BIG), **more)

    def click(self, x, y):
        self.display.tool("mousemove", int(x), int(y))
        self.display.tool("click", 1)

    def steady_screen(self, viewer):
        return wait_for(lambda: (lambda a, b: a if (a == b).all() else None)(viewer.screen(), viewer.screen()), "a screen that rests")

    def corner_of_menu(self, viewer, x, y):
        """Of the box that comes up by a click in the menu bar, which has to be there before it is clicked."""
        between = np.s_[24:400]  # menu bar and timeline, which come and go
        before = self.steady_screen(viewer)[between]

        def is_open():
            return (viewer.screen()[between] != before).sum() > 6000

        def opened():
            for place in (x + 1, x):
                self.display.tool("mousemove", place, y)
            wait_for(lambda: (viewer.screen()[:10, 300 : BIG[0]].std(axis=(0, 1)) < 1).all(), "the menu bar")
            self.display.tool("click", 1)
            end = time.monotonic() + 5
            while time.monotonic() < end and not is_open():
                time.sleep(0.1)
            return is_open()

        wait_for(opened, "a menu")
        changed = (self.steady_screen(viewer)[between] != before).any(axis=2)
        rows, columns = np.flatnonzero(changed.sum(axis=1) > 40), np.flatnonzero(changed.sum(axis=0) > 40)
        return int(columns[0]), 24 + int(rows[0])

    def panel_of(self, viewer):
        return self.report_of(viewer)["panel"]

    def choose_rotation(self, viewer):
        left, top = self.corner_of_menu(viewer, 115, 9)  # "Picture", whose first line is "Method"
        self.display.tool("mousemove", left + 40, top + 12)
        time.sleep(1)
        self.click(left + 200, top + 14)  # "rotation", the first of the menu beside it

    def test_a_menu_chooses_the_method(self):
        viewer = self.view("--scene", self.scene, "--json", size="{}x{}".format(*BIG))
        self.display.tool("mousemove", 320, 240)
        depth = viewer.picture()
        self.display.tool("keydown", "d")
        time.sleep(1)
        self.display.tool("keyup", "d")
        depth = viewer.resting_picture()
        self.choose_rotation(viewer)
        wait_for(lambda: psnr(viewer.picture(), depth) < 40, "a picture by rotation alone")
        self.assertEqual(self.panel_of(viewer)["method"]["in use"], "rotation")

    def test_more_tracks_are_read_from_the_frame_that_is_shown(self):
        words = ("--json", "--mirrors", "surface", "--fill", "pushpull", "--overlay")
        viewer = self.big(*words, "reliability")
        start = viewer.picture()
        viewer.close()  # and with it the keyboard
        began = time.monotonic()
        viewer = self.big(*words, "gaps")
        viewer.picture()
        opened_within_s = time.monotonic() - began
        for _ in range(3):
            before = viewer.picture()
            viewer.press("period")
            wait_for(lambda: psnr(viewer.picture(), before) < 60, "the next frame")
        viewer.press("r", "o")  # the overlay of confidence takes reflections' tracks
        time.sleep(2 + 2 * opened_within_s)
        viewer.press("r")
        self.assertLess(psnr(viewer.picture(), start), 60)
        recorded = sorted((self.out / "recording.0001").iterdir())
        self.assertGreater(len(recorded), 2)
        for file in recorded:
            self.assertLess(psnr(np.asarray(Image.open(file).convert("RGB")).astype(float), start), 60, file.name)
        self.assertEqual(self.report_of(viewer)["frames"], 2)  # of what was opened anew: the first, and the one that was sought

    def test_a_click_on_the_timeline_seeks(self):
        viewer = self.big("--json", "--loop", "off")
        pictures = [viewer.picture()]
        for _ in range(3):
            viewer.press("period")
            pictures.append(wait_for(lambda: (lambda p: p if psnr(p, pictures[-1]) < 60 else None)(viewer.picture()), "the next frame"))
        for frame in (1, 3, 0, 2):
            self.click(BAR_LEFT + (BIG[0] - 2 * BAR_LEFT) * (frame + 0.5) / 4, BAR_Y)
            wait_for(lambda: (viewer.picture() == pictures[frame]).all(), f"frame {frame}")
        self.assertEqual(self.panel_of(viewer)["source"]["frame"], "2")

    def test_the_button_plays(self):
        viewer = self.big()
        viewer.picture()
        self.click(BAR_LEFT + 8, BIG[1] - 20)
        seen = set()
        wait_for(lambda: seen.add(viewer.picture().tobytes()) or len(seen) >= 3, "three different frames")

    def test_menus_and_timeline_go_and_are_in_no_picture(self):
        viewer = self.big()
        still = viewer.picture()
        wait_for(lambda: (viewer.screen()[: BIG[1], : BIG[0]] == still).all(), "a picture without anything over it")
        self.display.tool("mousemove", 300, 200)
        shown = wait_for(lambda: (lambda s: s if (s[:15, : BIG[0]] != still[:15]).mean() > 0.5 else None)(viewer.screen()), "the menu bar")
        self.assertGreater((shown[BAR_Y - 10 : BIG[1], : BIG[0]] != still[BAR_Y - 10 :]).mean(), 0.5)
        self.assertTrue((viewer.picture() == still).all())
        viewer.press("Tab")
        wait_for(lambda: (viewer.screen()[60:400, 500 : BIG[0]] != still[60:400, 500:]).mean() > 0.5, "the panel")
        time.sleep(3)
        self.assertGreater((viewer.screen()[:15, : BIG[0]] != still[:15]).mean(), 0.5)  # they stay beside it
        self.assertTrue((viewer.picture() == still).all())
        viewer.press("Tab")
        wait_for(lambda: (viewer.screen()[: BIG[1], : BIG[0]] == still).all(), "the picture alone")

    def drag(self, x, y):
        self.display.tool("mousemove", x, y)
        self.display.tool("mousedown", 1)
        for step in range(1, 6):
            self.display.tool("mousemove", x - 12 * step, y)
        self.display.tool("mouseup", 1)

    def test_the_mouse_over_the_panel_turns_nothing(self):
        viewer = self.big("--panel")
        still = viewer.picture()
        self.drag(560, 300)
        self.assertTrue((viewer.resting_picture() == still).all())
        self.drag(200, 300)
        wait_for(lambda: psnr(viewer.picture(), still) < 30, "a turned view")

    def test_the_panel_says_what_info_says(self):
        viewer = self.big("--json", "--panel")
        viewer.picture()
        panel = self.panel_of(viewer)
        info = json.loads(PROGRAMS.run("info", self.stream, "--json"))
        main = info["tracks"][0]
        self.assertEqual(panel["source"]["size"], f"{main['width']}x{main['height']}")
        self.assertEqual(panel["source"]["codec"], main["codec"])
        self.assertEqual(panel["source"]["decoder"], "software")
        self.assertEqual(float(panel["source"]["frames/s"]), main["first_frame"]["frames_per_second"])
        self.assertEqual(float(panel["source"]["length"].split()[0]), 0.8)
        self.assertEqual(panel["source"]["scene"], main["first_frame"]["scene"])
        self.assertEqual(panel["source"]["frame"], "0")
        self.assertEqual((panel["network"]["lost"], panel["network"]["skipped"]), ("0", "0"))
        self.assertGreater(float(panel["speed"]["memory"].split()[0]), 10)
        self.assertGreater(float(panel["speed"]["on the GPU"].split()[0]), 1)

    def test_the_length_of_an_mp4_is_that_of_its_frames(self):
        # Whose tracks begin at times of their own, and which its container says too long.
        stream = self.root / "walk.mp4"
        PROGRAMS.run("encode", self.root / "frames", "--out", stream, "--depth", "auto", "--progress", "none")
        viewer = self.big("--json", source=stream)
        viewer.picture()
        self.assertEqual(self.panel_of(viewer)["source"]["length"], "0.80 s")

    def test_the_panel_says_what_is_under_the_mouse(self):
        viewer = self.by_geometry("--json", "--panel", "--layout", "left", size="{}x{}".format(*BIG))
        x, y = 123, 321
        self.display.tool("mousemove", x, y)
        seen = viewer.picture()
        before = viewer.screen()
        self.display.tool("mousemove", x + 1, y)
        self.display.tool("mousemove", x, y)
        time.sleep(1)
        mouse = self.panel_of(viewer)["mouse"]
        self.assertEqual(mouse["pixel of the eye"], f"{x}, {y}")
        self.assertEqual([int(value) for value in mouse["colour, 8 bit"].split()], seen[y, x].astype(int).tolist())
        linear = (seen[y, x] / 255 + 0.055) / 1.055
        for value, exact in zip(mouse["colour, linear"].split(), np.where(seen[y, x] / 255 <= 0.04045, seen[y, x] / 255 / 12.92, linear**2.4)):
            self.assertAlmostEqual(float(value), exact, delta=1e-3)
        self.assertEqual(mouse["coloured by"], "the main picture")
        ahead = perspective_direction(x + 0.5, y + 0.5, *BIG, np.pi / 2)
        tags = json.loads(PROGRAMS.run("info", self.stream, "--json"))["tracks"][0]["first_frame"]
        direction = rotation(tags["camera_pose"]["orientation_wxyz"]).T @ rotation(tags["head"]["orientation_wxyz"]) @ ahead
        longitude, latitude = (float(word) for word in mouse["looks to"].removesuffix(" deg").split(", "))
        self.assertAlmostEqual(longitude, np.degrees(np.arctan2(direction[0], -direction[2])), delta=0.02)
        self.assertAlmostEqual(latitude, np.degrees(np.arctan2(direction[1], np.hypot(direction[0], direction[2]))), delta=0.02)
        # The depth that was rendered there, but for where the eye stands beside the sphere's centre.
        depth = read_frame(self.root / "frames" / "centre" / "frame.0000.exr")["depth.Z"]
        u, v = equirect_pixel(direction[None], depth.shape[1], depth.shape[0])
        rendered = depth[int(v[0]), int(u[0]) % depth.shape[1]]
        self.assertAlmostEqual(float(mouse["depth"].split()[0]) / rendered, 1, delta=0.1)
        self.assertFalse((before[: BIG[1], : BIG[0]] == seen).all())  # the panel was there

    def type_source(self, viewer, source):
        self.display.tool("key", "ctrl+o")
        before = self.steady_screen(viewer)
        self.display.tool("type", "--delay", "10", str(source))
        wait_for(lambda: (viewer.screen() != before).any(), "what is typed")
        self.display.tool("key", "Return")

    def warned(self, viewer):
        red, green, blue = np.moveaxis(viewer.screen()[BIG[1] - 70 : BIG[1], : BIG[0]], -1, 0)
        return ((red > 180) & (green > 100) & (green < 180) & (blue < 110)).sum() > 40

    def test_another_source_is_opened_and_one_that_cannot_be_changes_nothing(self):
        viewer = self.big("--json")
        first = viewer.picture()
        self.type_source(viewer, self.root / "no-such.mkv")

        wait_for(lambda: self.warned(viewer), "a line on what cannot be opened")
        self.assertTrue((viewer.picture() == first).all())
        self.type_source(viewer, self.root / "frames")
        wait_for(lambda: psnr(viewer.picture(), first) < 60, "the folder, which is not coded")
        panel = self.panel_of(viewer)
        self.assertEqual(panel["source"]["kind"], "a folder of frames")
        self.assertEqual(panel["source"]["length"], "0.80 s")

    def test_what_is_dropped_on_the_window_is_opened(self):
        viewer = self.big("--json")
        first = viewer.picture()
        dragging = Dragging(self.display.name, viewer.window, PATIENCE_S)
        self.addCleanup(dragging.close)
        self.assertTrue(dragging.drop(self.root / "frames", BIG[0] // 2, BIG[1] // 2))
        wait_for(lambda: psnr(viewer.picture(), first) < 60, "the folder, which is not coded")
        self.assertEqual(self.panel_of(viewer)["source"]["kind"], "a folder of frames")

    def test_without_a_source_the_window_asks_for_one(self):
        viewer = self.big("--json", source="")

        def asked():
            shown = viewer.screen()[: BIG[1], : BIG[0]]
            lines = shown[200:280].max(axis=2) > 150
            return 500 < lines.sum() < 20000 and shown[60:200].max() == 0

        wait_for(asked, "a line in the middle of nothing")
        self.type_source(viewer, self.root / "no-such.mkv")
        wait_for(lambda: self.warned(viewer), "a line on what cannot be opened")
        wait_for(asked, "the line in the middle")
        self.type_source(viewer, self.stream)
        wait_for(lambda: self.out.exists() and viewer.screen()[60:200, : BIG[0]].std() > 10, "the stream")
        self.assertEqual(self.panel_of(viewer)["source"]["kind"], "Matroska / WebM")

    def test_what_is_chosen_without_a_source_is_for_the_one_that_comes(self):
        config = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        viewer = self.by_geometry("--json", source="", size="{}x{}".format(*BIG), config=config)
        self.choose_rotation(viewer)
        file = config / "equistream" / "view.json"
        wait_for(file.exists, "the file of settings")
        self.assertEqual(json.loads(file.read_text())["settings"]["method"], "rotation")
        self.type_source(viewer, self.stream)
        wait_for(lambda: viewer.screen()[60:200, : BIG[0]].std() > 10, "the stream")
        self.assertEqual(self.panel_of(viewer)["method"]["in use"], "rotation")

    def test_what_was_chosen_is_there_again(self):
        config = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        viewer = self.by_geometry(config=config)
        viewer.picture()
        self.display.tool("windowsize", "--sync", viewer.window, WIDTH + 20, HEIGHT)
        viewer.press("v", "o", "l")
        wait_for((config / "equistream" / "view.json").exists, "the file of settings")
        kept = viewer.resting_picture()
        viewer.press("Escape")
        self.assertEqual(viewer.end(), (0, ""))
        file = config / "equistream" / "view.json"
        written = json.loads(file.read_text())
        self.assertEqual(written["settings"], {"layout": "right", "loop": "off", "overlay": "depth"})
        self.assertEqual(written["recent"], [str(self.stream)])
        self.assertEqual((written["window"]["width"], written["window"]["height"]), (WIDTH + 20, HEIGHT))
        again = self.by_geometry(config=config, size=None)  # the window's size too
        self.assertTrue((again.picture() == kept).all())
        again.close()
        other = self.by_geometry("--layout", "left", config=config, size=None)
        self.assertFalse((other.picture() == kept).all())
        other.press("Escape")
        self.assertEqual(other.end(), (0, ""))
        self.assertEqual(json.loads(file.read_text())["settings"]["layout"], "right")  # an option is for once
        sized = self.by_geometry(config=config)
        sized.picture()
        sized.press("Escape")
        self.assertEqual(sized.end(), (0, ""))
        kept_size, was = json.loads(file.read_text())["window"], written["window"]
        self.assertEqual((kept_size["width"], kept_size["height"]), (was["width"], was["height"]))  # so is a size
        file.write_text('{"settings": {"layout": ')
        damaged = self.by_geometry(config=config)
        damaged.picture()
        damaged.press("Escape")
        status, said = damaged.end()
        self.assertEqual((status, len(said.splitlines())), (0, 1))
        self.assertIn(f"{file}: expected settings of the viewer in JSON", said)

    def test_loading_is_said_and_can_be_given_up(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            viewer = self.view(source=f"tcp://127.0.0.1:{server.getsockname()[1]}", size="{}x{}".format(*BIG))

            def loading():
                shown = viewer.screen()[: BIG[1], : BIG[0]]
                lines = shown[200:280].max(axis=2) > 150
                return 100 < lines.sum() < 6000 and shown[60:200].max() == 0

            wait_for(loading, "a line in the middle of nothing")
            viewer.press("Escape")
            self.assertEqual(viewer.end(), (0, ""))

    def test_letters_are_as_large_as_the_display_asks_for(self):
        heights = []
        for scale in (1, 2):
            self.display.set_scale(scale)
            viewer = self.big()
            still = viewer.picture()
            wait_for(lambda: (viewer.screen()[: BIG[1], : BIG[0]] == still).all(), "a picture without anything over it")
            self.display.tool("mousemove", 300 + scale, 200)
            wait_for(lambda: (viewer.screen()[:10, : BIG[0]] != still[:10]).mean() > 0.5, "the menu bar")
            changed = (self.steady_screen(viewer)[:200, 600 : BIG[0]] != still[:200, 600:]).any(axis=2).mean(axis=1) > 0.5
            heights.append(int(np.argmin(changed)))
            viewer.close()
        self.display.set_scale(1)
        self.assertAlmostEqual(heights[1] / heights[0], 2, delta=0.15)


if __name__ == "__main__":
    unittest.main()
