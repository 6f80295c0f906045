#!/usr/bin/env python3
"""Keeps what ./bench prints of the client, with the machine and the version: docs/results/reproject/speed.json.

    speed.py --bin build/release/bin

To be run on a machine that does nothing else.
"""

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from baselines import bench_result  # noqa: E402
from renders import REPOSITORY  # noqa: E402
from kept import result_text  # noqa: E402
from steps import run_as_program, write_whole  # noqa: E402

FIGURES = "^(rotate|two_eyes|fill_1080p|play|depth_|reliability|surface|splat|mesh)"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/reproject/speed.json")
    options = parser.parse_args()
    result = bench_result(options.bin, REPOSITORY, FIGURES)
    write_whole(options.out, result_text(result))
    print(f"{options.out}: {len(result['figures'])} figures")


if __name__ == "__main__":
    run_as_program(main)
