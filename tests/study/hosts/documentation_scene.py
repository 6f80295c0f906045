#!/usr/bin/env python3
"""Scenes of Mitsuba's own documentation, rendered as a sphere by Mitsuba and played back to two eyes: docs/results/mitsuba/documentation/NAME.{json,jpg}.

    documentation_scene.py --bin build/release/bin --scenes TUTORIALS/scenes --work FOLDER [NAME ...]

TUTORIALS is a copy of https://github.com/mitsuba-renderer/mitsuba-tutorials. The head walks inside the scene; Mitsuba renders a sphere at its
centre (with depth and geometry) and, as the truth, both eyes' perspective views, each with two seeds; the sphere is encoded and played with the
exported geometry's depth and with rotation only. The noise-free error is that of docs/compare.md; the ceiling is truth against truth of the
other seed. Interrupted runs go on where they stopped.
"""

import argparse
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from steps import Steps, machine, run_as_program, versions, write_whole  # noqa: E402

SEEDS = (1, 2)
FRAMES = 4
FRAMES_PER_SECOND = 30
# Name in the results -> method.
SYSTEMS = {"surface": "eye-depth", "sphere": "rotation"}
# Where the head is, what it looks at in the first and last frame; in the scene's own units, +Y up. `unit_m` makes a scene's size that of a room.
SCENES = {
    "cbox": {"file": "cbox.xml", "unit_m": 1.25, "from": ((0.05, 0.3, 0.95), (0, -0.4, 0)), "to": ((0.13, 0.3, 0.9), (0, -0.4, 0)),
             "picture": True},
    # Its licence (CC BY-NC) keeps its pictures out of the repository.
    "lego": {"file": "lego/scene.xml", "unit_m": 1.0, "from": ((0.0, 0.55, 0.75), (0.4, 0.42, 0.5)), "to": ((0.03, 0.55, 0.68), (0.4, 0.42, 0.5)),
             "picture": False},
}


def look_at(eye, target):
    """Quaternion w x y z: -Z towards the target, +Y staying up."""
    back = np.asarray(eye, float) - np.asarray(target, float)
    back /= np.linalg.norm(back)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    turn = np.stack([right, np.cross(back, right), back], axis=1)
    w = 0.5 * np.sqrt(max(0.0, 1 + np.trace(turn)))  # fine here: no camera turns by half a circle
    return [w, *(np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / (4 * w))]


def write_path(file, scene):
    keys = []
    for index, name in ((0, "from"), (FRAMES - 1, "to")):
        eye, target = scene[name]
        position = np.asarray(eye) * scene["unit_m"]
        keys.append(", ".join(f"{value:.9g}" for value in [index / FRAMES_PER_SECOND, *position, *look_at(eye, target)]))
    file.write_text("time_s, x_m, y_m, z_m, qw, qx, qy, qz\n" + "\n".join(keys) + "\n")


