"""Frames that several programs rendered, each into a folder of its own, as one sequence."""

import json
import os
import pathlib
import re
import shutil

from steps import Failed, made_whole, read_json, write_whole

FIRST_FRAME = "first_frame"
FRAME = re.compile(r"frame\.(\d+)\.exr")


def linked(file, target):
    """The same bytes under another name; copied where the file system has no links."""
    if target.exists():
        return
    try:
        os.link(file, target)
    except FileExistsError:
        pass
    except OSError:
        with made_whole(target) as aside:
            shutil.copyfile(file, aside)


GEOMETRY = "scene.glb", "scene.json"
"""What Mitsuba's host writes of a scene in XML, beside its streams."""


def require_one_render(part, whole):
    """Failed where a stream that has frames in the part has other settings in the whole."""
    for stream in sorted(manifest.parent for manifest in pathlib.Path(part).glob("*/manifest.json")):
        kept = pathlib.Path(whole) / stream.name / "manifest.json"
        if kept.exists() and any(stream.glob("frame.*.exr")) and read_json(kept)["fingerprint"] != read_json(stream / "manifest.json")["fingerprint"]:
            raise Failed(f"{stream}/manifest.json: expected the settings and the build of the renderer of {kept}, found others; render it again, or choose another folder")


def gather(parts, whole, command=None):
    """Links what folders of renders hold into the render `whole`. Its manifest is that of the frame with the lowest number, and says `command`."""
    for part in sorted(parts):
        require_one_render(part, whole)
        for file in (pathlib.Path(part) / name for name in GEOMETRY):
            if file.exists():
                pathlib.Path(whole).mkdir(parents=True, exist_ok=True)
                linked(file, pathlib.Path(whole) / file.name)
        add_streams(part, whole, command=command)


def take_over(part, whole, first, last):
    """Links these frames alone, for a render that goes on with them: what lies beside streams it writes itself."""
    require_one_render(part, whole)
    add_streams(part, whole, range(first, last + 1))


def add_streams(part, whole, only=None, command=None):
    """`only`: numbers of the frames that are wanted."""
    for stream in sorted(manifest.parent for manifest in pathlib.Path(part).glob("*/manifest.json")):
        numbers = {int(match[1]): file for file in stream.glob("frame.*.exr") if (match := FRAME.fullmatch(file.name))}
        if frames := [numbers[number] for number in sorted(numbers) if only is None or number in only]:
            add_stream(stream, frames, pathlib.Path(whole) / stream.name, command)


def add_stream(stream, frames, whole, command):
    whole.mkdir(parents=True, exist_ok=True)
    manifest, kept = read_json(stream / "manifest.json"), whole / "manifest.json"
    there = read_json(kept) if kept.exists() else None
    if not there or manifest[FIRST_FRAME]["index"] < there[FIRST_FRAME]["index"]:
        write_whole(kept, json.dumps({**manifest, **({"command": command} if command else {})}, indent=4) + "\n")
    for frame in frames:
        linked(frame, whole / frame.name)
