"""One frame of a scene from each host, as planes by channel name, with several independent renders of its colour."""

import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "programs"))
from independent import colour_of, read_frame  # noqa: E402

AOVS = "depth,motion,normal,ids"


class Failed(Exception):
    pass


class Programs:
    def __init__(self, folder):
        self.program = pathlib.Path(folder).resolve() / "equistream"
        if not self.program.is_file():
            raise Failed(f"{self.program}: expected the built program, found nothing (give --bin)")

    def run(self, *words):
        words = [str(word) for word in words]
        result = subprocess.run([self.program, *words], capture_output=True, text=True)
        if result.returncode != 0:
            lines = result.stderr.strip().splitlines()
            raise Failed(f"equistream {' '.join(words)}: exit {result.returncode}: {lines[-1] if lines else 'no message'}")
        return result.stdout


def frames(programs, host, scene, work, settings):
    """(planes of the first seed, colours of all seeds: seeds x height x width x 3). The hosts draw other random numbers from the same seeds."""
    # What the embedded host leaves out of the light on purpose Mitsuba does not.
    options = {"embree": ["--unbiased"], "mitsuba": ["--variant", settings.variant]}[host]
    planes, colours = None, []
    for seed in range(1, settings.seeds + 1):
        out = work / f"{host}-{seed}"
        programs.run("render", scene, "--host", host, *options, "--frames", settings.frame, "--size", f"{settings.width}x{settings.height}",
                     "--spp", settings.spp, "--seed", seed, "--aovs", AOVS, "--overwrite", "--out", out)
        frame = read_frame(out / "centre" / f"frame.{settings.frame:04d}.exr")
        planes = planes or frame
        colours.append(colour_of(frame))
    return planes, np.array(colours)
