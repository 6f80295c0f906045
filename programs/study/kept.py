"""What results, charts and pictures keep of what was measured: enough for every table, chart and page, in few bytes.

Numbers have eight digits: tables show six at most, and bytes at equal dB, which are interpolated, come out the same to a byte or nearly; a row of a list stands in one line, so that a change of one row is a change of one line.
"""

import json
import pathlib
import re
import xml.etree.ElementTree as ElementTree

from found import only_bounded
from steps import write_whole

DIGITS = 8
INTERVAL = ("mean_square", "mean_square_low", "mean_square_high", "db", "db_low", "db_high")
OF_PICTURES = ("width", "height", "frames", "identical", "psnr_mean_of_frames_db")
"""What `compare` says of pictures that every result says once, or that no table shows."""
WORST = ("whole_worst_percent", "noise_free_worst_percent")
SCORES = ("gaps", "flicker", *WORST, "milliseconds", "views")
"""Beside the errors: what stands in one experiment, `systems`, and is not repeated."""
NO_DISPLAY = "noise_free.display"
"""Methods are compared by linear values."""
LEFT_OUT = {"systems": (), "parity": (*SCORES, "renders", "commands"), "moved": (*SCORES, "renders", NO_DISPLAY), "where": ("renders", NO_DISPLAY),
            "parsimony": (*SCORES, "renders", NO_DISPLAY), "related": (*WORST, "flicker", "renders", NO_DISPLAY),
            "window": (*WORST, "gaps", "flicker", "views", "renders", "noise_free", "p95", "p99", "samples", "psnr_worst_percent_db", "ssim", "linear")}
"""Experiment -> what its results do not keep: a key, or one within another. Renders stand in `systems`."""


def lean(value, left_out=(), within=""):
    """A result without `left_out`, at any depth, and without what no table or chart reads."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, (list, tuple)):
        return [lean(each, left_out, within) for each in value]
    if not isinstance(value, dict):
        return value
    if "mean_square_low" in value:
        kept = [*INTERVAL, "only_bounded"] if only_bounded(value) else INTERVAL
        return {key: lean(value[key]) for key in kept if key in value}
    dropped = (*left_out, *(OF_PICTURES if "identical" in value else ()))
    return {key: lean(each, left_out, key) for key, each in value.items() if key not in dropped and f"{within}.{key}" not in dropped}


def result_text(result, lines=2):
    """JSON: the outer `lines` levels a line each, what is inside them without spaces."""
    def text(value, level):
        if level == lines or not isinstance(value, (dict, list, tuple)) or not value:
            return json.dumps(value, separators=(",", ":"))
        keys = [f"{json.dumps(str(key))}: " for key in value] if isinstance(value, dict) else [""] * len(value)
        rows = [f"\n{' ' * (level + 1)}{key}{text(each, level + 1)}" for key, each in zip(keys, value.values() if isinstance(value, dict) else value)]
        start, end = "{}" if isinstance(value, dict) else "[]"
        return f"{start}{','.join(rows)}\n{' ' * level}{end}"

    return text(lean(result), 0) + "\n"


def pictures_file(folder, scene):
    """A script and not JSON, since a page that is opened from a disk may load no other text."""
    return pathlib.Path(folder) / f"pictures/{scene}.js"


def write_pictures(folder, scene, pictures):
    """`pictures` as Pictures.all_of has them."""
    write_whole(pictures_file(folder, scene), "const pictures = " + json.dumps(pictures, indent=0).replace("</", "<\\/") + ";\n")


def read_pictures(folder, scene):
    """None where none were written."""
    file = pictures_file(folder, scene)
    return json.loads(file.read_text().removeprefix("const pictures = ").rstrip(";\n")) if file.exists() else None


def all_pictures(folder, scenes):
    """{scene: pictures} of those that have some."""
    return {scene: found for scene in scenes if (found := read_pictures(folder, scene))}


SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
LONG_NUMBER = re.compile(r"-?\d+\.\d{2,}")
COORDINATES = ("d", "x", "y", "width", "height", "transform", "points")
NO_TURN = "rotate(-0 "
FONTS = re.compile(r"font-family: [^;]*")
FEWER_FONTS = "font-family: DejaVu Sans,Verdana,sans-serif"
OF_WHOLE_GROUPS = re.compile(r"(?:^|[; ])opacity:")
"""Of a group this blends all that it holds at once, and is not handed down."""


def short_ids(text):
    """The text with what it refers to numbered in order, and those names; matplotlib's have eleven letters."""
    found = dict.fromkeys(re.findall(r'(?:url\(|href=")#([^)"]+)', text))
    names = {name: f"i{number}" for number, name in enumerate(found)}
    return re.sub(r'(\bid="|url\(#|href="#)([^)"]+)', lambda match: match[1] + names.get(match[2], match[2]), text), set(names.values())