class Playback:
    def __init__(self, options, name):
        self.options, self.name, self.scene = options, name, SCENES[name]
        self.work = (options.work / name).resolve()
        self.work.mkdir(parents=True, exist_ok=True)
        self.xml = (options.scenes / self.scene["file"]).resolve()
        aliases = {str(self.xml.parent): "TUTORIALS/scenes", str(self.work) + "/": ""}
        self.steps = Steps(self.work, options.bin, aliases, {"spp": options.spp})
        write_path(self.work / "head.csv", self.scene)

    def render(self, name, seed, *words):
        folder = f"{name}-{seed}"
        record = self.steps.run(f"render-{folder}", "render", self.xml, "--host", "mitsuba", "--unit-m", self.scene["unit_m"], "--path", "head.csv",
                                "--fps", FRAMES_PER_SECOND, "--spp", self.options.spp, "--seed", seed, *words, "--json", "--progress", "none",
                                "--out", folder, fresh=folder)
        return {**record, "report": json.loads(self.steps.output_of(f"render-{folder}"))}

    def run(self):
        view = ["--size", self.options.size, "--fov", self.options.fov]
        result = {"command": f"tests/study/hosts/documentation_scene.py --bin BIN --scenes TUTORIALS/scenes --work FOLDER --spp {self.options.spp}", "scene": self.name, "spp": self.options.spp, "seeds": list(SEEDS), "frames": FRAMES, "renders": [], "systems": {},
                  "versions": versions(self.steps.program, REPOSITORY), "machine": machine()}
        for seed in SEEDS:
            result["renders"].append(self.render("sphere", seed, "--size", self.options.sphere_size, "--aovs", "depth"))
            result["renders"].append(self.render("truth", seed, "--camera", "perspective", "--eye", "both", "--aovs", "none", *view))
            self.steps.run(f"encode-{seed}", "encode", f"sphere-{seed}", "--out", f"sphere-{seed}.mp4", "--crf", 16, "--progress", "none")
            for name, method in SYSTEMS.items():
                self.steps.run(f"play-{name}-{seed}", "play", f"sphere-{seed}.mp4", "--scene", f"sphere-{seed}/scene.json", "--method", method, *view,
                               "--progress", "none", "--out", f"eyes-{name}-{seed}")
        for name in SYSTEMS:
            result["systems"][name] = self.score(f"eyes-{name}", "--second", f"eyes-{name}-2", "truth-2")
        result["ceiling"] = self.score("truth", other="truth-2")
        write_whole(self.options.out / f"{self.name}.json", json.dumps(result, indent=1) + "\n")
        if self.scene["picture"]:
            self.draw()

    def score(self, pictures, *words, other="truth-1"):
        name = f"compare-{pictures}"
        record = self.steps.run(name, "compare", f"{pictures}-1", other, *words, "--json", "--progress", "none")
        eyes = json.loads(self.steps.output_of(name))["eyes"]
        for figures in eyes.values():
            figures.pop("per_frame", None)
        return {"command": record["command"], "eyes": eyes}

    def picture(self, frame_file, plane):
        """A plane of an EXR frame as PNG, by `info --pictures`."""
        folder = f"pictures/{pathlib.Path(frame_file).parent.as_posix().replace('/', '-')}"
        self.steps.run(f"pictures-{folder.rsplit('/', 1)[1]}", "info", frame_file, "--pictures", folder)
        return np.asarray(Image.open(next((self.work / folder).glob(f"*{plane}*.png"))).convert("RGB"))

    def draw(self):
        figure, axes = plt.subplot_mosaic([["colour", "depth"], ["truth-left", "truth-right"], ["left", "right"], ["gaps", "rotated"]],
                                          figsize=(10, 10.9), height_ratios=[1, 1.13, 1.13, 1.13], layout="constrained")
        frame = "frame.0001"
        eyes = {eye: np.asarray(Image.open(self.work / f"eyes-surface-1/{eye}/{frame}.png").convert("RGB")) for eye in ("left", "right")}
        panels = {
            "colour": ("the sphere, rendered by Mitsuba", self.picture(f"sphere-1/centre/{frame}.exr", "colour")),
            "depth": ("its depth", self.picture(f"sphere-1/centre/{frame}.exr", "depth")),
            **{f"truth-{eye}": (f"{eye} eye, rendered by Mitsuba", self.picture(f"truth-1/{eye}/{frame}.exr", "colour")) for eye in eyes},
            **{eye: (f"{eye} eye, played from the stream", picture) for eye, picture in eyes.items()},
            "gaps": ("right eye: what the sphere did not see", np.asarray(Image.open(self.work / f"eyes-surface-1/gaps/right/{frame}.png").convert("RGB"))),
            "rotated": ("right eye, rotation only: difference x 4", self.difference(frame)),
        }
        for name, (title, picture) in panels.items():
            axes[name].imshow(picture)
            axes[name].set_title(title, fontsize=10, loc="left")
            axes[name].set_axis_off()
        figure.savefig(self.options.out / f"{self.name}.jpg", dpi=100, pil_kwargs={"quality": 85, "optimize": True})

    def difference(self, frame):
        rotated = np.asarray(Image.open(self.work / f"eyes-sphere-1/right/{frame}.png").convert("RGB")).astype(int)
        return np.minimum(4 * np.abs(rotated - self.picture(f"truth-1/right/{frame}.exr", "colour")), 255).astype(np.uint8)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=list(SCENES), choices=[*SCENES, []], help="default: all")
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--scenes", required=True, type=pathlib.Path, help="the tutorials' folder of scenes")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder for renders, streams and views; not in the repository")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/mitsuba/documentation")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="640x360", help="of an eye")
    parser.add_argument("--sphere-size", default="1920x960")
    parser.add_argument("--fov", type=float, default=90)
    options = parser.parse_args()
    for name in options.names:
        Playback(options, name).run()


if __name__ == "__main__":
    run_as_program(main)
