#!/usr/bin/env python3
"""Pictures of the viewer's window for docs/results/viewer.md: docs/images/viewer-*.jpg.

    screenshots.py --bin build/release/bin --source STREAM --scene SCENE.json

Every picture is what stands on a display (Xvfb) after keys were pressed, the text over it included.
"""

import argparse
import pathlib
import sys
import tempfile
import time

import numpy as np
from PIL import Image

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1]), str(REPOSITORY / "tests/golden"), str(REPOSITORY / "tests/golden/viewer")]
from display import Display, ViewerProcess  # noqa: E402
from steps import run_as_program  # noqa: E402

SIZE = (800, 450)
# File -> rows of pictures, each the options and keys that make it.
PAGES = {
    "viewer-layouts": [[(["--layout", "left"], []), (["--layout", "sbs"], [])], [(["--layout", "anaglyph"], []), (["--layout", "headset"], [])],
                       [(["--layout", "sphere"], []), (["--method", "sphere"], [])]],
    "viewer-overlays": [[(["--overlay", "depth"], []), (["--overlay", "gaps"], ["hold d"])], [(["--overlay", "reliability"], ["hold d"]), (["--fill", "off"], ["hold d"])],
                        [([], ["hold d", "x"]), ([], ["hold w"] * 5)]],
    "viewer-text": [[([], ["h"]), ([], ["t"])]],
}
HOLD_S = 2
MESSAGE_S = 5.5  # until what the viewer wrote is no longer told of


def picture(display, options, words, keys):
    with tempfile.TemporaryDirectory() as out:
        viewer = ViewerProcess(display, options.bin.resolve() / "equistream", out, options.source, "--scene", options.scene, "--paused", "--size",
                               f"{SIZE[0]}x{SIZE[1]}", *words)
        try:
            viewer.picture()
            for key in keys:
                viewer.hold(key.removeprefix("hold "), HOLD_S) if key.startswith("hold ") else viewer.press(key)
            viewer.picture()  # all that was pressed has been handled
            time.sleep(MESSAGE_S)
            return viewer.screen()[: SIZE[1], : SIZE[0]].astype(np.uint8)
        finally:
            viewer.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--source", required=True, help="what is shown")
    parser.add_argument("--scene", required=True)
    options = parser.parse_args()
    display = Display()
    try:
        for name, rows in PAGES.items():
            whole = np.vstack([np.hstack([picture(display, options, *shot) for shot in row]) for row in rows])
            file = REPOSITORY / f"docs/images/{name}.jpg"
            Image.fromarray(whole).save(file, quality=85)
            print(file)
    finally:
        display.close()


if __name__ == "__main__":
    run_as_program(main)
