#!/usr/bin/env python3
"""Pictures of the viewer's window for docs/results/viewer.md: docs/images/viewer-*.jpg.

    screenshots.py --bin build/release/bin --work W

Every picture is what stands on a display (Xvfb) after keys were pressed, the text over it included. What is shown is rendered into W first, where it
is not there yet.
"""

import argparse
import io
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
from PIL import Image

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "programs/study"), *(str(REPOSITORY / "tests/programs" / room) for room in ("", "viewer"))]
from display import Display, ViewerProcess  # noqa: E402
from steps import run_as_program  # noqa: E402

SIZE = (640, 360)
MOST_BYTES = {"viewer-layouts": 100_000, "viewer-overlays": 100_000, "viewer-face": 62_000}
PAGE_COLUMNS = 960
# File -> rows of pictures, each of what, and the options and keys that make it.
PAGES = {
    "viewer-layouts": [[("walk", ["--layout", "left"], []), ("walk", ["--layout", "sbs"], [])],
                       [("walk", ["--layout", "anaglyph"], []), ("walk", ["--layout", "headset"], [])],
                       [("walk", ["--layout", "sphere"], []), ("walk", ["--method", "rotation"], [])]],
    "viewer-overlays": [[("walk", ["--overlay", "depth"], []), ("walk", ["--overlay", "gaps"], ["hold d"])],
                        [("walk", ["--overlay", "reliability"], ["hold d"]), ("moving", ["--overlay", "motion"], ["hold Right", "hold Right"])],
                        [("walk", ["--fill", "off"], ["hold d"]), ("walk", [], ["hold w"] * 5)]],
    "viewer-face": [[("walk", ["--panel", "--overlay", "depth"], [])]],
}
SIZES = {"viewer-face": (800, 600)}  # where the page's pictures have another
HOLD_S = 1.6
MESSAGE_S = 5.5  # until what the viewer wrote is no longer told of


class Sources:
    """Source and scene by name."""

    def __init__(self, programs, work):
        self.programs, self.work = programs, work
        work.mkdir(parents=True, exist_ok=True)
        self.make("pavilion.json", "scene", "generate", "pavilion", "--out", ".")
        self.make("motion.json", "scene", "generate", "motion", "--out", ".")
        self.make("frames", "render", "pavilion.json", "--frames", "40-41", "--size", "1536x768", "--spp", 16, "--layers", "--aovs", "all", "--out", "frames")
        # Coded, so that there is a decoder to be named.
        self.make("walk.mkv", "encode", "frames", "--crf", 12, "--out", "walk.mkv")
        self.make("spheres", "render", "motion.json", "--frames", "0-2", "--size", "1024x512", "--spp", 4, "--aovs", "depth,motion,ids", "--out", "spheres")
        self.make("moving.mkv", "encode", "spheres", "--motion", "auto", "--crf", 12, "--out", "moving.mkv")

    def make(self, product, *words):
        if not (self.work / product).exists():
            subprocess.run([self.programs / "equistream", *map(str, words)], cwd=self.work, check=True, stdout=subprocess.DEVNULL)

    def of(self, name):
        return {"walk": ("walk.mkv", "pavilion.json"), "moving": ("moving.mkv", "motion.json")}[name]


def picture(display, sources, size, name, words, keys):
    source, scene = sources.of(name)
    with tempfile.TemporaryDirectory() as out:
        viewer = ViewerProcess(display, sources.programs / "equistream", out, source, "--scene", scene, "--paused", "--size", f"{size[0]}x{size[1]}", *words)
        try:
            viewer.picture()
            for key in keys:
                viewer.hold(key.removeprefix("hold "), HOLD_S) if key.startswith("hold ") else viewer.press(key)
            viewer.picture()  # all that was pressed has been handled
            time.sleep(MESSAGE_S)
            return viewer.screen()[: size[1], : size[0]].astype(np.uint8)
        finally:
            viewer.close()


def jpeg(pixels, max_bytes):
    """As wide as a page shows it, and as good as so many bytes allow."""
    shown = Image.fromarray(pixels)
    shown = shown.resize((PAGE_COLUMNS, round(shown.height * PAGE_COLUMNS / shown.width)), Image.Resampling.LANCZOS)
    for quality in range(90, 20, -3):
        coded = io.BytesIO()
        shown.save(coded, "JPEG", quality=quality, optimize=True, progressive=True)
        if coded.tell() < max_bytes:
            break
    return coded.getvalue()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder for what is shown")
    parser.add_argument("--page", action="append", choices=list(PAGES), help="this one alone; may be given again (default: all)")
    options = parser.parse_args()
    sources = Sources(options.bin.resolve(), options.work.resolve())
    os.chdir(sources.work)  # the panel names what is shown
    display = Display()
    try:
        for name in options.page or PAGES:
            whole = np.vstack([np.hstack([picture(display, sources, SIZES.get(name, SIZE), *shot) for shot in row]) for row in PAGES[name]])
            file = REPOSITORY / f"docs/images/{name}.jpg"
            file.write_bytes(jpeg(whole, MOST_BYTES[name]))
            print(file)
    finally:
        display.close()


if __name__ == "__main__":
    run_as_program(main)
