"""What chains by `equistream play` share: the program, and scores of what it wrote."""

import subprocess

import numpy as np
from PIL import Image


def run(program, *words):
    words = [str(word) for word in words] + (["--overwrite"] if words[0] == "play" else [])
    result = subprocess.run([program, *words], capture_output=True, text=True)
    if result.returncode != 0:
        raise RuntimeError(f"equistream {' '.join(words)}: exit {result.returncode}: {result.stderr.strip()}")


def picture(out, eye, number):
    return np.asarray(Image.open(out / eye / f"frame.{number:04}.png").convert("RGB"))


def plane(out, name, eye, number):
    return np.asarray(Image.open(out / name / eye / f"frame.{number:04}.png"))
