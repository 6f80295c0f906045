"""What mouse, fingers, keys and dropped files do, by events that Chromium hands to the page as its own."""

import json
import math

import numpy as np

from page import FRAMES, PROGRAMS, Web, keep, multiplied, rotated, share_alike, turned
from independent import bytes_of, srgb

# Windows' codes of keys that are no letters.
KEY_CODES = {",": 188, ".": 190, " ": 32, "Home": 36, "ArrowLeft": 37}
# Red and cyan: what each eye adds to red, green and blue (Sanders and McAllister, Producing anaglyphs from synthetic
# images, 2003).
FROM_LEFT = np.array([[0.45610004, 0.50048381, 0.17638087], [-0.04008216, -0.03782458, -0.01575895],
                      [-0.01521607, -0.02059714, -0.00546856]])
FROM_RIGHT = np.array([[-0.0434706, -0.08793882, -0.00155529], [0.37847603, 0.73363998, -0.01845032],
                       [-0.07215268, -0.11296065, 1.2263951]])


def anaglyph(left, right):
    values = np.arange(256) / 255
    light = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return bytes_of(srgb(light[left] @ FROM_LEFT.T + light[right] @ FROM_RIGHT.T))


class Inputs(Web):
    def mouse(self, kind, at, button="left", **more):
        pressed = {"left": 1, "right": 2, "none": 0}[button]
        self.browser.call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], button=button, clickCount=1,
                          buttons=0 if kind == "mouseReleased" else pressed, **more)

    def drag(self, *places, **words):
        self.mouse("mousePressed", places[0], **words)
        for place in places[1:]:
            self.mouse("mouseMoved", place, **words)
        self.mouse("mouseReleased", places[-1], **words)

    def touch(self, kind, *places):
        self.browser.call("Input.dispatchTouchEvent", type=kind,
                          touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)])

    def key(self, kind, key, **more):
        code = KEY_CODES.get(key, ord(key[0].upper()))
        self.browser.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, **more)

    def press(self, key):
        self.key("rawKeyDown", key)
        self.key("keyUp", key)

    def centre_of(self, element):
        return self.browser.evaluate(f"(({{left, top, width, height}}) => [left + width / 2, top + height / 2])"
                                     f"(document.getElementById('{element}').getBoundingClientRect())")

    def rad_per_px(self):
        """In the middle of the view, which is 90 degrees wide, and high at most."""
        width, height = self.browser.evaluate("[equistream.canvas.clientWidth, equistream.canvas.clientHeight]")
        return 2 / max(width, height)

    def head(self):
        return self.browser.evaluate("[equistream.head.yaw, equistream.head.pitch]")

    def wait_for_frame(self, index):
        self.browser.wait_for(f"equistream.shownFrame.frame?.index === {index}")

    def open_still(self):
        """The first frame of a stream of four, and where its head is."""
        file = self.pece420()
        self.open_stream(file)
        self.browser.evaluate("equistream.player.plays = false; equistream.player.seek(0)")
        self.browser.wait_for("equistream.player.shown?.index === 0 && equistream.shownFrame.frame === equistream.player.shown")
        head = json.loads(PROGRAMS.run("info", file, "--json"))["tracks"][0]["first_frame"]["head"]
        return np.array(head["position_m"]), np.array(head["orientation_wxyz"])

    def seen_by(self, *eyes):
        """What each eye sees by itself, in the layout that is on the screen; the page draws again then."""
        view = self.browser.evaluate("equistream.viewed()")
        pictures = [self.look(0, *eye, (view["width"], view["height"]), view) for eye in eyes]
        self.browser.evaluate("equistream.isExact = false; equistream.seen = null")
        return pictures

    def assert_alike(self, name, seen, expected):
        share = share_alike(seen, expected)
        if share < 0.99:
            keep(name, seen=seen, expected=expected)
        self.assertGreaterEqual(share, 0.99, name)

    def test_what_the_mouse_holds_stays_under_it(self):
        place, facing = self.open_still()
        before = self.settled()
        x, y = map(round, self.centre_of("picture"))
        self.drag((x, y), (x + 70, y + 10), (x + 110, y + 40))
        rad = self.rad_per_px()
        np.testing.assert_allclose(np.degrees(self.head()), np.degrees([110 * rad, 40 * rad]), atol=1e-6)
        self.mouse("mouseMoved", (x, y), button="none")
        self.drag((x, y), (x + 50, y), button="right")
        self.mouse("mouseWheel", (x, y), button="none", deltaX=0, deltaY=240)
        np.testing.assert_allclose(np.degrees(self.head()), np.degrees([110 * rad, 40 * rad]), atol=1e-6)
        seen = self.settled()
        self.assertLess(share_alike(before, seen), 0.9)
        turn = multiplied(facing, turned(math.degrees(110 * rad), math.degrees(40 * rad)))
        self.assert_alike("dragged", seen, *self.seen_by((place, turn)))
        self.press("c")
        self.assertEqual(self.head(), [0, 0])
        self.assertTrue(np.array_equal(self.settled(), before))
        for _ in range(math.ceil(math.pi / 2 / (100 * rad))):
            self.drag((x, y + 50), (x, y - 50))
        self.assertEqual(np.degrees(self.head())[1], -90)  # straight down

    def test_a_pen_that_hovers_does_not_end_a_drag(self):
        self.open_still()
        x, y = map(round, self.centre_of("picture"))
        self.mouse("mousePressed", (x, y))
        self.browser.evaluate("equistream.canvas.dispatchEvent(new PointerEvent('pointermove', {pointerId: 77, buttons: 0}))")
        self.mouse("mouseMoved", (x + 50, y))
        self.mouse("mouseReleased", (x + 50, y))
        self.assertAlmostEqual(self.head()[0], 50 * self.rad_per_px())

    def test_a_device_without_sensors_is_told_so(self):
        self.open_still()
        self.browser.evaluate("document.querySelector('[data-key=g]').click()")
        self.browser.wait_for("document.getElementById('note').textContent.startsWith('no motion sensors')")
        self.assertIsNone(self.browser.evaluate("equistream.head.turned"))

    def test_one_finger_turns(self):
        self.open_still()
        x, y = map(round, self.centre_of("picture"))
        self.touch("touchStart", (x, y))
        for step in range(1, 6):
            self.touch("touchMove", (x - 20 * step, y + 5 * step))
        turned_by = np.degrees([-100 * self.rad_per_px(), 25 * self.rad_per_px()])
        self.browser.wait_for(f"Math.abs(equistream.head.yaw - {-100 * self.rad_per_px()}) < 1e-6")
        self.touch("touchStart", (x - 100, y + 25), (x, y - 100))
        self.touch("touchMove", (x - 100, y + 25), (x + 80, y - 60))  # the second one
        self.touch("touchEnd")
        np.testing.assert_allclose(np.degrees(self.head()), turned_by, atol=1e-6)
        for _ in range(2):  # a double tap
            self.touch("touchStart", (x, y))
            self.touch("touchEnd")
        np.testing.assert_allclose(np.degrees(self.head()), turned_by, atol=1e-6)
        self.assertEqual(self.browser.evaluate("[visualViewport.scale, scrollX, scrollY]"), [1, 0, 0])

    def test_both_eyes_side_by_side_and_in_red_and_cyan(self):
        place, facing = self.open_still()
        ipd = self.browser.evaluate("equistream.shownFrame.frame.info.ipd")
        eyes = [(place + rotated(facing, (side * ipd / 2, 0, 0)), facing) for side in (-1, 1)]
        self.press("v")
        seen = self.settled()
        left, right = self.seen_by(*eyes)
        half = left.shape[1]
        self.assert_alike("left", seen[:, :half], left)
        self.assert_alike("right", seen[:, half:2 * half], right)
        self.assertLess(share_alike(left, right), 0.9)
        self.press("v")
        seen = self.settled()
        left, right = self.seen_by(*eyes)
        self.assert_alike("anaglyph", seen, anaglyph(left, right))
        self.assertLess(share_alike(seen, anaglyph(right, left)), 0.9)
        self.press("v")
        self.assert_alike("one", self.settled(), *self.seen_by((place, facing)))

    def test_keys_that_go_through_time(self):
        self.open_still()
        for key, index in ((".", 1), (".", 2), (",", 1), (".", 2), (".", 3), (".", 3), ("Home", 0), (",", 0), (".", 1)):
            self.press(key)
            self.wait_for_frame(index)
            self.browser.evaluate("new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
            self.assertEqual(self.browser.evaluate("equistream.player.shown.index"), index)  # at an end it goes no farther
        self.key("rawKeyDown", ".")
        self.wait_for_frame(2)
        self.key("rawKeyDown", ".", autoRepeat=True)  # held down it goes on
        self.wait_for_frame(3)
        self.key("keyUp", ".")
        self.assertFalse(self.browser.evaluate("equistream.player.plays"))
        self.press("l")
        self.assertFalse(self.browser.evaluate("equistream.player.loops"))
        self.press(" ")
        self.browser.wait_for("equistream.player.isAtEnd && !equistream.player.plays")
        self.wait_for_frame(FRAMES - 1)
        self.press("l")
        self.assertTrue(self.browser.evaluate("equistream.player.loops"))
        self.watch_taken()
        self.press(" ")
        self.browser.wait_for(f"taken.length > {2 * FRAMES}")

    def test_keys_that_show_and_hide(self):
        self.open_still()
        for key, element in (("t", "figures"), ("h", "help")):
            before = self.browser.evaluate(f"document.getElementById('{element}').hidden")
            self.press(key)
            self.assertEqual(self.browser.evaluate(f"document.getElementById('{element}').hidden"), not before)
            self.key("rawKeyDown", key)
            self.key("rawKeyDown", key, autoRepeat=True)
            self.key("keyUp", key)
            self.assertEqual(self.browser.evaluate(f"document.getElementById('{element}').hidden"), before)
        self.press("f")
        self.browser.wait_for("document.fullscreenElement === document.documentElement")
        self.press("f")
        self.browser.wait_for("!document.fullscreenElement")

    def test_keys_that_are_held_turn_and_move_within_the_box(self):
        self.open_still()
        lean = self.browser.evaluate("equistream.shownFrame.frame.info.lean")
        for key, moves in (("ArrowLeft", "equistream.head.yaw > 0.05"),
                           ("d", f"Math.hypot(...equistream.head.offset) > {0.999 * lean}")):
            self.key("rawKeyDown", key)
            self.browser.wait_for(moves)
            self.key("keyUp", key)
            self.assertEqual(self.browser.evaluate("equistream.head.down.size"), 0)
        yaw, offset = self.browser.evaluate("[equistream.head.yaw, equistream.head.offset]")
        np.testing.assert_allclose(offset, lean * np.array([math.cos(yaw), 0, -math.sin(yaw)]), atol=1e-3 * lean)
        self.browser.evaluate("new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
        self.assertEqual(self.browser.evaluate("equistream.fading"), 0)
        self.assertEqual(self.said("state"), "")  # of a picture that fades

    def test_the_time_line_goes_where_it_is_clicked_and_dragged(self):
        self.open_still()
        left, width, y = self.browser.evaluate("(({left, top, width, height}) => [left, width, top + height / 2])"
                                               "(document.getElementById('time').getBoundingClientRect())")
        places = [(left + width * (index + 0.5) / FRAMES, y) for index in range(FRAMES)]
        for index in (2, 0, 3):
            self.drag(places[index])
            self.wait_for_frame(index)
        self.mouse("mousePressed", places[3])
        for index in (2, 1):
            self.mouse("mouseMoved", places[index])
            self.wait_for_frame(index)
        self.assertTrue(self.browser.evaluate("equistream.isSought"))
        self.mouse("mouseReleased", places[1])
        self.assertFalse(self.browser.evaluate("equistream.isSought"))
        self.assertEqual(self.head(), [0, 0])
        self.press(".")  # keys are the page's again
        self.wait_for_frame(2)

    def wait_for_rest(self, index):
        """Nothing else is sought."""
        self.browser.wait_for(f"equistream.player.sought === null && equistream.player.shown?.index === {index} && "
                              "equistream.shownFrame.frame === equistream.player.shown")

    def test_pictures_are_shown_while_the_time_line_is_dragged(self):
        """By a mouse that moves before each refresh."""
        self.open_still()
        self.browser.evaluate("""(() => {
            const {player} = equistream, {advance} = player, line = document.getElementById("time");
            globalThis.seen = new Set();
            player.advance = function (seconds) {
                line.value = Math.random() * player.length;
                line.dispatchEvent(new Event("input"));
                seen.add(equistream.shownFrame.frame.index);
                return advance.call(this, seconds);
            };
        })()""")
        self.browser.wait_for(f"seen.size === {FRAMES}")
        self.browser.evaluate("delete equistream.player.advance")
        self.browser.evaluate("for (const index of [3, 0, 2])"
                              f"equistream.player.seek((index + 0.5) / {FRAMES} * equistream.player.length)")
        self.wait_for_rest(2)

    def test_a_jump_that_leads_to_nothing_holds_up_no_other(self):
        """Neither where pictures cannot be decoded, nor where they have not come."""
        for is_complete in ("true", "false"):
            with self.subTest(is_complete=is_complete):
                self.open_still()
                self.browser.evaluate(f"""(() => {{
                    const {{player}} = equistream, {{came}} = player;
                    player.recording.isComplete = {is_complete};
                    player.came = frame => player.sought === null ? came.call(player, frame)
                                                                  : player.maker.forget(frame);
                    player.seek(0);
                    player.seek(2.5 / {FRAMES} * player.length);
                }})()""")
                self.browser.wait_for("equistream.player.sought === null")
                self.browser.evaluate("equistream.player.recording.isComplete = true")
                self.wait_for_rest(2)

    def test_a_file_that_is_dropped_is_opened(self):
        self.open("")
        for file, has_depth in ((self.pece420(), True), (self.encode("turned.mp4", "--depth", "none"), False)):
            data = {"items": [], "files": [str(file)], "dragOperationsMask": 1}
            x, y = self.centre_of("picture")
            for kind in ("dragEnter", "dragOver", "drop"):
                self.browser.call("Input.dispatchDragEvent", type=kind, x=x, y=y, data=data)
            self.browser.wait_for(f"equistream.player?.reader.name === '{file.name}' && equistream.times.firstPicture")
            self.browser.wait_for("equistream.player.recording.isComplete")
            self.assertEqual(self.browser.evaluate("equistream.player.recording.frames"), list(range(FRAMES)))
            self.assertEqual(self.browser.evaluate("Boolean(equistream.shownFrame.frame.main.distances)"), has_depth)
            self.assertTrue(self.browser.evaluate("document.getElementById('start').hidden"))
            self.assertEqual(self.said(), "")

    def test_buttons_and_the_time_line_keep_their_own_keys(self):
        self.open_stream(self.pece420())
        self.browser.wait_for("equistream.shownFrame.frame")

        def press(key, on):
            self.browser.evaluate(f"{on}.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}}))")

        press("ArrowRight", "document.getElementById('time')")
        self.assertEqual(self.browser.evaluate("equistream.head.down.size"), 0)
        press(" ", "document.querySelector('[data-key=v]')")
        self.assertTrue(self.browser.evaluate("equistream.player.plays"))
        press("ArrowRight", "document.body")
        self.assertEqual(self.browser.evaluate("equistream.head.down.size"), 1)

    def test_a_headset_without_a_stream_is_told_so(self):
        self.open("")
        self.browser.evaluate("document.getElementById('headset').click(); equistream.drawHeadset(0, [], null, null)")
        self.assertEqual(self.said("note"), "open a stream first")

    def test_buttons_without_a_stream_do_nothing(self):
        self.open("")
        self.browser.evaluate("document.getElementById('pause').click()")
        self.assertEqual(self.browser.console, [])

    def test_tilting_a_turned_device_keeps_the_horizon_level(self):
        """A tablet held upright is turned a quarter to the left, and half a radian is dragged upwards."""
        self.open("")
        orientation = self.browser.evaluate("""(async () => {
            const {head} = equistream, around = {position: [0, 0, 0], orientation: [1, 0, 0, 0]};
            const turn = alpha => {
                dispatchEvent(new DeviceOrientationEvent("deviceorientation", {alpha, beta: 90, gamma: 0}));
                return head.pose(around).orientation;
            };
            const heard = head.followDevice();
            while (!head.turned)  // the browser may be asked first
                await new Promise(resolve => setTimeout(resolve));
            const first = turn(20);
            turn(110);
            head.tilt(0.5);
            const turned = turn(110);
            await heard;
            await head.followDevice();
            turn(300);
            return {first, turned, after: head.pose(around).orientation};
        })()""")
        np.testing.assert_allclose(orientation["first"], [1, 0, 0, 0], atol=1e-9)
        np.testing.assert_allclose(rotated(np.array(orientation["turned"]), (1, 0, 0)), (0, 0, -1), atol=1e-9)
        np.testing.assert_allclose(rotated(np.array(orientation["turned"]), (0, 0, -1)),
                                   (-np.cos(0.5), np.sin(0.5), 0), atol=1e-9)
        np.testing.assert_allclose(orientation["after"], [np.cos(0.25), np.sin(0.25), 0, 0], atol=1e-9)
