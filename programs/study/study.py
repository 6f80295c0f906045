#!/usr/bin/env python3
"""The study: every method on every scene, speed against accuracy, and where each breaks.

    equistream study [--preset smoke|small|paper] [--scenes A,B] [--experiments A,B] --out DIR

Each experiment of each scene leaves DIR/EXPERIMENT/SCENE.json; what is there already is not measured again (--again), and what was interrupted goes on
where it stopped. Renders, streams and views stay in the work folder. In the end charts and a page for each scene are drawn from what DIR holds.
"""

import argparse
import pathlib
import platform
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from options import Parser, add_common, parse  # noqa: E402
from presets import EXPERIMENTS, PRESETS  # noqa: E402
from steps import expect_packages, packages, run_as_program  # noqa: E402


def names_of(known):
    def chosen(text):
        names = text.split(",")
        for name in names:
            if name not in known:
                raise argparse.ArgumentTypeError(f"expected some of {', '.join(known)}, found '{name}'")
        return names
    return chosen


class Packages(argparse.Action):
    """As --help and --version: nothing else has to be given."""

    def __call__(self, parser, *_):
        expect_packages("study")
        print(f"Python {platform.python_version()} ({sys.executable}) has {', '.join(packages())} and equistream")
        parser.exit()


def arguments(words=None):
    parser = Parser(prog="equistream study", description=__doc__.splitlines()[0],
                    epilog="example: equistream study --preset smoke --out study-out")
    parser.add_argument("--preset", choices=PRESETS, default="smoke",
                        help="smoke: the bundled scene in miniature, minutes; small: the real scenes on two cores, an hour each; paper: the paper's sizes and samples, for a farm (equistream farm study); default: smoke")
    parser.add_argument("--scenes", help="a comma-separated list; default: the preset's")
    parser.add_argument("--experiments", type=names_of(EXPERIMENTS), help=f"a comma-separated list of {', '.join(EXPERIMENTS)}; default: the preset's (smoke: all but where, moved, related and window)")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for EXPERIMENT/SCENE.json, charts and pages")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders, streams and views; default: OUT/work")
    parser.add_argument("--job", type=int, metavar="N", help="one of the render jobs that equistream farm study listed in the folder of --out, and nothing else")
    parser.add_argument("--charts", choices=("after", "only", "none"), default="after",
                        help="after: draw charts, tables and pages once all is measured; only: draw them from the results in --out; none: do not draw them")
    parser.add_argument("--again", action="store_true", help="measure again what is there already, but keep renders")
    add_common(parser)
    parser.add_argument("--packages", action=Packages, nargs=0, help="say which Python packages it needs are there, and end")
    parser.add_argument("--bin", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    return parse(parser, "study", words)


def main():
    options = arguments()
    expect_packages("study")
    from study_run import Study  # what needs these packages
    Study(options).run()


if __name__ == "__main__":
    run_as_program(main, "equistream study")
