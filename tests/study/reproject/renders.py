#!/usr/bin/env python3
"""What depth codes are measured with: path-traced eyes (the truth), and spheres that are turned into them.

    renders.py --bin build/release/bin --work FOLDER [SCENE ...]

One frame a scene, two seeds, equal samples everywhere. Truth: both eyes at 63 mm where the path's head is, unbiased. Sources: a sphere at the head's
centre and one at the left eye. The head box of the scene's description is widened to 0.25 m. Interrupted runs go on.
"""

import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from steps import Failed, Steps, run_as_program, write_if_other  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SEEDS = (1, 2)
# Scene -> the frame that is studied. In san-miguel's, of all the path's frames the one where it differs most, what is nearer than
# half a metre takes 5.9 % of the left eye and 1.9 % of the right one's: a branch hangs before the left eye. (All
# 150 frames rendered for both eyes at 96x54 with the AOV depth; pixels below 0.5 m counted.)
FRAMES = {"kitchen": 30, "san-miguel": 41, "sibenik": 30, "sponza-crytek": 62, "voxel-city": 30}
LEAN_M = 0.25
EYE = "960x540"
SHARE = 0.25
ROUNDS = 40  # more than the default: kitchen takes over 12 to keep the smallest budget

SPHERES = {name: {"size": "1920x960", "options": ["--eye", name]} for name in ("centre", "left")}


class SceneRenders:
    def __init__(self, work, programs, scene, spp):
        self.name = scene
        self.frame = FRAMES[scene]
        self.spp = spp
        self.work = (pathlib.Path(work) / scene).resolve()
        if REPOSITORY in self.work.parents:
            raise Failed(f"--work: expected a folder outside the repository, found {work}")
        self.work.mkdir(parents=True, exist_ok=True)
        self.steps = Steps(self.work, programs, {str(REPOSITORY) + "/": "", str(self.work) + "/": ""}, {"frame": self.frame})
        self.scene = self.widened_description()

    def widened_description(self):
        """The scene's description with the study's head box."""
        folder = REPOSITORY / "scenes/descriptions"
        description = json.loads((folder / f"{self.name}.json").read_text())
        description["head_box"] = {"lean_m": LEAN_M}
        target = self.work / "scene" / f"{self.name}.json"
        target.parent.mkdir(exist_ok=True)
        write_if_other(target, json.dumps(description, indent=1) + "\n")
        path = description["camera"]["path"]
        write_if_other(target.parent / path, (folder / path).read_text())
        return target

    def render(self, name, seed, *options):
        folder = f"renders/{name}-{seed}"
        done = self.steps.run(f"render-{name}-seed{seed}", "render", self.scene, "--frames", self.frame, "--spp", self.spp, "--seed", seed,
                              *options, "--json", "--progress", "none", "--out", folder, fresh=folder)
        return {"name": name, "seed": seed, **done}

    def model(self, error_px):
        """The client's geometry: its file, and what `equistream model` says of it."""
        name = f"model-{error_px:g}px"
        file = f"models/{name}.json"
        (self.work / "models").mkdir(exist_ok=True)
        record = self.steps.run(name, "model", self.scene, "--error-px", error_px, "--share", SHARE, "--rounds", ROUNDS, "--json", "--progress", "none", "--out", file)
        figures = json.loads(self.steps.output_of(name))
        kept = ("error_px", "share", "focal_px", "box_radius_m", "triangles", "bytes", "seconds", "rounds", "check")
        return file, {"command": record["command"], **{key: figures[key] for key in kept}}

    def truth(self, seed):
        return self.render("truth-stereo", seed, "--camera", "perspective", "--eye", "both", "--size", EYE, "--aovs", "depth", "--unbiased")

    def sphere(self, name, seed):
        sphere = SPHERES[name]
        return self.render(name, seed, "--size", sphere["size"], "--aovs", "depth", *sphere["options"])

    def all(self, names):
        made = [self.truth(seed) for seed in SEEDS] if "truth" in names else []
        return made + [self.sphere(name, seed) for name in SPHERES for seed in SEEDS if name in names]


def scene_name(text):
    if text not in FRAMES:
        raise argparse.ArgumentTypeError(f"expected one of {', '.join(FRAMES)}, found {text}")
    return text


def scene_parser(description, work=None):
    """What every program of this folder takes: scenes, the built programs, and, where it needs one, a work folder."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("scenes", nargs="*", type=scene_name, metavar="SCENE", default=list(FRAMES), help=", ".join(FRAMES))
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    if work:
        parser.add_argument("--work", required=True, type=pathlib.Path, help=work)
    return parser


def main():
    parser = scene_parser(__doc__, work="folder for renders; not in the repository")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--only", default="truth,left", help="truth and spheres, a comma-separated list")
    options = parser.parse_args()
    for scene in options.scenes:
        SceneRenders(options.work, options.bin, scene, options.spp).all(options.only.split(","))


if __name__ == "__main__":
    run_as_program(main)
