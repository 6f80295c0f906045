"""`equistream serve SCENE`: bytes, joining, poses, and how it ends.

usage: live_test.py BIN_DIR [test ...]
"""

import contextlib
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *  # noqa: E402,F403
from live_server import LiveServer, PATIENCE_S, Received, Viewer, is_alive, pose_message, turned, wait_for  # noqa: E402

PROGRAMS = Programs(sys.argv.pop(1))
WIDTH, HEIGHT = 128, 64


def without_pauses(stream):
    """Without the empty Void elements that each viewer is sent where no picture comes for a second."""
    return stream.replace(b"\xec\x80", b"")


class Live(unittest.TestCase):
    host = "embree"

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_live_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        description = json.loads(cls.scene.read_text())
        cls.begin = np.array(description["camera"]["keys"][0]["position_m"])

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    def serve(self, *words, spp=1, stderr=None):
        server = LiveServer(PROGRAMS.folder / "equistream", self.scene, self.folder, "--host", self.host, "--size", f"{WIDTH}x{HEIGHT}", "--spp", spp, *words,
                            stderr=stderr)
        self.addCleanup(server.close)
        return server

    def received(self, viewer):
        return Received(PROGRAMS, viewer.bytes, self.folder)

    def wait_to_see(self, viewer, place):
        """Until a sphere's centre is there."""

        def seen():
            viewer.wait_for_more(2)
            return np.allclose(self.received(viewer).heads()[-1], place, atol=1e-6, rtol=0)

        wait_for(seen, f"a sphere at {place}")

    def assert_depth_follows(self, received, low, high):
        """The lowest row looks down past half a pixel: to the floor, which is farther by what the head rose."""
        below = {tuple(np.round(head, 6)): depth[-1].mean() for head, depth in zip(received.heads(), received.depths_m(), strict=True)}
        rise = below[tuple(np.round(high, 6))] - below[tuple(np.round(low, 6))]
        self.assertAlmostEqual(rise, high[1] - low[1], delta=0.05 * (high[1] - low[1]))

    def assert_a_window_gives_up_pixels(self, *of_host):
        server = self.serve("--window", "90x60", "--density", 1024, "--mbit", 0.01, "--json", *of_host)
        viewer = Viewer(server)

        def windows():
            return [picture["camera"]["width"] for picture in self.received(viewer).tracks["window"]["frames"]]

        def has_fewest():
            viewer.wait_for_more(2)
            return windows()[-1] == 128

        wait_for(has_fewest, "a window of a quarter of its pixels")
        status, printed = server.end()
        viewer.wait_for_end()
        self.assertEqual(status, 0)
        widths = windows()
        self.assertEqual(widths, sorted(widths, reverse=True))
        self.assertEqual(widths[0], 256)
        fewer = 128 * 96 / (256 * 176)
        self.assertAlmostEqual(json.loads(printed)["live"]["window_pixels"], fewer, places=6)


