"""The page in a headless Chromium, on streams that are made for it: what the tests of web_test.py share."""

import base64
import contextlib
import json
import math
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from chromium import Chromium, Folder  # noqa: E402
from independent import Programs  # noqa: E402

PROGRAMS = Programs(sys.argv.pop(1))
ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGE = PROGRAMS.folder.parent / "share" / "equistream" / "web.html"
IPD = 0.063
SIZE = (640, 360)
FRAMES = 4
FRAME_DATA = bytes.fromhex("69c48036513347848093ec66a7475119")

# The page hands pixels over as text.
AS_TEXT = """(pixels => {
    let text = "";
    for (let i = 0; i < pixels.length; i += 8192)
        text += String.fromCharCode(...pixels.subarray(i, i + 8192));
    return btoa(text);
})"""
ON_SCREEN = """(() => {
    const {gl} = equistream, pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
})()"""


def turned(yaw_deg, pitch_deg):
    yaw, pitch = math.radians(yaw_deg) / 2, math.radians(pitch_deg) / 2
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([cy * cp, cy * sp, sy * cp, -sy * sp])


def rotated(q, v):
    w, r = q[0], np.asarray(q[1:])
    return v + 2 * np.cross(r, np.cross(r, v) + w * np.asarray(v))


def multiplied(p, q):
    """Quaternions."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def pictures_of(stream, role):
    """Where the frame data of a role's pictures begin, in the order they lie in the file."""
    return [found.start() for found in re.finditer(re.escape(FRAME_DATA), stream) if stream[found.start() + 20] == role]


@contextlib.contextmanager
def prepared():
    """A folder with the page, a scene and its frames, and a web server of it."""
    Web.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_web_"))
    try:
        shutil.copy(PAGE, Web.root / "web.html")
        Web.scene = PROGRAMS.scene("pavilion", Web.root)
        Web.frames = Web.root / "frames"
        PROGRAMS.run("render", Web.scene, "--frames", f"0-{FRAMES - 1}", "--size", "512x256", "--spp", 16, "--progress", "none",
                     "--out", Web.frames)
        Web.folder = Folder(Web.root)
        yield
        Web.folder.close()
    finally:
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

    def w10(self):
        return self.encode("w10.mkv", "--depth", "w10", "--depth-scale", 1)

    def pece420(self):
        return self.encode("pece420.mp4", "--depth", "pece420", "--depth-scale", 1)

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

    def pixels(self, script, size):
        """RGB of the RGBA that a script gives, row by row."""
        text = self.browser.evaluate(f"(async () => {AS_TEXT}(await {script}))()")
        return np.frombuffer(base64.b64decode(text), np.uint8).reshape(size[1], size[0], 4)[..., :3]

    def look(self, frame, position, orientation, size=SIZE, view=None):
        """What an eye sees, by itself; `view` as the page has it. The page stands still then."""
        words = {"frame": frame, "width": size[0], "height": size[1], **({"view": view} if view else {}),
                 "eye": {"position": list(position), "orientation": list(orientation)}}
        return self.pixels(f"equistream.look({json.dumps(words)})", size)

    def settled(self):
        """The picture on the screen, or in the headset, once it stays."""
        size = self.browser.evaluate("[equistream.gl.drawingBufferWidth, equistream.gl.drawingBufferHeight]")
        before = now = None
        for _ in range(100):
            self.browser.wait_for("!equistream.shownFrame.isMaking")
            before, now = now, self.pixels(f"new Promise(resolve => setTimeout(() => resolve({ON_SCREEN}), 500))", size)
            if before is not None and np.array_equal(before, now):
                break
        return now[::-1]


def keep(name, **pictures):
    """What failed, to be looked at."""
    folder = pathlib.Path(tempfile.gettempdir()) / "equistream_web_failures"
    folder.mkdir(exist_ok=True)
    for who, picture in pictures.items():
        Image.fromarray(picture).save(folder / f"{name}.{who}.png")


def share_alike(one, other):
    return np.mean(np.abs(one.astype(int) - other.astype(int)).max(axis=-1) <= 2)
