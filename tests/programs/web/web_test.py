"""The page that shows streams in a browser, in a real headless Chromium.

usage: web_test.py BIN_DIR [Accuracy | Streams | Gallery | Failures | Headset | Inputs | Serve]
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

import numpy as np
from PIL import Image

from page import FRAMES, IPD, PROGRAMS, ROOT, SIZE, Web, keep, prepared, rotated, share_alike, turned
from chromium import Chromium, find_chromium
from headset import Headset
from inputs import Inputs
from served import Serve
from streams import Streams

# Of the head, around where each frame's is: metres, and degrees to the left and up; then the share of pixels that must
# be alike. The last one looks into the roof's laths: a card places corners on 1/256 of a pixel, the CPU does not, and
# along so many outlines that shows.
HEADS = [((0, 0, 0), 0, 0, 0.999), ((0.06, 0.02, -0.03), 40, -10, 0.999), ((-0.07, 0, 0.04), 170, 20, 0.999),
         ((0.03, -0.05, 0.02), -80, 60, 0.99)]


def heads_of(file):
    """A head for each frame, in the world."""
    first = json.loads(PROGRAMS.run("info", file, "--json"))["tracks"][0]["first_frame"]["head"]
    around = np.array(first["position_m"])
    return [(around + np.array(offset), turned(yaw, pitch)) for offset, yaw, pitch, _ in HEADS]


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
        self.compare(self.w10(), "--method", "mesh", "--fill", "pushpull")

    def test_by_depth_of_8_bits_in_mp4(self):
        self.compare(self.pece420(), "--method", "mesh", "--fill", "pushpull")

    def test_by_halved_depth(self):
        self.compare(self.encode("halved.mkv", "--depth", "w10", "--depth-scale", 2), "--method", "mesh", "--fill", "pushpull")

    def test_with_a_window(self):
        frames = self.root / "seen"
        PROGRAMS.run("render", self.scene, "--frames", f"0-{FRAMES - 1}", "--window", "gaze,70x50", "--size", "256x128", "--density", 768,
                     "--spp", 4, "--progress", "none", "--out", frames)
        self.compare(self.encode("window.mkv", "--depth", "pece420", "--depth-scale", 1, frames=frames), "--method", "mesh",
                     "--fill", "base,pushpull")

    def test_with_a_live_window_whose_size_changes(self):
        orders = [{"frame": frame, "spp": 1, "window_halvings": halvings} for frame, halvings in enumerate((0, 2, 1, 0))]
        words = ["render", self.scene, "--follow", "--window", "gaze,70x50", "--size", "256x128", "--density", "768", "--aovs", "depth",
                 "--progress", "none", "--out", self.root / "ordered"]
        with subprocess.Popen([PROGRAMS.folder / "equistream", *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as renderer:
            renderer.stdout.readline()
            files = []
            for order in orders:
                print(json.dumps(order), file=renderer.stdin, flush=True)
                answer = json.loads(renderer.stdout.readline())
                files += [answer["file"], answer["window"]]
            renderer.stdin.close()
        stream = self.root / "sizes.mkv"
        subprocess.run([PROGRAMS.folder / "equistream_live_stream", stream, *files], check=True)
        told = json.loads(PROGRAMS.run("info", "--frames", stream, "--json"))
        (window,) = (track for track in told["tracks"] if track["name"] == "window")
        self.assertEqual(len({frame["camera"]["width"] for frame in window["frames"]}), 3)
        self.compare(stream, "--method", "mesh", "--fill", "base,pushpull")

    def test_without_depth(self):
        self.compare(self.encode("turned.mp4", "--depth", "none"), "--method", "rotation", "--fill", "pushpull")


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
        self.open_stream(self.pece420())
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
        self.open_stream(self.pece420())
        self.assertIn("the page's worker: the browser has ended it", self.said("note"))

    def test_a_worker_that_ends(self):
        self.open_stream(self.pece420())
        self.browser.wait_for("equistream.player.shown?.main.distances")
        self.browser.evaluate("equistream.helper.worker.onerror(new Event('error')); globalThis.turns = new Set()")
        self.browser.wait_for("turns.add(equistream.player.maker.generation) && turns.size > 2 && equistream.player.shown")
        self.assertIn("the page's worker: the browser has ended it", self.said("note"))

    # Connections that end as the address says: [how many bytes came, or null where it was never open, code, reason].
    # What waits to ask again waits no longer than its turn.
    SOCKETS = """
        const {ends, status} = JSON.parse(new URLSearchParams(location.search).get("script"));
        globalThis.asked = 0;
        globalThis.pauses = [];
        const later = setTimeout;
        globalThis.setTimeout = (act, milliseconds, ...words) => {
            const isPause = [250, 500, 1000, 2000, 4000].includes(milliseconds) && pauses.push(milliseconds);
            return later(act, isPause ? 0 : milliseconds, ...words);
        };
        globalThis.fetch = async () => {
            if (!status)
                throw new TypeError("nobody there");
            return {status};
        };
        globalThis.WebSocket = class {
            constructor() {
                const end = ends[asked++];
                if (end)
                    later(() => this.pass(...end));
            }
            pass(bytes, code, reason) {
                if (bytes !== null)
                    this.onopen();
                if (bytes > 0)
                    this.onmessage({data: new ArrayBuffer(bytes)});
                this.onclose({code, reason});
            }
            close() {}
        };
    """

    def connect(self, *ends, status=0):
        """`status`: what the server answers to those who ask whether it is there; 0: nothing does."""
        self.open("live=stream&script=" + urllib.parse.quote(json.dumps({"ends": ends, "status": status}), safe=""))

    def test_a_server_that_was_lost_is_asked_again_but_where_it_would_say_the_same(self):
        self.browser.before_pages(self.SOCKETS)
        gone, lost, over = [None, 1006, ""], [3, 1006, ""], [4, 1000, ""]
        pauses, ended = [250, 500, 1000, 2000, 4000, 4000], "expected pictures with poses"  # of these few bytes
        for what, ends, status, waited, said in (
                ("nobody there at first", [gone], 0, [], "no connection to the server$"),
                ("no room at first", [[0, 1013, "no room"]], 404, [], r"closed the connection \(no room\)$"),
                ("a fault of the page's", [[3, 1009, ""]], 404, [], "closed the connection$"),
                ("lost, and there again", [lost, *5 * [gone], [5, 1011, "cut"], over], 0, [*pauses, 250], ended),
                ("no room for a while", [lost, [0, 1013, "no room"], over], 404, pauses[:2], ended),
                ("cut in the same place", [lost, gone, lost], 0, pauses[:2], "the connection was lost$"),
                ("it refuses", [lost, gone, gone], 404, pauses[:2], "a refusal"),
                ("behind another server", [lost, gone, gone, over], 502, pauses[:3], ended)):
            with self.subTest(what):
                self.connect(*ends, status=status)
                self.browser.wait_for("document.getElementById('problem').textContent")
                self.assertEqual(self.browser.evaluate("asked"), len(ends))
                self.assertEqual(self.browser.evaluate("pauses"), waited)
                self.assertRegex(self.said(), said)
                self.assertEqual(self.browser.evaluate("equistream.lost"), "")
                self.assertEqual("has ended" in self.said("note"), said == ended)

    def test_one_line_says_that_a_server_is_lost(self):
        self.browser.before_pages(self.SOCKETS)
        self.connect([3, 1011, "the stream was cut off"], [None, 1006, ""], [0, 1013, "no room"])
        self.browser.wait_for("equistream.live.attempts === 3")
        self.browser.wait_for("document.getElementById('state').textContent === "
                              "'the server closed the connection (no room): trying again (3)'")
        self.assertEqual((self.said(), self.said("note")), ("", ""))


if __name__ == "__main__":
    if not find_chromium():
        print("skipped: no chromium here (apt-get install chromium)")
        sys.exit(77)
    with prepared():
        unittest.main()
