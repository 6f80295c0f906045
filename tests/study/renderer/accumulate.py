#!/usr/bin/env python3
"""What memory between frames gains and costs (docs/results/accumulate.json, tables of accumulate.md): noise, error and flicker of a walk, a still head, a lamp that
is switched off; and what it gives a live viewer at the rate that spheres had without it.

    accumulate.py --bin build/release/bin --work FOLDER [--scenes NAME,...] [--live] [--page]
    --live: that alone; --page: only write the tables anew

All errors are of display values, weighted by solid angle.
"""

import argparse
import itertools
import json
import math
import pathlib
import re
import sys

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from denoise import FOV, VIEW, Programs, whole_error  # noqa: E402
from kept import result_text  # noqa: E402
from pages import table  # noqa: E402
from presets import REAL_SCENES  # noqa: E402
from steps import machine, versions, write_whole  # noqa: E402

SIZE, SAMPLES, FRAMES, MEMORY, QUALITY = "480x240", 4, 16, 32, "balanced"
SMALL, STILL_FRAMES, LAMP_OFF, LAMP_FRAMES = "240x120", 64, 30, 60
LIVE = {"kitchen": (4.5, (1,)), "voxel-city": (3.4, (8, 2))}
"""Scene -> spheres a second that `serve` gave on two cores, as rendered with the first of the samples (docs/guide/serve.md); samples that are tried."""
LIVE_SIZES, LIVE_FRAMES, LIVE_TRUTH_SAMPLES, LIVE_TRUTH_SEEDS = ("340x170", SIZE, "680x340"), 12, 128, (101, 102)
LIVE_WAYS = {"as rendered": (), "accumulated": ("--accumulate", MEMORY), "denoised": ("--denoise", "fast"), "both": ("--accumulate", MEMORY, "--denoise", "fast")}
ROOM = ("mtllib room.mtl\no room\nusemtl wall\n" + "".join(f"v {x} {y} {z}\n" for x in (-2, 2) for y in (0, 3) for z in (-3, 3)) +
        "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
        "o lamp\nusemtl warm\nv -1.5 2.9 -1.5\nv -0.5 2.9 -1.5\nv -0.5 2.9 -0.5\nv -1.5 2.9 -0.5\nf 9 10 11 12\n"
        "o other\nusemtl cool\nv 0.8 2.9 1\nv 1.6 2.9 1\nv 1.6 2.9 1.8\nv 0.8 2.9 1.8\nf 13 14 15 16\n")
PAINT = "newmtl wall\nKd 0.6 0.6 0.6\nnewmtl warm\nKd 0 0 0\nKe 9 7 5\nnewmtl cool\nKd 0 0 0\nKe 3 4 5\n"


def rendered(programs, out, scene, *words):
    """Once."""
    if not list(out.glob("centre/frame.*.exr")):
        programs.run("render", scene, *words, "--out", out)
    return out


class Sequence:
    def __init__(self, folder, first_plane="colour"):
        import equistream as es
        self.es, self.folder, self.first_plane = es, folder, first_plane

    def planes(self, index, *names):
        return self.es.read_frame(self.folder / f"centre/frame.{index:04d}.exr", names)

    def shown(self, index, plane=None):
        frame = self.planes(index, plane or self.first_plane)
        return self.es.to_display(np.ascontiguousarray(frame[plane or self.first_plane][..., :3]), frame.info.exposure).astype(float) / 255


def weights(height):
    """By solid angle, 1 on average."""
    rows = np.cos((np.arange(height) + 0.5 - height / 2) / height * np.pi)[:, None]
    return rows / rows.mean()


def mean_square(difference, where=None):
    weight = weights(difference.shape[0]) * (np.ones(difference.shape[:2]) if where is None else where)
    return float(np.sum(np.mean(difference**2, -1) * weight) / np.sum(weight))


def decibels(ratio):
    return float(10 * np.log10(ratio))


def moved(picture, motion):
    """Bilinear, wrapped round the seam, at x + motion(x)."""
    height, width = picture.shape[:2]
    u, v = np.arange(width)[None] + motion[..., 0], np.clip(np.arange(height)[:, None] + motion[..., 1], 0, height - 1.001)
    left, top = np.floor(u).astype(int), np.floor(v).astype(int)
    right, down = (u - left)[..., None], (v - top)[..., None]
    at = lambda dx, dy: picture[top + dy, (left + dx) % width]  # noqa: E731
    return (at(0, 0) * (1 - right) + at(1, 0) * right) * (1 - down) + (at(0, 1) * (1 - right) + at(1, 1) * right) * down


