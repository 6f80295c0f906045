"""The page that shows streams in a browser, in a real headless Chromium.

usage: web_test.py BIN_DIR [Accuracy | Streams | Gallery | Failures | Headset | Serve]
"""

import base64
import contextlib
import hashlib
import http.client
import json
import math
import os
import pathlib
import random
import re
import shutil
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from chromium import Chromium, Folder, find_chromium  # noqa: E402
from independent import *  # noqa: E402,F403

PROGRAMS = Programs(sys.argv.pop(1))
ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGE = PROGRAMS.folder.parent / "share" / "equistream" / "web.html"
IPD = 0.063
SIZE = (640, 360)
FRAMES = 4
LONG = 45  # frames of two groups
FRAME_DATA = bytes.fromhex("69c48036513347848093ec66a7475119")
MAIN, SMALL, DEPTH = 0, 1, 2  # roles (docs/stream-format.md, "Frame data")

# The page hands pixels over as text.
LOOK = """equistream.look(%s).then(pixels => {
    let text = "";
    for (let i = 0; i < pixels.length; i += 8192)
        text += String.fromCharCode(...pixels.subarray(i, i + 8192));
    return btoa(text);
})"""


def turned(yaw_deg, pitch_deg):
    yaw, pitch = math.radians(yaw_deg) / 2, math.radians(pitch_deg) / 2
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([cy * cp, cy * sp, sy * cp, -sy * sp])


def rotated(q, v):
    w, r = q[0], np.asarray(q[1:])
    return v + 2 * np.cross(r, np.cross(r, v) + w * np.asarray(v))


# Of the head, around where each frame's is: metres, and degrees to the left and up; then the share of pixels that must
# be alike. The last one looks into the roof's laths: a card places corners on 1/256 of a pixel, the CPU does not, and
# along so many outlines that shows.
HEADS = [((0, 0, 0), 0, 0, 0.999), ((0.06, 0.02, -0.03), 40, -10, 0.999), ((-0.07, 0, 0.04), 170, 20, 0.999),
         ((0.03, -0.05, 0.02), -80, 60, 0.99)]


def pictures_of(stream, role):
    """Where the frame data of a role's pictures begin, in the order they lie in the file."""
    return [found.start() for found in re.finditer(re.escape(FRAME_DATA), stream) if stream[found.start() + 20] == role]


def setUpModule():
    Web.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_web_"))
    shutil.copy(PAGE, Web.root / "web.html")
    Web.scene = PROGRAMS.scene("pavilion", Web.root)
    Web.frames = Web.root / "frames"
    PROGRAMS.run("render", Web.scene, "--frames", f"0-{FRAMES - 1}", "--size", "512x256", "--spp", 16, "--progress", "none",
                 "--out", Web.frames)
    Web.folder = Folder(Web.root)


def tearDownModule():
    Web.folder.close()
    shutil.rmtree(Web.root, ignore_errors=True)


