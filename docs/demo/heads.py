"""Writes places of a head that moves from side to side where a render's first frame was made: OUT/NN.csv, as `equistream play --head` reads it.

usage: heads.py MANIFEST OUT
"""

import json
import pathlib
import sys

PLACES = 9


def right_of(orientation):
    """The head's own +X axis in the world."""
    w, x, y, z = orientation
    return 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)


def main():
    manifest, out = json.loads(pathlib.Path(sys.argv[1]).read_text()), pathlib.Path(sys.argv[2])
    head, reach_m = manifest["first_frame"]["head"], manifest["lean_m"]
    out.mkdir(parents=True, exist_ok=True)
    for i in range(PLACES):
        aside_m = reach_m * (2 * i / (PLACES - 1) - 1)
        position = [at + aside_m * axis for at, axis in zip(head["position_m"], right_of(head["orientation_wxyz"]))]
        (out / f"{i:02}.csv").write_text(", ".join(map(str, [0, *position, *head["orientation_wxyz"]])) + "\n")


if __name__ == "__main__":
    main()
