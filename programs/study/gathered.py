"""Frames that several programs rendered, each into a folder of its own, as one sequence."""

import json
import os
import pathlib
import shutil

from steps import Failed, read_json, write_whole

FIRST_FRAME = "first_frame"


def linked(file, target):
    """The same bytes under another name; copied where the file system has no links."""
    if target.exists():
        return
    try:
        os.link(file, target)
    except FileExistsError:
        pass
    except OSError:
        aside = target.with_name(f".{target.name}.aside")
        shutil.copyfile(file, aside)
        os.replace(aside, target)


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
        for stream in sorted(manifest.parent for manifest in pathlib.Path(part).glob("*/manifest.json")):
            frames = sorted(stream.glob("frame.*.exr"))
            if frames:
                add_stream(stream, frames, pathlib.Path(whole) / stream.name, command)


def add_stream(stream, frames, whole, command):
    whole.mkdir(parents=True, exist_ok=True)
    manifest, kept = read_json(stream / "manifest.json"), whole / "manifest.json"
    there = read_json(kept) if kept.exists() else None
    if not there or manifest[FIRST_FRAME]["index"] < there[FIRST_FRAME]["index"]:
        write_whole(kept, json.dumps({**manifest, **({"command": command} if command else {})}, indent=4) + "\n")
    for frame in frames:
        linked(frame, whole / frame.name)