class Embree(Live):
    def test_the_file_has_what_a_viewer_gets(self):
        out = self.folder / "all.mkv"
        server = self.serve("--out", out, "--json")
        viewer = Viewer(server)
        viewer.wait_for_more(6)
        status, printed = server.end()
        viewer.wait_for_end()
        self.assertEqual(status, 0, server.log.read_text())
        self.assertEqual(without_pauses(viewer.bytes), without_pauses(out.read_bytes()))
        received = self.received(viewer)
        self.assertTrue(received.whole, received.truncation)
        report = json.loads(printed)
        self.assertEqual(report["bytes_sent"], len(viewer.bytes))
        # The last one comes once more, to say so.
        self.assertEqual([len(t["frames"]) for t in received.tracks.values()], 2 * [report["live"]["spheres"] + 1])
        self.assertEqual(received.frames[-1]["index"], received.frames[-2]["index"] + 1)

    def test_it_begins_when_somebody_comes_and_plays_the_scenes_path(self):
        server = self.serve()
        first = Viewer(server)
        first.wait_for_more(3)
        first.leave()
        wait_for(lambda: "viewer 1" in server.log.read_text() and " left" in server.log.read_text(), "the viewer's leaving")
        second = Viewer(server)
        second.wait_for_more(3)
        server.end()
        second.wait_for_end()
        frames = self.received(first).frames
        np.testing.assert_allclose(frames[0]["head"]["position_m"], self.begin, atol=1e-12)
        self.assertEqual(frames[0]["index"], 0)
        path = PROGRAMS.folder / "equistream"
        out = self.folder / "frames"
        last = frames[-1]
        subprocess.run([path, "render", self.scene, "--frames", str(last["index"]), "--size", "64x64", "--spp", "1", "--aovs", "none", "--out", out], check=True,
                       capture_output=True)
        rendered = json.loads(PROGRAMS.run("info", "--json", out / "centre" / f"frame.{last['index']:04}.exr"))
        self.assertEqual(last["head"], rendered["frame"]["head"])

    def test_who_comes_later_joins_at_a_key_frame(self):
        server = self.serve()
        first = Viewer(server)
        first.wait_for_more(4)
        second = Viewer(server)
        wait_for(lambda: second.clusters() >= 3, "the second viewer's pictures")
        server.end()
        for viewer in (first, second):
            viewer.wait_for_end()
        header = first.bytes[: first.bytes.index(b"\x1f\x43\xb6\x75")]
        self.assertTrue(second.bytes.startswith(header))
        rest = second.bytes[len(header) :]
        self.assertGreater(len(rest), 1000)
        self.assertTrue(without_pauses(first.bytes).endswith(without_pauses(rest)))
        whole = {track: self.received(first).hashes(track) for track in (0, 1)}
        joined = self.received(second)
        for track in (0, 1):
            hashes = joined.hashes(track)
            self.assertGreaterEqual(len(hashes), 3)
            self.assertEqual(hashes, whole[track][-len(hashes) :])

    def test_a_pose_is_the_next_spheres_centre(self):
        server = self.serve()
        viewer = Viewer(server)
        viewer.wait_for_more(2)
        low = self.begin + (0.3, -0.2, 0.1)
        high = low + (0, 0.7, 0)
        for place in (low, high):
            viewer.send(pose_message(place, turned(0.5)))
            self.wait_to_see(viewer, place)
        server.end()
        viewer.wait_for_end()
        received = self.received(viewer)
        np.testing.assert_allclose(received.frames[-1]["camera_pose"]["position_m"], high, atol=1e-6)
        np.testing.assert_allclose(received.frames[-1]["head"]["orientation_wxyz"], turned(0.5), atol=1e-12)
        self.assert_depth_follows(received, low, high)

    def test_a_still_viewers_pictures_lose_their_noise(self):
        server = self.serve("--accumulate", 32)
        viewer = Viewer(server)
        viewer.send(pose_message(self.begin))
        self.wait_to_see(viewer, self.begin)
        viewer.wait_for_more(16)
        server.end()
        viewer.wait_for_end()
        received = self.received(viewer)
        self.assertTrue(received.whole, received.truncation)
        pictures = np.frombuffer(received.decoded(0, "-pix_fmt", "gray", "-f", "rawvideo"), np.uint8).reshape(-1, HEIGHT, WIDTH)[:-1].astype(float)
        changes = np.mean(np.abs(np.diff(pictures, axis=0)), axis=(1, 2))
        self.assertLess(np.mean(changes[-3:]), 0.4 * np.max(changes))  # a tenth, but for what moves and the codec

    def test_a_window_goes_where_the_viewer_looks(self):
        server = self.serve("--window", "90x60", "--density", 512)
        viewer = Viewer(server)
        for yaw in (0.0, -1.5):
            viewer.send(pose_message(self.begin, turned(yaw)))
            viewer.wait_for_more(6)
        server.end()
        viewer.wait_for_end()
        received = self.received(viewer)
        self.assertTrue(received.whole, received.truncation)
        self.assertEqual(list(received.tracks), ["main", "depth", "window", "window-depth"])
        windows = [frame["camera"]["longitudes_rad"] for frame in received.tracks["window"]["frames"]]
        middles = [sum(ends) / 2 for ends in windows]
        self.assertEqual(len(windows), len(received.frames))
        # Positive longitudes lie to the right. A window stays until the gaze has left its middle by an eighth of its width, and lies on blocks of 16 pixels.
        slack_rad = math.radians(90) / 8 + 2 * math.pi * 16 / 512
        self.assertTrue(any(abs(middle) < slack_rad for middle in middles), middles)
        self.assertAlmostEqual(middles[-1], 1.5, delta=slack_rad)
        for first, last in windows:
            self.assertGreaterEqual(last - first, math.radians(90) - 1e-9)

    def test_samples_go_to_the_window_before_its_base(self):
        server = self.serve("--window", "90x60", "--density", 512, "--rate", 0.02, "--accumulate", 32, "--json", spp=2)
        viewer = Viewer(server)

        def samples():
            tracks = self.received(viewer).tracks
            return [[frame["samples_per_pixel"] for frame in tracks[name]["frames"]][:7] for name in ("window", "main")]

        def seven_came():
            viewer.wait_for_more(2)
            return min(map(len, samples())) == 7

        wait_for(seven_came, "seven frames")
        status, printed = server.end()
        viewer.wait_for_end()
        self.assertEqual(status, 0)
        window, base = samples()
        self.assertEqual((window, base), ([1, 1, 2, 2, 2, 2, 2], [1, 1, 1, 1, 2, 2, 2]))
        self.assertEqual([json.loads(printed)["live"][name] for name in ("spp", "base_spp")], [2, 2])

    def test_a_window_lies_between_viewers_who_look_nearly_alike(self):
        server = self.serve("--window", "90x60", "--density", 1024)
        viewers = [Viewer(server) for _ in range(3)]
        viewers[0].send(pose_message(self.begin, turned(0)))
        viewers[0].wait_for_more(4)
        viewers[1].send(pose_message(self.begin, turned(-0.5)))
        viewers[2].send(pose_message(self.begin, turned(3)))  # too far to be held
        viewers[0].wait_for_more(6)
        server.end()
        for viewer in viewers:
            viewer.wait_for_end()
        frames = self.received(viewers[0]).tracks["window"]["frames"]
        first, last = frames[-1]["camera"]["longitudes_rad"]
        self.assertAlmostEqual((first + last) / 2, 0.25, delta=2 * math.pi * 16 / 1024)
        for frame in frames:  # as dense as a sphere of so many columns
            first, last = frame["camera"]["longitudes_rad"]
            self.assertAlmostEqual(frame["camera"]["width"] / (last - first), 1024 / (2 * math.pi), 6)

    def test_what_is_no_pose_changes_nothing(self):
        server = self.serve("--json")
        viewer = Viewer(server)
        viewer.wait_for_more(2)
        place, there = self.begin + (0.25, 0, 0), self.begin + (0, 0, 0.25)
        nan = float("nan")
        bad = [np.random.default_rng(1).bytes(30000), pose_message((nan, 0, 0)), pose_message(place, (nan, 0, 0, 0)), pose_message(place, (1, 1, 0, 0)),
               pose_message((float("inf"), 0, 0)), pose_message(place, version=2), pose_message(place, kind=9), pose_message(place, length=2**32 - 1),
               pose_message(place, length=5000)]
        for message in bad:
            viewer.send(message)
            viewer.wait_for_more(1)
        viewer.send(pose_message(there))
        self.wait_to_see(viewer, there)
        heads = self.received(viewer).heads()
        self.assertTrue((np.linalg.norm(heads - place, axis=1) > 1e-6).all())
        status, printed = server.end()
        self.assertEqual(status, 0)
        self.assertEqual(json.loads(printed)["live"]["poses"], 1)

    def test_the_first_to_come_steers_until_it_leaves(self):
        server = self.serve()
        first = Viewer(server)
        wait_for(lambda: server.log.read_text().count(" came") == 1, "the first viewer")
        second = Viewer(server)
        second.wait_for_more(1)
        here, there, elsewhere = (self.begin + step for step in ((0.2, 0, 0), (0, 0, 0.3), (0.1, 0, 0.3)))
        second.send(pose_message(there))
        self.wait_to_see(first, there)
        first.send(pose_message(here))
        self.wait_to_see(first, here)
        second.send(pose_message(elsewhere))
        first.wait_for_more(8)
        self.assertTrue((np.linalg.norm(self.received(first).heads() - elsewhere, axis=1) > 1e-6).all())
        np.testing.assert_allclose(self.received(first).heads()[-1], here, atol=1e-6)
        first.leave()
        self.wait_to_see(second, elsewhere)
        self.assertEqual(server.end()[0], 0)

    def test_a_renderer_that_dies_is_started_again_three_times(self):
        server = self.serve()
        viewer = Viewer(server)
        died = r"equistream serve: .*equistream-render-embree: ended by signal 9"
        viewer.wait_for_more(2)
        for restarts in range(1, 4):
            subprocess.run(["kill", "-KILL", str(server.renderer())], check=True)
            wait_for(lambda: server.log.read_text().count("restarting it") == restarts, "it to say so")
            viewer.wait_for_more(4)  # two may be of the one before
        last = int(self.received(viewer).frames[-1]["index"])
        subprocess.run(["kill", "-KILL", str(server.renderer())], check=True)
        server.process.communicate(timeout=PATIENCE_S)
        self.assertEqual(server.process.returncode, 1)
        lines = [line for line in server.log.read_text().splitlines() if "signal" in line]
        self.assertEqual(len(lines), 4, lines)
        for line in lines[:3]:
            self.assertRegex(line, f"^{died}; restarting it$")
        self.assertRegex(lines[3], f"^{died}$")
        viewer.wait_for_end()
        received = self.received(viewer)
        self.assertTrue(received.whole, received.truncation)
        indices = [frame["index"] for frame in received.frames]
        self.assertEqual(indices, sorted(set(indices)))
        self.assertGreaterEqual(indices[-1], last)

    def test_a_renderer_that_dies_before_anybody_comes_is_started_again(self):
        server = self.serve()
        subprocess.run(["kill", "-KILL", str(server.renderer())], check=True)
        wait_for(lambda: "restarting it" in server.log.read_text(), "it to say so")
        viewer = Viewer(server)
        viewer.wait_for_more(2)
        self.assertEqual(server.end()[0], 0)
        viewer.wait_for_end()

    def test_the_renderer_has_a_group_of_its_own_and_no_sockets(self):
        """The server passes on what a terminal sends. A socket that outlives the server would keep its address."""
        server = self.serve()
        renderer = server.renderer()
        self.assertNotEqual(os.getpgid(renderer), os.getpgid(server.process.pid))
        files = []
        for file in pathlib.Path(f"/proc/{renderer}/fd").iterdir():
            with contextlib.suppress(OSError):  # it has been closed meanwhile
                files.append(os.readlink(file))
        self.assertGreater(len(files), 2)
        self.assertEqual([file for file in files if file.startswith("socket:")], [])
        self.assertEqual(server.end()[0], 0)

    def test_whoever_reads_the_log_may_leave(self):
        """Of a live stream, and then of its recording."""
        reader, log = os.pipe()
        os.close(reader)
        self.addCleanup(os.close, log)
        out = self.folder / "all.mkv"

        def visit(server):
            viewer = Viewer(server)
            wait_for(lambda: viewer.clusters() > 0, "its first cluster")
            viewer.leave()
            self.assertEqual(server.end()[0], 0)

        visit(self.serve("--out", out, stderr=log))
        recorded = LiveServer(PROGRAMS.folder / "equistream", out, self.folder, stderr=log)
        self.addCleanup(recorded.close)
        visit(recorded)

    def test_the_renderer_ends_with_the_server(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGKILL):
            server = self.serve()
            viewer = Viewer(server)
            viewer.wait_for_more(1)
            renderer = server.renderer()
            self.assertTrue(is_alive(renderer))
            status, printed = server.end(number)
            if number == signal.SIGKILL:
                wait_for(lambda: not is_alive(renderer), "the renderer's end")
            else:
                self.assertEqual(status, 0)
                self.assertFalse(is_alive(renderer))
                self.assertIn("viewers served 1, refused 0, dropped 0; ", printed)
                self.assertEqual([p for p in self.folder.iterdir() if p.is_dir()], [])

    def test_what_the_renderer_and_the_encoder_are_told(self):
        place = self.begin + (0.5, 0.25, -0.5)
        path = self.folder / "head.csv"
        path.write_text("".join(f"{t},{','.join(repr(float(x)) for x in place)},1,0,0,0\n" for t in (0, 100)))
        server = self.serve("--denoise", "fast", "--path", path, "--threads", 3, "--depth", "none", "--crf", 30, "--preset", "ultrafast", "--json")
        viewer = Viewer(server)
        viewer.wait_for_more(3)
        words = pathlib.Path(f"/proc/{server.renderer()}/cmdline").read_bytes().split(b"\0")
        status, printed = server.end()
        viewer.wait_for_end()
        self.assertEqual(status, 0, server.log.read_text())
        self.assertEqual(words[words.index(b"--threads") + 1], b"3")
        received = self.received(viewer)
        self.assertEqual(list(received.tracks), ["main"])
        np.testing.assert_allclose(received.heads(), np.broadcast_to(place, (len(received.frames), 3)), atol=1e-9)
        self.assertEqual({frame["crf"] for frame in received.frames}, {30})
        self.assertEqual(json.loads(printed)["live"]["crf"], 30)
        for frame in received.frames:
            self.assertRegex(str(frame["denoiser"]), r"Open Image Denoise 2.*, fast$")
        self.assertTrue(b" cabac=0 " in viewer.bytes, "of x264's presets ultrafast alone goes without")

    def test_samples_rise_where_there_is_time(self):
        server = self.serve("--rate", 0.02, spp=4)
        viewer = Viewer(server)
        viewer.wait_for_more(12)
        server.end()
        viewer.wait_for_end()
        samples = [frame["samples_per_pixel"] for frame in self.received(viewer).frames]
        self.assertEqual(samples[:6], [1, 1, 2, 2, 4, 4])
        self.assertEqual(samples[-1], 4)

    def test_it_is_coded_coarser_for_a_limit(self):
        server = self.serve("--mbit", 0.01, "--json")
        viewer = Viewer(server)
        viewer.wait_for_more(12)
        status, printed = server.end()
        viewer.wait_for_end()
        self.assertEqual(status, 0)
        self.assertGreater(json.loads(printed)["live"]["crf"], 24)
        self.assertRegex(server.log.read_text(), r"to stay within --mbit 0\.01: CRF \d+ instead of 16\n")

    def test_a_window_gives_up_pixels_for_a_limit(self):
        self.assert_a_window_gives_up_pixels()

    def test_it_says_where_one_sample_is_too_slow(self):
        server = self.serve("--rate", 1000, spp=64)
        viewer = Viewer(server)
        wait_for(lambda: "even with 1 sample a pixel, too slow for --rate 1000" in server.log.read_text(), "it to say so")
        server.end()
        viewer.wait_for_end()
        self.assertEqual({frame["samples_per_pixel"] for frame in self.received(viewer).frames}, {1})

    def test_info_of_what_goes_on_is_of_what_came_first(self):
        server = self.serve("--rate", 200)
        said = json.loads(PROGRAMS.run("info", server.url, "--json"))
        self.assertIsNone(said["whole"])
        self.assertEqual(said["tracks"][0]["pictures"], 300)

    def test_bad_usage_is_one_line(self):
        def refused(*words):
            ran = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "serve", "--listen", "tcp://:0", *words]], capture_output=True, text=True)
            self.assertEqual(ran.returncode, 2, ran.stderr)
            self.assertEqual(len(ran.stderr.splitlines()), 1, ran.stderr)
            self.assertEqual(ran.stdout, "")
            return ran.stderr

        broken = self.folder / "broken.json"
        broken.write_text("{")
        self.assertIn("equistream render: ", refused(broken))
        for option, value in (("--host", "povray"), ("--size", "63x32"), ("--spp", 0), ("--rate", 0), ("--depth", "w8"), ("--out", "a.mp4"), ("--crf", 52)):
            self.assertIn(option, refused(self.scene, option, value))
        self.assertIn("--loop", refused(self.scene, "--loop"))
        self.assertIn("--follow: expected one eye", refused(self.scene, "--", "--eye", "both"))
        stream = self.folder / "a.mkv"
        stream.write_bytes(b"")
        self.assertIn("expected a scene", refused(stream, "--spp", 4))


