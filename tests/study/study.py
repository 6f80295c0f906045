#!/usr/bin/env python3
"""The study: every method on every scene, speed against accuracy, and where each breaks.

    equistream study [--preset smoke|small|paper] [--scenes A,B] [--experiments A,B] --out DIR

Each experiment of each scene leaves DIR/EXPERIMENT/SCENE.json; what is there already is not measured again (--again), and what was interrupted goes on
where it stopped. Renders, streams and views stay in the work folder. In the end charts and a page for each scene are drawn from what DIR holds.
"""

import argparse
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import charts.accuracy  # noqa: E402
import charts.latency  # noqa: E402
import charts.moved  # noqa: E402
import charts.paper  # noqa: E402
import charts.parity  # noqa: E402
import charts.parsimony  # noqa: E402
import charts.related  # noqa: E402
import charts.stability  # noqa: E402
import charts.where  # noqa: E402
import plan  # noqa: E402
from charts.looks import COLOURS  # noqa: E402
from experiments import EXPERIMENTS, OF_SCENES  # noqa: E402
from found import load  # noqa: E402
from kept import LEFT_OUT, all_pictures, lean, result_text, write_pictures  # noqa: E402
from page import write_page  # noqa: E402
from page_pictures import Pictures  # noqa: E402
from presets import PRESETS, SEEDS  # noqa: E402
from scene_work import REPOSITORY, SceneWork  # noqa: E402
from steps import Failed, provenance, read_json, run_as_program, write_whole  # noqa: E402
from tables import write_tables  # noqa: E402


def names_of(known):
    def chosen(text):
        names = text.split(",")
        for name in names:
            if name not in known:
                raise argparse.ArgumentTypeError(f"expected some of {', '.join(known)}, found '{name}'")
        return names
    return chosen


def arguments():
    parser = argparse.ArgumentParser(prog="equistream study", description=__doc__.splitlines()[0],
                                     epilog="example: equistream study --preset smoke --out study-out")
    parser.add_argument("--preset", choices=PRESETS, default="smoke",
                        help="smoke: the bundled scene in miniature, minutes; small: the real scenes on two cores, an hour each; paper: its own numbers, a job array")
    parser.add_argument("--scenes", help="a comma-separated list; default: the preset's")
    parser.add_argument("--experiments", type=names_of(EXPERIMENTS), help=f"a comma-separated list of {', '.join(EXPERIMENTS)}; default: the preset's, all but where, moved and related of smoke")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for EXPERIMENT/SCENE.json, charts and pages")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders, streams and views; default: DIR/work")
    parser.add_argument("--plan", action="store_true", help="measure nothing: write job arrays for Slurm and the Open Job Description, and tell what they would take")
    parser.add_argument("--job", type=int, metavar="N", help="one of the render jobs that --plan listed in the folder of --out, and nothing else")
    parser.add_argument("--measured", type=pathlib.Path, default=REPOSITORY / "docs/results/study", help="results that --plan tells times from; default: the committed ones")
    parser.add_argument("--charts", choices=("after", "only", "none"), default="after",
                        help="after: charts, tables and pages are drawn once all is measured; only: they are, of what is there; none: they are not")
    parser.add_argument("--again", action="store_true", help="measure what is there already, too")
    parser.add_argument("--bin", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    return parser.parse_args()


def settings(preset):
    """What makes a result another one: all numbers of the preset, and their seeds."""
    return {key: list(value) if isinstance(value, tuple) else value for key, value in vars(preset).items() if key != "scenes"} | {
        "widest": vars(preset.widest), "seeds": list(SEEDS)}


class Study:
    def __init__(self, options):
        self.options = options
        self.preset = PRESETS[options.preset]
        self.work = options.work or options.out / "work"
        self.experiments = options.experiments or [name for name in EXPERIMENTS if name not in self.preset.left_out]
        self.scenes = options.scenes.split(",") if options.scenes else list(self.preset.scenes)

    def is_done(self, file):
        if self.options.again or not file.exists():
            return False
        found = read_json(file)["settings"]
        wanted = json.loads(result_text(settings(self.preset)))
        # What a preset says more by now, nothing that was measured hangs on.
        if differing := ", ".join(key for key in found if found[key] != wanted.get(key)):
            raise Failed(f"{file}: expected a result of preset {self.preset.name} as it is now, found another {differing}; --again measures it anew")
        return True

    def file(self, experiment, scene):
        return self.options.out / experiment / f"{scene}.json"

    def measure(self, experiment, scene):
        file = self.file(experiment, scene)
        if self.is_done(file):
            print(f"{file}: there already", flush=True)
            return
        began = time.monotonic()
        work = SceneWork(self.work, self.options.bin, scene, self.preset)
        made = provenance(self.options.bin, REPOSITORY)
        result = {"scene": scene, "experiment": experiment,
                  "command": " ".join(["equistream study --preset", self.preset.name, *(["--scenes", scene] if experiment in OF_SCENES else []),
                                       "--experiments", experiment, "--out DIR"]),
                  "settings": settings(self.preset), **made, **EXPERIMENTS[experiment](work)}
        result["renders"] = work.render_records()
        result["took_s"] = round(time.monotonic() - began, 1)
        result["measuring_cpu_s"] = round(work.measuring_cpu_s(), 1)
        if experiment == "systems":
            write_pictures(self.options.out, scene, Pictures(work).all_of(result["systems"], result["anaglyph"]["view"]))
        write_whole(file, result_text(lean(result, LEFT_OUT.get(experiment, ()))))
        print(f"{file}: {result['took_s']:.0f} s", flush=True)

    def run(self):
        if self.options.plan:
            print(plan.write_plan(self.preset, self.scenes, self.options.measured, self.options.out))
            return
        if self.options.job is not None:
            self.render_job()
            return
        if self.options.charts != "only":
            self.measure_all()
        if self.options.charts != "none":
            self.draw()

    def measure_all(self):
        of_scenes = [experiment for experiment in self.experiments if experiment in OF_SCENES]
        wanted = [(experiment, scene) for scene in self.scenes for experiment in of_scenes]
        for scene in dict.fromkeys(scene for experiment, scene in wanted if not self.is_done(self.file(experiment, scene))):
            SceneWork(self.work, self.options.bin, scene, self.preset).expect_scene()
        for experiment, scene in wanted + [(experiment, "generated") for experiment in self.experiments if experiment not in of_scenes]:
            self.measure(experiment, scene)

    def render_job(self):
        job = plan.planned_job(self.preset, self.options.job, self.options.out)
        SceneWork(self.work, self.options.bin, job.scene, self.preset).render_part(job.render, job.first, job.last)

    def draw(self):
        for chart in (charts.accuracy, charts.paper, charts.where, charts.moved, charts.parity, charts.parsimony, charts.stability, charts.latency, charts.related):
            chart.draw_all(self.options.out)
        write_tables(self.options.out)
        systems = load(self.options.out, "systems")
        for scene in all_pictures(self.options.out, systems):
            write_page(systems[scene], COLOURS, self.options.out / f"{scene}.html")


def main():
    Study(arguments()).run()


if __name__ == "__main__":
    run_as_program(main)
