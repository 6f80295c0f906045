"""One scene's folder of the study: what it is rendered, coded, played and compared as, each by the program, each once (steps.py).

Records of commands name files relative to the folder, so that they do not depend on the machine.
"""

import functools
import json
import pathlib

import equistream as es
import render_list
from gathered import gather
from narrowed import made_once, narrow_sequence
from presets import SEEDS
from steps import HERE, REPOSITORY, Refused, Steps, measured_json

STRESS = next(folder for folder in (HERE / "stress", REPOSITORY / "tests/stress") if folder.is_dir())
"""Scenes that break reprojection, and how they are played and scored."""


@functools.cache
def fingerprint_of(program, description):
    """Of all that decides what the scene looks like, files that its model names among it. Asked once a run: the whole scene is read for it."""
    return measured_json(program, ["scene", "info", description, "--json"], ".")["fingerprint"]


class SceneWork:
    """`description` of the preset's scenes is the repository's; bundled scenes are generated."""

    def __init__(self, work, programs, scene, preset, progress=None):
        self.scene, self.preset = scene, preset
        self.folder = (pathlib.Path(work) / scene).resolve()
        if REPOSITORY in self.folder.parents and REPOSITORY / "build" not in self.folder.parents:
            raise Refused(f"--work: expected a folder outside the repository, found {work}")
        self.folder.mkdir(parents=True, exist_ok=True)
        self.first, self.last = preset.frame_range(scene)
        self.steps = Steps(self.folder, programs, {str(REPOSITORY) + "/": "", str(self.folder) + "/": ""},
                           {"preset": preset.name, "frames": f"{self.first}-{self.last}"}, progress)

    @functools.cached_property
    def description(self):
        """Steps that come after it is asked for are of the scene as it is now."""
        found = self.found_description()
        self.steps.context["scene"] = fingerprint_of(self.steps.program, found)
        return found

    def found_description(self):
        described = REPOSITORY / f"scenes/descriptions/{self.scene}.json"
        if described.exists():
            return described
        self.steps.run("scene", "scene", "generate", self.scene, "--out", "scene")
        return self.folder / f"scene/{self.scene}.json"

    def expect_scene(self):
        """Refused for a scene that is not there, before hours are spent on others."""
        self.steps.run("scene-info", "scene", "info", self.description, "--json")

    @property
    def info(self):
        """What `scene info` says of it."""
        self.expect_scene()
        return {key: value for key, value in json.loads(self.steps.output_of("scene-info")).items() if key != "command"}

    @property
    def frames(self):
        return f"{self.first}-{self.last}"

    # -- renders

    def render(self, spec, frames=None):
        """Its folder, relative; the step's record goes with the others (render_records). `frames` in place of the specification's."""
        out = f"renders/{spec.name}"
        frames = frames or (f"{self.first}-{self.first + spec.frames - 1}" if spec.frames else self.frames)
        self.gather(spec)
        with self.steps.keeping(f"render-{spec.name}", lambda report: json.loads(report)["frames_rendered"] > 0):
            self.steps.run(f"render-{spec.name}", "render", self.description, "--frames", frames, *spec.words(), "--json", "--progress", "none", "--out", out, fresh=out)
        return out

    def render_part(self, spec, first, last):
        """Some of its frames, in a folder of their own: no two programs write to one sequence. render() finds them."""
        out = f"parts/{spec.name}/{first:06}-{last:06}"
        self.steps.run(f"part-{spec.name}-{first}-{last}", "render", self.description, "--frames", f"{first}-{last}", *spec.words(), "--json", "--progress", "none", "--out", out, fresh=out)
        return out

    def gather(self, spec):
        """What parts have rendered, as one sequence."""
        gather((self.folder / "parts" / spec.name).glob("*"), self.folder / f"renders/{spec.name}")

    def render_record(self, step):
        """What render() or render_part() left of it: `step` is render-NAME or part-NAME-FIRST-LAST. None where a crash has left half of that."""
        record, said = Steps.record_in(self.folder / f"steps/{step}.json"), Steps.json_in(self.folder / f"steps/{step}.out")
        return {**Steps.told_of(record), **said, "command": record["command"]} if record and said else None

    def render_records(self):
        steps = sorted(file.stem for kind in ("render", "part") for file in (self.folder / "steps").glob(f"{kind}-*.json"))
        return [{"name": step.removeprefix("render-"), **record} for step in steps if (record := self.render_record(step))]

    def measuring_cpu_s(self):
        """Of all steps so far but renders, seconds of a processor, which other work beside does not stretch."""
        records = [Steps.record_in(file) for file in (self.folder / "steps").glob("*.json") if not file.name.startswith(("render-", "part-"))]
        return sum(record["cpu_s"] for record in records if record)

    def perspective(self, seed):
        return self.render(render_list.perspective(self.preset, seed))

    def truth(self, seed):
        """Both eyes, unbiased: what views of this seed are put beside, of a seed of its own."""
        return self.render(render_list.truth(self.preset, self.scene, seed))

    def pair(self, seed):
        """A view of each eye, a folder for each."""
        return [f"{self.perspective(seed)}/left", f"{self.render(render_list.right_eye(self.preset, seed))}/right"]

    def whole_sphere(self, place, seed):
        return self.render(render_list.whole_sphere(self.preset, place, seed))

    def sphere(self, place, width, seed):
        """Of this width: filtered from the wide one where that is a whole number of times as wide, else rendered, the first frames alone."""
        if not self.preset.is_filtered(width):
            return self.render(render_list.parity_sphere(self.preset, place, seed, width))
        wide = self.render(render_list.wide_sphere(self.preset, place, seed))
        return wide if width == self.preset.sphere_width else self.narrowed(wide, width, seed)

    def told_sphere(self, place, seed):
        """The wide one, with what AOVs tell of mirrors and glass."""
        wide = self.render(render_list.wide_sphere(self.preset, place, seed))
        return self.with_geometry(wide, "told", self.preset.sphere_width, seed, render_list.WITH_MIRRORS)

    def tells_of_mirrors(self, place):
        """Whether any of its spheres' pixels has something to tell."""
        told = self.folder / self.told_sphere(place, SEEDS[0]) / place
        return any(bool(frame["specular"].any()) for frame in es.Sequence(told, "specular"))

    def narrowed(self, wide, width, seed):
        """A rendered sphere, and what lies beside it, at another width."""
        return self.with_geometry(wide, f"at-{width}", width, seed, render_list.DEPTH)

    def with_geometry(self, wide, suffix, width, seed, aovs):
        name = f"{pathlib.Path(wide).name}-{suffix}"
        folders = sorted(folder.name for folder in (self.folder / wide).iterdir() if (folder / "manifest.json").exists())
        place = next(folder for folder in folders if folder in render_list.PLACES)
        geometry = self.render(render_list.geometry(name, place, seed, width, "small" in folders, aovs))
        for folder in folders:
            full, thin, out = (self.folder / path / folder for path in (wide, geometry, f"renders/{name}"))
            made_once(out, (full, thin), lambda full=full, thin=thin, out=out: narrow_sequence(full, thin, out))
        return f"renders/{name}"

    # -- coding, playing, comparing

    def encode(self, name, source, *options, suffix="mp4", timed=False):
        """A stream and its report: bytes and pictures of each track."""
        stream = f"streams/{name}.{suffix}"
        (self.folder / "streams").mkdir(exist_ok=True)
        record = self.steps.run(f"encode-{name}", "encode", source, "--out", stream, *options, "--json", "--progress", "none", timed=timed)
        report = json.loads(self.steps.output_of(f"encode-{name}"))
        tracks = {track["name"]: track["bytes"] for track in report["tracks"]}
        return stream, {"command": record["command"], "wall_s": record["wall_s"], "bytes": tracks}

    def play(self, name, source, *options, timed=False):
        """A folder of views, relative, and what `play` says of them."""
        views = f"views/{name}"
        record = self.steps.run(f"play-{name}", "play", source, "--size", render_list.size_text(self.preset.eye), "--fov", f"{self.preset.fov_deg:g}",
                                "--repeat", self.preset.repeat, *options, "--progress", "none", "--out", views, timed=timed)
        report = json.loads((self.folder / views / "report.json").read_text())
        return views, {"command": record["command"], "milliseconds": report["milliseconds"], "notes": report["notes"], "eyes": report["eyes"],
                       "bytes": report["bytes"]["input"], "frames": report["played"]}

    def compare(self, name, *words):
        file = f"scores/{name}.json"
        (self.folder / "scores").mkdir(exist_ok=True)
        record = self.steps.run(f"compare-{name}", "compare", *words, "--progress", "none", "--out", file)
        eyes = json.loads((self.folder / file).read_text())["eyes"]
        for eye in eyes.values():
            eye.pop("per_frame", None)
        return {"command": record["command"], "eyes": eyes}

    def scored(self, name, views, frames=None, eyes=None):
        return self.beside(name, views, self.truths(), frames, eyes)

    def truths(self):
        return [self.truth(seed) for seed in SEEDS]

    def beside(self, name, views, truth, frames=None, eyes=None):
        """Views of both seeds against both truths: the whole error of one, with its PSNR and SSIM, and the noise-free error of both; how either flickers."""
        words = self.choosing(views, frames, eyes)
        return {**self.wholly(name, views, truth, frames, eyes),
                "noise_free": self.compare(f"{name}-noise-free", views[0], truth[0], "--second", views[1], truth[1], "--metrics", "flicker", *words)["eyes"]}

    def wholly(self, name, views, truth, frames=None, eyes=None):
        """The whole error alone."""
        words = self.choosing(views, frames, eyes)
        return {"whole": self.compare(name, views[0], truth[1], "--truth2", truth[0], "--metrics", "psnr,ssim,flicker", *words)["eyes"]}

    def choosing(self, views, frames, eyes):
        gaps = f"{views[0]}/gaps"
        return [*(["--frames", frames] if frames else []), *(["--eyes", eyes] if eyes else []), *(["--gaps", gaps] if (self.folder / gaps).exists() else [])]
