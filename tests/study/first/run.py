#!/usr/bin/env python3
"""The first experiment: three systems, two codecs, two qualities, two seeds, on real scenes, end to end.

    run.py --bin build/release/bin --work FOLDER [SCENE ...]

For each scene it path traces, with two seeds, the truth (left and right eye), the paper's perspective system (the left
eye, which is the truth's, and a small right one), a sphere at the left eye and one at the head's centre (each with a
small right eye); encodes all in H.264 and H.265 at two CRFs; plays them with `surface` and `sphere`; and compares with
the truth. PSNR and SSIM compare a system of one seed with the truth of the other, since a perspective system shares its
left eye with the truth of its own seed. The noise-free error takes both seeds (docs/compare.md). The ceiling is
truth against truth of the other seed. "none" as codec is the system before coding.

Interrupted runs go on where they stopped. All figures go to docs/results/first/SCENE.json.
"""

import argparse
import itertools
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from steps import Failed, Steps, machine, run_as_program, versions, write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
SEEDS = (1, 2)
# Name -> what `render` makes of it; "perspective" is the paper's system 1, "sphere-left" its system 2.
SYSTEMS = {
    "perspective": {"camera": "perspective", "eye": "left"},
    "sphere-left": {"camera": "equirect", "eye": "left"},
    "sphere-centre": {"camera": "equirect", "eye": "centre"},
}
METHODS = ("surface", "sphere")
FILL = "small,spread"  # as the paper does


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=["sponza-crytek", "san-miguel"], help="sponza-crytek, san-miguel, pavilion or a description")
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder for renders, streams and views; not in the repository")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/first", help="folder for SCENE.json")
    parser.add_argument("--frames", default="60-67", help="FIRST-LAST")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="640x360", help="of an eye")
    parser.add_argument("--sphere-size", default="960x480")
    parser.add_argument("--fov", type=float, default=90)
    parser.add_argument("--codecs", default="h264,h265")
    parser.add_argument("--crfs", default="16,24")
    parser.add_argument("--repeat", type=int, default=5, help="timings of depth, reprojection and fill per frame")
    parser.add_argument("--render-only", action="store_true", help="stop after the renders")
    return parser.parse_args()


