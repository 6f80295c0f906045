#!/usr/bin/env python3
"""Every engine and the fill ladder against the path-traced eye, beside rotation, the paper's method and a plain mesh.

    accuracy.py --bin build/release/bin --work FOLDER [--systems NAMES [--add]] [SCENE ...]

FOLDER holds what renders.py made. Each system is played for both eyes at 63 mm where the sphere's head is ("stereo") and 0.25 m
aside ("moved"), from uncoded frames and, for the paper's method and ours, from streams of equal bytes. PSNR and SSIM are
against the truth of the other seed; the noise-free error takes both seeds (docs/compare.md). Gaps are what `surface`
finds that the sphere did not see: one mask for all systems of a source and a head, and for both spheres at the left eye; of a source that tells of
mirrors and glass also what these do not show the eye. Figures go to docs/results/reproject/accuracy/SCENE.json.
With --add the file keeps what it has: the systems named are put into it, or take the place of their own older figures, and each says by itself
when, how and with which version it was measured.
"""

import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from renders import EYE, HEADS, LEAN_M, MOVE_M, REPOSITORY, SEEDS, SPHERES, SceneRenders, scene_parser  # noqa: E402
from steps import Failed, provenance, run_as_program, write_whole  # noqa: E402

EXACT = ["--depth", "exact"]
LADDER = "hidden,patches,earlier,pushpull"  # what `play` does unless told otherwise
PATCHES_FIRST = "patches,hidden,earlier,pushpull"
IMAGES, GAPS, SURFACE = (["--mirrors", treatment] for treatment in ("images", "gaps", "surface"))
# Name -> source, method, depth or mirrors, fill. Engines are told apart with the same fill; then what fills the gaps; then what becomes of mirrors,
# which ours takes by their images unless told, and of which the paper's sphere does not tell.
SYSTEMS = {
    "sphere": ("centre", "sphere", [], "none"),
    "lean": ("centre", "lean", [], "none"),
    "splat": ("centre", "splat", EXACT, "pushpull"),
    "gather": ("centre", "gather", EXACT, "pushpull"),
    "mesh": ("centre", "mesh", EXACT, "pushpull"),
    "mesh-plain": ("centre", "mesh-plain", EXACT, "none"),
    "surface": ("centre", "surface", [], "pushpull"),
    "paper": ("left", "surface", [], "small,spread"),
    "paper-gaps": ("left-ours", "surface", GAPS, "small,spread"),
    "paper-images": ("left-ours", "surface", IMAGES, "small,spread"),
    "ours": ("centre", "surface", [], LADDER),
    "ours-gaps": ("centre", "surface", GAPS, LADDER),
    "ours-surface": ("centre", "surface", SURFACE, LADDER),
    "ours-left": ("left-ours", "surface", [], LADDER),
    "ours-left-gaps": ("left-ours", "surface", GAPS, LADDER),
    "ours-left-surface": ("left-ours", "surface", SURFACE, LADDER),
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
# Name -> source, track, of ours.
OURS_CODED = {f"{name}-coded-{track}": (source, track) for name, source in (("ours", "centre"), ("ours-left", "left-ours")) for track in CODED}
CODED_SYSTEMS = ("paper-coded", "paper-gaps-coded", *OURS_CODED)
ALL = (*SYSTEMS, "coded", "rungs")
WITH_MIRRORS = ("--mirrors", "always")
OURS = ("ours", *WITH_MIRRORS)
# Both spheres at the left eye are judged in the gaps of the one that tells of mirrors too.
MASK_OF = {"left": "left-ours"}
CRF = 16  # of the paper's method
BEST_CRF, WORST_CRF = 13, 21  # between which ours is looked for
REPEAT = 3  # timings of depth, reprojection and fill


def rung_name(rung):
    return "rung-" + rung.replace(",", "-")


ORDER = {name: i for i, name in enumerate((*SYSTEMS, *CODED_SYSTEMS, *map(rung_name, RUNGS)))}


def to_add_to(file, settings):
    """The result measured before; Failed where there is none, or one of other settings than these."""
    if not file.exists():
        raise Failed(f"--add: expected a result measured before to add to, found no {file}")
    before, now = json.loads(file.read_text()), json.loads(json.dumps(settings))
    for key, value in now.items():
        found = before["settings"].get(key)
        if key == "spheres":  # one may have been thought of since
            found, value = ({name: spheres[name] for name in found if name in value} for spheres in (found, value))
        if found != value:
            raise Failed(f"--add: {file}: expected {key} {value}, as now, found {found}")
    return before


def with_rows_of(before, result):
    """`before` with the rows of `result`, which take the place of the same system's for the same head and carry their own provenance."""
    own = {key: result[key] for key in ("command", "made", "versions", "machine")}
    both = {**before, "settings": {**before["settings"], "spheres": {**before["settings"].get("spheres", {}), **result["settings"].get("spheres", {})}}}
    for kind in ("systems", "coded", "rungs"):
        rows = {(row["head"], row["system"]): row for row in before.get(kind, [])}
        rows |= {(row["head"], row["system"]): {**row, "measured": own} for row in result.get(kind, [])}
        if rows:
            both[kind] = sorted(rows.values(), key=lambda row: (HEADS.index(row["head"]), ORDER.get(row["system"], len(ORDER))))
    return both


def write_result(file, result, add):
    if add:
        result = with_rows_of(to_add_to(file, result["settings"]), result)
    write_whole(file, json.dumps(result, indent=1) + "\n")


class Accuracy:
    def __init__(self, options, scene):
        self.options = options
        self.renders = SceneRenders(options.work, options.bin, scene, options.spp)
        self.steps = self.renders.steps
        self.work = self.renders.work
        self.file = options.out / f"{scene}.json"
        self.result = {
            "scene": scene,
            "command": f"tests/study/reproject/accuracy.py --bin BIN --work WORK --spp {options.spp} --systems {','.join(options.systems)}"
                       f"{' --add' * options.add} {scene}",
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
        source = MASK_OF.get(source, source)
        folder, _ = self.play(f"mask-{source}", f"renders/{source}-1", head, 1, ["--method", "surface", "--fill", "none"])
        return f"{folder}/gaps"

    def uncoded(self, name, head):
        source, method, further, fill = SYSTEMS[name]
        words = ["--method", method, *further, "--fill", fill]
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

    def paper(self, source, kind, *words):
        """Its streams by seed."""
        return [self.encoded(source, seed, CRF, "small", kind, "--fill-crf", CRF, *words) for seed in SEEDS]

    def streams_of(self, name):
        """A coded system's source, streams by seed, and how they are played."""
        paper_words = ["--method", "surface", "--fill", "small,spread"]
        if name == "paper-gaps-coded":
            return "left-ours", self.paper("left-ours", "paper-gaps", *WITH_MIRRORS), [*paper_words, *GAPS]
        paper = self.paper("left", "paper")
        if name == "paper-coded":
            return "left", paper, paper_words
        source, track = OURS_CODED[name]
        limits = [sum(record["bytes"].values()) for _, record in paper]
        ours = [self.ours_at_no_more_bytes(source, seed, limit, track) for seed, limit in zip(SEEDS, limits)]
        return source, ours, ["--method", "surface", "--fill", CODED[track]]

    def coded(self, name, head):
        source, streams, words = self.streams_of(name)
        score = self.score(name, [stream for stream, _ in streams], head, words, self.gaps_of(source, head))
        return {**score, "encoded": [record for _, record in streams]}

    def rungs(self, head):
        """What each rung gives alone (push-pull fills the rest), then all of them; earlier frames where there are some."""
        frames = ["--frames", self.renders.walk] if self.renders.walk else []
        scores = []
        for rung in RUNGS:
            if rung == "earlier" and not self.renders.walk:
                continue
            fill = rung if rung in ("none", "spread", "pushpull") or "," in rung else f"{rung},pushpull"
            score = self.score(rung_name(rung), [f"renders/centre-{seed}" for seed in SEEDS], head, ["--method", "surface", "--fill", fill, *frames],
                               self.gaps_of("centre", head))
            scores.append({**score, "fill": fill})
        return scores

    def run(self):
        asked = self.options.systems
        if self.options.add:
            to_add_to(self.file, self.result["settings"])  # refused before anything is measured
        else:
            self.result["ceiling"] = {head: self.compare(f"ceiling-{head}", f"renders/truth-{head}-1", f"renders/truth-{head}-2") for head in HEADS}
        self.result["systems"] = [self.uncoded(name, head) for head in HEADS for name in SYSTEMS if name in asked]
        if coded := [name for name in CODED_SYSTEMS if name in asked or "coded" in asked]:
            self.result["coded"] = [self.coded(name, head) for head in HEADS for name in coded]
        if "rungs" in asked:
            self.result["rungs"] = [score for head in HEADS for score in self.rungs(head)]
        write_result(self.file, self.result, self.options.add)
        print(f"{self.file}: {sum(len(self.result.get(kind, [])) for kind in ('systems', 'coded', 'rungs'))} scores")


def systems(text):
    names = text.split(",")
    for name in names:
        if name not in (*ALL, *CODED_SYSTEMS):
            raise argparse.ArgumentTypeError(f"expected some of {', '.join((*ALL, *CODED_SYSTEMS))}, found '{name}'")
    return names


def main():
    parser = scene_parser(__doc__, work="folder that renders.py filled")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/accuracy", help="folder for SCENE.json")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--systems", type=systems, default=list(ALL),
                        help=f"a comma-separated list of {', '.join(ALL)}; or, of coded, of {', '.join(CODED_SYSTEMS)}")
    parser.add_argument("--add", action="store_true", help="to what SCENE.json already has, measured with the same settings; otherwise it is replaced")
    options = parser.parse_args()
    for scene in options.scenes:
        Accuracy(options, scene).run()


if __name__ == "__main__":
    run_as_program(main)
