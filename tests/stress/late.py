"""Frames that come late or not at all: what eyes see at the refreshes of a display of a scene in which things move, by `equistream play --network`.

The scene, its stream and the truth of every refresh are made once a run. The share of pixels that show what moves is small, so the eyes look at it.
"""

import json
import math
import shutil
import threading

import chains
import played
from breakers import Breaker

BREAKERS = (
    Breaker("late motion", "motion", "delay of the network, ms", (0, 20, 50, 100, 200, 400), (0, 100, 400)),
    Breaker("lost packets", "motion", "share of packets that are lost", (0, 0.01, 0.03, 0.1, 0.3, 0.5, 0.7), (0, 0.1, 0.5)),
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
    played.run(program, "scene", "generate", "motion", "--option", f"seconds={SECONDS}", "--out", folder)
    scene, quiet = folder / "motion.json", ("--max-bounces", 0, "--progress", "none")
    (folder / "head.csv").write_text(head_path(scene))
    played.run(program, "render", scene, "--frames", f"0-{30 * SECONDS}", "--size", chains.size_text(chains.SPHERE_SIZE), "--spp", 4,
               "--aovs", "depth,motion,ids", *quiet, "--out", folder / "frames")
    played.run(program, "render", scene, "--camera", "perspective", "--eye", "both", "--path", folder / "head.csv", "--fps", REFRESH_HZ, "--frames", f"{FIRST}-{LAST}",
               "--size", chains.size_text(chains.EYE_SIZE), "--fov", 90, "--spp", 16, *quiet, "--out", folder / "truth")
    played.run(program, "render", scene, "--eye", "both", "--path", folder / "head.csv", "--fps", REFRESH_HZ, "--frames", f"{FIRST}-{LAST}",
               "--size", chains.size_text(chains.SPHERE_SIZE), "--spp", 4, *quiet, "--out", folder / "own")
    for eye in chains.EYES:
        played.run(program, "encode", folder / "own" / eye, "--out", folder / f"own-{eye}.mp4", *CODING, "--progress", "none")
    played.run(program, "encode", folder / "frames", "--out", folder / "motion.mp4", "--depth", "auto", "--motion", "auto", *CODING, "--progress", "none")


def scores(program, breaker, value, work):
    """Method -> figures."""
    folder = inputs(program, work.parent)
    network = NETWORKS[breaker.name].format(value=value)
    best = chains.ceiling(lambda eye: [frame.main for frame in chains.es.open_feed(folder / f"own-{eye}.mp4")], lambda eye: frames(folder / "truth" / eye))
    return {chains.CEILING: best.figures(), **{method: score(program, folder, network, method, work / method).figures(best) for method in chains.es.METHODS}}


def frames(folder):
    return [chains.es.read_frame(folder / f"frame.{refresh:04}.exr") for refresh in range(FIRST, LAST + 1)]


def score(program, folder, network, method, out):
    depth = [folder / word if word == "motion.json" else word for word in DEPTH.get(method, ["--depth", "stream"])]
    played.run(program, "play", folder / "motion.mp4", "--method", method, *depth, "--fill", "pushpull" if method != "rotation" else "none", "--head", folder / "head.csv",
               "--refresh", REFRESH_HZ, "--network", network, "--size", chains.size_text(chains.EYE_SIZE), "--fov", 90, "--reliability", "--progress", "none", "--out", out)
    found = chains.Score()
    for eye in chains.EYES:
        for refresh, truth in enumerate(frames(folder / "truth" / eye), FIRST):
            found.add(played.picture(out, eye, refresh), chains.displayed(truth),
                      played.plane(out, "gaps", eye, refresh) != 0, played.plane(out, "reliability", eye, refresh))
    return found