def lean_path(data):
    """Without spaces around letters, and without those that go without saying: lines lead on from moves and lines."""
    lean, before = "", ""
    for letter, numbers in re.findall(r"([A-Za-z])([^A-Za-z]*)", data):
        lean += " " if letter == "L" and before in ("L", "M") else letter
        lean += numbers.strip()
        before = letter
    return lean


def lean_number(text):
    """A tenth of a point is enough where a chart's parts lie, and not for the shapes of its small marks."""
    number = float(text)
    return f"{number:.{1 if abs(number) >= 10 else 2}f}".rstrip("0").rstrip(".")


def lean_svg(text):
    """A chart of matplotlib's without groups that say nothing, metadata and digits below a tenth of a hundredth of an inch; looks become classes."""
    ElementTree.register_namespace("", SVG)
    ElementTree.register_namespace("xlink", XLINK)
    text, named = short_ids(text)
    root = ElementTree.fromstring(text)
    looks = {}
    for element in root.iter():
        if element.tag == f"{{{SVG}}}g" or element.get("id") not in named:
            element.attrib.pop("id", None)
        for key in COORDINATES:
            if key in element.attrib:
                element.set(key, LONG_NUMBER.sub(lambda found: lean_number(found[0]), " ".join(element.get(key).split())))
        if "d" in element.attrib:
            element.set("d", lean_path(element.get("d")))
        if element.get("transform", "").startswith(NO_TURN):
            element.attrib.pop("transform")
        if element is not root and "style" in element.attrib:
            look = FONTS.sub(FEWER_FONTS, element.attrib.pop("style"))
            element.set("class", looks.setdefault(look, f"a{len(looks)}"))
    inherited = {name for look, name in looks.items() if not OF_WHOLE_GROUPS.search(look)}
    for group in root.iter(f"{{{SVG}}}g"):
        share_class(group, inherited)
    unwrap(root)
    for element in root.iter():
        if element.tag != f"{{{SVG}}}text" and not (element.text or "").strip():
            element.text = None
        element.tail = "\n" if element.tag in (f"{{{SVG}}}{kind}" for kind in ("g", "path", "use", "text", "defs")) else None
    style = ElementTree.Element(f"{{{SVG}}}style")
    style.text = "*{stroke-linejoin:round;stroke-linecap:butt}" + "".join(f".{name}{{{look.replace(': ', ':').replace('; ', ';')}}}" for look, name in looks.items())
    root.insert(0, style)
    return ElementTree.tostring(root, encoding="unicode").replace(" />", "/>") + "\n"


def share_class(group, inherited):
    """Marks of one curve look alike: their group says the look once, where what it says is handed down."""
    classes = {child.get("class") if child.tag == f"{{{SVG}}}use" else None for child in group}
    if len(group) > 1 and len(classes) == 1 and classes <= inherited and "class" not in group.attrib:
        group.set("class", classes.pop())
        for child in group:
            child.attrib.pop("class")


def unwrap(parent):
    """Groups without attributes give way to what they hold; metadata and matplotlib's own style go."""
    kept = []
    for child in list(parent):
        unwrap(child)
        if child.tag == f"{{{SVG}}}g" and not child.attrib:
            kept += list(child)
        elif child.tag == f"{{{SVG}}}metadata" or (child.tag == f"{{{SVG}}}defs" and (not len(child) or all(each.tag == f"{{{SVG}}}style" for each in child))):
            continue
        else:
            kept.append(child)
    parent[:] = kept
