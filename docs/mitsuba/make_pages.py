#!/usr/bin/env python3
"""Writes a page for each plugin of Mitsuba from its manual, the comment that its source begins with.

    make_pages.py [--check]

The comment is written as Mitsuba's own plugins are documented (reStructuredText). --check writes nothing and
fails where a page is not what the sources say. Pictures are make_pictures.py's.
"""

import argparse
import pathlib
import re
import sys
import textwrap

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = HERE.parents[1] / "host-adapters/mitsuba3/plugins"
PICTURES = {
    "equirect": "A room as one sphere; below it both eyes of VR180, and a band of rows",
    "equirect_aov": "One sphere: colour, depth, normals, albedo, ids, motion, mirrors, virtual depth",
}
TEX = {r"\pi": "pi", r"\cos": "cos", r"\sin": "sin", r"\qquad": " ", r"\quad": " ", r"\;": "", r"\,": ""}


def manual(name):
    """The lines of the comment."""
    return re.match(r"/\*\*!\n(.*?)\n \*/", (SOURCES / f"{name}.cpp").read_text(), re.S)[1].splitlines()


def plain_tex(text):
    for mark, word in TEX.items():
        text = text.replace(mark, word)
    return re.sub(r" +", " ", text).strip()


def inline(text):
    text = re.sub(r":math:`([^`]+)`", lambda found: f"``{plain_tex(found[1])}``", text)
    text = re.sub(r":\w+:`([^`]+)`", r"``\1``", text)
    return re.sub(r"``([^`]+)``", r"`\1`", text)


def parameters(name):
    """Names, type, meaning and whether it is exposed, one entry a row of the table."""
    rows = []
    for line in block(manual(name), ".. pluginparameters::"):
        if line.startswith(" * - "):
            rows.append([line[5:]])
        elif line.startswith("   - "):
            rows[-1].append(line[5:])
        elif line.strip():
            rows[-1][-1] += " " + line.strip()
    return [{"names": re.findall(r"\w+", row[0]) if not row[0].startswith("(") else [], "title": row[0], "type": row[1].replace("|", ""), "meaning": row[2],
             "exposed": "|exposed|" in row[3:]} for row in rows]


def documented(name):
    """By name: the row of the table. A row may say under which other name a parameter is exposed."""
    return {word: row for row in parameters(name) for word in row["names"] + re.findall(r"[Ee]xposed as ``(\w+)``", row["meaning"])}


def asked_for(name):
    """What the plugin reads from a scene file or exposes, by its source."""
    return set(re.findall(r'(?:props\.(?:get<[^(]*|has_property)|cb->put)\("(\w+)"', (SOURCES / f"{name}.cpp").read_text())) - {"nested"}


def block(lines, begin):
    """What belongs to a directive: all lines up to the first paragraph that is not indented."""
    at = lines.index(begin) + 1
    end = next((i for i in range(at + 1, len(lines)) if lines[i] and not lines[i].startswith(" ") and not lines[i - 1].strip()), len(lines))
    return lines[at:end]


def table(name):
    rows = [f"| {', '.join(f'`{word}`' for word in row['names']) or row['title']} | {inline(row['type'])} | {inline(row['meaning'])} | {'yes' if row['exposed'] else ''} |"
            for row in parameters(name)]
    return ["| parameter | type | meaning | exposed |", "|---|---|---|---|", *rows]


def fence(language, lines):
    return [f"```{language}", *textwrap.dedent("\n".join(lines)).strip("\n").splitlines(), "```", ""]


def tabs(lines):
    """The examples in Python are parts of a dictionary, no whole Python: the tests of pages compile what is called `python`."""
    out = []
    for language, code in re.findall(r"    \.\. code-tab:: (\w+)\n(.*?)(?=\n    \.\. |\Z)", "\n".join(lines), re.S):
        out += fence(language.replace("python", "py"), code.splitlines())
    return out


def wrapped(text, first="", rest=""):
    return textwrap.wrap(inline(text), 100, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False, break_long_words=False)


def prose(lines):
    """Paragraphs, formulas, code and lists."""
    out = []
    for part in re.split(r"\n\s*\n", "\n".join(lines).strip("\n")):
        if part.startswith(".. "):
            pending = "text"
        elif part.startswith("    "):
            out += fence(pending, [plain_tex(line) if "\\" in line else line for line in part.splitlines()])
        elif part.startswith("- "):
            for item in re.split(r"\n(?=- )", part):
                out += wrapped(" ".join(item[2:].split()), "- ", "  ")
            out.append("")
        else:
            out += [*wrapped(" ".join(part.split())), ""]
    return out


def page(name):
    lines = manual(name)
    title = re.sub(r" \(:monosp:.*", "", lines[lines.index("", 1) + 1])
    table_end = lines.index(".. pluginparameters::") + 1 + len(block(lines, ".. pluginparameters::"))
    at, limits = lines.index(".. tabs::"), lines.index("Limits:")
    return "\n".join([
        f"# {name}: {title[0].lower()}{title[1:]}", "", f"<!-- made by docs/mitsuba/make_pages.py of host-adapters/mitsuba3/plugins/{name}.cpp -->", "",
        f"![{PICTURES[name]}]({name}.jpg)", "", *prose(lines[table_end:at]), "## Parameters", "",
        "Exposed parameters may be changed between frames, by `mi.traverse(scene)`.", "", *table(name), "", "## Example", "", *tabs(lines[at:limits]),
        "## Limits", "", *prose(lines[limits + 1:]), "How Mitsuba finds the plugin: [Mitsuba 3](../mitsuba.md#making-them-found)."]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    for name in PICTURES:
        missing = sorted(asked_for(name) - set(documented(name)))
        if missing:
            sys.exit(f"host-adapters/mitsuba3/plugins/{name}.cpp: expected the manual to name all parameters, found nothing of {', '.join(missing)}")
    stale = [name for name in PICTURES if not (HERE / f"{name}.md").exists() or (HERE / f"{name}.md").read_text() != page(name)]
    if options.check and stale:
        sys.exit(f"docs/mitsuba: {', '.join(stale)}: not what the plugin's source says now.\nRun docs/mitsuba/make_pages.py and commit what it writes.")
    for name in stale:
        (HERE / f"{name}.md").write_text(page(name))


if __name__ == "__main__":
    main()
