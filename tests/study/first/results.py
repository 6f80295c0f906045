"""Reading docs/results/first/*.json: what charts and tables share."""

import json
import math
import pathlib

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RESULTS = REPOSITORY / "docs/results/first"
CLIENT_STAGES = ("decode", "convert", "depth", "reproject", "fill")
SYSTEM_NAMES = {"perspective": "one perspective view", "sphere-left": "sphere at the left eye", "sphere-centre": "sphere at the head's centre"}
METHOD_NAMES = {"surface": "reprojected", "sphere": "rotated only"}
CODING_NAMES = {("none", None): "uncoded", ("h264", 16): "H.264, CRF 16", ("h264", 24): "H.264, CRF 24", ("h265", 16): "H.265, CRF 16",
                ("h265", 24): "H.265, CRF 24"}


def load(folder=RESULTS):
    files = sorted(pathlib.Path(folder).glob("*.json"))
    # In the paper's order of heaviness: what has fewer unique triangles first.
    return sorted((json.loads(file.read_text()) for file in files), key=lambda r: r["renders"][0]["unique_triangles"])


def coding_name(entry):
    return CODING_NAMES.get((entry["codec"], entry["crf"]), f"{entry['codec']}, CRF {entry['crf']}")


# A decoder hands pictures out in bursts, so only its mean is the cost of a frame; the others' median leaves out what else
# the machine was doing.
STAGE_FIGURES = {"decode": "mean", "convert": "mean"}


def stage_times(entry, stage):
    """{p50, p95, p99, mean} in milliseconds a frame, both eyes, of the faster of the two seeds' runs; None where the stage does not run."""
    found = [run["milliseconds"][stage] for run in entry["played"] if stage in run["milliseconds"]]
    return min(found, key=lambda times: times[STAGE_FIGURES.get(stage, "p50")]) if found else None


def stage_ms(entry, stage):
    times = stage_times(entry, stage)
    return times[STAGE_FIGURES.get(stage, "p50")] if times else None


def client_ms(entry):
    """All stages of the client but writing files; None for uncoded systems, which read EXR files instead of decoding a stream."""
    if entry["codec"] == "none":
        return None
    return sum(stage_ms(entry, stage) or 0 for stage in CLIENT_STAGES)


def bytes_per_frame(entry):
    """Mean of both seeds, all tracks; nothing for uncoded systems."""
    if "bytes" not in entry["played"][0]:
        return None
    return sum(sum(run["bytes"].values()) / run["frames"] for run in entry["played"]) / len(entry["played"])


def psnr(comparisons, eye):
    """Both seeds' squared errors pooled; None where identical."""
    square = sum(c["eyes"][eye]["mean_square"] for c in comparisons) / len(comparisons)
    return 10 * math.log10(255 ** 2 / square) if square > 0 else None


def mean_of(comparisons, eye, *keys):
    values = []
    for comparison in comparisons:
        value = comparison["eyes"][eye]
        for key in keys:
            value = (value or {}).get(key)
        if value is not None:
            values.append(value)
    return sum(values) / len(values) if values else None
