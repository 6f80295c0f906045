"""A study: measures what is missing, then draws. See study.py."""

import contextlib
import json
import sys
import time

import charts.paper
import charts.parity
import charts.parsimony
import charts.related
import charts.stability
import charts.systems
import charts.window
import plan
from charts.looks import COLOURS
from experiments import EXPERIMENTS
from found import known_within_db, load, whole_errors
from kept import LEFT_OUT, all_pictures, lean, result_text, write_pictures
from options import Progress
from page import Pictures, write_page
from presets import KNOWN_DB, OF_SCENES, PRESETS, SEEDS
from scene_work import REPOSITORY, SceneWork
from steps import Refused, provenance, read_json, write_whole
from tables import write_tables


def settings(preset, scene):
    """What makes a result of a scene another one: all numbers of the preset, and their seeds."""
    return {key: list(value) if isinstance(value, tuple) else value for key, value in vars(preset).items() if key not in ("scenes", "steps")} | {
        "parity": vars(preset.parity), "seeds": list(SEEDS), "truth_samples": preset.truth_samples_of(scene)}


def tell_how_well_known(result, file):
    """How wide the whole errors' intervals are; a line on the standard error where one is wider than it is to be."""
    halves = sorted(map(known_within_db, whole_errors(result)))
    if not halves:
        return
    wide = [half for half in halves if half > KNOWN_DB]
    print(f"{file}: whole errors known within {halves[len(halves) // 2]:.2f} dB (the median of {len(halves)}), {halves[-1]:.2f} dB at most", flush=True)
    if wide:
        print(f"{file}: warning: expected whole errors known within {KNOWN_DB:g} dB, found {len(wide)} of {len(halves)} wider, with "
              f"{result['settings']['truth_samples']} samples a pixel of the truth (truth_samples of the preset)", file=sys.stderr, flush=True)


class Study:
    def __init__(self, options):
        self.options = options
        self.preset = PRESETS[options.preset]
        self.work = options.work or options.out / "work"
        self.experiments = options.experiments or [name for name in EXPERIMENTS if name not in self.preset.left_out]
        self.progress = Progress("study", options.progress, self.steps_left())
        self.scenes = options.scenes.split(",") if options.scenes else list(self.preset.scenes)
        self.since = time.time() if options.again else 0
        self.results = []

    def is_done(self, file):
        if self.options.again or not file.exists():
            return False
        found = read_json(file)
        if not isinstance(found, dict) or not isinstance(found.get("settings"), dict):
            raise Refused(f"{file}: expected what a study wrote, found other JSON; remove it")
        found = found["settings"]
        wanted = json.loads(result_text(settings(self.preset, file.stem)))
        # What a preset says more by now, nothing that was measured hangs on.
        if differing := ", ".join(key for key in found if found[key] != wanted.get(key)):
            raise Refused(f"{file}: expected a result of preset {self.preset.name} as it is now, found another {differing}; --again measures it anew")
        return True

    def file(self, experiment, scene):
        return self.options.out / experiment / f"{scene}.json"

    def work_of(self, scene):
        work = SceneWork(self.work, self.options.bin, scene, self.preset, self.progress)
        work.steps.since = self.since
        return work

    def measure(self, experiment, scene):
        file = self.file(experiment, scene)
        self.results.append(file)
        if self.is_done(file):
            print(f"{file}: there already", flush=True)
            return
        began = time.monotonic()
        work = self.work_of(scene)
        made = provenance(self.options.bin, REPOSITORY)
        result = {"scene": scene, "experiment": experiment,
                  "command": " ".join(["equistream study --preset", self.preset.name, *(["--scenes", scene] if experiment in OF_SCENES else []),
                                       "--experiments", experiment, "--out DIR"]),
                  "settings": settings(self.preset, scene), **made, **EXPERIMENTS[experiment](work)}
        result["renders"] = work.render_records()
        result["took_s"] = round(time.monotonic() - began, 1)
        result["measuring_cpu_s"] = round(work.measuring_cpu_s(), 1)
        if experiment == "systems":
            write_pictures(self.options.out, scene, Pictures(work).all_of(result["systems"], result["anaglyph"]["view"]))
        write_whole(file, result_text(lean(result, LEFT_OUT.get(experiment, ()))))
        print(f"{file}: {result['took_s']:.0f} s", flush=True)
        tell_how_well_known(result, file)

    def steps_left(self):
        """Of the preset as it comes; None where nobody has counted them."""
        if not self.preset.steps or self.options.experiments or self.options.scenes or self.options.again:
            return None
        return max(1, self.preset.steps - len(list(self.work.glob("*/steps/*.json"))))

    def run(self):
        began = time.monotonic()
        with contextlib.redirect_stdout(sys.stderr) if self.options.json else contextlib.nullcontext():
            self.do()
        if self.options.json:
            files = self.results or [file for experiment in self.experiments for file in sorted((self.options.out / experiment).glob("*.json"))]
            print(json.dumps({"preset": self.preset.name, "results": [str(file) for file in files], "seconds": round(time.monotonic() - began, 1),
                              **provenance(self.options.bin, REPOSITORY)}, indent=1))

    def do(self):
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
            self.work_of(scene).expect_scene()
        for experiment, scene in wanted + [(experiment, "generated") for experiment in self.experiments if experiment not in of_scenes]:
            self.measure(experiment, scene)

    def render_job(self):
        job = plan.planned_job(self.preset, self.options.job, self.options.out)
        self.work_of(job.scene).render_part(job.render, job.first, job.last)

    def draw(self):
        if not any(self.options.out.glob("*/*.json")):
            raise Refused(f"{self.options.out}: expected what a study measured, EXPERIMENT/SCENE.json, found none")
        for chart in (charts.systems, charts.paper, charts.parity, charts.parsimony, charts.stability, charts.related, charts.window):
            chart.draw_all(self.options.out)
        write_tables(self.options.out)
        systems = load(self.options.out, "systems")
        for scene in all_pictures(self.options.out, systems):
            write_page(systems[scene], COLOURS, self.options.out / f"{scene}.html")
