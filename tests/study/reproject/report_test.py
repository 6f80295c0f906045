#!/usr/bin/env python3
"""The tables' arithmetic, on figures whose answers are known: eyes together, who is ahead, bounds, codecs, the worst pixels."""

import unittest

import report
import results

from found import decibels, only_bounded, together  # report puts its folder on the path


def figure(mean_square, half=0.0):
    found = {"mean_square": mean_square, "mean_square_low": mean_square - half, "mean_square_high": mean_square + half}
    return {**found, "db": decibels(mean_square), "db_low": decibels(mean_square + half),
            "db_high": decibels(mean_square - half), "only_bounded": half >= mean_square}


def entry(system, left, right, worst=None):
    """Of linear mean squares; display values are twice as wrong in amplitude."""
    def eye(found):
        display = figure(4 * found["mean_square"], 4 * (found["mean_square"] - found["mean_square_low"]))
        score = {"noise_free": {"linear": found, "display": display}}
        return score | ({"noise_free_worst_percent": {"linear": worst, "display": worst}} if worst else {})
    noisy = {"psnr_db": 20.0, "ssim": 0.5, "psnr_worst_percent_db": 5.0}
    return {"system": system, "head": "stereo", "noise_free": {"eyes": {"left": eye(left), "right": eye(right)}},
            "against_other_seed": {"eyes": {"left": noisy, "right": noisy}}, "played": [{"milliseconds": {}}]}


def measured(systems):
    return {"systems": systems, "versions": {"commit": "abc"}}


def row_of(text, start):
    return next([cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith(f"| {start} |"))


class Tables(unittest.TestCase):
    def test_eyes_together_are_the_mean_of_mean_squares_not_of_decibels(self):
        both = results.both_eyes(entry("ours", figure(0.019), figure(0.001)), "linear")
        self.assertAlmostEqual(both["db"], 20)
        self.assertFalse(only_bounded(both))
        self.assertTrue(only_bounded(together([figure(0.01, 0.005), figure(0.01, 0.016)])), "halves of intervals add")
        self.assertIsNone(together([figure(-0.01), figure(0.005)])["db"])

    def test_linear_leads_and_display_stands_in_brackets(self):
        found = {"scene": {"systems": [entry("sphere", figure(0.01), figure(0.001, 0.002))]}}
        self.assertEqual(row_of(report.summary(found, "stereo"), "rotation only")[1], "20.0 / > 25.2 (14.0 / > 19.2)")

    def test_who_is_ahead_by_how_much_and_where_nothing_can_be_said(self):
        rival, ours = entry("paper", figure(0.01), figure(0.01)), entry("ours", figure(0.005), figure(0.005))
        unsure = entry("ours-left", figure(0.01), figure(0.01, 0.03))
        text = report.ahead({"scene": measured([rival, ours, unsure])})
        rows = {line.split("|")[2].strip(): line.split("|")[3].strip() for line in text.splitlines() if line.startswith("| 63 mm")}
        self.assertEqual(rows[results.NAMES["paper"]], "20.00 (13.98)")
        self.assertEqual(rows[results.NAMES["ours"]], "+3.01 (+3.01)")
        self.assertEqual(rows[results.NAMES["ours-left"]], "0.00? (0.00?)")

    def test_who_was_not_measured_has_no_row(self):
        found = {"scene": measured([entry("paper", figure(0.01), figure(0.01)), entry("ours", figure(0.005), figure(0.005))])}
        self.assertNotIn(results.NAMES["paper-gaps"], report.ahead(found))
        found["scene"]["systems"].append(entry("paper-gaps", figure(0.02), figure(0.02)))
        self.assertIn("| 63 mm stereo | the paper's method, mirrors as gaps | -3.01 (-3.01) |", report.ahead(found))

    def test_a_lead_over_what_another_version_measured_says_so(self):
        rival, ours = entry("paper", figure(0.01), figure(0.01)), entry("ours", figure(0.005), figure(0.005))
        found = {"scene": measured([rival, {**ours, "measured": {"versions": {"commit": "def"}}}])}
        self.assertIn("| +3.01 (+3.01)* |", report.ahead(found))

    def test_mirrors_by_what_becomes_of_them(self):
        systems = [entry(system, figure(0.01 * i), figure(0.001)) for i, system in enumerate(("paper", "paper-gaps", "ours-surface", "ours"), start=1)]
        text = report.mirrors({"scene": {"systems": systems}, "other": {"systems": systems[:1]}})
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()[2:]]
        ours, paper = results.NAMES["ours"], results.NAMES["paper"]
        self.assertEqual([row[:3] for row in rows], [["63 mm stereo", paper, "surface"], ["63 mm stereo", paper, "gaps"],
                                                     ["63 mm stereo", ours, "surface"], ["63 mm stereo", ours, "images"]])
        self.assertEqual([row[3:] for row in rows[:2]], [["20.0 / 30.0 (14.0 / 24.0)"] * 2, ["17.0 / 30.0 (11.0 / 24.0)", "-"]])

    def test_only_who_met_mirrors_tells_of_them(self):
        met, none = entry("ours", figure(0.01), figure(0.01)), entry("paper", figure(0.01), figure(0.01))
        met["played"] = [{"milliseconds": {}, "eyes": {"left": {}, "right": {"specular": {"kept": 1}}}}]
        self.assertTrue(results.tells_of_mirrors({"systems": [none], "coded": [met]}))
        self.assertFalse(results.tells_of_mirrors({"systems": [none]}))

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

    def test_the_worst_pixels_are_noise_free_where_all_systems_have_them(self):
        ceiling = {"psnr_db": 20.0, "ssim": 0.5, "psnr_worst_percent_db": 6.0}
        result = {"ceiling": {"stereo": {"eyes": {"left": ceiling, "right": ceiling}}},
                  "systems": [entry("sphere", figure(0.01), figure(0.01), worst=figure(0.1)), entry("paper", figure(0.01), figure(0.01), worst=figure(0.05))]}
        text = report.accuracy(result, "stereo")
        self.assertIn("worst 1 %, noise-free, left", text)
        self.assertEqual(row_of(text, "rotation only")[6], "10.0 (10.0)")
        result["systems"][1]["noise_free"]["eyes"]["right"].pop("noise_free_worst_percent")
        text = report.accuracy(result, "stereo")
        self.assertIn("worst 1 %, PSNR, left", text)
        self.assertEqual(row_of(text, "rotation only")[6], "5.00")

    def test_a_depth_track_has_the_codec_that_it_was_sent_with(self):
        asked = {"codec": "h264"}
        self.assertEqual(results.depth_codec(asked, {"code": "w10", "codec": "h265"}), "h265")
        self.assertEqual([results.depth_codec(asked, {"code": code}) for code in ("w8", "w10", "w12", "hue", "lossless")],
                         ["h264", "h264", "h265", "h265", "h265"])

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
