"""`equistream view tcp://...` of a scene that is rendered meanwhile: keys move the spheres, and nothing runs away.

usage: live_view_test.py BIN_DIR
"""

import json
import pathlib
import re
import shutil
import signal
import sys
import tempfile
import threading
import time
import unittest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[n] / name) for n, name in ((1, ""), (1, "viewer"))]
from display import Display, ViewerProcess  # noqa: E402
from independent import *  # noqa: E402,F403
from live_server import LiveServer, Received, Viewer, still_scene, wait_for  # noqa: E402

PROGRAMS = Programs(sys.argv.pop(1))


class LiveView(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="equistream_live_view_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scene, self.begin = still_scene(PROGRAMS, self.folder)
        self.display = Display()
        self.addCleanup(self.display.close)

    def test_keys_move_the_spheres(self):
        server = LiveServer(PROGRAMS.folder / "equistream", self.scene, self.folder, "--size", "128x64", "--spp", 1)
        self.addCleanup(server.close)
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", self.folder, server.url, "--scene", self.scene, "--size", "160x90", "--json", "--panel")
        self.addCleanup(viewer.close)
        watching = Viewer(server)
        watching.wait_for_more(3)

        def moved():
            return np.linalg.norm(Received(PROGRAMS, watching.bytes, self.folder).heads() - self.begin, axis=1)

        self.assertTrue((moved() < 1e-9).all())
        viewer.hold("Left", 1)  # a head that only turns leaves the spheres where they are
        watching.wait_for_more(4)
        self.assertTrue((moved() < 1e-9).all())
        viewer.hold("w", 2)
        wait_for(lambda: moved()[-1] > 0.02, "spheres that move")
        # A head that has come to rest is where it is: what moved it is not added again with each sphere.
        watching.wait_for_more(6)
        resting = moved()[-1]
        watching.wait_for_more(12)
        ways = moved()
        self.assertAlmostEqual(ways[-1], resting, delta=1e-9)
        self.assertLess(ways.max(), 5)
        self.assertTrue((np.diff(ways) >= -1e-9).all(), ways)
        viewer.press("c")
        wait_for(lambda: moved()[-1] < 1e-6, "the way back")
        viewer.press("Escape")
        self.assertEqual(viewer.end()[0], 0)
        self.check_network(json.loads(viewer.printed)["panel"]["network"], len(moved()))
        watching.leave()
        self.assertEqual(server.end()[0], 0, server.log.read_text())

    def check_network(self, panel, spheres):
        """As the panel has it at the end. `spheres`: so many came to another viewer meanwhile."""
        frames, megabytes = re.fullmatch(r"(\d+) frames, ([\d.]+) MB", panel["so far"]).groups()
        self.assertAlmostEqual(int(frames), spheres, delta=4)
        self.assertGreater(float(megabytes), 0)
        self.assertGreater(float(panel["received"].removesuffix(" Mbit/s")), 0)
        self.assertEqual((panel["lost"], panel["reconnected"], panel["steering"]), ("0", "0 times", "the server follows this head"))
        self.assertLessEqual(int(panel["late"]) + int(panel["skipped"]), int(frames))
        self.assertGreaterEqual(float(panel["play-out delay"].removesuffix(" ms")), 0)
        self.assertGreater(float(panel["jitter"].removesuffix(" ms")), 0)

    def test_a_lost_server_is_said_and_found_again(self):
        def serve(port=0):
            server = LiveServer(PROGRAMS.folder / "equistream", self.scene, self.folder, "--size", "128x64", "--spp", 1, port=port)
            self.addCleanup(server.close)
            return server

        server = serve()
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", self.folder, server.url, "--scene", self.scene, "--size", "640x180")
        self.addCleanup(viewer.close)
        said = []
        listening = threading.Thread(target=lambda: said.extend(viewer.process.stderr), daemon=True)
        listening.start()

        def warned():
            """The line at the bottom that is written in orange."""
            red, green, blue = np.moveaxis(viewer.screen()[120:180, :640], -1, 0)
            return ((red > 180) & (green > 100) & (green < 180) & (blue < 110)).sum() > 40

        first = viewer.picture()
        wait_for(lambda: not warned(), "no warning")  # at first a slow machine's spheres are late
        server.end(signal.SIGKILL)
        wait_for(lambda: len(said) == 1 and said[0].endswith(f"{server.url}: the connection was lost; trying again\n"), "the line that says so")
        wait_for(warned, "the same on the screen")
        viewer.hold("Left", 0.5)
        self.assertFalse((viewer.picture() == first).all())  # what came last can be looked around in
        time.sleep(4.5)
        self.assertTrue(warned())
        again = serve(server.port)
        self.assertEqual(again.url, server.url)
        wait_for(lambda: len(said) == 2 and said[1].endswith(f"{server.url}: connected again\n"), "the line that says that it is back")
        wait_for(lambda: not warned(), "no warning")
        viewer.press("Escape")
        self.assertEqual(viewer.process.wait(60), 0)
        listening.join()
        self.assertEqual(len(said), 2, said)
        self.assertEqual(again.end()[0], 0, again.log.read_text())


if __name__ == "__main__":
    unittest.main()
