#!/usr/bin/env python3
"""How far random eyes of the head box see things displaced, by engine: docs/results/reproject/shift.json.

    shift.py --bin build/release/bin --work FOLDER [SCENE ...]

No renders are needed: measured_shift.cpp casts rays for the sphere's depth, the eyes' and the truth. Once with small eyes, many of
them; once with eyes of 1920x1080, whose quarter of a pixel is a fourth of the angle; and with those once more where all depth is that of
the client's model for the same budget, which is made in FOLDER. Runs that are done are kept there and not repeated.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from renders import FRAMES, LEAN_M, REPOSITORY, SceneRenders, scene_parser  # noqa: E402
from results import keep  # noqa: E402
from steps import digest, measured_json, provenance, run_as_program, write_whole  # noqa: E402

MODEL_PX = 0.25
RUNS = ({"run": "small eyes", "size": "480x270", "eyes": 64}, {"run": "eyes", "size": "1920x1080", "eyes": 8},
        {"run": "eyes, the client's model", "size": "1920x1080", "eyes": 8})


class Shifts:
    def __init__(self, options, scene):
        self.options, self.scene = options, scene
        self.program = options.bin / "equistream_measured_shift"
        self.study = SceneRenders(options.work, options.bin, scene, options.spp)

    def measured(self, run, size, eyes):
        words = [f"scenes/descriptions/{self.scene}.json", "--frame", str(FRAMES[self.scene]), "--lean", str(LEAN_M), "--eyes", str(eyes),
                 "--seed", str(self.options.seed), "--engines", self.options.engines, "--size", size]
        result = {"run": run, "size": size, "n": {"eyes": eyes, "seed": self.options.seed}}
        model = []
        if "model" in run:
            file, result["model"] = self.study.model(MODEL_PX)
            model = ["--model", str(self.study.work / file)]
        result["command"] = " ".join([self.program.name, *words, *(["--model", file] if model else [])])
        kept = self.study.work / f"shift/{run.replace(' ', '-')}.json"
        programs = digest(self.options.bin)
        if kept.exists():
            done = json.loads(kept.read_text())
            if done["programs"] == programs and done["result"]["command"] == result["command"]:
                return done["result"]
        result["engines"] = measured_json(self.program, [*words, *model], REPOSITORY)
        write_whole(kept, json.dumps({"programs": programs, "result": result}) + "\n")
        return result


def main():
    parser = scene_parser(__doc__, work="folder for the client's models and what is measured; not in the repository")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/shift.json", help="file of all scenes' results")
    parser.add_argument("--spp", type=int, default=16, help="of renders made in FOLDER before: not looked at here")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engines", default="eye-depth,mesh,splat")
    options = parser.parse_args()
    for scene in options.scenes:
        shifts = Shifts(options, scene)
        result = {"scene": scene, "command": f"tests/study/reproject/shift.py --bin BIN --work FOLDER --seed {options.seed} --engines {options.engines} {scene}",
                  "runs": [shifts.measured(**run) for run in RUNS], **provenance(options.bin, REPOSITORY)}
        keep(options.out, scene, result)


if __name__ == "__main__":
    run_as_program(main)