class Web(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Chromium()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def encode(self, name, *words, frames=None):
        file = self.root / name
        if not file.exists():
            PROGRAMS.run("encode", frames or self.frames, "--out", file, "--fill", "none", "--progress", "none", *words)
        return file

    def open(self, query):
        self.browser.open(f"{self.folder.url}web.html?{query}")

    def open_stream(self, file):
        self.open(f"src={file.name}")
        self.browser.wait_for("equistream.times.firstPicture")

    def watch_taken(self, then=""):
        """From now on `taken` lists the frames that the player shows."""
        self.browser.evaluate("""(() => {
            const {player} = equistream, take = player.take;
            %s
            globalThis.taken = [];
            player.take = function () {
                take.call(this);
                taken.push(this.shown.index);
            };
        })()""" % then)

    def said(self, where="problem"):
        return self.browser.evaluate(f"document.getElementById('{where}').textContent")

    def look(self, frame, position, orientation, size=None):
        size = size or SIZE
        words = {"frame": frame, "width": size[0], "height": size[1],
                 "eye": {"position": list(position), "orientation": list(orientation)}}
        pixels = base64.b64decode(self.browser.evaluate(LOOK % json.dumps(words)))
        return np.frombuffer(pixels, np.uint8).reshape(size[1], size[0], 4)[..., :3]


def heads_of(file):
    """A head for each frame, in the world."""
    first = json.loads(PROGRAMS.run("info", file, "--json"))["tracks"][0]["first_frame"]["head"]
    around = np.array(first["position_m"])
    return [(around + np.array(offset), turned(yaw, pitch)) for offset, yaw, pitch, _ in HEADS]


def keep(name, **pictures):
    """What failed, to be looked at."""
    folder = pathlib.Path(tempfile.gettempdir()) / "equistream_web_failures"
    folder.mkdir(exist_ok=True)
    for who, picture in pictures.items():
        Image.fromarray(picture).save(folder / f"{name}.{who}.png")


def share_alike(one, other):
    return np.mean(np.abs(one.astype(int) - other.astype(int)).max(axis=-1) <= 2)


class Accuracy(Web):
    """The page and `play` show the same: in nearly all pixels no channel differs by more than 2 of 255."""

    def compare(self, file, *words):
        heads = heads_of(file)
        path = self.root / "heads.csv"
        path.write_text("".join(", ".join(map(repr, map(float, (i / 30, *place, *turn)))) + "\n"
                                for i, (place, turn) in enumerate(heads)))
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        PROGRAMS.run("play", file, "--head", path, "--size", "{}x{}".format(*SIZE), "--ipd", IPD, "--mirrors", "surface",
                     "--progress", "none", "--out", out, *words)
        self.open_stream(file)
        shares = {}
        for i, (place, turn) in enumerate(heads):
            for side, eye in ((-0.5, "left"), (0.5, "right")):
                ours = self.look(i, place + rotated(turn, (side * IPD, 0, 0)), turn)
                theirs = np.asarray(Image.open(out / eye / f"frame.{i:04d}.png").convert("RGB"))
                shares[i, eye] = share_alike(ours, theirs)
                if shares[i, eye] < HEADS[i][3]:
                    keep(f"{file.stem}.{i}.{eye}", page=ours, play=theirs)
        print(file.name, {key: round(float(share), 5) for key, share in shares.items()}, self.said("note"))
        for key, share in shares.items():
            self.assertGreaterEqual(share, HEADS[key[0]][3], f"frame and eye {key} of {file.name}")

    def test_by_depth(self):
        self.compare(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--method", "mesh", "--fill", "pushpull")

    def test_by_depth_of_8_bits_in_mp4(self):
        self.compare(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1), "--method", "mesh", "--fill", "pushpull")

    def test_by_halved_depth(self):
        self.compare(self.encode("halved.mkv", "--depth", "w10", "--depth-scale", 2), "--method", "mesh", "--fill", "pushpull")

    def test_with_a_window(self):
        frames = self.root / "seen"
        PROGRAMS.run("render", self.scene, "--frames", f"0-{FRAMES - 1}", "--window", "gaze,70x50", "--size", "256x128", "--density", 768,
                     "--spp", 4, "--progress", "none", "--out", frames)
        self.compare(self.encode("window.mkv", "--depth", "pece420", "--depth-scale", 1, frames=frames), "--method", "mesh",
                     "--fill", "base,pushpull")

    def test_without_depth(self):
        self.compare(self.encode("turned.mp4", "--depth", "none"), "--method", "rotation", "--fill", "pushpull")


class Streams(Web):
    """What may be wrong with a stream is said in one line."""

    def problem_of(self, query):
        self.open(query)
        self.browser.wait_for("document.getElementById('problem').textContent")
        return self.said()

    def test_what_cannot_be_shown_is_said(self):
        self.encode("h265.mkv", "--codec", "h265", "--depth", "none")
        (self.root / "text.mkv").write_text("no stream at all\n" * 100)
        self.assertIn("404", self.problem_of("src=missing.mkv"))
        self.assertIn("expected a stream that", self.problem_of("src=text.mkv"))
        self.assertIn("--codec h264", self.problem_of("src=h265.mkv"))
        self.assertIn("another host", self.problem_of("src=https://example.com/a.mkv"))

    def test_a_recording_that_is_too_large_for_the_browser_is_refused(self):
        with (self.root / "large.mkv").open("wb") as file:
            file.truncate(3_000_000_000)
        self.assertRegex(self.problem_of("src=large.mkv"), r"large\.mkv: expected a recording of at most 2 GB, .* found 3\.0 GB$")
        self.browser.evaluate("equistream.openFile({name: 'dropped.mkv', size: 1e10})")
        self.assertRegex(self.said(), r"^dropped\.mkv: expected a recording of at most 2 GB, .* found 10\.0 GB$")
        # A server need not say how long its answer is.
        unsaid = self.browser.evaluate("""(() => {
            const {recording} = equistream.open("unsaid.mkv", false);
            recording.bytes = 2e9;
            try {
                recording.add({role: "main", bytes: new Uint8Array(1)});
            } catch (error) {
                return error.message;
            }
        })()""")
        self.assertRegex(unsaid, "expected a recording of at most 2 GB, .* found more$")
        self.assertEqual(self.browser.console, [])

    def test_depth_that_browsers_do_not_decode_is_left_out(self):
        self.open_stream(self.encode("w12.mkv", "--depth", "w12"))
        self.browser.wait_for("document.getElementById('note').textContent.includes('encode --depth pece420')")
        self.assertIn("no depth", self.said("figures"))

    def test_a_decoder_that_was_taken_away_is_opened_again(self):
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        self.browser.wait_for("equistream.shownFrame.frame")
        self.browser.evaluate("for (const decoder of equistream.player.maker.decoders.values()) decoder.close();"
                              "globalThis.turns = new Set()")
        self.browser.wait_for("turns.add(equistream.player.maker.generation) && turns.size > 2 && equistream.player.shown.main.distances")

    def test_buttons_and_the_time_line_keep_their_own_keys(self):
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
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

    def test_an_address_that_is_none_ends_loading(self):
        self.open("live=stream%23x")
        self.browser.wait_for("document.getElementById('problem').textContent")
        self.assertTrue(self.browser.evaluate("document.getElementById('loading').hidden"))

    def test_tilting_a_turned_device_keeps_the_horizon_level(self):
        """A tablet held upright is turned a quarter to the left, and half a radian is dragged upwards."""
        self.open("")
        orientation = self.browser.evaluate("""(async () => {
            const {head} = equistream, around = {position: [0, 0, 0], orientation: [1, 0, 0, 0]};
            const turn = alpha => {
                dispatchEvent(new DeviceOrientationEvent("deviceorientation", {alpha, beta: 90, gamma: 0}));
                return head.pose(around).orientation;
            };
            await head.followDevice();
            const first = turn(20);
            turn(110);
            head.tilt(0.5);
            const turned = turn(110);
            await head.followDevice();
            turn(300);
            return {first, turned, after: head.pose(around).orientation};
        })()""")
        np.testing.assert_allclose(orientation["first"], [1, 0, 0, 0], atol=1e-9)
        np.testing.assert_allclose(rotated(np.array(orientation["turned"]), (1, 0, 0)), (0, 0, -1), atol=1e-9)
        np.testing.assert_allclose(rotated(np.array(orientation["turned"]), (0, 0, -1)), (-np.cos(0.5), np.sin(0.5), 0), atol=1e-9)
        np.testing.assert_allclose(orientation["after"], [np.cos(0.25), np.sin(0.25), 0, 0], atol=1e-9)

    def test_it_plays_over_and_over_and_stops_and_jumps(self):
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        self.browser.wait_for("(globalThis.turns ??= new Set()).add(equistream.player.maker.generation) && turns.size > 2")
        self.browser.wait_for("equistream.shownFrame.frame")
        self.browser.evaluate("dispatchEvent(new KeyboardEvent('keydown', {key: ' '}))")
        self.assertFalse(self.browser.evaluate("equistream.player.plays"))
        self.browser.evaluate("equistream.player.seek(2 / 30)")
        self.browser.wait_for("equistream.shownFrame.frame.index === 2")
        self.assertEqual(self.said(), "")
        self.assertEqual(self.browser.console, [])

    def test_damaged_bytes_end_in_a_line(self):
        for file in (self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1),
                     self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1)):
            self.open_stream(file)
            tried = self.browser.evaluate("""(async () => {
                const whole = new Uint8Array(await (await fetch(%s)).arrayBuffer());
                const Reader = equistream.player.reader.constructor;
                let seed = 1, packets = 0;
                const random = most => (seed = (seed * 48271) %% 2147483647) %% most;
                const others = new Set();
                for (let trial = 0; trial < 400; ++trial) {
                    const bytes = whole.slice(0, trial %% 2 ? 1 + random(whole.length) : whole.length);
                    for (let i = 0; i < trial %% 8; ++i)
                        bytes[random(Math.min(bytes.length, trial %% 3 ? 4096 : bytes.length))] = random(256);
                    try {
                        const reader = new Reader("damaged", () => ++packets);
                        for (let at = 0; at < bytes.length; at += 5000)
                            reader.push(bytes.subarray(at, at + 5000));
                        reader.end();
                    } catch (error) {
                        if (error.constructor.name !== "StreamError")
                            others.add(`${error.stack}`);
                    }
                }
                return {packets, others: [...others]};
            })()""" % json.dumps(file.name))
            self.assertEqual(tried["others"], [])
            self.assertGreater(tried["packets"], 0)

    def test_damaged_files_end_in_a_line_on_the_page(self):
        for file in (self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1),
                     self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1)):
            whole = file.read_bytes()
            changed = random.Random(1)
            for trial in range(8):
                damaged = bytearray(whole[:len(whole) // (1 + trial % 2)])
                for _ in range(4 * trial):
                    damaged[changed.randrange(len(damaged))] = changed.randrange(256)
                (self.root / f"damaged{file.suffix}").write_bytes(damaged)
                self.open(f"src=damaged{file.suffix}")
                self.browser.wait_for("document.getElementById('problem').textContent || equistream.times.firstPicture")
                self.assertEqual(self.browser.console, [], f"trial {trial} of {file.name}: {self.said()}")
                self.assertNotIn("\n", self.said())

    def long_stream(self, name, *words):
        frames = self.root / "long"
        if not frames.exists():
            PROGRAMS.run("render", self.scene, "--frames", f"0-{LONG - 1}", "--size", "128x64", "--spp", 1, "--progress", "none", "--out", frames)
        return self.encode(name, "--depth", "pece420", "--depth-scale", 1, *words, frames=frames)

    def with_hole(self, file, role):
        """The first key picture of a track is none any more, as its decoder sees it."""
        damaged = bytearray(file.read_bytes())
        key = damaged.index(b"\x65\x88", pictures_of(damaged, role)[0])
        damaged[key] = 0x41
        (self.root / f"hole{file.suffix}").write_bytes(damaged)
        return self.root / f"hole{file.suffix}"

    def test_without_a_sound_key_frame_there_is_a_line(self):
        for file in (self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1), self.long_stream("one_group.mkv", "--gop", 100)):
            self.assertIn("expected pictures that can be decoded from a key frame on", self.problem_of(f"src={self.with_hole(file, MAIN).name}"))

    def test_what_ended_the_bytes_is_said_first(self):
        file = self.with_hole(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1), MAIN)
        file.write_bytes(file.read_bytes() + b"\xff\xff\xff\xffmoof" + bytes(16))
        self.open(f"src={file.name}")
        self.browser.wait_for("equistream.player.isExhausted")
        self.assertIn("expected a box of at most", self.said())

    def test_holes_in_long_groups_hold_nothing_up(self):
        for role in (MAIN, DEPTH):
            self.open(f"src={self.with_hole(self.long_stream('long.mkv', '--gop', 30), role).name}")
            self.browser.wait_for("(globalThis.turns ??= new Set()).add(equistream.player.maker.generation) && turns.size > 2")
            self.browser.wait_for("equistream.player.shown?.index >= 30 && equistream.player.shown.main.distances")
            self.assertEqual(self.said(), "")

    def test_a_depth_track_that_ends_early_is_waited_for_no_more(self):
        damaged = bytearray(self.long_stream("long.mkv", "--gop", 30).read_bytes())
        for at in pictures_of(damaged, DEPTH)[10:]:
            damaged[at + 20] = SMALL
        (self.root / "short_depth.mkv").write_bytes(damaged)
        self.open("src=short_depth.mkv")
        self.browser.wait_for("equistream.player.shown?.index < 10 && equistream.player.shown.main.distances")
        self.browser.wait_for("equistream.player.shown?.index >= 30 && !equistream.player.shown.main.distances")

    def test_few_frames_are_ready_at_once(self):
        self.open_stream(self.long_stream("long.mkv", "--gop", 30))
        self.browser.evaluate("""(() => {
            const {player} = equistream, came = player.came;
            globalThis.most = 0;
            globalThis.turns = new Set();
            player.came = function (frame) {
                came.call(this, frame);
                most = Math.max(most, this.ready.length + this.maker.whole.length);
            };
        })()""")
        self.browser.wait_for("turns.add(equistream.player.maker.generation) && turns.size > 2")
        self.assertLess(self.browser.evaluate("most"), 12)

    def test_a_picture_that_says_nothing_of_itself_is_left_out_alone(self):
        damaged = bytearray(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1).read_bytes())
        key = pictures_of(damaged, MAIN)[0]
        damaged[key + 16:key + 18] = b"\xff\xff"  # its version
        (self.root / "unsaid.mp4").write_bytes(damaged)
        self.open("src=unsaid.mp4")
        self.browser.wait_for("equistream.times.firstPicture")
        self.watch_taken("player.seek(0);")
        self.browser.wait_for(f"taken.length >= {2 * (FRAMES - 1)}")
        self.assertEqual(self.browser.evaluate(f"taken.slice(0, {2 * (FRAMES - 1)})"), 2 * list(range(1, FRAMES)))
        self.assertIn("expected version 1", self.said("note"))
        self.assertEqual(self.said(), "")

    def test_a_stream_that_was_cut_plays_and_is_said_to_be(self):
        for file in (self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1),
                     self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1)):
            whole = file.read_bytes()
            third = pictures_of(whole, MAIN)[2]
            (self.root / f"cut{file.suffix}").write_bytes(whole[:third + 300])
            self.open(f"src=cut{file.suffix}")
            self.browser.wait_for("equistream.times.firstPicture")
            self.browser.wait_for("document.getElementById('note').textContent")
            self.assertRegex(self.said("note"), r": main (was cut after frame \d \(2 |lacks 2 of 4 pictures)")
            self.assertEqual(self.said(), "")

    def test_a_time_that_is_damaged_stops_nothing(self):
        whole = self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1).read_bytes()
        for index in (1, FRAMES - 1):
            damaged, good = bytearray(whole), struct.pack("<d", index / 30)
            for at in pictures_of(whole, MAIN) + pictures_of(whole, DEPTH):
                place = damaged.find(good, at + 40, at + 80)
                if place >= 0:
                    damaged[place:place + 8] = struct.pack("<d", 1.23456789e9 + 1 / 3)
            self.assertNotEqual(damaged, whole)
            (self.root / "late.mp4").write_bytes(damaged)
            self.open_stream(self.root / "late.mp4")
            self.watch_taken("player.seek(0);")
            self.browser.wait_for(f"taken.length >= {3 * FRAMES}")
            self.assertEqual(self.browser.evaluate(f"taken.slice(0, {2 * FRAMES})"), 2 * list(range(FRAMES)))
            self.assertLess(self.browser.evaluate("equistream.player.length"), 1)

    def test_one_frame_is_decoded_once(self):
        self.open_stream(self.encode("one.mkv", "--depth", "pece420", "--depth-scale", 1, "--frames", "0-0"))
        self.browser.wait_for("equistream.player.recording.isFinished && equistream.player.shown")
        before = self.browser.evaluate("equistream.player.maker.generation")
        self.browser.evaluate("new Promise(resolve => setTimeout(resolve, 500))")
        self.assertEqual(self.browser.evaluate("equistream.player.maker.generation"), before)

    def test_notes_stand_beside_each_other(self):
        damaged = bytearray(self.encode("w12.mkv", "--depth", "w12").read_bytes())
        second = pictures_of(damaged, MAIN)[1]
        damaged[second + 16:second + 18] = b"\xff\xff"
        (self.root / "two_notes.mkv").write_bytes(damaged)
        self.open_stream(self.root / "two_notes.mkv")
        self.assertIn("encode --depth pece420", self.said("note"))
        self.assertIn("expected version 1", self.said("note"))

    def test_a_second_track_that_says_it_is_main_is_left_out(self):
        damaged = bytearray(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1).read_bytes())
        damaged[pictures_of(damaged, DEPTH)[1] + 20] = MAIN
        (self.root / "two_mains.mp4").write_bytes(damaged)
        self.open_stream(self.root / "two_mains.mp4")
        self.assertIn("a second track of main is left out", self.said("note"))
        self.assertEqual(self.browser.evaluate("equistream.player.recording.packets.get('main').length"), FRAMES)

    def test_what_the_helper_keeps_of_a_frame_goes_with_it(self):
        """Also where its window is of no use, and where the stream was closed meanwhile."""
        frames = self.root / "seen"
        PROGRAMS.run("render", self.scene, "--frames", f"0-{FRAMES - 1}", "--window", "gaze,70x50", "--size", "256x128", "--density", 768,
                     "--spp", 4, "--progress", "none", "--out", frames)
        file = self.encode("window.mkv", "--depth", "pece420", "--depth-scale", 1, frames=frames)
        self.open("")
        asked = self.browser.evaluate("""(async () => {
            const whole = new Uint8Array(await (await fetch(%s)).arrayBuffer()), asked = {depth: 0, forget: 0};
            const helper = {ask(order, words) {
                ++asked[order];
                return equistream.helper.ask(order, words);
            }};
            const problems = [], Player = equistream.openFile(new File([], "none")) && equistream.player.constructor;
            const player = new Player(helper, "moved", {isLive: false, onNote: text => problems.push(text),
                                                        onProblem: error => problems.push(error.message)});
            const take = player.reader.onPacket;
            player.reader.onPacket = packet => {
                if (packet.role.startsWith("window"))
                    packet.info.pose = {...packet.info.pose, position: [1, 2, 3]};
                take(packet);
            };
            player.push(whole);
            player.end();
            const first = player.maker.generation;
            while (player.maker.generation < first + 3 && problems.length === 0) {
                player.advance(0.02);
                player.forgetLeft([]);
                await new Promise(resolve => setTimeout(resolve, 5));
            }
            player.close();
            await new Promise(resolve => setTimeout(resolve, 500));
            return {problems, windows: asked.depth > 8, left: asked.depth - asked.forget};
        })()""" % json.dumps(file.name))
        self.assertEqual(asked, {"problems": [], "windows": True, "left": 0})

    def test_samples_without_bytes_are_refused(self):
        damaged = bytearray(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1).read_bytes())
        run = flags = 0
        while not flags & 0x200:  # a first sample's size is the usual one
            run = damaged.index(b"trun", run) + 4
            flags, = struct.unpack_from(">I", damaged, run)
        at = run + 8 + 4 * bool(flags & 1) + 4 * bool(flags & 4) + 4 * bool(flags & 0x100)
        struct.pack_into(">I", damaged, at, 0)
        (self.root / "empty.mp4").write_bytes(damaged)
        self.assertIn("expected samples that have bytes", self.problem_of("src=empty.mp4"))

    def test_every_lap_has_all_frames(self):
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        self.watch_taken("player.seek(0);")
        self.browser.wait_for(f"taken.length >= {3 * FRAMES}")
        self.assertEqual(self.browser.evaluate(f"taken.slice(0, {3 * FRAMES})"), 3 * list(range(FRAMES)))

    def test_without_laps_it_stays_at_the_end_and_plays_again(self):
        file = self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1)
        self.open(f"src={file.name}&loop=0")
        self.browser.wait_for("equistream.player.isAtEnd")
        self.assertFalse(self.browser.evaluate("equistream.player.plays"))
        self.watch_taken()
        self.browser.evaluate("dispatchEvent(new KeyboardEvent('keydown', {key: ' '}))")
        self.browser.evaluate("dispatchEvent(new KeyboardEvent('keydown', {key: ' ', repeat: true}))")  # a key held down pauses nothing
        self.browser.wait_for("taken.length > 0 && equistream.player.isAtEnd")
        taken = self.browser.evaluate("taken")
        self.assertEqual(taken, sorted(set(taken)))
        self.assertLess(taken[0], FRAMES - 1)
        self.assertEqual(taken[-1], FRAMES - 1)

    def test_a_live_stream_that_nobody_looks_at_keeps_its_newest_frame_alone(self):
        file = self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1)
        self.open_stream(file)
        unseen = self.browser.evaluate("""(async () => {
            const whole = new Uint8Array(await (await fetch(%s)).arrayBuffer());
            const problems = [];
            const player = new equistream.player.constructor(equistream.helper, "live", {
                isLive: true, onNote: text => problems.push(text), onProblem: error => problems.push(error.message)});
            player.push(whole);
            player.end();
            for (let i = 0; i < 6000 && problems.length === 0 && player.ready[0]?.index !== %d; ++i)
                await new Promise(resolve => setTimeout(resolve, 5));
            return {problems, ready: player.ready.length, passed: player.lateFrames};
        })()""" % (json.dumps(file.name), FRAMES - 1))
        self.assertEqual(unseen, {"problems": [], "ready": 1, "passed": FRAMES - 1})

    def test_a_live_stream_that_ends_without_a_picture_says_so(self):
        file = self.with_hole(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1), MAIN)
        self.open_stream(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1))
        problem = self.browser.evaluate("""(async () => {
            const whole = new Uint8Array(await (await fetch(%s)).arrayBuffer());
            return new Promise(resolve => {
                const player = new equistream.player.constructor(equistream.helper, "live", {
                    isLive: true, onNote() {}, onProblem: error => resolve(error.message)});
                player.push(whole);
                player.end();
            });
        })()""" % json.dumps(file.name))
        self.assertIn("live: expected pictures that can be decoded from a key frame on", problem)

    def test_the_page_connects_to_its_own_host_alone(self):
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        for script in ("fetch('http://127.0.0.2:9/').then(() => 'let through', error => String(blocked))",
                       "new Promise(resolve => new WebSocket('ws://127.0.0.2:9/').onerror = () => resolve(String(blocked)))"):
            self.assertEqual("connect-src", self.browser.evaluate("""(async () => {
                globalThis.blocked = null;
                addEventListener("securitypolicyviolation", event => blocked = event.effectiveDirective);
                try {
                    await %s;
                } catch {}
                await new Promise(resolve => setTimeout(resolve, 100));
                return String(blocked);
            })()""" % script))


