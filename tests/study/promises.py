#!/usr/bin/env python3
"""Whether `fit` keeps its word (docs/results/trust/promises.json): its settings files used on other noise than it measured, beside other truths.

    promises.py --bin build/release/bin --work FOLDER [--scenes NAME,...] [--out FILE]

For each scene files are asked for, from the highest of LEVELS down, until three are to be had. Each is used as its reader would: render, encode,
play, compare with two truths. Truths and renders have seeds of their own. Some scenes have one frame, and of one noise it is as if it were
measured once: so it is rendered with as many as its mean needs, as `fit` does. What other runs found of other scenes stays in the file.
"""

import argparse
import json
import pathlib
import subprocess
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
import found  # noqa: E402
from fitting.search import mean_is_known  # noqa: E402
from kept import result_text  # noqa: E402
from presets import REAL_SCENES  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

LEVELS, WANTED = (29, 26, 23, 20, 17, 14), 3
EYE, FOV, MOST_SAMPLES = "256x144", 90, 16
SEEDS, TRUTH_SEEDS, TRUTH_SAMPLES = range(201, 233), (31, 32), 64
GENERATED = ("pavilion", "motion", "materials", "leaf", "near", "poles", "seam", "wires", "mirror", "glass", "inside", "grazing", "sky")


class Scene:
    def __init__(self, programs, work, name):
        self.programs, self.folder, self.name = programs, work / name, name
        self.commit = provenance(programs, REPOSITORY)["versions"]["commit"]
        self.folder.mkdir(parents=True, exist_ok=True)
        self.file = REPOSITORY / f"scenes/descriptions/{name}.json"
        if not self.file.exists():
            self.file = self.folder / f"scene/{name}.json"
            if not self.file.exists():
                self.run("equistream", "scene", "generate", name, "--out", "scene")

    def run(self, program, *words):
        done = subprocess.run([self.programs / program, *map(str, words)], cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError((done.stderr.strip().splitlines() or ["no message"])[-1])
        return done.stdout

    def fitted(self, level):
        """What fit says of the file that it writes; why not, where it writes none."""
        try:
            return json.loads(self.run("equistream-fit", self.file, "--db", level, "--eye-size", EYE, "--fov", FOV, "--most-spp", MOST_SAMPLES, "--json",
                                       "--progress", "none", "--work", "fit", "--out", f"{level}.ini"))
        except RuntimeError as failure:
            if "not to be had" not in str(failure):
                raise
            print(f"{self.name}: {failure}", flush=True)
            return None

    def truths(self, frames):
        for seed in TRUTH_SEEDS:
            self.run("equistream", "render", self.file, "--camera", "perspective", "--fov", FOV, "--eye", "both", "--size", EYE, "--spp", TRUTH_SAMPLES, "--seed", seed,
                     "--unbiased", "--frames", frames, "--progress", "none", "--out", f"truth-{seed}")
        return [f"truth-{seed}" for seed in TRUTH_SEEDS]

    def used(self, level, frames, seed):
        """Its error, of both eyes together. What an earlier run of the same programs has found by the same file is taken as it is."""
        name, settings = f"{level}-{seed}", ("--settings", f"{level}.ini", "--progress", "none", "--out")
        found_in, asked_by = self.folder / f"{name}.json", self.folder / f"{name}.ini"
        asked = f"# {self.commit}, frames {frames}\n" + "\n".join(line for line in (self.folder / f"{level}.ini").read_text().splitlines() if not line.startswith("#"))
        if found_in.exists() and asked_by.exists() and asked_by.read_text() == asked:
            return found.error({"whole": json.loads(found_in.read_text())["eyes"]}, kind=found.WHOLE)
        found_in.unlink(missing_ok=True)
        asked_by.write_text(asked)
        self.run("equistream", "render", self.file, "--seed", seed, "--frames", frames, "--overwrite", *settings, f"frames-{name}")
        self.run("equistream", "encode", f"frames-{name}", *settings, f"{name}.mp4")
        self.run("equistream", "play", f"{name}.mp4", "--overwrite", *settings, f"eyes-{name}")
        first, second = self.truths(frames)
        self.run("equistream", "compare", f"eyes-{name}", first, "--truth2", second, "--metrics", "none", "--progress", "none", "--out", f"{name}.json")
        return found.error({"whole": json.loads(found_in.read_text())["eyes"]}, kind=found.WHOLE)

    def promises(self):
        kept = []
        for level in LEVELS:
            said = self.fitted(level)
            if said is None:
                continue
            frames = "-".join(str(frame) for frame in said["frames"])
            each = []
            for seed in SEEDS:
                each.append(self.used(level, frames, seed))
                if mean_is_known([one["db"] for one in each]):
                    break
            here = found.together(each)
            kept.append({"wanted_db": level, "promised_db": said["db"], "promised_low": said["db_low"], "promised_high": said["db_high"], "frames": frames,
                         "found_db": here["db"], "found_each": [one["db"] for one in each], "seeds_tried": said["seeds"],
                         "samples": said["samples"], "denoise": said["denoise"], "columns": said["columns"], "crf": said["crf"]})
            print(f"{self.name}: promised {said['db']:.2f} dB, found {here['db']:.2f}", flush=True)
            if len(kept) == WANTED:
                break
        return kept


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--scenes", default=",".join(GENERATED + REAL_SCENES))
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/trust/promises.json")
    asked = parser.parse_args()
    for name in asked.scenes.split(","):
        promises = Scene(asked.bin.resolve(), asked.work.resolve(), name).promises()
        report = json.loads(asked.out.read_text()) if asked.out.exists() else {"scenes": {}}  # now: another run may have written it meanwhile
        report["scenes"][name] = {"promises": promises, "eye": EYE, "most_samples": MOST_SAMPLES, "first_seed": SEEDS[0], "truth_seeds": TRUTH_SEEDS,
                                  "truth_samples": TRUTH_SAMPLES, **provenance(asked.bin, REPOSITORY)}
        write_whole(asked.out, result_text(report))


if __name__ == "__main__":
    main()
