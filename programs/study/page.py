"""The page of one scene, where a point of a chart shows its command and its pictures: an HTML file and, beside it, pictures/SCENE.js.

Pictures are small: the right eye of the middle frame beside the truth, their difference and the gaps.
"""

import base64
import html
import io
import json
import pathlib

import equistream as es
import numpy as np
from drawing import rgb
from found import KINDS, WHOLE, all_bytes, ceiling_psnr, coding_name, db, error, ms, only_bounded, psnr, ssim
from kept import lean
from PIL import Image
from render_list import EYES
from steps import write_whole
from tables.systems import flicker_db

TEMPLATE = pathlib.Path(__file__).with_name("page.html")


def level(entry, kind):
    """dB, whether that is a bound, and the ends of its interval; None where this kind was not measured. The whole error is of display values."""
    scale = "display" if kind == WHOLE else "linear"
    figures = error(entry, scale=scale, kind=kind)
    return figures and {"db": db(entry, scale=scale, kind=kind), "bounded": only_bounded(figures), "low": figures["db_low"], "high": figures["db_high"]}


def point(entry, titles):
    return {"system": entry["system"], "title": titles[entry["system"]], "coding": coding_name(entry), "width": entry["width"], "ms": ms(entry),
            "bytes": all_bytes(entry), **{kind: level(entry, kind) for kind in KINDS}, "psnr": psnr(entry), "ssim": [ssim(entry, eye) for eye in EYES],
            "flip": [entry["perceived"][eye]["flip"] for eye in EYES], "flicker": [flicker_db(entry, kind) for kind in KINDS],
            "gaps": [entry["gap_fraction"][eye] for eye in EYES], "n": entry["n"], "commands": [command for pair in entry["commands"] for command in pair],
            "view": entry["views"][0]}


def write_page(result, colours, file):
    data = {"scene": result["scene"], "settings": result["settings"], "machine": result["machine"], "versions": result["versions"], "made": result["made"],
            "ceiling": ceiling_psnr(result), "colours": {name: colour for name, colour in colours.items() if name in result["titles"]}, "points": [point(entry, result["titles"]) for entry in result["systems"]]}
    # What is in a script element ends at the first "</".
    text = json.dumps(lean(data), separators=(",", ":")).replace("</", "<\\/")
    page = TEMPLATE.read_text().replace("@TITLE@", html.escape(f"equistream study: {result['scene']}")).replace("@SCENE@", html.escape(result["scene"])).replace("@DATA@", text)
    write_whole(file, page)
    print(file)


EYE = "right"
ANAGLYPH_QUALITY, ANAGLYPH_WIDTH = 60, 480
DIFFERENCE_GAIN = 4
LOOKS, LARGEST = ((60, 256), (45, 256), (35, 256), (25, 256), (20, 256), (20, 208), (20, 160)), 500_000
"""Quality of AVIF and columns, the first with which all pictures of a page are no larger, characters, or else the last: noise takes many."""
OTHER_SEED = 2
"""Of the truth: views are of the first, and none may share its noise."""


def data_uri(pixels, width, resampling=Image.Resampling.BOX, kind="avif", **coding):
    """A picture of rows x columns x 3, or of gaps, rows x columns, as text."""
    image = Image.fromarray(pixels)
    height = round(image.height * width / image.width)
    image = image.resize((width, height), resampling)
    data = io.BytesIO()
    image.save(data, kind.upper(), **coding)
    return f"data:image/{kind};base64," + base64.b64encode(data.getvalue()).decode()


def amplified(difference, width):
    """A difference of -255 to 255, averaged over a small picture's pixels while it has its sign, so that what is noise alone fades."""
    size = width, round(difference.shape[0] * width / difference.shape[1])
    small = [Image.fromarray(channel).resize(size, Image.Resampling.BOX) for channel in np.moveaxis(difference, -1, 0)]
    return np.clip(DIFFERENCE_GAIN * np.abs(np.stack(small, axis=-1)), 0, 255).astype(np.uint8)


def file_of(folder, number):
    return next(folder.glob(f"frame.{number:04}.*"))


class Pictures:
    """Of one scene. `truth` is shown beside all."""

    def __init__(self, work):
        self.work = work
        self.number = (work.first + work.last) // 2
        frame = es.read_frame(file_of(work.folder / work.truth(OTHER_SEED) / EYE, self.number))
        self.truth = es.to_display(frame["colour"], frame.info.exposure)

    def of(self, view, quality, width):
        """What play wrote for the first seed."""
        folder = self.work.folder / view
        seen = rgb(file_of(folder / EYE, self.number))
        found = {"seen": data_uri(seen, width, quality=quality), "difference": data_uri(amplified(seen.astype(np.float32) - self.truth, width), width, quality=quality)}
        gaps = folder / "gaps" / EYE
        if gaps.exists() and (mask := np.asarray(Image.open(file_of(gaps, self.number)).convert("L"))).any():
            found["gaps"] = data_uri(mask, width, resampling=Image.Resampling.NEAREST, kind="webp", lossless=True, method=6)
        return found

    def anaglyph(self, played):
        """What the first seed's `played`, frames with both eyes in one picture, shows of the same frame."""
        return data_uri(rgb(file_of(self.work.folder / played / "both", self.number)), ANAGLYPH_WIDTH, quality=ANAGLYPH_QUALITY)

    def all_of(self, entries, anaglyph):
        for quality, width in LOOKS:
            found = self.all_with(quality, width, entries, anaglyph)
            if len(json.dumps(found)) <= LARGEST:
                break
        return found

    def all_with(self, quality, width, entries, anaglyph):
        return {"anaglyph": self.anaglyph(anaglyph), "frame": self.number, "eye": EYE, "gain": DIFFERENCE_GAIN, "truth": data_uri(self.truth, width, quality=quality),
                "views": {entry["views"][0]: self.of(entry["views"][0], quality, width) for entry in entries}}
