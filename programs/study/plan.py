"""A preset as jobs for a farm, with the time they take told from frames that were measured.

Every render is split into runs of frames, a job each; a scene's experiments are one job that needs all of its renders. A render's time is its samples by the
samples a second that the same scene was rendered with in an earlier result; what is measured of a scene takes what it took there, by frames and pixels.
Jobs go out as an array for Slurm (`sbatch`) and as a template of the Open Job Description. What each of them is stands in a list beside them, so that it does
not change when results do; each leaves its frames in a folder of its own (SceneWork.gather).
"""

import dataclasses
import json
import math

import found
import render_list
from presets import OF_SCENES, OF_THEIR_OWN
from steps import Failed, read_json, write_whole

JOB_S = 3600
"""What a render job is meant to take."""
LARGEST_ARRAY = 1000
"""Of Slurm, unless its administrator allows more (MaxArraySize)."""
ARRAY_SCRIPT = """#!/bin/sh
# Every render of preset {preset}, {each} of the {count} jobs a task. All of it, one after the other:
#   renders=$(sbatch --parsable '{out}/{name}.sh')
#   measured=$(sbatch --parsable --dependency=afterok:$renders '{out}/{name}-measure.sh')
#   sbatch --dependency=afterok:$measured --wrap 'equistream study --preset {preset} --charts only --out "{out}"'
#SBATCH --job-name={name}
#SBATCH --array=0-{last}
#SBATCH --time={minutes}
job=$((SLURM_ARRAY_TASK_ID * {each}))
end=$((job + {each}))
while [ $job -lt $end ] && [ $job -lt {count} ]; do
    equistream study --preset {preset} --job $job --out "{out}" || exit
    job=$((job + 1))
done
"""
MEASURE_SCRIPT = """#!/bin/sh
# What is measured of each scene, when all renders are there; last, what has scenes of its own. Submitted again, a task whose time ran out goes on where it was.
#SBATCH --job-name={name}-measure
#SBATCH --array=0-{last}
#SBATCH --time={minutes}
[ "$SLURM_ARRAY_TASK_ID" = {last} ] && exec equistream study --preset {preset} --experiments {generated} --charts none --out "{out}"
set -- {scenes}
shift "$SLURM_ARRAY_TASK_ID"
exec equistream study --preset {preset} --scenes "$1" --experiments {of_scenes} --charts none --out "{out}"
"""


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
        raise Failed(f"{result['scene']}: expected renders that were timed whole, found none")
    processor_s = sum(sum(record["cpu_s"].values()) for record in made)
    return sum(record["paths"] for record in made) * result["machine"]["cores"] / processor_s


def rates(folder, scenes):
    """Scene -> samples a second, and which result says so. Failed for a scene that has none."""
    measured = found.load(folder, "systems")
    for scene in scenes:
        if scene not in measured:
            raise Failed(f"{folder}/systems/{scene}.json: expected a measured result to tell times from, found none (--preset small makes it)")
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
    """One of those that write_plan listed."""
    file = jobs_file(preset, out)
    if not file.exists():
        raise Failed(f"{file}: expected the list that --plan writes, found none")
    jobs = read_json(file)
    if not 0 <= number < len(jobs):
        raise Failed(f"--job: expected 0 to {len(jobs) - 1}, found {number}")
    job = jobs[number]
    render = next((render for render in render_list.every_render(preset, job["scene"]) if render.name == job["render"]), None)
    if render is None:
        raise Failed(f"{file}: job {number}: expected a render of preset {preset.name}, found '{job['render']}'; --plan makes the list anew")
    return Job(job["scene"], render, job["first"], job["last"], job["seconds"])


def measuring_s(preset, scene, folder):
    """What its experiments had taken of one processor beside renders when the last of them was done, by frames and by pixels of eyes."""
    results = [found.load(folder, experiment).get(scene) for experiment in OF_SCENES]
    last = max((result for result in results if result and "measuring_cpu_s" in result), key=lambda result: result["measuring_cpu_s"], default=None)
    if last is None:
        raise Failed(f"{folder}: expected a result of {scene} that says what its measuring took of a processor, found none; --again measures it anew")
    before = last["settings"]
    pixels = preset.eye[0] * preset.eye[1] / (before["eye"][0] * before["eye"][1])
    return last["measuring_cpu_s"] * preset.frames / before["frames"] * pixels