def flicker(pair):
    """Between consecutive frames after motion, where the same thing is seen: root mean square. Two seeds' difference: without what is no noise."""
    squares = []
    for index in range(FRAMES // 2, FRAMES):
        frame, before = pair[0].planes(index, "backward", "instance_id"), pair[0].planes(index - 1, "instance_id")
        ids = before["instance_id"][..., None].astype(float)
        same = np.abs(moved(ids, frame["backward"])[..., 0] - frame["instance_id"]) < 1e-6
        now, then = (pair[0].shown(i) - pair[1].shown(i) for i in (index, index - 1))
        squares.append(mean_square(now - moved(then, frame["backward"]), same) / 2)
    return float(np.sqrt(np.mean(squares)))


def walk(programs, scene, work):
    common = ["--size", SIZE, "--spp", SAMPLES, "--frames", f"0-{FRAMES - 1}", "--denoise", QUALITY]
    alone, kept = ([Sequence(rendered(programs, work / f"{name}-{seed}", scene, *common, "--seed", seed, "--aovs", aovs, *more)) for seed in (1, 2)]
                   for name, aovs, more in (("alone", "raw,motion,ids", ()), ("kept", "raw,motion,ids,samples,variance", ("--accumulate", MEMORY))))
    one = ["--size", SIZE, "--frames", FRAMES - 1, "--aovs", "none"]
    truth = Sequence(rendered(programs, work / "truth", scene, *one, "--spp", 256, "--seed", 9)).shown(FRAMES - 1)
    fresh = Sequence(rendered(programs, work / "fresh", scene, *one, "--spp", SAMPLES * FRAMES, "--seed", 5)).shown(FRAMES - 1)
    noise = lambda pair, index, plane: mean_square(pair[0].shown(index, plane) - pair[1].shown(index, plane)) / 2  # noqa: E731
    gains = {str(n): decibels(noise(alone, n - 1, "raw") / noise(kept, n - 1, "raw")) for n in (1, 2, 4, 8, FRAMES)}
    samples = kept[0].planes(FRAMES - 1, "samples")["samples"]
    full = samples >= 0.75 * SAMPLES * FRAMES
    last = kept[0].shown(FRAMES - 1, "raw")
    error = lambda picture, where=None: decibels(1 / mean_square(picture - truth, where))  # noqa: E731
    return {"noise_gain_db_after_frames": gains, "full_memory_share": float(np.mean(full * weights(full.shape[0]))),
            "error_db": {"accumulated": error(last), "fresh": error(fresh), "one_frame": error(alone[0].shown(FRAMES - 1, "raw")),
                         "accumulated_full_memory": error(last, full), "fresh_full_memory": error(fresh, full)},
            "denoised_error_db": {"accumulated": error(kept[0].shown(FRAMES - 1)), "one_frame": error(alone[0].shown(FRAMES - 1))},
            "denoised_flicker": {"accumulated": flicker(kept), "one_frame": flicker(alone)}}


def still(programs, scene, work):
    path = work / "still.csv"
    if not path.exists():
        rows = scene.with_suffix(".csv").read_text().splitlines()
        first = next(row for row in rows if re.match(r"[-0-9]", row))
        path.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "\n".join(f"{time}," + first.split(",", 1)[1] for time in ("0", "10")) + "\n")
    common = ["--path", path, "--size", SMALL]
    kept = Sequence(rendered(programs, work / "still", scene, *common, "--frames", f"0-{STILL_FRAMES - 1}", "--spp", SAMPLES, "--accumulate", MEMORY, "--aovs", "samples"))
    truths = [Sequence(rendered(programs, work / f"still-{seed}", scene, *common, "--frames", "0", "--spp", SAMPLES * STILL_FRAMES, "--seed", seed, "--aovs", "none")).shown(0) for seed in (11, 12)]
    off = mean_square(kept.shown(STILL_FRAMES - 1) - truths[0])
    return {"samples": float(np.mean(kept.planes(STILL_FRAMES - 1, "samples")["samples"])), "difference_db": decibels(1 / off),
            "difference_of_two_renders_db": decibels(1 / mean_square(truths[1] - truths[0]))}


