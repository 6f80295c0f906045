#!/usr/bin/env python3
"""Makes a loop of what the demo's chain played at its places of the head: turned only beside with depth.

    EQUISTREAM_DEMO_SPP=48 ./demo
    build/venv/bin/python3 docs/demo/loop.py demo-out docs/images/parallax.webp
"""

import pathlib
import sys

from PIL import Image, ImageDraw, ImageFont

SIZE = (384, 216)
MILLISECONDS = 90
LABEL = 24


def beside(out, place):
    sides = {"turned only": min((out / "rotated/left").glob("*.png")), "with depth": next((out / "moved" / place / "left").glob("*.png"))}
    canvas = Image.new("RGB", (2 * SIZE[0] + 4, SIZE[1] + LABEL), "#16171a")
    for i, (text, file) in enumerate(sides.items()):
        picture = Image.open(file).convert("RGB")
        canvas.paste(picture.resize(SIZE, Image.Resampling.LANCZOS), (i * (SIZE[0] + 4), LABEL))
        ImageDraw.Draw(canvas).text((i * (SIZE[0] + 4) + 6, 3), text, "#e8e6e1", ImageFont.load_default(15))
    return canvas


def main():
    out, file = map(pathlib.Path, sys.argv[1:3])
    there = [beside(out, csv.stem) for csv in sorted((out / "heads").glob("*.csv"))]
    frames = there + there[-2:0:-1]
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0, quality=50, method=6)
    print(f"{file}: {frames[0].size[0]}x{frames[0].size[1]}, {len(frames)} frames, {file.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
