#!/usr/bin/env python3
"""Whether looking up between display values keeps the light: docs/results/trust/light.json.

    look_up_light.py --bin build/release/bin --work FOLDER [--report FILE]          PYTHONPATH=build/release/package

A sphere of 1,920 columns of each real scene at its path's first frame, as rendered, denoised, and coded after that. The client looks up its path's view from the
sphere's place: once as it does, between display values, and once between linear ones. There it is given each sample's linear value as two bytes, one picture
each. The share says by how much the first view's mean linear light is below the second's. What mixing light would cost, `budgets.py --look-ups` says.
"""

import argparse
import pathlib
import sys

import equistream as es
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPOSITORY / "programs/study"), str(REPOSITORY / "tests/study/renderer")]
from budgets import to_linear  # noqa: E402
from denoise import Programs, rendered  # noqa: E402
from kept import result_text  # noqa: E402
from presets import REAL_SCENES  # noqa: E402
from steps import provenance, run_as_program, write_whole  # noqa: E402

SPHERE, VIEW, SAMPLES, SEED, QUALITY, CRF = "1920x960", (640, 360), 8, 1, "balanced", 24
RENDERED = {"as rendered": (), "denoised": ("--denoise", QUALITY)}


def linear_of(display):
    return to_linear(display.astype(float) / 255)


def darker_percent(source):
    frame = next(iter(es.open_feed(str(source))))
    camera = es.PerspectiveCamera(*VIEW, np.radians(90))

    def view(bytes_of_samples):
        frame.main.rgb[...] = bytes_of_samples
        return es.reproject(frame, camera, frame.main.info.head).rgb

    samples = frame.main.rgb.copy()
    words = np.rint(65535 * linear_of(samples)).astype(int)
    between_linear = (256 * view(words >> 8).astype(float) + view(words & 255)) / 65535
    return 100 * (1 - linear_of(view(samples)).mean() / between_linear.mean())


def measured(programs, scene, work):
    sources = {name: rendered(programs, work / name.replace(" ", "-"), scene, "--size", SPHERE, "--spp", SAMPLES, "--seed", SEED, "--aovs", "none", *denoise)
               for name, denoise in RENDERED.items()}
    coded = sources[f"denoised, CRF {CRF}"] = work / "coded.mp4"
    programs.run("encode", sources["denoised"], "--crf", CRF, "--out", coded)
    return {name: darker_percent(source) for name, source in sources.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--report", type=pathlib.Path, default=REPOSITORY / "docs/results/trust/light.json")
    options = parser.parse_args()
    programs = Programs(options.bin)
    scenes = {name: measured(programs, REPOSITORY / f"scenes/descriptions/{name}.json", options.work / name) for name in REAL_SCENES}
    write_whole(options.report, result_text({"command": "look_up_light.py --bin build/release/bin --work FOLDER", **provenance(options.bin, REPOSITORY),
                                             "sphere": SPHERE, "samples": SAMPLES, "seed": SEED, "n": 1, "quality": QUALITY, "scenes": scenes}))


if __name__ == "__main__":
    run_as_program(main)
