"""Scores of pictures whose errors are known pixel by pixel."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time
import types
import unittest
import unittest.mock

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "programs"))
import chains  # noqa: E402
import redraw  # noqa: E402
import run  # noqa: E402
from independent import wait_until  # noqa: E402

SHAPE = (8, 10)
OFF = chains.es.RELIABILITY_TOLERANCE + 1


def score(off, flagged):
    """Of one picture: how far each pixel is off, and which the map flags."""
    found = chains.Score()
    truth = np.zeros((*SHAPE, 3), np.uint8)
    found.add(np.repeat(off[:, :, None], 3, axis=2), truth, np.zeros(SHAPE, bool), np.where(flagged, 0, 255))
    return found


def at(*pixels):
    mask = np.zeros(SHAPE, bool)
    mask[tuple(zip(*pixels))] = True
    return mask


class Failing(unittest.TestCase):
    def figures(self, off, flagged, ceiling_off):
        return score(off, flagged).figures(score(ceiling_off, at((0, 0))))

    def test_what_the_ceiling_has_wrong_within_a_pixel_does_not_fail(self):
        off = OFF * at((2, 2), (2, 5), (6, 8)).astype(int)
        ceiling = OFF * at((3, 3), (2, 7)).astype(int)  # beside (2, 2), two columns from (2, 5)
        figures = self.figures(off, at((2, 5), (2, 2), (0, 0), (0, 1)), ceiling)
        self.assertEqual((figures["bad_share"], figures["failing_share"]), (3 / 80, 2 / 80))
        self.assertEqual((figures["flagged_recall"], figures["failing_recall"], figures["flagged_precision"]), (0.6667, 0.5, 0.5))

    def test_what_is_off_much_more_than_the_ceiling_fails_beside_it_too(self):
        ceiling = OFF * at((3, 3)).astype(int)
        self.assertEqual(self.figures(2 * ceiling - 1, at((3, 3)), ceiling)["failing_share"], 0)  # the tolerance beyond it, and no more
        self.assertEqual(self.figures(2 * ceiling, at((3, 3)), ceiling)["failing_share"], 1 / 80)

    def test_two_alike_fail_as_often_beside_each_other_as_chance_has_it(self):
        random = np.random.default_rng(3)
        one, other = (OFF * (random.random(SHAPE) < 0.05) for _ in range(2))
        figures, mirrored = self.figures(one, at((0, 0)), other), self.figures(other, at((0, 0)), one)
        self.assertEqual((figures["failing_share"], figures["failing_by_chance"]), (mirrored["failing_by_chance"], mirrored["failing_share"]))
        near = [sum(abs(y - v) <= 1 and abs(x - u) <= 1 for v, u in zip(*other.nonzero())) > 0 for y, x in zip(*one.nonzero())]
        self.assertEqual(figures["failing_share"], near.count(False) / 80)
        self.assertGreater(figures["failing_share"], 0)
        self.assertGreater(figures["failing_by_chance"], 0)

    def test_nothing_fails_beside_itself(self):
        off = np.arange(80).reshape(SHAPE)
        figures = self.figures(off, at((0, 0)), off)
        self.assertEqual((figures["failing_share"], figures["failing_recall"]), (0, None))


class Thresholds(unittest.TestCase):
    FIGURES = {"psnr_db": 30.0, "worst_percent_db": 15.0, "gaps_db": None, "bad_share": 0.4, "flagged_recall": 0.5, "flagged_precision": 0.45,
               "failing_share": 0.1, "failing_by_chance": 0.01, "failing_recall": 0.8}

    def test_of_all_that_is_known(self):
        self.assertEqual(redraw.minima_of(self.FIGURES), {"psnr_db": 29.7, "worst_percent_db": 14.2, "flagged_recall": 0.4, "failing_recall": 0.64})  # 0.36 is less than chance

    def test_not_of_a_handful(self):
        self.assertNotIn("failing_recall", redraw.minima_of({**self.FIGURES, "failing_share": 0.004}))
        self.assertNotIn("failing_recall", redraw.minima_of({**self.FIGURES, "failing_by_chance": 0.06}))
        self.assertNotIn("flagged_recall", redraw.minima_of({**self.FIGURES, "bad_share": 0.004}))

    def test_the_ceiling_fails_nowhere(self):
        ceiling = {key: value for key, value in self.FIGURES.items() if not key.startswith("failing")}
        self.assertEqual(set(redraw.minima_of(ceiling)), {"psnr_db", "worst_percent_db", "flagged_recall"})


class Sweep(unittest.TestCase):
    def test_what_fails_ends_what_waits_for_its_turn(self):
        begun = []

        def fail(*words):
            begun.append(words)
            time.sleep(0.05)
            raise RuntimeError("no light")

        breaker = types.SimpleNamespace(name="b", values=range(100), few=())
        with unittest.mock.patch.object(run, "measured", fail), self.assertRaisesRegex(RuntimeError, "no light"):
            run.sweep(None, None, [breaker], every_value=True)
        self.assertLess(len(begun), 10)

    def test_programs_end_with_what_started_them(self):
        with tempfile.TemporaryDirectory() as folder:
            program, started = pathlib.Path(folder) / "equistream", pathlib.Path(folder) / "started"
            program.write_text(f"#!/bin/sh\necho $$ > {started}.new && mv {started}.new {started}\nexec sleep 1000\n")
            program.chmod(0o755)
            waits = "import sys, chains; chains.run_program(sys.argv[1], 'scene')"
            killed = subprocess.Popen([sys.executable, "-B", "-c", waits, program], env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
            wait_until(started.exists, "the program", 20)
            killed.kill()
            killed.wait()
            process = pathlib.Path("/proc") / started.read_text().strip()
            wait_until(lambda: not process.exists() or ") Z " in (process / "stat").read_text(), "its end", 20)


if __name__ == "__main__":
    unittest.main()