class Gallery(Web):
    """The folder that docs/site/gallery.sh makes plays from any web host."""

    def test_each_scene_plays(self):
        settings = {"FRAMES": "0-2", "SPHERE": "128x64", "SPP": "1"}
        subprocess.run([ROOT / "docs/site/gallery.sh", self.root / "gallery"], check=True, stdout=subprocess.DEVNULL, env={
            **os.environ, "PATH": f"{PROGRAMS.folder}:{os.environ['PATH']}",
            **{f"EQUISTREAM_GALLERY_{name}": value for name, value in settings.items()}})
        self.browser.open(f"{self.folder.url}gallery/index.html")
        pages = self.browser.evaluate("[...document.querySelectorAll('a')].map(link => link.href)")
        self.assertEqual(len(pages), 3)
        self.assertEqual(self.browser.evaluate("[...document.images].map(image => image.naturalWidth)"), 3 * [640])
        for page in pages:
            self.browser.open(page)
            self.browser.wait_for("equistream.times.firstPicture && equistream.player.shown?.main.distances")
            self.assertEqual((self.said(), self.said("note")), ("", ""))


class Failures(Web):
    """What the browser may refuse on the way is said, and what can go on goes on. Each in a browser of its own."""

    setUpClass = tearDownClass = classmethod(lambda cls: None)

    def setUp(self):
        self.browser = Chromium()
        self.addCleanup(self.browser.close)

    # Those that a script may end, or make throw.
    DECODERS = """
        globalThis.made = [];
        globalThis.refused = 0;
        globalThis.VideoDecoder = class extends VideoDecoder {
            constructor(init) {
                super(init);
                made.push([this, init]);
            }
            decode(chunk) {
                if (globalThis.refuses-- > 0 && ++refused)
                    throw new DOMException("no key frame", "DataError");
                super.decode(chunk);
            }
        };
    """

    def go_on(self):
        self.browser.evaluate("globalThis.turns = new Set()")
        self.browser.wait_for("turns.add(equistream.player.maker.generation) && turns.size > 2 && equistream.player.shown?.main.distances")

    def test_decoders_that_fail(self):
        self.browser.before_pages(self.DECODERS)
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        self.go_on()
        self.browser.evaluate("made[1][0].close(), made[1][1].error(new DOMException('damaged', 'EncodingError'))")
        self.go_on()
        self.assertIn("depth track: this browser cannot decode it (damaged)", self.said("note"))
        self.assertEqual(self.said(), "")
        self.browser.evaluate("globalThis.refuses = 1")
        self.go_on()
        self.assertEqual(self.browser.evaluate("refused"), 1)
        self.assertIn("(no key frame)", self.said() + self.said("note"))

    def test_a_worker_that_does_not_start(self):
        self.browser.before_pages("""globalThis.Worker = class {
            constructor() { setTimeout(() => this.onerror(new Event("error"))); }
            postMessage() {}
        };""")
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        self.assertIn("beside the page: the browser has ended it", self.said("note"))

    def test_a_worker_that_ends(self):
        self.open_stream(self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1))
        self.browser.wait_for("equistream.player.shown?.main.distances")
        self.browser.evaluate("equistream.helper.worker.onerror(new Event('error')); globalThis.turns = new Set()")
        self.browser.wait_for("turns.add(equistream.player.maker.generation) && turns.size > 2 && equistream.player.shown")
        self.assertIn("beside the page: the browser has ended it", self.said("note"))


