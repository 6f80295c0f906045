"""What is left when the head is not where the server thought: every system played for heads that have turned and moved on from where its source was rendered.

A source that was rendered at the very eye is exact only while the head stays; here each has to make do with what it has until the next frame comes. Uncoded, one frame.
"""

import dataclasses
import math

import equistream as es
import numpy as np
from presets import SEEDS
from render_list import EYES, moved_eyes
from steps import write_if_other

from .systems import SYSTEMS, Player, systems_of

ASIDE = np.array([0.8, 0.36, -0.48])
"""Right, up and ahead, in the head's axes: of length 1."""


@dataclasses.dataclass(frozen=True)
class Head:
    name: str
    turned_deg: float
    moved_m: float

    def pose(self, head):
        """This head's, of the one that the source was rendered for."""
        turn, step = math.radians(self.turned_deg), np.eye(4)
        step[:3, :3] = [[math.cos(turn), 0, math.sin(turn)], [0, 1, 0], [-math.sin(turn), 0, math.cos(turn)]]
        step[:3, 3] = self.moved_m * ASIDE
        return es.Pose.from_matrix(head.matrix @ step)


HEADS = (Head("as-told", 0, 0), Head("turned", 20, 0), Head("moved", 0, 0.05), Head("further", 0, 0.1), Head("both", 20, 0.1))
PLAYED = ("perspective", "pair", "sphere-left", "two-spheres", "centre", "centre-told", "default", "centre-mesh", "centre-turned")

DEFAULT = next(system for system in SYSTEMS if system.by_default)
BY_FILL = tuple(dataclasses.replace(DEFAULT, name=f"fill-{fill.split(',')[0]}", title=f"{DEFAULT.title}, gaps by {fill}", play=("--fill", fill))
                for fill in ("none", "spread", "pushpull", "hidden,pushpull", "patches,pushpull", "geometry,pushpull"))
BY_MIRRORS = tuple(dataclasses.replace(DEFAULT, name=f"mirrors-{how}", title=f"{DEFAULT.title}, --mirrors {how}", play=("--mirrors", how)) for how in ("gaps", "surface"))
"""What fills gaps, and what becomes of mirrors, each alone: of the sphere that has the tracks for all of it."""


PATH_LAST_S = 60.0
"""Beyond every scene's own path."""


def path_text(keys):
    """(time_s, pose) of each key, as the camera path that programs take (docs/scenes.md)."""
    lines = [",".join(repr(float(value)) for value in (time_s, *pose.position_m, *pose.orientation)) for time_s, pose in keys]
    return "\n".join(["time_s,x,y,z,qw,qx,qy,qz", *lines]) + "\n"


def standing(pose):
    """The keys of a head that stands still."""
    return [(time_s, pose) for time_s in (0.0, PATH_LAST_S)]


def told_of(work, number):
    """What a frame says of the head and of its time."""
    return es.read_frame_info(next((work.folder / work.truth(SEEDS[0]) / EYES[0]).glob(f"frame.{number:04}.*")))


def path_file(work, name, keys):
    """The file of a path."""
    file = work.folder / f"heads/{name}.csv"
    file.parent.mkdir(exist_ok=True)
    write_if_other(file, path_text(keys))
    return file


def path_of(work, head, number):
    """The file of a head that stands still where `head` is, beside the one that the frame tells of."""
    return path_file(work, head.name, standing(head.pose(told_of(work, number).head)))


def played_of(work):
    by_mirrors = BY_MIRRORS if work.tells_of_mirrors("centre") else ()
    return [*(system for system in systems_of(work) if system.name in PLAYED), *BY_FILL, *by_mirrors]


def run(work):
    number = (work.first + work.last) // 2
    found, ceiling = [], {}
    for head in HEADS:
        path = path_of(work, head, number)
        truths = [work.render(moved_eyes(work.preset, work.scene, head.name, seed, path), str(number)) for seed in SEEDS]
        ceiling[head.name] = work.compare(f"moved-{head.name}-ceiling", *truths)["eyes"]
        player = Player(work, str(number), path)
        for system in played_of(work):
            views, said = player.play_seeds(system, work.preset.sphere_width, None)
            found.append({"head": head.name, "system": system.name, "width": work.preset.sphere_width if system.is_sphere else None,
                          "commands": [[played["command"]] for played in said[0]], **work.beside(f"moved-{head.name}-{system.name}", views, truths)})
    return {"n": {"frames": 1, "seeds": len(SEEDS)}, "heads": [dataclasses.asdict(head) for head in HEADS], "ceiling": ceiling,
            "titles": {system.name: system.title for system in played_of(work)}, "systems": found}
