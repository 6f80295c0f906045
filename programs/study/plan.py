"""A preset as jobs for a farm, with the time they take told from frames that were measured.

Every render is split into runs of frames, a job each; a scene's experiments are one job that needs all of its renders. A render's time is its samples by the
samples a second that the same scene was rendered with in an earlier result; what is measured of a scene takes what it took there, by frames and pixels.
`equistream farm study` makes tasks of them. What each job is stands in a list, so that it does not change when results do; each leaves its frames in a folder of
its own (SceneWork.gather).
"""

import dataclasses
import json

import found
import render_list
from presets import OF_SCENES, OF_THEIR_OWN, PRESETS
from steps import Refused, read_json, write_whole

JOB_S = 3600
"""What a render job is meant to take."""


@dataclasses.dataclass(frozen=True)
class Job:
    scene: str
    render: render_list.Render
    first: int
    last: int
    seconds: float


def samples_per_second(result):
    """Of all renders of a result together, those that began from nothing: by the processor's seconds over its cores, which other work beside does not stretch."""
    made = [record for record in result["renders"] if record["frames_kept"] == 0 and not record["name"].startswith("geometry-")]
    if not made:
        raise Refused(f"{result['scene']}: expected renders that were timed whole, found none")
    processor_s = sum(sum(record["cpu_s"].values()) for record in made)
    return sum(record["paths"] for record in made) * result["machine"]["cores"] / processor_s


def rates(folder, scenes):
    """Scene -> samples a second, and which result says so. Refused for a scene that has none."""
    measured = found.load(folder, "systems")
    for scene in scenes:
        if scene not in measured:
            raise Refused(f"{folder}/systems/{scene}.json: expected a measured result to tell times from, found none (--preset small makes it)")
    return {scene: samples_per_second(measured[scene]) for scene in scenes}


def jobs_of(preset, scene, rate):
    first, last = preset.frame_range(scene)
    for render in render_list.every_render(preset, scene):
        end = first + render.frames - 1 if render.frames else last
        frame_s = render.samples_a_frame() / rate
        step = max(1, int(JOB_S / frame_s))
        for begin in range(first, end + 1, step):
            until = min(begin + step - 1, end)
            yield Job(scene, render, begin, until, (until - begin + 1) * frame_s)


def all_jobs(preset, scenes, folder):
    by_scene = rates(folder, scenes)
    return [job for scene in scenes for job in jobs_of(preset, scene, by_scene[scene])]


def jobs_file(preset, out):
    return out / f"study-{preset.name}.jobs.json"


def planned_job(preset, number, out):
    """One of those that steps() listed."""
    file = jobs_file(preset, out)
    if not file.exists():
        raise Refused(f"{file}: expected the list that equistream farm study writes, found none")
    jobs = read_json(file)
    if not 0 <= number < len(jobs):
        raise Refused(f"--job: expected 0 to {len(jobs) - 1}, found {number}")
    job = jobs[number]
    render = next((render for render in render_list.every_render(preset, job["scene"]) if render.name == job["render"]), None)
    if render is None:
        raise Refused(f"{file}: job {number}: expected a render of preset {preset.name}, found '{job['render']}'; equistream farm study makes the list anew")
    return Job(job["scene"], render, job["first"], job["last"], job["seconds"])


def measuring_s(preset, scene, folder):
    """What its experiments had taken of one processor beside renders when the last of them was done, by frames and by pixels of eyes."""
    results = [found.load(folder, experiment).get(scene) for experiment in OF_SCENES]
    last = max((result for result in results if result and "measuring_cpu_s" in result), key=lambda result: result["measuring_cpu_s"], default=None)
    if last is None:
        raise Refused(f"{folder}: expected a result of {scene} that says what its measuring took of a processor, found none; --again measures it anew")
    before = last["settings"]
    pixels = preset.eye[0] * preset.eye[1] / (before["eye"][0] * before["eye"][1])
    return last["measuring_cpu_s"] * preset.frames / before["frames"] * pixels


def of_scenes(preset):
    return [experiment for experiment in OF_SCENES if experiment not in preset.left_out]


def steps(study, measured, step):
    """A farm's steps of the study with these options: its list of jobs is written, and stays as it is when results change."""
    preset = PRESETS[study.preset]
    scenes = study.scenes.split(",") if study.scenes else list(preset.scenes)
    jobs = all_jobs(preset, scenes, measured)
    write_whole(jobs_file(preset, study.out), json.dumps([{"scene": job.scene, "render": job.render.name, "first": job.first, "last": job.last, "seconds": round(job.seconds, 1)}
                                                          for job in jobs], indent=0) + "\n")
    of_all = ["study", "--preset", preset.name, "--out", str(study.out), *(["--work", str(study.work)] if study.work else [])]
    measuring = [round(measuring_s(preset, scene, measured), 1) for scene in scenes]
    return [step("render", "run", words=of_all, numbered="--job", tasks=len(jobs), seconds=max(job.seconds for job in jobs), all_s=sum(job.seconds for job in jobs)),
            step("measure", "run", after=["render"], words=[*of_all, "--experiments", ",".join(of_scenes(preset)), "--charts", "none"], tasks=len(scenes),
                 each=[["--scenes", scene] for scene in scenes], seconds=max(measuring), all_s=sum(measuring)),
            step("generated", "run", words=[*of_all, "--experiments", ",".join(OF_THEIR_OWN), "--charts", "none"]),
            step("draw", "run", after=["measure", "generated"], words=[*of_all, "--charts", "only"])]
