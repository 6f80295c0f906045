"""`equistream play tcp://... --head CSV` of a scene that is rendered meanwhile: spheres are made for where that head is.

usage: live_play_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *  # noqa: E402,F403
from live_server import PATIENCE_S, LiveServer, Received, Viewer, still_scene, wait_for  # noqa: E402

PROGRAMS = Programs(sys.argv.pop(1))
SPEED_M_S = np.array([0.06, 0.02, 0])
SETTLING = 12  # until the first ones made for a head have said how far ahead it has to be
SPHERES = 24


class LivePlay(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="equistream_live_play_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scene, self.begin = still_scene(PROGRAMS, self.folder)
        self.head = self.folder / "head.csv"
        rows = [[t, *(self.begin + t * SPEED_M_S), 1, 0, 0, 0] for t in (0.0, float(PATIENCE_S))]
        self.head.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "".join(",".join(map(repr, map(float, row))) + "\n" for row in rows))

    def is_led(self, frame):
        return not np.allclose(frame["head"]["position_m"], self.begin, atol=1e-9, rtol=0)

    def played(self, *words):
        """What somebody saw who sends nothing, and what play reports."""
        server = LiveServer(PROGRAMS.folder / "equistream", self.scene, self.folder, "--size", "128x64", "--spp", 1, "--", "--fps", 40)
        self.addCleanup(server.close)
        out = self.folder / "eyes"
        command = [PROGRAMS.folder / "equistream", "play", server.url, *words, "--method", "mesh", "--size", "96x64", "--progress", "none", "--out", out]
        play = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (play.kill(), play.communicate()))
        watching = Viewer(server)
        watching.wait_for_more(3)
        if words:
            wait_for(lambda: watching.wait_for_more(2) or self.is_led(Received(PROGRAMS, watching.bytes, self.folder).frames[-1]), "spheres that follow")
            watching.wait_for_more(SETTLING)
        watching.wait_for_more(SPHERES)
        self.assertEqual(server.end()[0], 0, server.log.read_text())
        watching.wait_for_end()
        _, said = play.communicate(timeout=PATIENCE_S)
        self.assertEqual((play.returncode, said), (0, ""))
        return Received(PROGRAMS, watching.bytes, self.folder), json.loads((out / "report.json").read_text())

    def test_spheres_are_made_for_the_paths_head(self):
        received, report = self.played("--head", self.head)
        times_s = np.array([frame["time_s"] for frame in received.frames])
        moved = received.heads() - self.begin
        heads_s = moved @ SPEED_M_S / (SPEED_M_S @ SPEED_M_S)
        # On the path, nowhere else.
        np.testing.assert_allclose(moved, heads_s[:, None] * SPEED_M_S, atol=1e-9)
        np.testing.assert_allclose([frame["camera_pose"]["position_m"] for frame in received.frames], received.heads(), atol=1e-9)
        # Where it is at the sphere's own time, give or take how unevenly spheres come.
        times_s, heads_s = times_s[-SPHERES:], heads_s[-SPHERES:]
        interval_s = np.median(np.diff(times_s))
        rounding_s = 1e-6  # both are whole intervals
        self.assertLessEqual(np.median(np.abs(times_s - heads_s)), interval_s + rounding_s, (times_s, heads_s))
        steering = report["steering"]
        self.assertGreater(steering["frames_made_for_them"], SPHERES / 2)
        self.assertGreaterEqual(steering["heads_sent"], steering["frames_made_for_them"])
        self.assertLess(abs(steering["late_ms"]), 1e3 * times_s[0])

    def test_without_a_path_nobody_steers(self):
        received, report = self.played()
        np.testing.assert_allclose(received.heads(), np.broadcast_to(self.begin, received.heads().shape), atol=1e-9)
        self.assertNotIn("steering", report)

    @unittest.skipUnless(shutil.which("ip") and shutil.which("unshare") and not subprocess.run(["unshare", "--mount", "--net", "true"], capture_output=True).returncode,
                         "a network of its own takes root, ip and unshare")
    def test_a_name_server_that_is_silent_keeps_nobody(self):
        resolver = self.folder / "resolv.conf"
        resolver.write_text("nameserver 127.0.0.1\noptions timeout:30 attempts:1\n")
        inside = ("import os, socket, subprocess, sys, time; subprocess.run(['ip', 'link', 'set', 'lo', 'up'], check=True); "
                  "silent = socket.socket(type=socket.SOCK_DGRAM); silent.bind(('127.0.0.1', 53)); silent.settimeout(1); begin = time.monotonic(); "
                  "status = subprocess.run(sys.argv[1:]).returncode; assert silent.recv(512); print(status, time.monotonic() - begin)")
        command = [PROGRAMS.folder / "equistream", "play", "tcp://server.example:5000", "--out", self.folder / "eyes"]
        mounted = f'mount --bind "{resolver}" /etc/resolv.conf && exec "$@"'
        done = subprocess.run(["unshare", "--mount", "--net", "sh", "-c", mounted, "sh", sys.executable, "-c", inside, *command],
                              capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertIn("the server did not answer for 10 s", done.stderr)
        status, seconds = done.stdout.split()
        self.assertEqual(status, "1")
        self.assertLess(float(seconds), 20)  # the look-up ends after 30


if __name__ == "__main__":
    unittest.main()