# A headset that does what a script says: globalThis.headset has its head and where its eyes are.
FAKE_HEADSET = """
globalThis.headset = {position: [0, 1.6, 0], orientation: [1, 0, 0, 0], ended: false};
const transform = ({position, orientation}) => ({
    position: {x: position[0], y: position[1], z: position[2]},
    orientation: {w: orientation[0], x: orientation[1], y: orientation[2], z: orientation[3]},
});
class FakeSession extends EventTarget {
    renderState = {};
    updateRenderState(state) { Object.assign(this.renderState, state); }
    async requestReferenceSpace() { return {}; }
    requestAnimationFrame(act) {
        setTimeout(() => act(performance.now(), {getViewerPose: () => {
            const {position, orientation} = headset;
            const views = (headset.eyes ?? [position, position]).map((eye, i) => ({
                eye: ["left", "right"][i], transform: transform({position: eye, orientation}),
                // Wider to the outside than to the inside, and higher than low, as headsets have it.
                projectionMatrix: [1, 0, 0, 0, 0, 16 / 9, 0, 0, (i ? 1 : -1) * 0.1, 0.05, -1, -1, 0, 0, -0.02, 0],
            }));
            return {transform: transform(headset), views};
        }}), 10);
    }
}
globalThis.XRWebGLLayer = class {
    framebuffer = null;
    constructor(session, gl) { this.canvas = gl.canvas; }
    getViewport({eye}) {
        const width = this.canvas.width / 2;
        return {x: eye === "left" ? 0 : width, y: 0, width, height: this.canvas.height};
    }
};
WebGL2RenderingContext.prototype.makeXRCompatible = async () => {};
Object.defineProperty(navigator, "xr", {value: {
    isSessionSupported: async mode => mode === "immersive-vr",
    requestSession: async () => new FakeSession(),
}});
"""


