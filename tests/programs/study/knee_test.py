"""Knees of curves whose bend is where it was put."""

import unittest

import knee

BENT = [(1, 10.0), (2, 20.0), (4, 30.0), (8, 30.05), (16, 30.1), (32, 30.15)]


class Knee(unittest.TestCase):
    def test_the_bend_is_found(self):
        self.assertEqual(knee.knee(BENT), 4)

    def test_what_never_helps_is_had_for_the_least(self):
        self.assertEqual(knee.knee([(1, 30.0), (2, 30.0), (4, 29.9)]), 1)

    def test_the_least_within_a_loss(self):
        self.assertEqual(knee.least_within(BENT, 0.1), 8)
        self.assertEqual(knee.least_within(BENT, 0.2), 4)

    def test_a_lucky_cheap_point_does_not_count_where_dearer_ones_are_worse(self):
        self.assertEqual(knee.least_within([(1, 30.0), (2, 25.0), (4, 30.0)], 0.1), 4)

    def test_where_less_is_better_the_least_is_enough(self):
        self.assertEqual(knee.least_within([(1, 31.0), (2, 30.5), (4, 30.0)], 0.1), 1)


if __name__ == "__main__":
    unittest.main()
