#!/usr/bin/env python3
"""What streamed depth costs and loses: every depth code within a share of the colour's bits, beside lossless depth.

    depth_codes.py --bin build/release/bin --work FOLDER [SCENE ...]

FOLDER holds what renders.py made (truth and `left`). Colour is the same CRF 16 for all, so views differ by their depth
alone. Each code takes the best CRF whose bytes stay within --share of the colour's (`encode --depth CODE --depth-share`);
codes that cannot are given at their worst, and Pece's packing at the colour's CRF too, as the paper would. Both eyes are
played from streamed depth alone; the eye that the sphere was rendered for is only turned, so the loss is told of the other one. The
noise-free error takes both seeds (docs/compare.md). Figures go to docs/results/reproject/depth_codes.json.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from renders import EYE, LEAN_M, REPOSITORY, SEEDS, SPHERES, SceneRenders, scene_parser  # noqa: E402
from results import keep  # noqa: E402
from steps import provenance, run_as_program  # noqa: E402

CRF = 16
REFERENCE = "lossless"
# Name -> code, codec, CRF where it is not looked for, and what `encode` is told besides.
SYSTEMS = {
    REFERENCE: ("lossless", "h264", None),
    "auto": ("auto", "h264", None),
    "w8": ("w8", "h264", None),
    "w10": ("w10", "h264", None),
    "w12": ("w12", "h264", None),
    "w10-h265": ("w10", "h265", None),
    "w10-h265-whole": ("w10", "h265", None, "--depth-scale", 1),
    "w12-whole": ("w12", "h264", None, "--depth-scale", 1),
    "w12-half": ("w12", "h264", None, "--depth-scale", 2),
    "pece420": ("pece420", "h264", None),
    "pece444": ("pece444", "h264", None),
    "pece420-crf16": ("pece420", "h264", CRF),
    "pece444-crf16": ("pece444", "h264", CRF),
    "hue": ("hue", "h264", None),
}
METHODS = ("splat", "mesh")
SCALES = ("linear", "display")


def loss(best, found):
    """dB between two noise-free figures of compare; None where one of them found no error."""
    return None if best["db"] is None or found["db"] is None else best["db"] - found["db"]


class DepthCodes:
    def __init__(self, options, scene):
        self.options = options
        self.renders = SceneRenders(options.work, options.bin, scene, options.spp)
        self.steps = self.renders.steps
        self.work = self.renders.work
        self.result = {
            "scene": scene,
            "command": f"tests/study/reproject/depth_codes.py --bin BIN --work WORK --spp {options.spp} --share {options.share} "
                       f"--systems {options.systems} {scene}",
            "settings": {"frame": self.renders.frame, "spp": options.spp, "seeds": list(SEEDS), "source": options.source,
                         "sphere": SPHERES[options.source]["size"], "eye_size": EYE, "fov_deg": 90, "lean_m": LEAN_M, "crf": CRF,
                         "preset": "medium", "share": options.share, "fill": "pushpull"},
            "n": {"frames": 1, "seeds": len(SEEDS), "eyes": 2},
            **provenance(options.bin, REPOSITORY),
        }

    def encode(self, name, seed):
        code, codec, crf, *further = SYSTEMS[name]
        stream = f"streams/depth-{name}-{seed}.mkv"
        (self.work / "streams").mkdir(exist_ok=True)
        quality = ["--depth-crf", crf] if crf is not None else ["--depth-share", self.options.share]
        record = self.steps.run(f"encode-depth-{name}-{seed}", "encode", f"renders/{self.options.source}-{seed}", "--out", stream, "--crf", CRF,
                                "--codec", codec, "--frames", self.renders.frame, "--fill", "none", "--depth", code, *quality, *further,
                                "--json", "--progress", "none")
        tracks = {t["name"]: t for t in json.loads(self.steps.output_of(f"encode-depth-{name}-{seed}"))["tracks"]}
        return stream, {"command": record["command"], "colour_bytes": tracks["main"]["bytes"], "depth_bytes": tracks["depth"]["bytes"],
                        "share": tracks["depth"]["bytes"] / tracks["main"]["bytes"], "codec": tracks["depth"].get("codec"), **tracks["depth"]["depth_code"]}

    def play(self, name, method, seed, stream):
        views = f"views/depth-{name}-{method}-{seed}"
        record = self.steps.run(f"play-depth-{name}-{method}-{seed}", "play", stream, "--depth", "stream", "--method", method, "--size", EYE,
                                "--fov", 90, "--fill", "pushpull", "--progress", "none", "--out", views)
        return views, record["command"]

    def compare(self, name, views):
        file = f"scores/depth-{name}.json"
        (self.work / "scores").mkdir(exist_ok=True)
        truth = [f"renders/truth-stereo-{seed}" for seed in SEEDS]
        record = self.steps.run(f"compare-depth-{name}", "compare", views[0], truth[0], "--second", views[1], truth[1], "--metrics", "none",
                                "--progress", "none", "--out", file)
        eyes = json.loads((self.work / file).read_text())["eyes"]
        return record["command"], {eye: score["noise_free"] for eye, score in eyes.items()}

    def score(self, name):
        streams = [self.encode(name, seed) for seed in SEEDS]
        scores = {}
        for method in METHODS:
            views, commands = zip(*(self.play(name, method, seed, stream) for seed, (stream, _) in zip(SEEDS, streams)))
            command, noise_free = self.compare(f"{name}-{method}", views)
            scores[method] = {"played": list(commands), "command": command, "noise_free": noise_free}
        return {"system": name, "code": SYSTEMS[name][0], "codec": SYSTEMS[name][1], "encoded": [record for _, record in streams],
                "scores": scores}

    def losses(self):
        """Of each eye, method and scale of values, beside the same colour with lossless depth: above 0 is worse."""
        reference = self.result["systems"][0]["scores"]
        for system in self.result["systems"]:
            for method, score in system["scores"].items():
                score["loss_db"] = {eye: {scale: loss(reference[method]["noise_free"][eye][scale], noise_free[scale]) for scale in SCALES}
                                    for eye, noise_free in score["noise_free"].items()}

    def run(self):
        names = [name for name in SYSTEMS if name == REFERENCE or name in self.options.systems.split(",")]
        self.result["systems"] = [self.score(name) for name in names]
        self.losses()
        keep(self.options.out, self.renders.name, self.result)
        for system in self.result["systems"]:
            lost = system["scores"][METHODS[0]]["loss_db"]
            share = sum(record["share"] for record in system["encoded"]) / len(SEEDS)
            print(f"{system['system']:14} {100 * share:6.1f} % of the colour  " +
                  "  ".join(f"{eye} {'none' if db['linear'] is None else format(db['linear'], '+.3f') + ' dB'}" for eye, db in lost.items()))


def main():
    parser = scene_parser(__doc__, work="folder that renders.py filled")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--share", type=float, default=0.1, help="of the colour's bits that depth may take")
    parser.add_argument("--source", default="left", choices=["left", "centre"], help="which sphere; `centre` moves both eyes")
    parser.add_argument("--systems", default=",".join(SYSTEMS), help="a comma-separated list; lossless always comes along")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/depth_codes.json")
    options = parser.parse_args()
    for scene in options.scenes:
        DepthCodes(options, scene).run()


if __name__ == "__main__":
    run_as_program(main)
