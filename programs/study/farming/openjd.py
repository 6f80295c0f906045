"""A template of the Open Job Description, version jobtemplate-2023-09."""

LONGEST_NAME = 128
"""Of a job."""
NOTICE_S = 60
"""From the request to end to the end: a render keeps its whole frames."""


def action(step, task):
    words = ["farm", "task", "{{Param.Farm}}", step["name"], task, "--system", "openjd"]
    limit = {"timeout": int(step["limit"]) + 1} if step["limit"] else {}
    return {"actions": {"onRun": {"command": "equistream", "args": words, **limit, "cancelation": {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": NOTICE_S}}}}


def step_of(step):
    many = step["tasks"] > 1
    made = {"name": step["name"], "script": action(step, "{{Task.Param.Task}}" if many else "0")}
    if many:
        made["parameterSpace"] = {"taskParameterDefinitions": [{"name": "Task", "type": "INT", "range": f"0-{step['tasks'] - 1}"}]}
    if step["after"]:
        made["dependencies"] = [{"dependsOn": name} for name in step["after"]]
    return made


def template(plan):
    """Its parameter is the folder that it lies in; a farm that mounts it elsewhere maps it."""
    return {"specificationVersion": "jobtemplate-2023-09", "name": f"equistream {plan['name']}"[:LONGEST_NAME],
            "parameterDefinitions": [{"name": "Farm", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT", "default": "."}],
            "steps": [step_of(step) for step in plan["steps"]]}
