"""What the eye sees while the server is late: dB against the truth of every refresh, and degrees, against delay, jitter, loss and stalls of the network.

The bundled `motion` glows, so that what differs differs in place: things move, the head walks, turns and looks about. `play --network` is a simulation on the
frames' own clock, so that every run is the same everywhere.
"""

import json
import sys

from found import together_psnr
from scene_work import REPOSITORY
from steps import write_if_other

sys.path.insert(0, str(REPOSITORY / "tests/stability"))
from late import head_path  # noqa: E402

SPHERE, EYES, FOV_DEG = "480x240", "200x112", 90
FRAMES_HZ, REFRESH_HZ = 30, 30
FIRST_S = 1.0
"""Of the refreshes that are scored: until then the clock learns how even the network is."""
STALL_AT_S = 1.2
METHODS = {"surface": ["--method", "surface", "--scene", "scene/motion.json"], "mesh": ["--method", "mesh", "--depth", "stream"],
           "held": ["--method", "mesh", "--depth", "stream", "--carry", "0"], "sphere": ["--method", "sphere"]}
TITLES = {"surface": "surface, client's geometry", "mesh": "mesh, streamed depth", "held": "mesh, moving things left where frames show them", "sphere": "turned only"}
SWEEPS = {
    "delay, ms": ("delay={:g}", (0, 20, 50, 100, 200, 400)),
    "jitter beside a delay of 50 ms, ms": ("delay=50,jitter={:g},seed=3", (0, 10, 30, 100, 200)),
    "share of packets lost, sent again (TCP)": ("delay=50,loss={:g},seed=3", (0, 0.003, 0.01, 0.03, 0.1)),
    "share of packets lost for good (datagrams)": ("delay=50,loss={:g},transport=datagrams,seed=3", (0, 0.01, 0.03, 0.1, 0.3)),
    "silence of the server, s": (f"delay=50,stall={STALL_AT_S}:" + "{:g}", (0, 0.1, 0.3, 1, 2, 4)),
}


def make_inputs(work, seconds):
    steps, quiet = work.steps, ("--max-bounces", 0, "--progress", "none")
    steps.run("scene", "scene", "generate", "motion", "--option", f"seconds={seconds}", "--out", "scene")
    write_if_other(work.folder / "head.csv", head_path(work.folder / "scene/motion.json"))
    last = REFRESH_HZ * seconds - 2
    steps.run("frames", "render", "scene/motion.json", "--frames", f"0-{FRAMES_HZ * seconds}", "--size", SPHERE, "--spp", 4, "--aovs", "depth,motion,ids", *quiet, "--out", "frames",
              fresh="frames")
    steps.run("truth", "render", "scene/motion.json", "--camera", "perspective", "--eye", "both", "--path", "head.csv", "--fps", REFRESH_HZ,
              "--frames", f"{round(FIRST_S * REFRESH_HZ)}-{last}", "--size", EYES, "--fov", FOV_DEG, "--spp", 16, *quiet, "--out", "truth", fresh="truth")
    steps.run("encode", "encode", "frames", "--out", "motion.mp4", "--crf", 16, "--depth", "auto", "--motion", "auto", "--progress", "none")
    return f"{round(FIRST_S * REFRESH_HZ)}-{last}"


def score(work, method, network, scored):
    """dB of both eyes over all refreshes, and of the worst; degrees by which the head's pose and, in a plain remote renderer, the picture's was off."""
    name = f"{method}-{network}".replace("=", "-").replace(",", "-").replace(":", "-")
    record = work.steps.run(f"play-{name}", "play", "motion.mp4", *METHODS[method], "--fill", "none" if method == "sphere" else "pushpull", "--head", "head.csv",
                            "--refresh", REFRESH_HZ, "--network", network, "--size", EYES, "--fov", FOV_DEG, "--progress", "none", "--out", f"views/{name}")
    work.steps.run(f"compare-{name}", "compare", f"views/{name}", "truth", "--frames", scored, "--metrics", "psnr", "--progress", "none", "--out", f"scores/{name}.json")
    eyes = json.loads((work.folder / f"scores/{name}.json").read_text())["eyes"]
    viewing = json.loads((work.folder / f"views/{name}/report.json").read_text())["viewing"]
    squares = [eye["mean_square"] for eye in eyes.values()]
    worst = min(frame["psnr_db"] for eye in eyes.values() for frame in eye["per_frame"])
    return {"method": method, "network": network, "command": record["command"], "psnr_db": together_psnr(squares), "worst_refresh_db": worst,
            **{key: viewing[key] for key in ("age_ms", "error_deg", "unreprojected_error_deg") if key in viewing}}


def run(work):
    seconds = work.preset.latency_seconds
    scored = make_inputs(work, seconds)
    (work.folder / "scores").mkdir(exist_ok=True)
    methods = METHODS if work.preset.every_value else ("surface", "sphere")
    sweeps = {}
    for label, (network, values) in SWEEPS.items() if work.preset.every_value else list(SWEEPS.items())[:1]:
        ended = [value for value in values if not label.startswith("silence") or STALL_AT_S + value < seconds - 0.5]
        chosen = ended if work.preset.every_value else (ended[0], ended[-1])
        sweeps[label] = {f"{value:g}": [score(work, method, network.format(value), scored) for method in methods] for value in chosen}
    return {"n": {"refreshes": scored, "refresh_hz": REFRESH_HZ, "frames_hz": FRAMES_HZ, "seconds": seconds}, "titles": {method: TITLES[method] for method in methods}, "sweeps": sweeps}