class Mitsuba(Live):
    host = "mitsuba"

    def setUp(self):
        super().setUp()
        if not (PROGRAMS.folder / "equistream-render-mitsuba").exists():
            self.skipTest("built without Mitsuba")

    def test_a_pose_is_the_next_spheres_centre(self):
        server = self.serve("--", "--variant", "scalar_rgb")
        viewer = Viewer(server)
        viewer.wait_for_more(2)
        low = self.begin + (0.3, -0.2, 0.1)
        high = low + (0, 0.7, 0)
        for place in (low, high):
            viewer.send(pose_message(place))
            self.wait_to_see(viewer, place)
        renderer = server.renderer()
        self.assertEqual(server.end()[0], 0, server.log.read_text())
        self.assertFalse(is_alive(renderer))
        viewer.wait_for_end()
        received = self.received(viewer)
        self.assertTrue(received.whole, received.truncation)
        self.assertIn("mitsuba", received.frames[0]["host"])
        self.assert_depth_follows(received, low, high)

    def test_a_window_gives_up_pixels_for_a_limit(self):
        self.assert_a_window_gives_up_pixels("--", "--variant", "scalar_rgb")


if __name__ == "__main__":
    unittest.main(defaultTest=["Embree"] if len(sys.argv) == 1 else None)
