"""What may be wrong with a stream, and playing it."""

import json
import random
import struct

from page import FRAMES, PROGRAMS, Web, pictures_of

LONG = 45  # frames of two groups
MAIN, SMALL, DEPTH = 0, 1, 2  # roles (docs/stream-format.md, "Frame data")


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
        self.open_stream(self.pece420())
        self.browser.wait_for("equistream.shownFrame.frame")
        self.browser.evaluate("for (const decoder of equistream.player.maker.decoders.values()) decoder.close();"
                              "globalThis.turns = new Set()")
        self.browser.wait_for("turns.add(equistream.player.maker.generation) && turns.size > 2 && equistream.player.shown.main.distances")

    def test_an_address_that_is_none_ends_loading(self):
        self.open("live=stream%23x")
        self.browser.wait_for("document.getElementById('problem').textContent")
        self.assertTrue(self.browser.evaluate("document.getElementById('loading').hidden"))

    def test_it_plays_over_and_over_and_stops_and_jumps(self):
        self.open_stream(self.pece420())
        self.browser.wait_for("(globalThis.turns ??= new Set()).add(equistream.player.maker.generation) && turns.size > 2")
        self.browser.wait_for("equistream.shownFrame.frame")
        self.browser.evaluate("dispatchEvent(new KeyboardEvent('keydown', {key: ' '}))")
        self.assertFalse(self.browser.evaluate("equistream.player.plays"))
        self.browser.evaluate("equistream.player.seek(2 / 30)")
        self.browser.wait_for("equistream.shownFrame.frame.index === 2")
        self.assertEqual(self.said(), "")
        self.assertEqual(self.browser.console, [])

    def test_damaged_bytes_end_in_a_line(self):
        for file in (self.pece420(),
                     self.w10()):
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
        for file in (self.pece420(),
                     self.w10()):
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
        for file in (self.pece420(), self.long_stream("one_group.mkv", "--gop", 100)):
            self.assertIn("expected pictures that can be decoded from a key frame on", self.problem_of(f"src={self.with_hole(file, MAIN).name}"))

    def test_what_ended_the_bytes_is_said_first(self):
        file = self.with_hole(self.pece420(), MAIN)
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
        damaged = bytearray(self.pece420().read_bytes())
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
        for file in (self.pece420(),
                     self.w10()):
            whole = file.read_bytes()
            third = pictures_of(whole, MAIN)[2]
            (self.root / f"cut{file.suffix}").write_bytes(whole[:third + 300])
            self.open(f"src=cut{file.suffix}")
            self.browser.wait_for("equistream.times.firstPicture")
            self.browser.wait_for("document.getElementById('note').textContent")
            self.assertRegex(self.said("note"), r": main (was cut after frame \d \(2 |lacks 2 of 4 pictures)")
            self.assertEqual(self.said(), "")

    def test_a_time_that_is_damaged_stops_nothing(self):
        whole = self.pece420().read_bytes()
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
        damaged = bytearray(self.pece420().read_bytes())
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
        damaged = bytearray(self.pece420().read_bytes())
        run = flags = 0
        while not flags & 0x200:  # a first sample's size is the usual one
            run = damaged.index(b"trun", run) + 4
            flags, = struct.unpack_from(">I", damaged, run)
        at = run + 8 + 4 * bool(flags & 1) + 4 * bool(flags & 4) + 4 * bool(flags & 0x100)
        struct.pack_into(">I", damaged, at, 0)
        (self.root / "empty.mp4").write_bytes(damaged)
        self.assertIn("expected samples that have bytes", self.problem_of("src=empty.mp4"))

    def test_every_lap_has_all_frames(self):
        self.open_stream(self.pece420())
        self.watch_taken("player.seek(0);")
        self.browser.wait_for(f"taken.length >= {3 * FRAMES}")
        self.assertEqual(self.browser.evaluate(f"taken.slice(0, {3 * FRAMES})"), 3 * list(range(FRAMES)))

    def test_without_laps_it_stays_at_the_end_and_plays_again(self):
        file = self.pece420()
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
        file = self.pece420()
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
        file = self.with_hole(self.pece420(), MAIN)
        self.open_stream(self.w10())
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
        self.open_stream(self.pece420())
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