class Experiment:
    def __init__(self, options, scene):
        self.options = options
        self.name = pathlib.Path(scene).stem
        self.work = (options.work / self.name).resolve()
        if REPOSITORY in self.work.parents:
            raise Failed(f"--work: expected a folder outside the repository, found {options.work}")
        self.work.mkdir(parents=True, exist_ok=True)
        self.steps = Steps(self.work, options.bin, {str(REPOSITORY) + "/": "", str(self.work) + "/": ""}, {"frames": options.frames})
        self.scene = self.description(scene)
        self.result = {
            "scene": self.name,
            "settings": {"frames": options.frames, "spp": options.spp, "eye_size": options.size, "sphere_size": options.sphere_size,
                         "fov_deg": options.fov, "seeds": list(SEEDS), "repeat": options.repeat,
                         "note": f"bytes depend on noise: {options.spp} samples per pixel"},
            "made": time.strftime("%Y-%m-%d", time.gmtime()),
            "command": f"tests/study/first/run.py --bin BIN --work WORK --frames {options.frames} --spp {options.spp} --size {options.size} "
                       f"--sphere-size {options.sphere_size} --fov {options.fov:g} --codecs {options.codecs} --crfs {options.crfs} "
                       f"--repeat {options.repeat} {scene}",
            "versions": versions(self.steps.program, REPOSITORY), "machine": machine(),
        }

    def description(self, scene):
        if scene.endswith(".json"):
            return pathlib.Path(scene).resolve()
        described = REPOSITORY / "scenes/descriptions" / f"{scene}.json"
        if described.exists():
            return described
        self.steps.run(f"generate-{scene}", "scene", "generate", scene, "--out", "scene")
        return self.work / "scene" / f"{scene}.json"

    # -- rendering

    def render(self, name, seed, folder, *options):
        step = f"render-{name}-seed{seed}"
        done = self.steps.run(step, "render", self.scene, "--frames", self.options.frames, "--spp", self.options.spp, "--seed", seed,
                              "--aovs", "none", *options, "--json", "--progress", "none", "--out", folder, fresh=folder)
        report = json.loads(self.steps.output_of(step))
        return {"name": name, "seed": seed, **done, **report}

    def renders(self):
        made = []
        for seed in SEEDS:
            for name, system in SYSTEMS.items():
                view = system["camera"] == "perspective"
                size = ["--size", self.options.size, "--fov", self.options.fov] if view else ["--size", self.options.sphere_size]
                made.append(self.render(name, seed, f"renders/{name}-{seed}", "--camera", system["camera"], "--eye", system["eye"],
                                        "--small", "right", *size))
            made.append(self.render("truth-right", seed, f"renders/truth-{seed}", "--camera", "perspective", "--eye", "right", "--size",
                                    self.options.size, "--fov", self.options.fov))
            left = self.work / f"renders/truth-{seed}/left"
            if not left.is_symlink():
                left.symlink_to(f"../perspective-{seed}/left")
        return made

    # -- one system, coded and played

    def source(self, system, seed, codec, crf):
        """What play is given: a stream, or the renders themselves. Returns it with the encoder's record."""
        renders = f"renders/{system}-{seed}"
        if codec == "none":
            return renders, None
        stream = f"streams/{system}-{codec}-crf{crf}-{seed}.mp4"
        (self.work / "streams").mkdir(exist_ok=True)
        record = self.steps.run(f"encode-{system}-{codec}-crf{crf}-seed{seed}", "encode", renders, "--out", stream, "--codec", codec,
                                "--crf", crf, "--fill-crf", crf, "--progress", "none")
        return stream, record

    def play(self, system, method, seed, codec, crf):
        source, encoded = self.source(system, seed, codec, crf)
        name = f"{system}-{method}-{codec}" + ("" if codec == "none" else f"-crf{crf}") + f"-{seed}"
        record = self.steps.run(f"play-{name}", "play", source, "--scene", self.scene, "--method", method, "--fill", FILL, "--size", self.options.size,
                                "--fov", self.options.fov, "--repeat", self.options.repeat, "--progress", "none", "--out", f"views/{name}")
        report = json.loads((self.work / f"views/{name}/report.json").read_text())
        played = {"command": record["command"], "milliseconds": report["milliseconds"], "scene_load_ms": report["scene_load_ms"],
                  "gap_fraction": {eye: report["eyes"][eye]["gap_fraction"] for eye in ("left", "right")},
                  "filled": {eye: report["eyes"][eye]["filled"] for eye in ("left", "right")},
                  "frames": len(report["frames"]), "notes": report["notes"]}
        if encoded:
            played["encode_command"] = encoded["command"]
            played["bytes"] = {track: entry["bytes"] for track, entry in report["bytes"]["input"].items()}
            played["file_bytes"] = (self.work / source).stat().st_size
        return f"views/{name}", played

    def compare(self, name, picture, truth, *options):
        file = f"scores/{name}.json"
        (self.work / "scores").mkdir(exist_ok=True)
        record = self.steps.run(f"compare-{name}", "compare", picture, truth, *options, "--progress", "none", "--out", file)
        scores = json.loads((self.work / file).read_text())
        for eye in scores["eyes"].values():
            eye.pop("per_frame", None)
        return {"command": record["command"], "eyes": scores["eyes"]}

    def score(self, system, method, codec, crf):
        views, played = zip(*(self.play(system, method, seed, codec, crf) for seed in SEEDS))
        name = views[0].removeprefix("views/").removesuffix(f"-{SEEDS[0]}")
        noisy = [self.compare(f"{name}-seed{seed}", view, f"renders/truth-{other}", "--gaps", f"{view}/gaps")
                 for seed, other, view in zip(SEEDS, reversed(SEEDS), views)]
        free = self.compare(f"{name}-noise-free", views[0], f"renders/truth-{SEEDS[0]}", "--second", views[1],
                            f"renders/truth-{SEEDS[1]}", "--metrics", "none")
        return {"system": system, "method": method, "codec": codec, "crf": crf, "n_frames": played[0]["frames"], "n_seeds": len(SEEDS),
                "played": list(played), "against_other_seed": noisy,
                "noise_free": {"command": free["command"], "eyes": {eye: figures["noise_free"] for eye, figures in free["eyes"].items()}}}

    def scores(self):
        codings = [("none", None)] + [(codec, int(crf)) for codec, crf in
                                            itertools.product(self.options.codecs.split(","), self.options.crfs.split(","))]
        return [self.score(system, method, codec, crf)
                for system, method, (codec, crf) in itertools.product(SYSTEMS, METHODS, codings)]

    def run(self):
        self.result["renders"] = self.renders()
        if self.options.render_only:
            return
        self.result["ceiling"] = self.compare("ceiling", f"renders/truth-{SEEDS[0]}", f"renders/truth-{SEEDS[1]}")
        self.result["systems"] = self.scores()
        write_whole(self.options.out / f"{self.name}.json", json.dumps(self.result, indent=1) + "\n")
        print(f"{self.options.out / (self.name + '.json')}: {len(self.result['systems'])} systems")


def main():
    options = arguments()
    for scene in options.scenes:
        Experiment(options, scene).run()


if __name__ == "__main__":
    run_as_program(main)
