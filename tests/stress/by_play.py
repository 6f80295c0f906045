"""Breakers with chains of their own, by `equistream play`.

Broken pixels: NaN, infinity and absurd numbers in colour and depth of rendered frames, of which nothing may reach an eye or stop a program. Frames are
damaged on disk and played by `--depth exact`, into linear EXR (where a NaN would show), and encoded.

Late motion, lost packets: frames that come late or not at all; what eyes see at the refreshes of a display of a scene in which things move, by `--network`.
The scene, its stream and the truth of every refresh are made once a run. The share of pixels that show what moves is small, so the eyes look at it.
"""

import json
import math
import shutil
import threading

import chains
import numpy as np
import OpenEXR
from breakers import Breaker, at_arm_length

BROKEN = (Breaker("broken pixels", "near", "share of broken pixels in colour and depth", (0, 0.0001, 0.001, 0.01, 0.05, 0.2), (0.05,),
                    at_arm_length),)
POISON = {"colour": (np.nan, np.inf, -np.inf, -3.0, 6e4), "depth": (np.nan, -np.inf, -1.0, 0.0, 1e-30, np.inf, 3e38)}
SEED = 5


def break_file(file, share, random):
    """Some pixels of every picture, each with one kind of poison in all its channels."""
    source = OpenEXR.File(str(file), separate_channels=True)
    for part in source.parts:
        for name, channel in part.channels.items():
            kind = "depth" if name.endswith("depth.Z") else "colour" if name in "RGB" else None
            if kind is None:
                continue
            pixels = channel.pixels
            hit = random.random(pixels.shape) < share
            pixels[hit] = random.choice(POISON[kind], hit.sum()).astype(pixels.dtype)
    OpenEXR.File(source.parts).write(str(file))


def scores_of_broken(program, breaker, share, work):
    """Method -> figures, of what `play` made of a damaged folder."""
    renders = chains.Renders(program, breaker, share, work)
    truth = {eye: chains.es.read_frame(work / "truth" / eye / "frame.0000.exr") for eye in chains.EYES}
    # Exact depth of the eyes lies beside the sphere.
    for eye in chains.EYES:
        (work / "truth" / eye).rename(work / "sphere" / eye)
    random = np.random.default_rng(SEED)
    for file in sorted((work / "sphere").rglob("*.exr")):
        break_file(file, share, random)
    chains.run_program(program, "encode", work / "sphere", "--out", work / "sphere.mp4", "--progress", "none")
    best = chains.ceiling(lambda eye: [renders.frame("own", eye)], lambda eye: [truth[eye]])
    return {chains.CEILING: best.figures(), **{method: score_broken(program, work, method, truth).figures(best) for method in chains.es.METHODS}}


def score_broken(program, work, method, truth):
    out = work / f"eyes-{method}"
    chains.run_program(program, "play", work / "sphere", "--depth", "exact", "--method", method, "--fill", chains.chain(), "--size", chains.size_text(chains.EYE_SIZE),
               "--format", "exr", "--reliability", "--progress", "none", "--out", out)
    found = chains.Score()
    for eye, frame in truth.items():
        colour = chains.es.read_frame(out / eye / "frame.0000.exr")["colour"]
        if not np.isfinite(colour).all():
            raise RuntimeError(f"{method}: expected finite colours, found {int((~np.isfinite(colour)).sum())} others in the {eye} eye")
        shown, true = (chains.es.to_display(picture, frame.info.exposure) for picture in (colour, frame["colour"]))
        found.add(shown, true, chains.played_plane(out, "gaps", eye, 0) != 0, chains.played_plane(out, "reliability", eye, 0))
    return found


LATE = (
    Breaker("late motion", "motion", "delay of the network, ms", (0, 20, 50, 100, 200, 400), (400,)),
    Breaker("lost packets", "motion", "share of packets that are lost", (0, 0.01, 0.03, 0.1, 0.3, 0.5, 0.7), (0.5,)),
)
NETWORKS = {"late motion": "delay={value:g}", "lost packets": "delay=20,loss={value:g},transport=datagrams,seed=3"}
SECONDS, REFRESH_HZ = 2, 15
FIRST, LAST = REFRESH_HZ, 2 * REFRESH_HZ - 2
"""Refreshes at which there is something to show however late frames are."""
DEPTH = {"eye-depth": ["--scene", "motion.json"], "rotation": [], "proxy-sphere": []}
CODING = ("--crf", 16)
making = threading.Lock()


