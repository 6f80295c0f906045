#!/usr/bin/env python3
"""How far the study's figures hold at other places: several systems at three places of a scene's path, 30 frames in a row at each.

    PYTHONPATH=build/release/package places.py --bin build/release/bin --work FOLDER [--scenes NAME,...] [--out FILE]

The path is cut in three, and the frames lie in the middle of each part. Views and spheres have half the study's pixels; samples and denoiser are the study's.
Truths have half as many samples, of seven times as many frames. What other runs found of other scenes stays in the file.
"""

import argparse
import dataclasses
import json
import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
import found  # noqa: E402
from experiments.systems import SYSTEMS, Player, codings  # noqa: E402
from kept import lean, result_text  # noqa: E402
from options import Progress  # noqa: E402
from presets import PRESETS, SEEDS, Preset  # noqa: E402
from scene_work import SceneWork  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

SCENES = ("sponza-crytek", "voxel-city")
PLACES, FRAMES, CRF = 3, 30, 16
EYE, SPHERE_WIDTH, TRUTH_SAMPLES = (448, 256), 1344, 16
CHOSEN = ("perspective", "pair", "centre", "centre-mesh", "centre-turned")


@dataclasses.dataclass(frozen=True)
class AtPlace(Preset):
    first: int = 0

    def frame_range(self, _scene):
        return self.first, self.first + self.frames - 1


def at_place(first):
    return AtPlace(**{**vars(PRESETS["small"]), "name": "places", "frames": FRAMES, "eye": EYE, "sphere_width": SPHERE_WIDTH, "crfs": (CRF,), "repeat": 1, "timed": False,
                      "truth_samples": dict.fromkeys(SCENES, TRUTH_SAMPLES), "first": first})


def path_frames(scene, work):
    rate = json.loads(work.description.read_text()).get("frames_per_second", 30)
    return round(work.info["path_duration_s"] * rate) + 1


def first_frames(count):
    """Of runs of FRAMES in the middle of each of PLACES parts of a path of so many."""
    return [round((place + 0.5) * count / PLACES - FRAMES / 2) for place in range(PLACES)]


def figures(entry):
    """One system in one coding: dB of both eyes with their intervals, linear values."""
    whole = {key: value for key, value in found.error(entry, kind=found.WHOLE).items() if key.startswith("db")}
    return {"system": entry["system"], "crf": entry["crf"], "whole": whole, "bytes_a_frame": found.all_bytes(entry)}


def measured(folder, programs, scene):
    info = SceneWork(folder / "info", programs, scene, at_place(0), Progress("places", "none"))
    places = []
    for first in first_frames(path_frames(scene, info)):
        work = SceneWork(folder / f"from-{first}", programs, scene, at_place(first), Progress(f"{scene} from {first}"))
        player = Player(work, seeds=SEEDS[:1])
        systems = [system for system in SYSTEMS if system.name in CHOSEN]
        entries = [figures(player.score(system, work.preset.sphere_width, coding)) for system in systems for coding in codings(work.preset)]
        places.append({"frames": work.frames, "entries": entries})
    return {"eye": EYE, "sphere_width": SPHERE_WIDTH, "samples": info.preset.sphere_samples, "denoise": info.preset.denoise, "truth_samples": TRUTH_SAMPLES, "seeds": 1,
            "places": places}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/trust/places.json")
    asked = parser.parse_args()
    report = json.loads(asked.out.read_text()) if asked.out.exists() else {"scenes": {}}
    for scene in asked.scenes.split(","):
        report["scenes"][scene] = {**measured(asked.work.resolve(), asked.bin.resolve(), scene), **provenance(asked.bin.resolve(), REPOSITORY)}
        write_whole(asked.out, result_text(lean(report)))


if __name__ == "__main__":
    main()
