"""Options that could do nothing are refused, paths that cannot be looked at are bad input, and reports say whose they are.

usage: options_test.py BIN_DIR   (the folder of the built programs)
"""

import json
import unittest

from commands import Commands

PLAY = ["--method", "rotation", "--size", "64x36", "--frames", 0]


class Options(Commands):
    def test_pictures_of_a_display_have_no_exposure_and_no_view(self):
        self.done("play", self.frames, *PLAY, "--out", self.out / "views")
        picture, frame = self.out / "views/left/frame.0000.png", self.frames / "centre/frame.0000.exr"
        for option, value in (("--exposure", 4), ("--view", "Un-tone-mapped")):
            self.refused(["compare", picture, picture, option, value], f"{option}: expected an EXR among the pictures, found PNG alone")
            self.done("compare", frame, frame, "--metrics", "psnr", option, value)

    def test_nothing_is_carried_on_without_refreshes(self):
        for value in (0, 7):
            self.refused(["play", self.frames, *PLAY, "--carry", value, "--out", self.out / "views"],
                         "--carry: expected --refresh or --network beside it, found neither")

    def test_a_dry_run_knows_its_options(self):
        self.refused(["import", self.frames / "centre", "--dry-run", "--progress", "bogus"], "--progress", "bogus")

    def test_paths_that_cannot_be_looked_at(self):
        circle, long = self.out / "circle", self.out / ("x" * 300)
        circle.symlink_to(circle)
        for path, why in ((circle, "symbolic links"), (long, "name too long")):
            for words in (["info", path], ["import", path, "--dry-run"], ["play", self.frames, *PLAY, "--out", path / "a.mp4"],
                          ["play", path, *PLAY, "--out", self.out / "views"], ["encode", path, "--out", self.out / "a.mkv"]):
                self.refused(words, "expected ", why)


class Reports(Commands):
    def assert_names_its_making(self, *words):
        report = json.loads(self.done(*words))
        self.assertTrue(report["command"].startswith("equistream " + " ".join(words[:1])), report["command"])
        self.assertTrue(report["version"] and report["machine"]["cpu"] and report["machine"]["threads"] >= 1, words)
        return report

    def test_what_info_says(self):
        for source, kind in ((self.frames, "render"), (self.frames / "centre/frame.0000.exr", "exr")):
            self.assertEqual(self.assert_names_its_making("info", source, "--json")["kind"], kind)

    def test_what_scene_says(self):
        self.assertEqual(self.assert_names_its_making("scene", "info", self.scene, "--json")["scene"], "motion")
        xml = self.out / "motion.xml"
        self.assertGreater(self.assert_names_its_making("scene", "convert", self.scene, xml, "--json")["triangles"], 0)
        self.assertEqual(self.assert_names_its_making("scene", "info", xml, "--json")["must_change"], [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