def lamp(programs, work):
    """A room with two lamps; one leaves between two frames, before a still head."""
    work.mkdir(parents=True, exist_ok=True)
    (work / "room.obj").write_text(ROOM)
    (work / "room.mtl").write_text(PAINT)
    keys = [(0, 0), ((LAMP_OFF - 1) / 30, 0), (LAMP_OFF / 30, 100), (10, 100)]
    pose = {"orientation_wxyz": [1, 0, 0, 0]}
    scene = work / "room.json"
    scene.write_text(json.dumps({"name": "room", "model": "room.obj", "sky": {"radiance": [0, 0, 0]}, "frames_per_second": 30, "exposure": 1, "head_box": {"lean_m": 0.1},
                                 "camera": {"keys": [{"time_s": t, "position_m": [0, 1.5, 0], **pose} for t in (0, 2)]},
                                 "moving": [{"object": "lamp", "keys": [{"time_s": t, "position_m": [0, y, 0], **pose} for t, y in keys]}]}))
    common = [scene, "--size", SMALL]
    kept = Sequence(rendered(programs, work / "kept", *common, "--frames", f"0-{LAMP_FRAMES - 1}", "--spp", SAMPLES, "--accumulate", MEMORY, "--aovs", "none"))
    before, after = (kept.es.read_frame(rendered(programs, work / f"truth-{i}", *common, "--frames", i, "--spp", 128, "--seed", 7, "--aovs", "none") / f"centre/frame.{i:04d}.exr", "colour")["colour"][..., :3].astype(float)
                     for i in (LAMP_OFF - 1, LAMP_FRAMES - 1))
    weight = weights(before.shape[0])[..., None] * (np.abs(before) < 1)  # without the lamps themselves
    left = [float(np.sum((kept.planes(i, "colour")["colour"][..., :3] - after) * weight) / np.sum((before - after) * weight)) for i in range(LAMP_OFF, LAMP_FRAMES)]
    return {"left_after_frames": left, "frames_until_95_percent_is_forgotten": next(i + 1 for i in range(len(left)) if max(map(abs, left[i:])) < 0.05)}


def live(programs, scene, work, rate, samples):
    """A walk whose frames are as far apart as spheres come: processor seconds a sphere, and the whole error of what the last one shows (denoise.py's view)."""
    work.mkdir(parents=True, exist_ok=True)
    last = LIVE_FRAMES - 1
    truths = [rendered(programs, work / f"live-truth-{seed}", scene, "--fps", rate, "--camera", "perspective", "--fov", FOV, "--size", VIEW, "--frames", last, "--spp", LIVE_TRUTH_SAMPLES,
                       "--seed", seed, "--unbiased", "--aovs", "none") / "centre" for seed in LIVE_TRUTH_SEEDS]
    ways = []
    for size, taken, (way, words) in itertools.product(LIVE_SIZES, samples, LIVE_WAYS.items()):
        def seconds(frames):
            return programs.run("render", scene, "--fps", rate, "--size", size, "--spp", taken, "--frames", f"0-{frames - 1}", "--aovs", "depth", *words, "--overwrite", "--out", out)[1]
        out = work / f"live-{size}-{taken}-{way.replace(' ', '-')}"
        once = seconds(1)
        ways.append({"way": way, "size": size, "samples": taken, "sphere_cpu_s": (seconds(LIVE_FRAMES) - once) / (LIVE_FRAMES - 1), "whole": whole_error(programs, out / "centre", work, truths, "--frames", last)})
        print(scene.stem, size, taken, way, f"{ways[-1]['sphere_cpu_s']:.3f} s, {ways[-1]['whole']['db']:.1f} dB", flush=True)
    return {"spheres_a_second": rate, "ways": ways}


def live_rows(kept):
    """What `serve` sent, and every way that no other beats in both time and error."""
    for scene, result in kept.get("live", {}).items():
        ways = sorted(result["ways"], key=lambda way: way["sphere_cpu_s"])
        today = next(way for way in ways if (way["way"], way["size"], way["samples"]) == ("as rendered", SIZE, LIVE[scene][1][0]))
        best = -math.inf
        for way in ways:
            if way["whole"]["db"] <= best and way is not today:
                continue
            best = max(best, way["whole"]["db"])
            name = f"**{way['way']}**" if way is today else way["way"]
            yield [scene, name, way["size"], str(way["samples"]), f"{way['sphere_cpu_s']:.2f}", f"{way['sphere_cpu_s'] / today['sphere_cpu_s']:.2f}",
                   f"{way['whole']['db']:.1f}", f"{way['whole']['db'] - today['whole']['db']:+.1f}"]


