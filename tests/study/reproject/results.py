"""The JSON of docs/results/reproject, KIND.json of all scenes: what is measured there and drawn from it."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from kept import result_text  # noqa: E402
from steps import write_whole  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RESULTS = REPOSITORY / "docs/results/reproject"
SCENES = ("sponza-crytek", "sibenik", "voxel-city", "kitchen", "san-miguel")
EYES = ("left", "right")
SCALES = ("linear", "display")
# Of older results: engines that have another name today, and engines that are gone.
ENGINES = {"surface": "eye-depth"}
GONE = ("gather",)


def load(kind, folder=RESULTS):
    """{scene: result} of one experiment, in the order of SCENES, then by name; empty where it was not measured."""
    file = pathlib.Path(folder) / f"{kind}.json"
    found = json.loads(file.read_text()) if file.exists() else {}
    return {scene: found[scene] for scene in sorted(found, key=lambda scene: (SCENES.index(scene) if scene in SCENES else len(SCENES), scene))}


def keep(file, scene, result):
    """Puts a scene's result into KIND.json, which has those of the other scenes."""
    found = json.loads(file.read_text()) if file.exists() else {}
    write_whole(file, result_text({**found, scene: result}))
    print(f"{file}: {scene}", flush=True)
