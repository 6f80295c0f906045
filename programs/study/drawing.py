"""What charts and pictures of result pages share: their look, and eyes as pixels."""

import subprocess

import matplotlib

matplotlib.use("Agg")
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

STYLE = {"font.size": 9.5, "font.family": "sans-serif", "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
         "grid.color": "#e6e6e6", "grid.linewidth": 0.7, "axes.axisbelow": True, "svg.hashsalt": "equistream", "svg.fonttype": "none",
         "axes.titlesize": 10.5, "axes.titleweight": "bold"}


def plain_number(value, _):
    """A tick's label without exponents, short enough for several in a narrow panel."""
    for least, unit, letter in ((1e6, 1e6, "M"), (1e4, 1e3, "k")):
        if value >= least:
            return f"{value / unit:g}{letter}"
    return f"{value:,.0f}" if value >= 1 else f"{value:g}"


def pareto(points):
    """(cost, dB) that no other beats in both."""
    kept = []
    for cost, db in sorted(points, key=lambda point: (point[0], -point[1])):
        if not kept or db > kept[-1][1]:
            kept.append((cost, db))
    return kept


def rgb(file):
    return np.asarray(Image.open(file).convert("RGB"))


def truth(program, work, render, eye, frame):
    """A rendered eye as display pixels, by `info --pictures`; `render` is its folder under work/renders."""
    folder = work / f"pictures/{render}-{eye}"
    subprocess.run([program, "info", f"renders/{render}/{eye}/frame.{frame:04d}.exr", "--pictures", folder], cwd=work, check=True, capture_output=True)
    return rgb(next(folder.glob("*colour*.png")))
