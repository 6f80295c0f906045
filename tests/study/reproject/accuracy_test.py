#!/usr/bin/env python3
"""Systems measured later are put into a result beside the others, and only into one of the same settings."""

import argparse
import copy
import json
import pathlib
import tempfile
import unittest

import accuracy
from steps import Failed

SETTINGS = {"frame": 3, "spp": 4, "seeds": [1, 2], "eye_size": "8x6", "move_m": (0.5, 0.25, 0), "spheres": {"left": "16x8"}}


def result(made, **rows):
    return {"scene": "room", "command": f"measured in {made}", "settings": SETTINGS, "made": made, "versions": {"commit": f"c{made}"}, "machine": {"cores": 2},
            **{kind: [{"system": system, "head": head, "db": db} for system, head, db in found] for kind, found in rows.items()}}


def rows(found, kind):
    return [(row["system"], row["head"], row["db"]) for row in found[kind]]


class Added(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.file = pathlib.Path(holder.name) / "room.json"
        before = result("2001", systems=[("paper", "stereo", 1), ("ours", "stereo", 2), ("paper", "moved", 3), ("ours", "moved", 4)],
                        coded=[("ours-coded-none", "stereo", 5)], rungs=[("rung-none", "stereo", 6)])
        accuracy.write_result(self.file, before | {"ceiling": 7}, False)

    def read(self):
        return json.loads(self.file.read_text())

    def test_rows_come_beside_the_others_in_the_order_of_a_whole_run(self):
        later = result("2002", systems=[("paper-gaps", "stereo", 10), ("ours", "moved", 11)], coded=[("paper-gaps-coded", "stereo", 12)])
        accuracy.write_result(self.file, later, True)
        found = self.read()
        self.assertEqual(rows(found, "systems"), [("paper", "stereo", 1), ("paper-gaps", "stereo", 10), ("ours", "stereo", 2), ("paper", "moved", 3),
                                                  ("ours", "moved", 11)])
        self.assertEqual(rows(found, "coded"), [("paper-gaps-coded", "stereo", 12), ("ours-coded-none", "stereo", 5)])
        self.assertEqual(rows(found, "rungs"), [("rung-none", "stereo", 6)])
        self.assertEqual((found["made"], found["command"], found["ceiling"]), ("2001", "measured in 2001", 7))

    def test_each_added_row_says_what_measured_it(self):
        accuracy.write_result(self.file, result("2002", systems=[("ours", "stereo", 10)]), True)
        accuracy.write_result(self.file, result("2003", systems=[("paper-gaps", "stereo", 11)]), True)
        measured = {(row["system"], row["head"]): row.get("measured") for row in self.read()["systems"]}
        said = {key: None if own is None else (own["command"], own["made"], own["versions"]["commit"], own["machine"]["cores"]) for key, own in measured.items()}
        self.assertEqual(said, {("paper", "stereo"): None, ("paper", "moved"): None, ("ours", "moved"): None,
                                ("ours", "stereo"): ("measured in 2002", "2002", "c2002", 2), ("paper-gaps", "stereo"): ("measured in 2003", "2003", "c2003", 2)})

    def test_otherwise_the_file_is_replaced(self):
        accuracy.write_result(self.file, result("2002", systems=[("ours", "stereo", 10)]), False)
        self.assertEqual((rows(self.read(), "systems"), "coded" in self.read(), "measured" in self.read()["systems"][0]), ([("ours", "stereo", 10)], False, False))

    def test_other_settings_are_refused(self):
        kept = self.file.read_text()
        for key, value in (("frame", 4), ("spp", 16), ("seeds", [1, 3]), ("eye_size", "16x9"), ("spheres", {"left": "32x16"})):
            later = copy.deepcopy(result("2002", systems=[("ours", "stereo", 10)]))
            later["settings"][key] = value
            with self.assertRaisesRegex(Failed, f"^--add: .*room.json: expected {key} "):
                accuracy.write_result(self.file, later, True)
        self.assertEqual(self.file.read_text(), kept)

    def test_a_sphere_that_is_new_is_no_other_setting(self):
        later = result("2002", systems=[("ours", "stereo", 10)])
        later["settings"] = SETTINGS | {"spheres": {"left": "16x8", "centre": "16x8"}}
        accuracy.write_result(self.file, later, True)
        self.assertEqual(self.read()["settings"]["spheres"], later["settings"]["spheres"])

    def test_without_a_file_nothing_is_added(self):
        with self.assertRaisesRegex(Failed, "^--add: expected a result measured before to add to, found no .*other.json$"):
            accuracy.write_result(self.file.with_name("other.json"), result("2002"), True)

    def test_names_of_systems(self):
        self.assertEqual(accuracy.systems("paper-gaps,coded,paper-gaps-coded"), ["paper-gaps", "coded", "paper-gaps-coded"])
        with self.assertRaisesRegex(argparse.ArgumentTypeError, "found 'papers'"):
            accuracy.systems("paper,papers")


if __name__ == "__main__":
    unittest.main()