def tables(kept):
    scenes = kept["scenes"]
    row = lambda name, cells: f"| {name} | " + " | ".join(cells) + " |"  # noqa: E731
    head = lambda cells: [row("scene", cells), "|---|" + "--:|" * len(cells)]  # noqa: E731
    noise = head([f"{n} frames" for n in (2, 4, 8, FRAMES)]) + [row(name, [f"{s['noise_gain_db_after_frames'][str(n)]:.1f}" for n in (2, 4, 8, FRAMES)]) for name, s in scenes.items()]
    error = head(["one frame", "accumulated", "64 fresh", "share with full memory", "there accumulated", "there fresh"]) + [
        row(name, [f"{s['error_db'][k]:.1f}" for k in ("one_frame", "accumulated", "fresh")] + [f"{100 * s['full_memory_share']:.0f} %"] +
            [f"{s['error_db'][k]:.1f}" for k in ("accumulated_full_memory", "fresh_full_memory")]) for name, s in scenes.items()]
    shown = head(["error, one frame", "error, accumulated", "flicker, one frame", "flicker, accumulated", "ratio"]) + [
        row(name, [f"{s['denoised_error_db'][k]:.1f}" for k in ("one_frame", "accumulated")] + [f"{255 * s['denoised_flicker'][k]:.2f}" for k in ("one_frame", "accumulated")] +
            [f"{s['denoised_flicker']['accumulated'] / s['denoised_flicker']['one_frame']:.2f}"]) for name, s in scenes.items()]
    still_head = head(["samples", "difference", "of two renders"]) + [row(name, [f"{s['still'][k]:.{d}f}" for k, d in (("samples", 0), ("difference_db", 1), ("difference_of_two_renders_db", 1))]) for name, s in scenes.items()]
    heads = ["scene", "way", "sphere", "samples", "processor s a sphere", "times", "whole error, dB", "beside"]
    at_its_rate = table(heads, live_rows(kept), 3).splitlines()
    return {"noise": noise, "error": error, "shown": shown, "still": still_head, "live": at_its_rate}


def write_page(file, kept):
    text = file.read_text()
    for name, rows in tables(kept).items():
        text = re.sub(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", lambda m: m[1] + "\n".join(rows) + "\n" + m[2], text, flags=re.S)
    write_whole(file, text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, default=REPOSITORY / "build/release/bin")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("accumulate-work"))
    parser.add_argument("--scenes", default=",".join(REAL_SCENES))
    parser.add_argument("--live", action="store_true")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/accumulate.json")
    options = parser.parse_args()
    programs = Programs(options.bin)
    kept = json.loads(options.out.read_text()) if options.out.exists() else {"scenes": {}}
    if options.live:
        for name, (rate, samples) in LIVE.items():
            kept.setdefault("live", {})[name] = live(programs, REPOSITORY / f"scenes/descriptions/{name}.json", options.work / name, rate, samples)
        kept["live_on"] = {"versions": versions(options.bin / "equistream", REPOSITORY), "machine": machine()}
        write_whole(options.out, result_text(kept))
    for name in [] if options.page or options.live else options.scenes.split(","):
        scene, work = REPOSITORY / f"scenes/descriptions/{name}.json", options.work / name
        work.mkdir(parents=True, exist_ok=True)
        kept["scenes"][name] = {**walk(programs, scene, work), "still": still(programs, scene, work)}
        kept["lamp"] = lamp(programs, options.work / "lamp")
        kept |= {"settings": {"size": SIZE, "samples": SAMPLES, "frames": FRAMES, "accumulate": MEMORY, "denoise": QUALITY, "small": SMALL, "still_frames": STILL_FRAMES},
                 "versions": versions(options.bin / "equistream", REPOSITORY), "machine": machine()}
        write_whole(options.out, result_text(kept))
        print(json.dumps(kept["scenes"][name]), flush=True)
    if (page := options.out.with_suffix(".md")).exists():
        write_page(page, kept)


if __name__ == "__main__":
    main()