class Headset(Web):
    """By WebXR both eyes see what they should: from where the head is, relative to where it began."""

    def test_both_eyes(self):
        self.browser.before_pages(FAKE_HEADSET)
        file = self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1)
        around = json.loads(PROGRAMS.run("info", file, "--json"))["tracks"][0]["first_frame"]["head"]
        self.open_stream(file)
        self.browser.evaluate("equistream.player.plays = false; equistream.player.seek(0)")
        self.browser.wait_for("equistream.shownFrame.frame.index === 0 && !document.getElementById('headset').hidden")
        self.browser.evaluate("document.getElementById('headset').click()")
        self.browser.wait_for("equistream.headset.centre")
        self.browser.evaluate("Object.assign(equistream.canvas, {width: 640, height: 180})")
        turn = turned(25, 10)
        eyes = [np.array([0.02, 0.03, -0.04]) + rotated(turn, (side * IPD / 2, 0, 0)) for side in (-1, 1)]
        self.browser.evaluate("Object.assign(headset, %s)" % json.dumps({
            "position": [0.02, 1.63, -0.04], "orientation": list(turn),
            "eyes": [list(eye + (0, 1.6, 0)) for eye in eyes]}))
        seen = self.settled()
        place, facing = np.array(around["position_m"]), np.array(around["orientation_wxyz"])
        self.browser.evaluate("equistream.headset.session = null")
        for i, eye in enumerate(eyes):
            words = {"frame": 0, "eye": {"position": list(place + rotated(facing, eye)),
                                         "orientation": list(multiplied(facing, turn))},
                     "view": {"width": 320, "height": 180, "focal": 160, "middle": [[176, 144][i], 94.5]}}
            pixels = base64.b64decode(self.browser.evaluate(LOOK % json.dumps(words)))
            expected = np.frombuffer(pixels, np.uint8).reshape(180, 320, 4)[..., :3]
            share = share_alike(seen[:, 320 * i:320 * (i + 1)], expected)
            if share < 0.99:
                keep(f"headset.{i}", seen=seen, expected=expected)
            self.assertGreaterEqual(share, 0.99)
        self.assertLess(share_alike(seen[:, :320], seen[:, 320:]), 0.9)

    def settled(self):
        """The picture in the headset, once it stays."""
        script = """new Promise(resolve => {
            const {gl} = equistream, pixels = new Uint8Array(4 * 640 * 180);
            gl.bindFramebuffer(gl.FRAMEBUFFER, null);
            gl.readPixels(0, 0, 640, 180, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
            let text = "";
            for (let i = 0; i < pixels.length; i += 8192)
                text += String.fromCharCode(...pixels.subarray(i, i + 8192));
            resolve(btoa(text));
        })"""
        before = None
        for _ in range(100):
            self.browser.evaluate("new Promise(resolve => setTimeout(resolve, 500))")
            now = self.browser.evaluate(script)
            if now == before:
                break
            before = now
        return np.frombuffer(base64.b64decode(now), np.uint8).reshape(180, 640, 4)[::-1, :, :3]


