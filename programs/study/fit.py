#!/usr/bin/env python3
"""Finds the cheapest settings for a wanted accuracy, measured on the scene itself, and writes them as a settings file for render, encode, play and view.

    equistream fit SCENE.json --db N [--out FILE.ini]
    equistream fit SCENE.json --kb N [--out FILE.ini]      the highest accuracy within N thousand bytes a frame

Accuracy is the whole error of docs/compare.md on linear values, both eyes together: noise counts, and so does a denoiser. What was measured stays in the work
folder, and another N goes on from there.
"""

import argparse
import contextlib
import json
import math
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from options import Parser, Progress, add_common, not_utf8, parse, typed_command  # noqa: E402
from steps import REPOSITORY, Failed, expect_packages, measured_json, provenance, read_json, run_as_program, scene_files, write_whole  # noqa: E402

FEWEST_PIXELS = 64
AUTO = "auto"
SLACK, INFO_FOV_DEG = 0.75, 90
"""Of the windows that `scene info` says (programs/scene/summary.cpp)."""


def in_range(low, high, kind=float):
    def number(text):
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= high:
            raise argparse.ArgumentTypeError(f"expected a number from {low:g} to {high:g}, found '{text}'")
        return value
    return number


def size(text):
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if not match or min(int(side) for side in match.groups()) < FEWEST_PIXELS:
        raise argparse.ArgumentTypeError(f"expected WxH of {FEWEST_PIXELS} pixels or more, found '{text}'")
    return tuple(int(side) for side in match.groups())


def window(text):
    if text == AUTO:
        return text
    match = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", text)
    sides = tuple(map(float, match.groups())) if match else (0, 0)
    if not (0 < sides[0] < 360 and 0 < sides[1] <= 180):
        raise argparse.ArgumentTypeError(f"expected {AUTO}, or WxH, degrees below 360 and up to 180, found '{text}'")
    return sides


def window_for(eye, fov_deg, info):
    """Degrees, as `scene info` has them for a view of 90: the view, what the head turns meanwhile, and the room that the gaze has before a window follows."""
    turned_deg = SLACK * info["window_deg"][0] - INFO_FOV_DEG
    half = math.tan(math.radians(fov_deg) / 2)
    sides = fov_deg, 2 * math.degrees(math.atan(half * eye[1] / eye[0]))
    return tuple(min(most, math.ceil((side + turned_deg) / SLACK)) for side, most in zip(sides, (359, 180)))


def frames(text):
    match = re.fullmatch(r"(\d+)-(\d+)", text)
    if not match or int(match[1]) > int(match[2]):
        raise argparse.ArgumentTypeError(f"expected FIRST-LAST, found '{text}'")
    return int(match[1]), int(match[2])


