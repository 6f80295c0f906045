#!/usr/bin/env python3
"""What the reprojection study is made of: path-traced eyes (the truth) and the spheres that are turned into them.

    renders.py --bin build/release/bin --work FOLDER [SCENE ...]

One frame a scene, two seeds, equal samples everywhere. Truth: both eyes at 63 mm where the path's head is ("stereo"), and
where it is 0.25 m aside ("moved"). Sources: a sphere at the head's centre with its hidden layer, patches and small right
eye, where a leaf is before an eye for the frames before too; the paper's sphere at the left eye with its small right eye, and ours
there with hidden layer and patches besides; spheres of twice the width at the centre and, with its small right eye, at the left eye. The head box of
the scene's description is widened to 0.25 m, so that the moved head stands on its surface. Interrupted runs go on.
"""

import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from standing_head import path_text  # noqa: E402
from steps import Failed, Steps, run_as_program, write_if_other  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SEEDS = (1, 2)
# Scene -> the frame that is studied. In san-miguel's, of all the path's frames the one where it differs most, what is nearer than
# half a metre takes 5.9 % of the left eye and 1.9 % of the right one's: a branch hangs before the left eye. (All
# 150 frames rendered for both eyes at 96x54 with the AOV depth; pixels below 0.5 m counted.)
FRAMES = {"kitchen": 30, "san-miguel": 41, "sibenik": 30, "sponza-crytek": 62, "voxel-city": 30}
# Scene -> the first of the frames that the centre's sphere is rendered for, up to the studied one: for the `earlier` rung.
WALKS_FROM = {"san-miguel": 39}
LEAN_M = 0.25
MOVE_M = (0.20, 0.09, -0.12)  # 0.25 m, in the head's axes
EYE = "960x540"
HEADS = ("stereo", "moved")

SPHERES = {
    "centre": {"size": "1920x960", "options": ["--eye", "centre", "--small", "right", "--layers", "--patches"]},
    "left": {"size": "1920x960", "options": ["--eye", "left", "--small", "right"]},
    "left-ours": {"size": "1920x960", "options": ["--eye", "left", "--small", "right", "--layers", "--patches"]},
    "centre-3840": {"size": "3840x1920", "options": ["--eye", "centre"]},
    "left-3840": {"size": "3840x1920", "options": ["--eye", "left", "--small", "right"]},
}


def rotated(orientation_wxyz, v):
    """v turned by a unit quaternion."""
    w, *q = orientation_wxyz

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    t = [2 * c for c in cross(q, v)]
    return [v[i] + w * t[i] + cross(q, t)[i] for i in range(3)]


class SceneRenders:
    def __init__(self, work, programs, scene, spp):
        self.name = scene
        self.frame = FRAMES[scene]
        self.walk = f"{WALKS_FROM[scene]}-{self.frame}" if scene in WALKS_FROM else None
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
        frames = self.walk if name == "centre" and self.walk else self.frame
        done = self.steps.run(f"render-{name}-seed{seed}", "render", self.scene, "--frames", frames, "--spp", self.spp, "--seed", seed,
                              *options, "--json", "--progress", "none", "--out", folder, fresh=folder)
        return {"name": name, "seed": seed, **done}

    def moved_head(self):
        """CSV of the head 0.25 m aside, from the pose that the stereo truth was rendered at."""
        head = json.loads((self.work / "renders/truth-stereo-1/left/manifest.json").read_text())["first_frame"]["head"]
        position = [a + b for a, b in zip(head["position_m"], rotated(head["orientation_wxyz"], MOVE_M))]
        file = self.work / "scene/moved.csv"
        write_if_other(file, path_text(position, head["orientation_wxyz"]))
        return file

    def truth(self, head, seed):
        # This path stands still; the frame's time is the sphere's, so that moving objects are where they were.
        path = ["--path", self.moved_head()] if head == "moved" else []
        return self.render(f"truth-{head}", seed, "--camera", "perspective", "--eye", "both", "--size", EYE, "--aovs", "depth", *path)

    def sphere(self, name, seed):
        sphere = SPHERES[name]
        # Both seeds must be one system: mirrors and glass are reworked by their planes.
        aovs = "all" if name in ("centre", "left-ours") else "depth"
        return self.render(name, seed, "--size", sphere["size"], "--aovs", aovs, *sphere["options"])

    def all(self, names):
        made = [self.truth(head, seed) for head in HEADS for seed in SEEDS] if "truth" in names else []
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
    parser.add_argument("--only", default="truth,left,left-ours,centre,centre-3840,left-3840", help="truth and spheres, a comma-separated list")
    options = parser.parse_args()
    for scene in options.scenes:
        SceneRenders(options.work, options.bin, scene, options.spp).all(options.only.split(","))


if __name__ == "__main__":
    run_as_program(main)