def head_line(key):
    """Of a head that goes with the sphere, looks back and up, where things move, and sways."""
    time_s = key["time_s"]
    yaw, pitch = (math.pi + 0.3 * math.sin(2 * time_s)) / 2, math.radians(35) / 2
    turn = (math.cos(yaw) * math.cos(pitch), math.cos(yaw) * math.sin(pitch), math.sin(yaw) * math.cos(pitch), -math.sin(yaw) * math.sin(pitch))
    return ",".join(repr(float(value)) for value in (time_s, *key["position_m"], *turn))


def head_path(scene):
    """The text of a file for `--head`, along the path of a scene's description."""
    keys = json.loads(scene.read_text())["camera"]["keys"]
    return "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "\n".join(map(head_line, keys)) + "\n"


def inputs(program, runs):
    """A folder of them, beside those of the run's values."""
    folder = runs / "late"
    with making:
        if not folder.exists():
            aside = runs / "late.unfinished"
            shutil.rmtree(aside, ignore_errors=True)
            make_inputs(program, aside)
            aside.rename(folder)
    return folder


def make_inputs(program, folder):
    chains.run_program(program, "scene", "generate", "motion", "--option", f"seconds={SECONDS}", "--out", folder)
    scene, quiet = folder / "motion.json", ("--max-bounces", 0, "--seed", chains.SEED["render"], "--progress", "none")
    (folder / "head.csv").write_text(head_path(scene))
    chains.run_program(program, "render", scene, "--frames", f"0-{30 * SECONDS}", "--size", chains.size_text(chains.SPHERE_SIZE), "--spp", 4,
               "--aovs", "depth,motion,ids", *quiet, "--out", folder / "frames")
    chains.run_program(program, "render", scene, "--camera", "perspective", "--eye", "both", "--path", folder / "head.csv", "--fps", REFRESH_HZ, "--frames", f"{FIRST}-{LAST}",
               "--size", chains.size_text(chains.EYE_SIZE), "--fov", 90, "--spp", 16, *quiet, "--out", folder / "truth")
    chains.run_program(program, "render", scene, "--eye", "both", "--path", folder / "head.csv", "--fps", REFRESH_HZ, "--frames", f"{FIRST}-{LAST}",
               "--size", chains.size_text(chains.SPHERE_SIZE), "--spp", 4, *quiet, "--out", folder / "own")
    for eye in chains.EYES:
        chains.run_program(program, "encode", folder / "own" / eye, "--out", folder / f"own-{eye}.mp4", *CODING, "--progress", "none")
    chains.run_program(program, "encode", folder / "frames", "--out", folder / "motion.mp4", "--depth", "auto", "--motion", "auto", *CODING, "--progress", "none")


def scores_of_late(program, breaker, value, work):
    """Method -> figures."""
    folder = inputs(program, work.parent)
    network = NETWORKS[breaker.name].format(value=value)
    best = chains.ceiling(lambda eye: [frame.main for frame in chains.es.open_feed(folder / f"own-{eye}.mp4")], lambda eye: frames(folder / "truth" / eye))
    return {chains.CEILING: best.figures(), **{method: score_late(program, folder, network, method, work / method).figures(best) for method in chains.es.METHODS}}


def frames(folder):
    return [chains.es.read_frame(folder / f"frame.{refresh:04}.exr") for refresh in range(FIRST, LAST + 1)]


def score_late(program, folder, network, method, out):
    depth = [folder / word if word == "motion.json" else word for word in DEPTH.get(method, ["--depth", "stream"])]
    chains.run_program(program, "play", folder / "motion.mp4", "--method", method, *depth, "--fill", "pushpull" if method != "rotation" else "none", "--head", folder / "head.csv",
               "--refresh", REFRESH_HZ, "--network", network, "--size", chains.size_text(chains.EYE_SIZE), "--fov", 90, "--reliability", "--progress", "none", "--out", out)
    found = chains.Score()
    for eye in chains.EYES:
        for refresh, truth in enumerate(frames(folder / "truth" / eye), FIRST):
            found.add(chains.played_picture(out, eye, refresh), chains.displayed(truth),
                      chains.played_plane(out, "gaps", eye, refresh) != 0, chains.played_plane(out, "reliability", eye, refresh))
    return found


SCORES_OF = {**dict.fromkeys(BROKEN, scores_of_broken), **dict.fromkeys(LATE, scores_of_late)}
"""Breaker -> its scores(program, breaker, value, work)."""
