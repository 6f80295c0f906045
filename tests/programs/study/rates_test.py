"""Curves whose averages, crossings and knees are known in closed form."""

import math
import unittest

import rates

BYTES = (1000, 2000, 4000, 8000, 16000)


def straight(gain=1.0, offset_db=0.0):
    """6 dB for each doubling, of `gain` times the bytes."""
    return [(gain * count, 6 * math.log2(count / 1000) + 30 + offset_db) for count in BYTES]


class Rates(unittest.TestCase):
    def test_a_fifth_more_bytes_everywhere_is_twenty_per_cent(self):
        self.assertAlmostEqual(rates.bd_rate_percent(straight(), straight(gain=1.2)), 20, places=6)

    def test_half_a_decibel_less_everywhere_is_that(self):
        self.assertAlmostEqual(rates.bd_db(straight(), straight(offset_db=-0.5)), -0.5, places=6)

    def test_curves_that_share_no_decibels_have_no_rate(self):
        self.assertIsNone(rates.bd_rate_percent(straight(), straight(offset_db=100)))

    def test_curves_that_share_too_little_have_no_rate(self):
        self.assertIsNotNone(rates.bd_rate_percent(straight(), straight(offset_db=22)))
        self.assertIsNone(rates.bd_rate_percent(straight(), straight(offset_db=23.5)))
        self.assertIsNotNone(rates.bd_db(straight(), straight(gain=7)))
        self.assertIsNone(rates.bd_db(straight(), straight(gain=9)))

    def test_three_points_are_too_few(self):
        self.assertIsNone(rates.bd_rate_percent(straight()[:3], straight()))

    def test_a_point_that_costs_more_and_is_worse_is_left_out(self):
        self.assertEqual(rates.curve([(1, 30.0), (2, 29.0), (3, 31.0)]), [(1, 30.0), (3, 31.0)])

    def test_bytes_for_a_level_between_two_points(self):
        self.assertAlmostEqual(rates.bytes_for(straight(), 33), 1000 * math.sqrt(2), places=6)
        self.assertIsNone(rates.bytes_for(straight(), 60))
        self.assertIsNone(rates.bytes_for(straight(), 20))

    def test_the_fewest_bytes_of_curves_that_come_to_a_level(self):
        curves = {"narrow": straight(), "dear": straight(gain=2), "never": straight(offset_db=-60)}
        count, *which = rates.fewest_bytes(curves, 36)
        self.assertAlmostEqual(count, 2000)
        self.assertEqual(which, ["narrow", False])
        self.assertEqual(rates.fewest_bytes({**curves, "wide": straight(gain=1.5, offset_db=20)}, 36), (1500, "wide", True))
        self.assertEqual(rates.fewest_bytes(curves, 80), (None, None, None))

    def test_where_a_curve_over_width_comes_to_a_level(self):
        self.assertAlmostEqual(rates.crossing((640, 1280, 2560), (20.0, 30.0, 32.0), 25), 640 * math.sqrt(2))
        self.assertIsNone(rates.crossing((640, 1280), (20.0, 24.0), 25))
        self.assertEqual(rates.crossing((640, 1280), (26.0, 27.0), 25), 640)
        self.assertAlmostEqual(rates.crossing((640, 1280), (20.0, math.inf), 25), 640)


BENT = [(1, 10.0), (2, 20.0), (4, 30.0), (8, 30.05), (16, 30.1), (32, 30.15)]


class Knee(unittest.TestCase):
    def test_the_bend_is_found(self):
        self.assertEqual(rates.knee(BENT), 4)

    def test_what_never_helps_is_had_for_the_least(self):
        self.assertEqual(rates.knee([(1, 30.0), (2, 30.0), (4, 29.9)]), 1)

    def test_the_least_within_a_loss(self):
        self.assertEqual(rates.cheapest_within(BENT, 0.1), 8)
        self.assertEqual(rates.cheapest_within(BENT, 0.2), 4)

    def test_a_lucky_cheap_point_does_not_count_where_dearer_ones_are_worse(self):
        self.assertEqual(rates.cheapest_within([(1, 30.0), (2, 25.0), (4, 30.0)], 0.1), 4)

    def test_where_less_is_better_the_least_is_enough(self):
        self.assertEqual(rates.cheapest_within([(1, 31.0), (2, 30.5), (4, 30.0)], 0.1), 1)


if __name__ == "__main__":
    unittest.main()
