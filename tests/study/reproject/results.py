"""The JSON of docs/results/reproject, KIND.json of all scenes or KIND/SCENE.json: what tables and charts share."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from kept import result_text  # noqa: E402
from found import together  # noqa: E402
from steps import write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RESULTS = REPOSITORY / "docs/results/reproject"
SCENES = ("sponza-crytek", "sibenik", "voxel-city", "kitchen", "san-miguel")
EYES = ("left", "right")
SCALES = ("linear", "display")
NAMES = {
    "sphere": "rotation only", "lean": "proxy sphere, without depth", "splat": "splat", "gather": "gather", "mesh": "mesh, cut and adaptive",
    "mesh-plain": "plain mesh of every cell", "surface": "eye-depth", "paper": "the paper's method", "ours": "ours: eye-depth, the whole fill chain",
    "ours-left": "ours, with the sphere at the left eye",
    "paper-gaps": "the paper's method, mirrors as gaps", "paper-images": "the paper's method, mirrors by images",
    "ours-gaps": "ours, mirrors as gaps", "ours-surface": "ours, mirrors on their surface",
    "ours-left-gaps": "ours, with the sphere at the left eye, mirrors as gaps",
    "ours-left-surface": "ours, with the sphere at the left eye, mirrors on their surface",
    "surface-3840": "eye-depth, 3,840 wide", "gather-3840": "gather, 3,840 wide", "mesh-3840": "mesh, 3,840 wide", "sphere-3840": "rotation only, 3,840 wide",
    "splat-3840": "splat, 3,840 wide", "mesh-plain-3840": "plain mesh of every cell, 3,840 wide", "paper-3840": "the paper's method, 3,840 wide",
    "paper-coded": "the paper's method, coded", "paper-gaps-coded": "the paper's method, coded, mirrors as gaps", "ours-coded-none": "ours, coded, no track for gaps",
    "ours-coded-small": "ours, coded, small stream", "ours-coded-hidden": "ours, coded, hidden layer", "ours-coded-patches": "ours, coded, patches",
    "ours-left-coded-none": "ours at the left eye, coded, no track for gaps",
    "ours-left-coded-small": "ours at the left eye, coded, small stream", "ours-left-coded-hidden": "ours at the left eye, coded, hidden layer",
    "ours-left-coded-patches": "ours at the left eye, coded, patches",
}

# Engines whose results were measured under another name.
ENGINES = {"surface": "eye-depth", "sphere": "rotation", "lean": "proxy-sphere"}

CODED = [name for name in NAMES if "-coded" in name]

# Who -> what becomes of mirrors and glass (`play --mirrors`) -> the system. The paper's sphere has no reflection data.
MIRRORS = {"paper": {"surface": "paper", "gaps": "paper-gaps", "images": "paper-images"},
           "ours": {"surface": "ours-surface", "gaps": "ours-gaps", "images": "ours"},
           "ours-left": {"surface": "ours-left-surface", "gaps": "ours-left-gaps", "images": "ours-left"}}


def load(kind, folder=RESULTS):
    """{scene: result} of one experiment, in the order of SCENES, then by name."""
    whole = pathlib.Path(folder) / f"{kind}.json"
    if whole.exists():
        found = json.loads(whole.read_text())
        return {scene: found[scene] for scene in sorted(found, key=lambda scene: (SCENES.index(scene) if scene in SCENES else len(SCENES), scene))}
    files = {file.stem: file for file in sorted((pathlib.Path(folder) / kind).glob("*.json"))}
    order = [scene for scene in SCENES if scene in files] + [scene for scene in files if scene not in SCENES]
    return {scene: json.loads(files[scene].read_text()) for scene in order}


def keep(file, scene, result):
    """Puts a scene's result into KIND.json, which has those of the other scenes."""
    found = json.loads(file.read_text()) if file.exists() else {}
    write_whole(file, result_text({**found, scene: result}))
    print(f"{file}: {scene}", flush=True)


def find(result, kind, system, head):
    return next((entry for entry in result.get(kind, []) if entry["system"] == system and entry["head"] == head), None)


def commit_of(result, entry):
    """Of the version that a row was measured with."""
    return entry.get("measured", result)["versions"]["commit"]


def error(entry, eye, scale):
    """Noise-free over the whole view, on `linear` or `display` values (docs/compare.md)."""
    return entry["noise_free"]["eyes"][eye]["noise_free"][scale]


def gap_error(entry, eye, scale="display"):
    """Noise-free in the gaps alone; None without gaps."""
    gaps = entry["noise_free"]["eyes"][eye].get("gaps")
    return gaps["noise_free"][scale] if gaps and "noise_free" in gaps else None


def worst_error(entry, eye, scale):
    """Noise-free of the worst hundredth of the pixels; None where compare did not tell it yet."""
    worst = entry["noise_free"]["eyes"][eye].get("noise_free_worst_percent")
    return worst[scale] if worst else None


def tells_of_mirrors(result):
    """Whether any system was played that met mirrors or glass and knew."""
    return any("specular" in eye for kind in ("systems", "coded") for entry in result.get(kind, [])
               for run in entry["played"] for eye in run.get("eyes", {}).values())


def both_eyes(entry, scale):
    return together([error(entry, eye, scale) for eye in EYES])


# What `encode` sends as H.265 whatever --codec says (TrackSettings::codec). Only for results from before its report told each track's codec.
ONLY_H265 = ("w12", "hue", "lossless")


def depth_codec(system, record):
    """The codec that a depth track truly has, `h264` or `h265`."""
    return record.get("codec") or ("h265" if record["code"] in ONLY_H265 else system["codec"])


def reprojection_ms(entry):
    """Of both eyes, fill with it, medians of the faster seed's run. Without depth: some systems cast rays and some are given the AOV."""
    def total(run):
        return sum(run["milliseconds"].get(stage, {}).get("p50", 0) for stage in ("reproject", "fill"))
    return min(total(run) for run in entry["played"])


def coded_bytes(entry):
    """All tracks, mean of the seeds; None for what was not coded."""
    if "encoded" not in entry:
        return None
    return sum(sum(record["bytes"].values()) for record in entry["encoded"]) / len(entry["encoded"])
