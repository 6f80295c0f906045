#!/usr/bin/env python3
"""Every engine and the fill ladder against the path-traced eye, beside rotation, the paper's method and a plain mesh.

    accuracy.py --bin build/release/bin --work FOLDER [SCENE ...]

FOLDER holds what renders.py made. Each system is played for both eyes at 63 mm where the sphere's head is ("stereo") and 0.25 m
aside ("moved"), from uncoded frames and, for the paper's method and ours, from streams of equal bytes. PSNR and SSIM are
against the truth of the other seed; the noise-free error takes both seeds (docs/compare.md). Gaps are what `surface`
finds that the sphere did not see: one mask for all systems of a source and a head; of a source that tells of mirrors and glass also what these
do not show the eye. Figures go to
docs/results/reproject/accuracy/SCENE.json.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from renders import EYE, HEADS, LEAN_M, MOVE_M, REPOSITORY, SEEDS, SPHERES, SceneRenders, scene_parser  # noqa: E402
from steps import Failed, provenance, run_as_program, write_whole  # noqa: E402

EXACT = ["--depth", "exact"]
LADDER = "hidden,patches,earlier,pushpull"  # what `play` does unless told otherwise
PATCHES_FIRST = "patches,hidden,earlier,pushpull"
# Name -> source, method, depth, fill. Engines are told apart with the same fill; then what fills the gaps.
SYSTEMS = {
    "sphere": ("centre", "sphere", [], "none"),
    "lean": ("centre", "lean", [], "none"),
    "splat": ("centre", "splat", EXACT, "pushpull"),
    "gather": ("centre", "gather", EXACT, "pushpull"),
    "mesh": ("centre", "mesh", EXACT, "pushpull"),
    "mesh-plain": ("centre", "mesh-plain", EXACT, "none"),
    "surface": ("centre", "surface", [], "pushpull"),
    "paper": ("left", "surface", [], "small,spread"),
    "ours": ("centre", "surface", [], LADDER),
    "ours-left": ("left-ours", "surface", [], LADDER),
    "surface-3840": ("centre-3840", "surface", [], "pushpull"),
    "gather-3840": ("centre-3840", "gather", EXACT, "pushpull"),
    "mesh-3840": ("centre-3840", "mesh", EXACT, "pushpull"),
    "sphere-3840": ("centre-3840", "sphere", [], "none"),
    "splat-3840": ("centre-3840", "splat", EXACT, "pushpull"),
    "mesh-plain-3840": ("centre-3840", "mesh-plain", EXACT, "none"),
    "paper-3840": ("left-3840", "surface", [], "small,spread"),
}
RUNGS = ("none", "spread", "pushpull", "small", "small-wide", "hidden", "patches", "geometry", "earlier", LADDER, PATCHES_FIRST)
# Which track for gaps comes along -> what fills them.
CODED = {"none": "pushpull", "small": "small-wide,pushpull", "hidden": "hidden,pushpull", "patches": "patches,pushpull"}
OURS = ("ours", "--mirrors", "always")
CRF = 16  # of the paper's method
BEST_CRF, WORST_CRF = 13, 21  # between which ours is looked for
REPEAT = 3  # timings of depth, reprojection and fill


class Accuracy:
    def __init__(self, options, scene):
        self.options = options
        self.renders = SceneRenders(options.work, options.bin, scene, options.spp)
        self.steps = self.renders.steps
        self.work = self.renders.work
        self.result = {
            "scene": scene,
            "command": f"tests/study/reproject/accuracy.py --bin BIN --work WORK --spp {options.spp} --systems {options.systems} {scene}",
            "settings": {"frame": self.renders.frame, "spp": options.spp, "seeds": list(SEEDS), "eye_size": EYE, "fov_deg": 90, "lean_m": LEAN_M,
                         "move_m": MOVE_M, "spheres": {name: sphere["size"] for name, sphere in SPHERES.items()}, "crf": CRF},
            "n": {"frames": 1, "seeds": len(SEEDS), "eyes": 2},
            **provenance(options.bin, REPOSITORY),
        }

    # -- one system played for one head

    def play(self, name, source, head, seed, words):
        views = f"views/{name}-{head}-{seed}"
        place = ["--head", self.renders.moved_head()] if head == "moved" else []
        frames = [] if "--frames" in words else ["--frames", self.renders.frame]
        record = self.steps.run(f"play-{name}-{head}-{seed}", "play", source, "--scene", self.renders.scene, "--size", EYE, "--fov", 90,
                                *place, *frames, *words, "--repeat", REPEAT, "--progress", "none", "--out", views)
        report = json.loads((self.work / views / "report.json").read_text())
        return views, {"command": record["command"], "milliseconds": report["milliseconds"], "notes": report["notes"],
                       "eyes": report["eyes"], "bytes": report["bytes"]["input"]}

    def compare(self, name, *words):
        file = f"scores/{name}.json"
        (self.work / "scores").mkdir(exist_ok=True)
        record = self.steps.run(f"compare-{name}", "compare", *words, "--frames", self.renders.frame, "--progress", "none", "--out", file)
        eyes = json.loads((self.work / file).read_text())["eyes"]
        for eye in eyes.values():
            eye.pop("per_frame", None)
        return {"command": record["command"], "eyes": eyes}

    def score(self, name, sources, head, words, gaps):
        """`sources` by seed."""
        views, played = zip(*(self.play(name, source, head, seed, words) for seed, source in zip(SEEDS, sources)))
        truth = [f"renders/truth-{head}-{seed}" for seed in SEEDS]
        masks = ["--gaps", gaps] if gaps else []
        return {"system": name, "head": head, "played": list(played),
                "against_other_seed": self.compare(f"{name}-{head}", views[0], truth[1], *masks),
                "noise_free": self.compare(f"{name}-{head}-noise-free", views[0], truth[0], "--second", views[1], truth[1],
                                           *masks, "--metrics", "none")}

    def gaps_of(self, source, head):
        """Masks of what the source did not see, of seed 1's geometry; there is none of a perspective source here."""
        folder, _ = self.play(f"mask-{source}", f"renders/{source}-1", head, 1, ["--method", "surface", "--fill", "none"])
        return f"{folder}/gaps"

    def uncoded(self, name, head):
        source, method, depth, fill = SYSTEMS[name]
        words = ["--method", method, *depth, "--fill", fill]
        return self.score(name, [f"renders/{source}-{seed}" for seed in SEEDS], head, words, self.gaps_of(source, head))

    # -- streams of equal bytes

    def encoded(self, source, seed, crf, fill, kind, *words):
        stream = f"streams/{kind}-{source}-{fill}-crf{crf:g}-{seed}.mp4"
        (self.work / "streams").mkdir(exist_ok=True)
        record = self.steps.run(f"encode-{pathlib.Path(stream).stem}", "encode", f"renders/{source}-{seed}", "--out", stream, "--crf", crf,
                                "--frames", self.renders.frame, "--fill", fill, *words, "--json", "--progress", "none")
        report = json.loads(self.steps.output_of(f"encode-{pathlib.Path(stream).stem}"))
        return stream, {"command": record["command"], "crf": crf, "bytes": {track["name"]: track["bytes"] for track in report["tracks"]}}

    def ours_at_no_more_bytes(self, source, seed, limit, track):
        """The best quality from BEST_CRF on, to a quarter of a CRF, whose bytes, all tracks together, do not pass the paper's."""

        def keeps(quarters):
            return sum(self.encoded(source, seed, quarters / 4, track, *OURS)[1]["bytes"].values()) <= limit

        best, worst = BEST_CRF * 4, WORST_CRF * 4
        if not keeps(worst):
            raise Failed(f"{self.renders.name}: no quality of ours keeps to {limit} bytes")
        while best < worst:
            middle = (best + worst) // 2
            best, worst = (best, middle) if keeps(middle) else (middle + 1, worst)
        return self.encoded(source, seed, worst / 4, track, *OURS)

    def coded(self, head):
        paper = [self.encoded("left", seed, CRF, "small", "paper", "--fill-crf", CRF) for seed in SEEDS]
        limits = [sum(record["bytes"].values()) for _, record in paper]
        plays = {"paper-coded": ("left", paper, ["--method", "surface", "--fill", "small,spread"])}
        for source, name in (("centre", "ours"), ("left-ours", "ours-left")):
            for track, fill in CODED.items():
                ours = [self.ours_at_no_more_bytes(source, seed, limit, track) for seed, limit in zip(SEEDS, limits)]
                plays[f"{name}-coded-{track}"] = (source, ours, ["--method", "surface", "--fill", fill])
        scores = []
        for name, (source, streams, words) in plays.items():
            score = self.score(name, [stream for stream, _ in streams], head, words, self.gaps_of(source, head))
            scores.append({**score, "encoded": [record for _, record in streams]})
        return scores

    def rungs(self, head):
        """What each rung gives alone (push-pull fills the rest), then all of them; earlier frames where there are some."""
        frames = ["--frames", self.renders.walk] if self.renders.walk else []
        scores = []
        for rung in RUNGS:
            if rung == "earlier" and not self.renders.walk:
                continue
            fill = rung if rung in ("none", "spread", "pushpull") or "," in rung else f"{rung},pushpull"
            name = "rung-" + rung.replace(",", "-")
            score = self.score(name, [f"renders/centre-{seed}" for seed in SEEDS], head, ["--method", "surface", "--fill", fill, *frames],
                               self.gaps_of("centre", head))
            scores.append({**score, "fill": fill})
        return scores

    def run(self):
        self.result["ceiling"] = {head: self.compare(f"ceiling-{head}", f"renders/truth-{head}-1", f"renders/truth-{head}-2") for head in HEADS}
        names = [name for name in self.options.systems.split(",") if name in SYSTEMS]
        self.result["systems"] = [self.uncoded(name, head) for head in HEADS for name in names]
        if "coded" in self.options.systems:
            self.result["coded"] = [score for head in HEADS for score in self.coded(head)]
        if "rungs" in self.options.systems:
            self.result["rungs"] = [score for head in HEADS for score in self.rungs(head)]
        file = self.options.out / f"{self.renders.name}.json"
        write_whole(file, json.dumps(self.result, indent=1) + "\n")
        print(f"{file}: {len(self.result['systems'])} scores")


def main():
    parser = scene_parser(__doc__, work="folder that renders.py filled")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/accuracy", help="folder for SCENE.json")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--systems", default=",".join([*SYSTEMS, "coded", "rungs"]), help="a comma-separated list of " + ", ".join([*SYSTEMS, "coded", "rungs"]))
    options = parser.parse_args()
    for scene in options.scenes:
        Accuracy(options, scene).run()


if __name__ == "__main__":
    run_as_program(main)
