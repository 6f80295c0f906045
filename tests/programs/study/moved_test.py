"""Heads that have turned and moved on: how far, and about what."""

import math
import tempfile
import unittest
from pathlib import Path

import equistream as es
import numpy as np
from standing_head import path_text

from experiments import moved

TOLD = es.Pose.look_at((1, 2, 3), (4, 2.5, -1), (0, 1, 0))


class Heads(unittest.TestCase):
    def test_the_first_stays(self):
        np.testing.assert_allclose(moved.HEADS[0].pose(TOLD).matrix, TOLD.matrix, atol=1e-12)

    def test_they_move_and_turn_as_far_as_they_say(self):
        for head in moved.HEADS:
            pose = head.pose(TOLD)
            self.assertAlmostEqual(np.linalg.norm(np.subtract(pose.position_m, TOLD.position_m)), head.moved_m)
            turned = TOLD.matrix[:3, :3].T @ pose.matrix[:3, :3]
            self.assertAlmostEqual(math.degrees(math.acos(min(1, (np.trace(turned) - 1) / 2))), head.turned_deg, places=4)
            np.testing.assert_allclose(turned[:, 1], (0, 1, 0), atol=1e-9)

    def test_a_path_that_stands_still(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "head.csv"
            there = moved.HEADS[-1].pose(TOLD)
            file.write_text(path_text(there.position_m, there.orientation))
            head, *rows = file.read_text().splitlines()
            self.assertEqual(head, "time_s,x,y,z,qw,qx,qy,qz")
            self.assertEqual(len({row.split(",", 1)[1] for row in rows}), 1)
            back = es.Pose([float(v) for v in rows[0].split(",")[1:4]], [float(v) for v in rows[0].split(",")[4:]])
            np.testing.assert_allclose(back.matrix, there.matrix, atol=1e-9)


if __name__ == "__main__":
    unittest.main()
