"""What the eye sees while the server is late: dB against the truth of every refresh, and degrees, against delay, jitter, loss and stalls of the network.

The bundled `motion` glows, so that what differs differs in place: things move, the head walks, turns and looks about. `play --network` is a simulation on the
frames' own clock, so that every run is the same everywhere. Beside spheres, what a server of views sends: both eyes as the head was when they left, turned by
the client to where it is by now; as wide as the eye sees, and wider.
"""

import dataclasses
import json
import math
import sys

from found import together_psnr
from scene_work import STRESS
from steps import write_if_other

sys.path.insert(0, str(STRESS))
from by_play import head_path  # noqa: E402

SPHERE, EYES, FOV_DEG = "480x240", "200x112", 90
FRAMES_HZ, REFRESH_HZ = 30, 30
FIRST_S = 1.0
"""Of the refreshes that are scored: until then the clock learns how even the network is."""
STALL_AT_S = 1.2
EYE_SIZE, WIDE_FOV_DEG = tuple(map(int, EYES.split("x"))), 120


@dataclasses.dataclass(frozen=True)
class Way:
    """Streams that are played, and what for: one for both eyes, or one for each."""
    title: str
    words: tuple
    streams: tuple = (("spheres", ("left", "right")),)
    tracks: tuple = ("main",)
    """That it takes of them."""


def of_views(name):
    return tuple((f"{name}-{eye}", (eye,)) for eye in ("left", "right"))


WAYS = {"surface": Way("surface, client's geometry", ("--method", "eye-depth", "--scene", "scene/motion.json")),
        "mesh": Way("mesh, streamed depth", ("--method", "mesh", "--depth", "stream"), tracks=("main", "depth")),
        "held": Way("mesh, moving things left where frames show them", ("--method", "mesh", "--depth", "stream", "--extrapolate", "0"), tracks=("main", "depth")),
        "sphere": Way("turned only", ("--method", "rotation")),
        "views": Way(f"both eyes' views of {FOV_DEG} degrees, turned", ("--method", "rotation"), of_views("views")),
        "wide-views": Way(f"both eyes' views of {WIDE_FOV_DEG} degrees, turned", ("--method", "rotation"), of_views("wide-views")),
        "reprojected-views": Way(f"both eyes' views of {WIDE_FOV_DEG} degrees, client's geometry", ("--method", "eye-depth", "--scene", "scene/motion.json"), of_views("wide-views"))}
"""By name."""
SWEEPS = {
    "delay, ms": ("delay={:g}", (0, 20, 50, 100, 200, 400)),
    "jitter beside a delay of 50 ms, ms": ("delay=50,jitter={:g},seed=3", (0, 10, 30, 100, 200)),
    "share of packets lost, sent again (TCP)": ("delay=50,loss={:g},seed=3", (0, 0.003, 0.01, 0.03, 0.1)),
    "share of packets lost for good (datagrams)": ("delay=50,loss={:g},transport=datagrams,seed=3", (0, 0.01, 0.03, 0.1, 0.3)),
    "silence of the server, s": (f"delay=50,stall={STALL_AT_S}:" + "{:g}", (0, 0.1, 0.3, 1, 2, 4)),
}


def wide_size():
    """As dense in the middle as what the eye sees, a multiple of 16 across."""
    wider = math.tan(math.radians(WIDE_FOV_DEG) / 2) / math.tan(math.radians(FOV_DEG) / 2)
    return "x".join(str(round(side * wider / 16) * 16) for side in EYE_SIZE)


