#!/usr/bin/env python3
"""What the client's model costs in accuracy: triangles kept against dB lost, by error budget.

    model.py --bin build/release/bin --work FOLDER [SCENE ...]

FOLDER holds what renders.py made. For each budget `equistream model` makes the client's geometry; `play --method surface` then
turns the spheres of both seeds to both eyes with the scene's own geometry and with the model's, gaps left alone. The noise-free error takes
both seeds (docs/compare.md). Figures go to docs/results/reproject/model/SCENE.json.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from renders import EYE, LEAN_M, REPOSITORY, SEEDS, SceneRenders, scene_parser  # noqa: E402
from steps import provenance, run_as_program, write_whole  # noqa: E402

BUDGETS_PX = (0.0625, 0.25, 1.0, 4.0)
SHARE = 0.25
ROUNDS = 40  # more than the default: kitchen takes over 12 to keep the smallest budget


class ModelStudy:
    def __init__(self, options, scene):
        self.options = options
        self.renders = SceneRenders(options.work, options.bin, scene, options.spp)
        self.steps = self.renders.steps
        self.work = self.renders.work

    def model(self, error_px):
        name = f"model-{error_px:g}px"
        file = f"models/{name}.json"
        (self.work / "models").mkdir(exist_ok=True)
        record = self.steps.run(name, "model", self.renders.scene, "--error-px", error_px, "--share", SHARE, "--rounds", ROUNDS, "--json", "--progress", "none", "--out", file)
        figures = json.loads(self.steps.output_of(name))
        kept = ("error_px", "share", "focal_px", "box_radius_m", "triangles", "bytes", "seconds", "rounds", "check")
        return file, {"command": record["command"], **{key: figures[key] for key in kept}}

    def score(self, name, *geometry):
        """Of both eyes at 63 mm, by the spheres of both seeds."""
        views = []
        for seed in SEEDS:
            views.append(f"views/model-{name}-{seed}")
            self.steps.run(f"play-model-{name}-{seed}", "play", f"renders/{self.options.source}-{seed}", *geometry, "--frames", self.renders.frame, "--method",
                           "surface", "--fill", "spread", "--size", EYE, "--fov", 90, "--progress", "none", "--out", views[-1])
        file = f"scores/model-{name}.json"
        (self.work / "scores").mkdir(exist_ok=True)
        truth = [f"renders/truth-stereo-{seed}" for seed in SEEDS]
        record = self.steps.run(f"compare-model-{name}", "compare", views[0], truth[0], "--second", views[1], truth[1], "--metrics", "none",
                                "--progress", "none", "--out", file)
        eyes = json.loads((self.work / file).read_text())["eyes"]
        for eye in eyes.values():
            eye.pop("per_frame", None)
        return {"command": record["command"], "eyes": eyes}

    def run(self):
        exact = self.score("scene", "--scene", self.renders.scene)
        models = []
        for error_px in self.options.budgets:
            file, made = self.model(error_px)
            score = self.score(f"{error_px:g}px", "--model", file)
            models.append({"model": made, "noise_free": score})
        result = {"scene": self.renders.name,
                  "command": f"tests/study/reproject/model.py --bin BIN --work WORK --spp {self.options.spp} --source {self.options.source} {self.renders.name}",
                  "settings": {"frame": self.renders.frame, "spp": self.options.spp, "seeds": list(SEEDS), "source": self.options.source,
                               "eye_size": EYE, "fov_deg": 90, "lean_m": LEAN_M, "fill": "spread"},
                  "n": {"frames": 1, "seeds": len(SEEDS), "eyes": 2}, "scene_geometry": exact, "models": models,
                  **provenance(self.options.bin, REPOSITORY)}
        file = self.options.out / f"{self.renders.name}.json"
        write_whole(file, json.dumps(result, indent=1) + "\n")
        print(f"{file}: {len(models)} models")


def main():
    parser = scene_parser(__doc__, work="folder that renders.py filled")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/model", help="folder for SCENE.json")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--source", default="centre", help="which sphere of renders.py: centre or left")
    parser.add_argument("--budgets", type=lambda text: [float(word) for word in text.split(",")], default=list(BUDGETS_PX),
                        help="whole error budgets in pixels, a comma-separated list")
    options = parser.parse_args()
    for scene in options.scenes:
        ModelStudy(options, scene).run()


if __name__ == "__main__":
    run_as_program(main)