def arguments():
    parser = Parser(prog="equistream fit", description=__doc__.splitlines()[0],
                    epilog="example: equistream fit scenes/pavilion.json --db 27 --out pavilion.ini")
    parser.add_argument("scene", metavar="SCENE", type=pathlib.Path, help="scene description (JSON)")
    wanted = parser.add_mutually_exclusive_group(required=True)
    wanted.add_argument("--db", type=in_range(1, 80),
                        help="the accuracy wanted: whole error on linear values, both eyes together, in dB (docs/compare.md)")
    wanted.add_argument("--kb", type=in_range(0.1, 1e6), metavar="N",
                        help="instead of --db: the highest accuracy within N thousand bytes a frame, to a quarter of a dB; a model's bytes are divided among the path's frames")
    parser.add_argument("--out", type=pathlib.Path, help="settings file to write; the client's model, if one is chosen, comes beside it; default: NAME-fit.ini")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders, streams and views, which can be removed afterwards; default: NAME-fit")
    parser.add_argument("--eye-size", type=size, default=(640, 360), metavar="WxH", help="size of each eye's view in pixels, for which the settings are found (640x360)")
    parser.add_argument("--fov", type=in_range(1, 170), default=90.0, metavar="DEG", help="horizontal field of view of each eye, degrees (90)")
    parser.add_argument("--frames", type=frames, metavar="A-B", help="frames to measure; default: two in the middle of the path")
    parser.add_argument("--truth-spp", type=in_range(1, 65536, int), default=64, metavar="N", help="samples a pixel of both truths (64); more samples measure the error more precisely")
    parser.add_argument("--most-spp", type=in_range(1, 65536, int), default=64, metavar="N", help="samples a pixel of the spheres tried, at most (64)")
    parser.add_argument("--codec", choices=("h264", "h265"), default="h264", help="codec of the stream (h264)")
    parser.add_argument("--widest", type=in_range(0.5, 8), default=2 ** 0.5, metavar="TIMES",
                        help="the widest sphere tried, in units of 2 pi f columns, where f is the focal length in pixels (1.41)")
    parser.add_argument("--window", type=window, metavar="WxH",
                        help="also try a window of this many degrees around the gaze, in a coarse sphere, and take it if it has fewer bytes; auto: large enough for the view and the head's fastest turn")
    add_common(parser)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    options = parse(parser, "fit")
    options.info = scene_info(parser, options)
    if options.window == AUTO:
        options.window = window_for(options.eye_size, options.fov, options.info)
    last = path_frames(options) - 1
    middle = max(0, last // 2)
    options.frames = options.frames or (middle, min(middle + 1, last))
    if options.frames[1] > last:
        parser.error(f"argument --frames: expected at most {last}, the path's last, found {options.frames[1]}")
    options.out = options.out or pathlib.Path(f"{options.scene.stem}-fit.ini")
    options.work = options.work or pathlib.Path(f"{options.scene.stem}-fit")
    require_place(parser, options)
    return options


def model_files(out):
    """Where the client's model comes, if one is chosen: its description and its geometry."""
    return [out.with_name(f"{out.stem}-model{end}") for end in (".json", ".glb")]


def require_place(parser, options):
    """Before hours are spent: for the settings file and what comes beside it."""
    out = options.out
    if not out.resolve().parent.is_dir() or out.is_dir():
        parser.error(f"argument --out: expected a file in a folder that is there, found {out}")
    if not os.access(out.resolve().parent, os.W_OK):
        parser.error(f"argument --out: expected a folder that may be written, found {out.resolve().parent}")
    for made in (out, *model_files(out)):
        if made.exists() and any(made.samefile(file) for file in scene_files(options.scene)):
            parser.error(f"argument --out: expected names that are not the scene's, found {made}")
    paths = [str(path.resolve()) for path in (out, options.scene, options.work)]  # settings files name them
    if (found := not_utf8([*paths, typed_command("fit")])) is not None:
        parser.error(f"expected paths and words in UTF-8, as settings files are, found '{found}'; rename what they name")
    for path in paths:
        if path.splitlines() != [path] or {'"', "'"} <= set(path):
            parser.error(f"expected a path without line ends and without both kinds of quotes, found {path!r}")


def scene_info(parser, options):
    done = subprocess.run([options.bin / "equistream", "scene", "info", options.scene, "--json"], capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        parser.error((done.stderr.strip().splitlines() or ["no message"])[-1].removeprefix("equistream scene: "))
    info = json.loads(done.stdout)
    if "fingerprint" not in info:
        parser.error(f"{options.scene}: expected a scene description (JSON), found a scene in Mitsuba's XML")
    return info


def path_frames(options):
    rate = read_json(options.scene).get("frames_per_second", 30)
    return math.floor(options.info["path_duration_s"] * rate + 1e-6) + 1  # as `render` counts them (make_timeline)


def keep_model(chosen, work, out):
    """The chosen model beside the settings file: a description, and the geometry that it names by itself."""
    kept, geometry = model_files(out)
    made = work.folder / chosen.model_file
    description = json.loads(made.read_text())
    write_whole(geometry, made.with_suffix(".glb").read_bytes())
    write_whole(kept, json.dumps({**description, "model": geometry.name}) + "\n")
    return kept.resolve()


def require_same_scene(options):
    """Failed where it is another one than when measuring began: some of the figures are the one's, some the other's."""
    found = measured_json(options.bin / "equistream", ["scene", "info", options.scene.resolve(), "--json"], ".")["fingerprint"]
    if found != options.info["fingerprint"]:
        raise Failed(f"{options.scene}: expected the scene as it was when measuring began, found it changed; run it again")


def main():
    options = arguments()
    expect_packages("fit")
    from fitting.choice import Fit, Unreachable, best_for_bytes  # what needs these packages
    from fitting.report import chosen_text, n_text, report, sections_of, times_text, unreachable_text, write_settings
    from fitting.trial import tried_file
    from fitting.work import Asked, FitWork, Measurer
    began = time.time()
    limit = 1000 * options.kb if options.kb else None
    asked = Asked(options.eye_size, options.fov, *options.frames, options.truth_spp, options.most_spp, options.widest, options.window)
    with contextlib.redirect_stdout(sys.stderr):
        work = FitWork(options.work, options.bin, options.scene, options.info["fingerprint"], asked, Progress("fit", options.progress))
        measure = Measurer(work, options.codec)

        def fit_for(level):
            return Fit(work, asked, options.codec, level, path_frames(options), measure)

        if limit:
            fit, chosen = best_for_bytes(limit, fit_for)
        else:
            fit = fit_for(options.db)
            try:
                chosen = fit.run()
            except Unreachable as short:
                raise Failed(unreachable_text(short.best, fit)) from None
        fit.begin("trial")
        chosen = tried_file(fit, chosen, options.db, limit)
    require_same_scene(options)
    said = "\n".join([*report(fit, chosen), times_text(work, began, time.time())])
    if chosen.model_px:
        chosen.geometry_file = keep_model(chosen, work, options.out)
    command = typed_command("fit")
    remarks = [f"{command}, measured {time.strftime('%Y-%m-%d', time.gmtime())}", chosen_text(chosen, fit), n_text(asked)]
    write_settings(options.out, remarks, sections_of(chosen, asked, options.codec))
    if options.json:
        point = chosen.point
        print(json.dumps({"settings_file": str(options.out), "wanted_db": options.db, "wanted_kb": options.kb, "db": point.db, "db_low": point.low, "db_high": point.high, "frames": options.frames, "columns": chosen.width, "samples": chosen.light.samples, "denoise": chosen.light.denoise,
                          "codec": options.codec, "crf": chosen.crf, "fill": chosen.fill.passes, "seeds": chosen.trials, "bytes_a_frame": point.bytes, "bytes_once": chosen.bytes_once, "bytes_a_frame_in_all": chosen.bytes_a_frame(fit.path_frames),
                          "reflections": chosen.told, "window": chosen.point.way.window, "why": fit.why, "seconds": round(time.time() - began, 1),
                          "command": command, **provenance(options.bin, REPOSITORY)}, indent=1))
        return
    print(said)
    print(f"\nwritten: {options.out}\n{use_of(options.scene, options.out)}")


def use_of(scene, settings):
    """The commands that use the file, to copy into a shell."""
    scene, settings, video = (shlex.quote(f"./{path}" if str(path).startswith("-") else str(path)) for path in (scene, settings, f"{scene.stem}.mp4"))
    return (f"  equistream render {scene} --settings {settings} --out frames\n"
            f"  equistream encode frames --settings {settings} --out {video}\n"
            f"  equistream play {video} --settings {settings} --out eyes      (or view)")


if __name__ == "__main__":
    run_as_program(main, "equistream fit")