def multiplied(p, q):
    """Quaternions."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


class Serve(Web):
    """`serve --web` hands out the page, streams to it, and hears where its head is."""

    def serve(self, *words, web="0", stderr=None):
        server = subprocess.Popen([PROGRAMS.folder / "equistream", "serve", *map(str, words), "--web", web, "--json",
                                   "--progress", "none"], stdout=subprocess.PIPE, stderr=stderr, text=True)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.said_first = json.loads(server.stdout.readline())
        return server, self.said_first["web"]

    def end(self, server):
        server.terminate()
        return json.loads(server.stdout.read().splitlines()[-1])

    def connected(self, url, **buffers):
        """To the server; the connection stays."""
        host, port = url.removeprefix("http://").rstrip("/").split(":")
        connection = socket.socket()
        self.addCleanup(connection.close)
        connection.settimeout(30)
        for name, size in buffers.items():
            connection.setsockopt(socket.SOL_SOCKET, getattr(socket, name), size)
        connection.connect((host, int(port)))
        return connection

    def asking(self, url, **buffers):
        """For an upgrade, as the server's page does."""
        connection = self.connected(url, **buffers)
        host = url.removeprefix("http://").rstrip("/")
        connection.sendall(f"GET /stream HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                           "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode())
        return connection

    def test_a_recording(self):
        server, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1))
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("equistream.times.firstPicture")
        self.browser.wait_for("document.getElementById('note').textContent.includes('ended')")
        self.browser.wait_for(f"equistream.shownFrame.frame.index === {FRAMES - 1}")
        self.assertEqual(self.said(), "")
        self.assertEqual(self.end(server)["viewers"], 1)

    def test_a_recording_that_is_sent_over_and_over(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--loop")
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("(globalThis.turns ??= new Set()).add(equistream.player.maker.generation) && turns.size > 3")
        self.browser.wait_for(f"equistream.shownFrame.frame.index === {FRAMES - 1} && equistream.shownFrame.frame.main.distances")
        self.assertEqual(self.said("note"), "")
        self.assertEqual(self.said(), "")

    def test_those_that_find_no_room_count_until_they_have_gone(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--loop", "--viewers", 1)

        def answer():
            try:
                return self.asking(url).recv(12)
            except ConnectionError:
                return b""

        self.assertEqual(answer(), b"HTTP/1.1 101")  # the one that there is room for
        with self.asking(url).makefile("rb") as refused:
            while refused.readline().strip():
                pass
            opcode, length, code = struct.unpack(">BBH", refused.read(4))
            self.assertEqual((opcode, code), (0x88, 1013))  # closed; "try again later"
            self.assertIn("no room", refused.read(length - 2).decode())
        for _ in range(63):
            self.assertEqual(answer(), b"HTTP/1.1 101")  # said "no room" then, and waited for
        self.assertEqual(answer(), b"")

    def test_those_that_find_no_room_keep_nobody_waiting(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1))

        def is_turned_away():
            with self.connected(url) as one:
                return one.recv(1) == b""

        silent = [self.connected(url) for _ in range(64)]
        self.assertTrue(is_turned_away())
        start = time.monotonic()
        for _ in range(1000):
            self.connected(url).close()
        self.assertTrue(is_turned_away())  # after all that came before
        self.assertLess(time.monotonic() - start, 9)  # at 100 a second it would take ten
        for one in silent:
            one.close()

        def is_let_in():
            with contextlib.suppress(OSError, http.client.HTTPException):
                return self.status(url) == 302

        wait_until(is_let_in, "the page", 30)

    def test_a_hundred_a_second_may_ask(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1))
        start = time.monotonic()
        asking = [self.connected(url) for _ in range(50)]
        for one in asking:
            one.sendall(f"GET / HTTP/1.1\r\nHost: {url.removeprefix('http://').rstrip('/')}\r\n\r\n".encode())
        for one in asking:
            self.assertEqual(one.recv(12), b"HTTP/1.1 302")
        self.assertGreater(time.monotonic() - start, 0.48)

    def test_who_has_become_a_viewer_asks_no_more(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--loop", "--viewers", 100)
        for _ in range(70):
            with self.asking(url).makefile("rb") as viewer:
                self.assertEqual(viewer.read(12), b"HTTP/1.1 101")
                while viewer.readline().strip():
                    pass
                self.assertEqual(len(viewer.read(4)), 4)  # of the stream

    def test_one_that_was_dropped_keeps_nothing_open(self):
        server, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--loop", "--patience", 3)

        def sockets():
            count = 0
            for file in pathlib.Path(f"/proc/{server.pid}/fd").iterdir():
                with contextlib.suppress(OSError):  # it has been closed meanwhile
                    count += os.readlink(file).startswith("socket:")
            return count

        before = sockets()
        one = self.asking(url, SO_RCVBUF=4096)
        self.assertEqual(one.recv(12), b"HTTP/1.1 101")

        def is_closed():
            with contextlib.suppress(OSError):
                one.sendall(b"\x8a\x80\0\0\0\0")  # a pong that nobody asked for: it is there
            return sockets() == before

        wait_until(lambda: sockets() > before, "it to come", 30)
        wait_until(is_closed, "its sockets to go", 60)
        self.assertEqual(self.end(server)["viewers"], 1)

    def test_what_a_browser_sends_is_read_slowly(self):
        """Also what the server never hears of."""
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--loop")
        one = self.asking(url, SO_SNDBUF=65536)
        self.assertEqual(one.recv(12), b"HTTP/1.1 101")
        one.setblocking(False)
        pongs, sent, end = 500 * (b"\x8a\xfd" + bytes(4 + 125)), 0, time.monotonic() + 3
        while time.monotonic() < end:
            try:
                sent += one.send(pongs[sent % len(pongs):])
            except BlockingIOError:
                time.sleep(0.001)
            self.assertLess(sent, 2 << 20)  # systems on the way keep some of it
        self.assertGreater(sent, 1 << 16)

    def test_what_is_too_large_is_refused(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--loop")

        def answer(more):
            with contextlib.suppress(ConnectionError):
                one = self.connected(url)
                one.sendall(f"GET / HTTP/1.1\r\nHost: {url.removeprefix('http://').rstrip('/')}\r\n{more}".encode())
                return one.recv(12)
            return b""

        self.assertEqual(answer(f"A: {7000 * 'a'}\r\n\r\n"), b"HTTP/1.1 302")
        self.assertEqual(answer(f"A: {9000 * 'a'}\r\n\r\n"), b"")
        self.assertEqual(answer("Content-Length: 5\r\n\r\nhello"), b"")

        viewer = self.asking(url)
        self.assertEqual(viewer.recv(12), b"HTTP/1.1 101")
        viewer.sendall(struct.pack(">BBH", 0x82, 0x80 | 126, 4109) + bytes(4))  # the head of a message
        last, end = b"", time.monotonic() + 30
        while time.monotonic() < end and (block := viewer.recv(65536)):
            last = (last + block)[-4:]
        self.assertEqual(last, struct.pack(">BBH", 0x88, 2, 1009))  # closed; "message too big"

    def test_a_scene(self):
        server, url = self.serve(self.scene, "--size", "128x64", "--spp", 1)
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("equistream.times.firstPicture", 120)
        self.browser.evaluate("equistream.head.yaw = 1")
        self.watch_taken()
        self.browser.wait_for("taken.length > 1", 120)
        self.assertEqual(self.browser.evaluate("equistream.live.sent"), 0)  # turning needs no new sphere
        self.browser.evaluate("equistream.head.offset = [0.05, 0, 0]")
        self.browser.wait_for("equistream.followed.isFollowed", 120)
        self.browser.evaluate("taken.length = 0")
        self.browser.wait_for("taken.length > 3", 120)  # spheres for the head that was sent move it no further
        place = "equistream.followed.around.position", "equistream.shownFrame.frame.info.head.position"
        around, found = (np.array(self.browser.evaluate(each)) for each in place)
        self.assertAlmostEqual(np.linalg.norm(found - around), 0.05, delta=1e-6)
        self.assertNotIn("no depth", self.said("figures"))
        self.assertEqual(self.said(), "")
        self.assertGreater(self.end(server)["live"]["poses"], 0)

    def status(self, url, **headers):
        connection = http.client.HTTPConnection(url.removeprefix("http://").rstrip("/"), timeout=30)
        self.addCleanup(connection.close)
        connection.request("GET", "/stream" if "Upgrade" in headers else "/", headers={
            name.replace("_", "-"): value for name, value in headers.items()})
        return connection.getresponse().status

    def test_other_pages_are_refused(self):
        _, url = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1))
        host = url.removeprefix("http://").rstrip("/")
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13",
                   "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ=="}
        self.assertEqual(self.status(url), 302)
        self.assertEqual(self.status(url, Host="evil.example"), 403)
        self.assertEqual(self.status(url, **upgrade), 403)
        self.assertEqual(self.status(url, **upgrade, Origin="http://evil.example"), 403)
        self.assertEqual(self.status(url, **upgrade, Origin=f"http://{host}"), 101)
        _, other = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), web="127.0.0.2:0")
        self.assertEqual(self.status(other), 302)  # by the address that it listens on
        self.assertEqual(self.status(other, Host="127.0.0.3"), 403)

    def test_it_says_who_can_come(self):
        server, _ = self.serve(self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1), "--open", web="0.0.0.0:0", stderr=subprocess.PIPE)
        self.end(server)
        said = server.stderr.read().splitlines()
        self.assertEqual(["the page of --web 0.0.0.0:0" in line for line in said], [True])

    def test_https_for_those_who_know_the_secret(self):
        """The certificate is checked as a client checks one that it trusts, and in Chromium as its user does who goes on."""
        stream = self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1)
        pem = self.root / "server.pem"
        server, url = self.serve(stream, "--certificate", pem, web="https://127.0.0.1:0")
        self.assertEqual(pem.stat().st_mode & 0o077, 0)
        address, secret = url.split("/#")
        host = address.removeprefix("https://")
        trusted = ssl.create_default_context(cafile=pem)
        certificate = ssl.PEM_cert_to_DER_cert("-----BEGIN CERT" + pem.read_text().split("-----BEGIN CERT")[1])
        digest = hashlib.sha256(certificate).hexdigest().upper()
        self.assertEqual(self.said_first["certificate"].replace(":", ""), digest)

        def status(target, **headers):
            connection = http.client.HTTPSConnection(host, timeout=30, context=trusted)
            self.addCleanup(connection.close)
            connection.request("GET", target, headers={
                "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Origin": address, **headers})
            return connection.getresponse().status

        self.assertEqual(status("/stream"), 403)
        self.assertEqual(status("/stream?key=" + secret[:-1]), 403)
        self.assertEqual(status("/stream?key=" + secret, Origin="https://evil.example"), 403)
        self.assertEqual(status("/stream?key=%" + secret[0].encode().hex() + secret[1:]), 101)
        with self.assertRaises((OSError, http.client.HTTPException)):
            self.status("http://" + host)

        self.browser.call("Security.setIgnoreCertificateErrors", ignore=True)
        self.browser.call("Page.navigate", url=url)  # which leads on to the page, with what stands behind #
        self.browser.wait_for("globalThis.equistream?.times.firstPicture")
        self.browser.wait_for(f"equistream.shownFrame.frame.index === {FRAMES - 1}")
        self.assertEqual(self.said(), "")
        self.browser.call("Page.navigate", url=address + "/#another-secret-than-the-server-has")
        self.browser.wait_for("document.getElementById('problem')?.textContent.includes('hung up')")
        self.assertNotIn("another-secret", self.said())
        self.assertGreaterEqual(self.end(server)["viewers"], 2)

        _, again = self.serve(stream, "--certificate", pem, web="https://127.0.0.1:0")
        self.assertEqual(self.said_first["certificate"].replace(":", ""), digest)
        self.assertNotEqual(again.split("#")[1], secret)

    def test_certificates_that_are_none(self):
        file = self.root / "none.pem"
        file.write_text("nothing")
        file.chmod(0o600)

        def refusal(*words):
            done = subprocess.run([PROGRAMS.folder / "equistream", "serve", self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1),
                                   *map(str, words)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)
            return done.stderr.strip()

        where = f"equistream serve: {file}: expected "
        self.assertEqual(refusal("--web", "https://:0", "--certificate", file),
                         where + "a private key and its certificate, as PEM without a password, found something else")
        file.chmod(0o644)
        self.assertEqual(refusal("--web", "https://:0", "--certificate", file),
                         where + "a secret's file that is its owner's alone (chmod 600), found others' too")
        self.assertEqual(refusal("--web", "0", "--certificate", file),
                         "equistream serve: --certificate: expected --web https://HOST:PORT beside it, found 0")
        self.assertIn("https:// before it, or --open", refusal("--web", "0.0.0.0:0"))


if __name__ == "__main__":
    if not find_chromium():
        print("skipped: no chromium here (apt-get install chromium)")
        sys.exit(77)
    unittest.main()