def make_inputs(work, seconds):
    steps, quiet = work.steps, ("--max-bounces", 0, "--progress", "none")
    steps.run("scene", "scene", "generate", "motion", "--option", f"seconds={seconds}", "--out", "scene")
    write_if_other(work.folder / "head.csv", head_path(work.folder / "scene/motion.json"))
    last = REFRESH_HZ * seconds - 2
    head = ("--camera", "perspective", "--eye", "both", "--path", "head.csv")
    steps.run("frames", "render", "scene/motion.json", "--frames", f"0-{FRAMES_HZ * seconds}", "--size", SPHERE, "--spp", 4, "--aovs", "depth,motion,ids", *quiet, "--out", "frames",
              fresh="frames")
    steps.run("truth", "render", "scene/motion.json", *head, "--fps", REFRESH_HZ, "--frames", f"{round(FIRST_S * REFRESH_HZ)}-{last}", "--size", EYES, "--fov", FOV_DEG, "--spp", 16,
              *quiet, "--out", "truth", fresh="truth")
    steps.run("encode-spheres", "encode", "frames", "--out", "spheres.mp4", "--crf", 16, "--depth", "auto", "--motion", "auto", "--json", "--progress", "none")
    for name, size, fov_deg in (("views", EYES, FOV_DEG), ("wide-views", wide_size(), WIDE_FOV_DEG)):
        steps.run(name, "render", "scene/motion.json", *head, "--fps", FRAMES_HZ, "--frames", f"0-{last}", "--size", size, "--fov", fov_deg, "--spp", 4, "--seed", 2, "--aovs", "none",
                  *quiet, "--out", f"rendered/{name}", fresh=f"rendered/{name}")
        for eye in ("left", "right"):
            steps.run(f"encode-{name}-{eye}", "encode", f"rendered/{name}/{eye}", "--out", f"{name}-{eye}.mp4", "--crf", 16, "--json", "--progress", "none")
    return f"{round(FIRST_S * REFRESH_HZ)}-{last}"


def seen(work, method, stream, eyes, network, scored):
    """Of one stream: how `eyes` compare with the truth, what `play` said of the viewing, and the command."""
    name = f"{method}-{stream}-{network}".replace("=", "-").replace(",", "-").replace(":", "-")
    record = work.steps.run(f"play-{name}", "play", f"{stream}.mp4", *WAYS[method].words, "--fill", "pushpull", "--head", "head.csv",
                            "--refresh", REFRESH_HZ, "--network", network, "--size", EYES, "--fov", FOV_DEG, "--progress", "none", "--out", f"views/{name}")
    work.steps.run(f"compare-{name}", "compare", f"views/{name}", "truth", "--frames", scored, "--eyes", ",".join(eyes), "--metrics", "psnr", "--progress", "none",
                   "--out", f"scores/{name}.json")
    report = json.loads((work.folder / f"views/{name}/report.json").read_text())
    return json.loads((work.folder / f"scores/{name}.json").read_text())["eyes"], report["viewing"], record["command"]


def score(work, method, network, scored):
    """dB of both eyes over all refreshes, and of the worst; degrees by which the head's pose and, in a plain remote renderer, the picture's was off."""
    found = [seen(work, method, stream, eyes, network, scored) for stream, eyes in WAYS[method].streams]
    eyes, viewing = [eye for by_eye, _, _ in found for eye in by_eye.values()], found[0][1]
    return {"method": method, "network": network, "commands": [command for _, _, command in found], "psnr_db": together_psnr([eye["mean_square"] for eye in eyes]),
            "worst_refresh_db": min(frame["psnr_db"] for eye in eyes for frame in eye["per_frame"]),
            **{key: viewing[key] for key in ("age_ms", "error_deg", "unreprojected_error_deg") if key in viewing}}


def bytes_a_second(work, method):
    """Of the tracks that it takes."""
    found = 0
    for stream, _ in WAYS[method].streams:
        report = json.loads(work.steps.output_of(f"encode-{stream}"))
        found += sum(track["bytes_per_frame"] * FRAMES_HZ for track in report["tracks"] if track["name"] in WAYS[method].tracks)
    return found


def run(work):
    seconds = work.preset.latency_seconds
    scored = make_inputs(work, seconds)
    (work.folder / "scores").mkdir(exist_ok=True)
    methods = list(WAYS) if work.preset.every_value else ["surface", "sphere", "wide-views"]
    sweeps = {}
    for label, (network, values) in SWEEPS.items() if work.preset.every_value else list(SWEEPS.items())[:1]:
        ended = [value for value in values if not label.startswith("silence") or STALL_AT_S + value < seconds - 0.5]
        chosen = ended if work.preset.every_value else (ended[0], ended[-1])
        sweeps[label] = {f"{value:g}": work.steps.side_by_side(lambda method, value=value: score(work, method, network.format(value), scored), methods) for value in chosen}
    return {"n": {"refreshes": scored, "refresh_hz": REFRESH_HZ, "frames_hz": FRAMES_HZ, "seconds": seconds}, "titles": {method: WAYS[method].title for method in methods},
            "bytes_a_second": {method: bytes_a_second(work, method) for method in methods}, "sweeps": sweeps}
