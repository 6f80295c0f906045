"""The page of one scene, where a point of a chart shows its command and its pictures: an HTML file and, beside it, pictures/SCENE.js."""

import html
import json
import pathlib

from found import all_bytes, ceiling_psnr, coding_name, db, error, ms, psnr
from kept import lean
from render_list import EYES
from steps import write_whole
from tables.systems import flicker_db

TEMPLATE = pathlib.Path(__file__).with_name("page.html")


def point(entry, titles):
    figures = error(entry)
    return {"system": entry["system"], "title": titles[entry["system"]], "coding": coding_name(entry), "width": entry["width"], "ms": ms(entry),
            "bytes": all_bytes(entry), "noise_free": db(entry), "bounded": figures["only_bounded"], "low": figures["db_low"], "high": figures["db_high"],
            "psnr": psnr(entry), "ssim": [entry["against_other_seed"][eye]["ssim"] for eye in EYES],
            "flip": [entry["perceived"][eye]["flip"] for eye in EYES], "flicker": flicker_db(entry),
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
