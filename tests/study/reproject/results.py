"""Reading docs/results/reproject/*/SCENE.json: what tables, charts and pictures share."""

import json
import math
import pathlib

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RESULTS = REPOSITORY / "docs/results/reproject"
SCENES = ("sponza-crytek", "sibenik", "voxel-city", "kitchen", "san-miguel")
EYES = ("left", "right")
NAMES = {
    "sphere": "rotation only", "lean": "leaning without depth", "splat": "splat", "gather": "gather", "mesh": "mesh, cut and adaptive",
    "mesh-plain": "plain mesh of every cell", "surface": "surface", "paper": "the paper's method", "ours": "ours: surface, the whole ladder",
    "ours-left": "ours, with the sphere at the left eye",
    "surface-3840": "surface, 3,840 wide", "gather-3840": "gather, 3,840 wide", "mesh-3840": "mesh, 3,840 wide", "sphere-3840": "rotation only, 3,840 wide",
    "paper-coded": "the paper's method, coded", "ours-coded-none": "ours, coded, no track for gaps",
    "ours-coded-hidden": "ours, coded, hidden layer", "ours-coded-patches": "ours, coded, patches",
    "ours-left-coded-none": "ours at the left eye, coded, no track for gaps", "ours-left-coded-hidden": "ours at the left eye, coded, hidden layer",
    "ours-left-coded-patches": "ours at the left eye, coded, patches",
}

CODED = [name for name in NAMES if "-coded" in name]


def load(kind, folder=RESULTS):
    """{scene: result} of one experiment, in the order of SCENES, then by name."""
    files = {file.stem: file for file in sorted((pathlib.Path(folder) / kind).glob("*.json"))}
    order = [scene for scene in SCENES if scene in files] + [scene for scene in files if scene not in SCENES]
    return {scene: json.loads(files[scene].read_text()) for scene in order}


def find(result, kind, system, head):
    return next((entry for entry in result.get(kind, []) if entry["system"] == system and entry["head"] == head), None)


def display_error(entry, eye):
    return entry["noise_free"]["eyes"][eye]["noise_free"]["display"]


def both_eyes_db(entry):
    """Noise-free, of the two eyes' mean square errors together."""
    errors = [display_error(entry, eye)["mean_square"] for eye in EYES]
    return -10 * math.log10(sum(errors) / len(errors))


def gap_error(entry, eye):
    """Noise-free in the gaps alone; None without gaps."""
    gaps = entry["noise_free"]["eyes"][eye].get("gaps")
    return gaps["noise_free"]["display"] if gaps and "noise_free" in gaps else None


def client_ms(entry):
    """Depth, reprojection and fill of both eyes, medians of the faster seed's run."""
    def total(run):
        return sum(run["milliseconds"].get(stage, {}).get("p50", 0) for stage in ("depth", "reproject", "fill"))
    return min(total(run) for run in entry["played"])


def coded_bytes(entry):
    """All tracks, mean of the seeds; None for what was not coded."""
    if "encoded" not in entry:
        return None
    return sum(sum(record["bytes"].values()) for record in entry["encoded"]) / len(entry["encoded"])
