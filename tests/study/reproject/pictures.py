#!/usr/bin/env python3
"""What each rung of the fill ladder makes of the gaps: docs/results/reproject/rungs-SCENE.jpg, cut where an eye's gaps are largest.

    pictures.py --bin build/release/bin --work FOLDER [--head stereo] [--eye left] [--brighter 1] [SCENE ...]

FOLDER is what accuracy.py left, with its views; the decibels under the pictures are of the whole eye's gaps, from
docs/results/reproject/accuracy/SCENE.json.
"""

import pathlib
import sys

import numpy as np

import results

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from drawing import rgb, truth  # noqa: E402
from pages import noise_free_short  # noqa: E402
from renders import FRAMES, HEADS, scene_parser  # noqa: E402
from steps import Failed, run_as_program  # noqa: E402

import matplotlib.pyplot as plt  # noqa: E402

CUT = (320, 180)
COLUMNS = 4


def fullest_cut(mask):
    """Corner (x, y) of the window that holds most of the mask."""
    sums = np.pad(np.cumsum(np.cumsum(mask.astype(np.int64), axis=0), axis=1), ((1, 0), (1, 0)))
    width, height = CUT
    held = sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width] + sums[:-height, :-width]
    y, x = np.unravel_index(np.argmax(held), held.shape)
    return int(x), int(y)


def panel_title(entry, eye):
    if entry["fill"] == "none":
        return "gaps left alone"
    name = entry["fill"].removesuffix(",pushpull").replace(",", ", ")
    return f"{name}: {noise_free_short(results.gap_error(entry, eye))} dB"


def panels_of(options, scene):
    work, frame = (options.work / scene).resolve(), FRAMES[scene]
    result = results.load("accuracy", options.results).get(scene)
    if result is None or "rungs" not in result:
        raise Failed(f"{options.results / 'accuracy' / scene}.json: expected the rungs that accuracy.py measures, found none")
    mask = rgb(work / f"views/mask-centre-{options.head}-1/gaps/{options.eye}/frame.{frame:04d}.png")[..., 0] > 0
    x, y = fullest_cut(mask)
    place = np.s_[y:y + CUT[1], x:x + CUT[0]]
    panels = [("path traced", truth(options.bin.resolve() / "equistream", work, f"truth-{options.head}-1", options.eye, frame)[place])]
    for entry in [entry for entry in result["rungs"] if entry["head"] == options.head]:
        view = work / f"views/{entry['system']}-{options.head}-1/{options.eye}/frame.{frame:04d}.png"
        panels.append((panel_title(entry, options.eye), rgb(view)[place]))
    return panels, mask


def draw(options, scene):
    panels, mask = panels_of(options, scene)
    rows = -(-len(panels) // COLUMNS)
    figure, axes = plt.subplots(rows, COLUMNS, figsize=(13, rows * 2.15 + 0.5), squeeze=False, layout="constrained")
    for panel in axes.flat:
        panel.set_axis_off()
    for panel, (title, picture) in zip(axes.flat, panels):
        panel.imshow(np.clip(picture * options.brighter, 0, 255).astype(np.uint8), interpolation="nearest")
        panel.set_title(title, fontsize=9.5, loc="left")
    brighter = f"; shown {options.brighter:g} times as bright" if options.brighter != 1 else ""
    figure.suptitle(f"{scene}, {options.head}, {options.eye} eye ({100 * mask.mean():.1f} % gaps): noise-free dB in the eye's gaps, by what fills them before push-pull{brighter}",
                    fontsize=10.5, x=0.005, ha="left")
    file = options.results / f"rungs-{scene}.jpg"
    figure.savefig(file, dpi=100, pil_kwargs={"quality": 86, "optimize": True})
    plt.close(figure)
    print(file)


def main():
    parser = scene_parser(__doc__, work="folder that accuracy.py filled")
    parser.add_argument("--results", type=pathlib.Path, default=results.RESULTS)
    parser.add_argument("--head", default="stereo", choices=HEADS)
    parser.add_argument("--eye", default="left", choices=results.EYES)
    parser.add_argument("--brighter", type=float, default=1, help="factor on all pictures' display values (default: %(default)s)")
    options = parser.parse_args()
    for scene in options.scenes:
        draw(options, scene)


if __name__ == "__main__":
    run_as_program(main)
