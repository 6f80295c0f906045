#!/usr/bin/env python3
"""The tables' arithmetic, on figures whose answers are known: leads, bounds, and engines that are gone."""

import unittest

import report
import results

from found import decibels  # report puts its folder on the path


def figure(mean_square, half=0.0):
    found = {"mean_square": mean_square, "mean_square_low": mean_square - half, "mean_square_high": mean_square + half}
    return {**found, "db": decibels(mean_square), "db_low": decibels(mean_square + half),
            "db_high": decibels(mean_square - half), "only_bounded": half >= mean_square}


def row_of(text, start):
    return next([cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith(f"| {start} |"))


class Tables(unittest.TestCase):
    def test_who_is_ahead_by_how_much_and_where_nothing_can_be_said(self):
        self.assertEqual(report.lead(figure(0.005), figure(0.01)), "+3.01")
        self.assertEqual(report.lead(figure(0.01), figure(0.01)), "0.00")
        self.assertEqual(report.lead(figure(0.01, 0.03), figure(0.01)), "0.00?")
        self.assertEqual(report.lead({**figure(0.01), "db": None}, figure(0.01)), "?")

    def test_shifts_tell_runs_apart_and_an_empty_class_is_a_dash(self):
        def part(pixels, within=1.0):
            if not pixels:
                return {"pixels": 0}
            return {"pixels": pixels, "within_budget": within, "within_twice_budget": (1 + within) / 2, "p999_px": 0.125}
        engine = {"engine": "surface", "pixels": 400, "coloured": part(200, 0.5), "smooth": part(100, 0.75), "added": part(100, 0.875), "sampled": part(0)}
        runs = [{"run": "eyes", "size": "8x4", "n": {"eyes": 3}, "engines": [engine]},
                {"run": "eyes, the client's model", "size": "8x4", "n": {"eyes": 2}, "model": {}, "engines": [engine]}]
        text = report.shift({"scene": {"runs": runs}})
        self.assertEqual(row_of(text, "scene | 3 of 8x4")[2:], ["eye-depth", "50.0", "50.00", "50.0", "75.000", "87.500", "0.0", "-", "-", "-"])
        self.assertIn("2 of 8x4, the client's model", text)
        gone = [{**runs[0], "engines": [{**engine, "engine": "gather"}]}]
        self.assertEqual(report.shift({"scene": {"runs": gone + runs}}), text, "an engine that is gone has no row")

    def test_scenes_whose_depth_other_methods_played_share_a_table(self):
        def scene(method):
            both = {scale: figure(0.01) for scale in results.SCALES}
            encoded = {"code": "w12", "codec": "h265", "scale": 1, "share": 0.1, "crf": None}
            return {"systems": [{"system": "lossless", "codec": "h264", "encoded": [encoded], "scores": {method: {"noise_free": {"right": both}}}}]}
        text = report.depth_codes({"old": scene("gather"), "new": scene("splat")})
        self.assertEqual(row_of(text, "scene")[-2:], ["dB lost, gather", "dB lost, splat"])
        self.assertEqual([row_of(text, name)[-2:] for name in ("old", "new")], [["0.00 (0.00)", "-"], ["-", "0.00 (0.00)"]])

    def test_a_bench_s_pictures_stand_beside_its_time(self):
        result = {"notes": ["2 processors; ratio = peer's time / ours", "fill/ours: 19 dB", "fill/telea: 15 dB"],
                  "figures": [{"name": "fill", "ms": 1.0, "ratio": 50.0, "peer": "telea"}, {"name": "rotate", "ms": 1.0, "ratio": None, "peer": "memcpy"}]}
        self.assertEqual(row_of(report.speed(result), "fill")[-1], "19 dB; the peer's: 15 dB")
        self.assertEqual(row_of(report.speed(result), "rotate")[-1], "-")


if __name__ == "__main__":
    unittest.main()
