"""Scripts for Slurm: one that submits all steps, each after those it needs, and one that is a task."""

import shlex

LARGEST_ARRAY = 1000
"""Of Slurm, unless its administrator allows more (MaxArraySize)."""
SUBMIT = """#!/bin/sh
# Submits every job of this farm to Slurm. Words go to each sbatch: sh submit.sh --partition=NAME --account=NAME
# Submitted again, it goes on where it was: what is finished stays. Earlier jobs must have ended: two tasks in one folder would be in each other's way.
set -e
CDPATH= cd -- "$(dirname -- "$0")"
mkdir -p logs
command -v equistream > /dev/null || {{ echo 'submit.sh: expected equistream in PATH, found none' >&2; exit 1; }}
command -v squeue > /dev/null && command -v sbatch > /dev/null || {{ echo 'submit.sh: expected Slurm (squeue and sbatch in PATH), found none' >&2; exit 1; }}
touch submitted
queued=$(squeue --me --noheader --format=%F)
left=$(echo "$queued" | awk 'FILENAME == "submitted" {{ ours[$1]; next }} $1 in ours && !seen[$1]++ {{ print $1 }}' submitted -)
test -z "$left" || {{ echo "submit.sh: expected no job of this farm in the queue, found" $left"; wait, or scancel them first" >&2; exit 1; }}
: > submitted
submit() {{ job=$(sbatch --parsable --job-name={name}-"$@"); job=${{job%%;*}}; echo "$job" >> submitted; }}

{steps}
echo "submitted; squeue --me lists the jobs, logs/ has what they say"
"""
TASK = """#!/bin/sh
#SBATCH --requeue --open-mode=append
# One task of a step, as submit.sh submits it. More lines of #SBATCH here hold for all.
exec equistream farm task . "$1" $((${2:-0} + ${SLURM_ARRAY_TASK_ID:-0}))
"""


def clock(seconds):
    minutes = int(seconds // 60) + 1
    return f"{minutes // 60}:{minutes % 60:02}:00"


def variable(step):
    return step["name"].replace("-", "_")


def submissions(step):
    """Lines of the shell: an array for each thousand of the step's tasks, and their numbers in a variable."""
    words = [f"--cpus-per-task={step['processors']}"]
    words += [f"--time={clock(step['limit'])}"] if step["limit"] else []
    if step["after"]:
        words += ["--dependency=afterok" + "".join(f"${variable({'name': name})}" for name in step["after"]), "--kill-on-invalid-dep=yes"]
    for begin in range(0, step["tasks"], LARGEST_ARRAY):
        last = min(LARGEST_ARRAY, step["tasks"] - begin) - 1
        array = [f"--array=0-{last}", "--output=logs/%x-%A_%a.log"] if step["tasks"] > 1 else ["--output=logs/%x-%j.log"]
        yield " ".join(["submit", step["name"], *array, *words, '"$@"', "task.sh", step["name"], str(begin)])
        yield f"{variable(step)}=${variable(step)}:$job" if begin else f"{variable(step)}=:$job"


def scripts(plan):
    steps = "\n".join(line for step in plan["steps"] for line in submissions(step))
    return {"submit.sh": SUBMIT.format(name=shlex.quote(plan["name"]), steps=steps), "task.sh": TASK}