def of_scenes(preset):
    return [experiment for experiment in OF_SCENES if experiment not in preset.left_out]


def action(*words):
    return {"actions": {"onRun": {"command": "equistream", "args": ["study", *words, "--out", "{{Param.Out}}"]}}}


def tasks(name, kind, values):
    return {"taskParameterDefinitions": [{"name": name, "type": kind, "range": values}]}


def template(preset, scenes, count):
    """Of the Open Job Description, version jobtemplate-2023-09. OUT is where the plan was written: its list of jobs is read there."""
    start = ("--preset", preset.name)
    return {"specificationVersion": "jobtemplate-2023-09", "name": f"equistream study, preset {preset.name}",
            "parameterDefinitions": [{"name": "Out", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT"}],
            "steps": [{"name": "render", "parameterSpace": tasks("Job", "INT", f"0-{count - 1}"), "script": action(*start, "--job", "{{Task.Param.Job}}")},
                      {"name": "measure", "dependencies": [{"dependsOn": "render"}], "parameterSpace": tasks("Scene", "STRING", list(scenes)),
                       "script": action(*start, "--scenes", "{{Task.Param.Scene}}", "--experiments", ",".join(of_scenes(preset)), "--charts", "none")},
                      {"name": "generated", "script": action(*start, "--experiments", ",".join(OF_THEIR_OWN), "--charts", "none")},
                      {"name": "draw", "dependencies": [{"dependsOn": "measure"}, {"dependsOn": "generated"}], "script": action(*start, "--charts", "only")}]}


def clock(seconds):
    minutes = int(seconds // 60) + 1
    return f"{minutes // 60}:{minutes % 60:02}:00"


def write_plan(preset, scenes, measured, out):
    """The list, the scripts, and a table of what each scene takes."""
    jobs = all_jobs(preset, scenes, measured)
    name, out = f"study-{preset.name}", out.resolve()
    each = math.ceil(len(jobs) / LARGEST_ARRAY)
    longest = max(job.seconds for job in jobs)
    results = found.load(measured, "systems")
    measuring = {scene: measuring_s(preset, scene, measured) for scene in scenes}
    write_whole(out / f"{name}.sh", ARRAY_SCRIPT.format(preset=preset.name, name=name, each=each, count=len(jobs), last=math.ceil(len(jobs) / each) - 1, minutes=clock(2 * each * longest),
                                                         out=out))
    write_whole(out / f"{name}-measure.sh", MEASURE_SCRIPT.format(preset=preset.name, name=name, last=len(scenes), minutes=clock(2 * max(measuring.values())), scenes=" ".join(scenes),
                                                                  of_scenes=",".join(of_scenes(preset)), generated=",".join(OF_THEIR_OWN), out=out))
    write_whole(jobs_file(preset, out), json.dumps([{"scene": job.scene, "render": job.render.name, "first": job.first, "last": job.last, "seconds": round(job.seconds, 1)}
                                                    for job in jobs], indent=0) + "\n")
    write_whole(out / f"{name}.template.json", json.dumps(template(preset, scenes, len(jobs)), indent=1) + "\n")
    lines = [f"{'scene':<16}{'jobs':>8}{'rendering, h':>14}{'measuring, h':>14}   (of machines like {next(iter(results.values()))['machine']['cpu']}, {next(iter(results.values()))['machine']['cores']} cores)"]
    for scene in scenes:
        own = [job for job in jobs if job.scene == scene]
        lines.append(f"{scene:<16}{len(own):>8}{sum(job.seconds for job in own) / 3600:>14.1f}{measuring[scene] / 3600:>14.1f}")
    lines.append(f"{'all':<16}{len(jobs):>8}{sum(job.seconds for job in jobs) / 3600:>14.1f}{sum(measuring.values()) / 3600:>14.1f}")
    return "\n".join(lines)
