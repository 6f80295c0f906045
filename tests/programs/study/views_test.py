"""What the study does with pictures and heads, beside closed forms: spheres filtered narrower (rendered_test.py has them beside rendered ones); FLIP of what
is the same; what tables say of whole and noise-free errors, and of results that have none; truths of noise that no view has; kinds of pixels, whose edges begin where closed form says; heads that have turned and moved on.
"""

import contextlib
import io
import json
import math
import os
import shutil
import tempfile
import types
import unittest
from pathlib import Path

import equistream as es
import found
import kept
import narrowed
import numpy as np
import pages
import perceived
import render_list
import study_run
from charts import window as window_tables
from experiments import moved, where, window
from experiments.systems import SYSTEMS, Player
from PIL import Image
from presets import PRESETS
from tables import systems
from tables.where import kinds_of, shares


class Narrowed(unittest.TestCase):
    def test_each_pixel_is_the_mean_of_those_it_covers(self):
        colour = np.arange(4 * 8 * 3, dtype=float).reshape(4, 8, 3)
        np.testing.assert_allclose(narrowed.narrowed(colour, (4, 2))[1, 3], colour[2:4, 6:8].mean(axis=(0, 1)))

    def test_light_is_kept(self):
        random = np.random.default_rng(2).random((9, 18, 3))
        np.testing.assert_allclose(narrowed.narrowed(random, (6, 3)).mean(axis=(0, 1)), random.mean(axis=(0, 1)), atol=1e-12)

    def test_other_sizes_are_refused(self):
        for size in ((8, 4), (3, 2), (4, 1)):
            with self.assertRaisesRegex(ValueError, f"a whole fraction of 4x2, found {size[0]}x{size[1]}"):
                narrowed.narrowed(np.zeros((2, 4, 3)), size)


SIZE, GREY = (96, 64), 128


class Perceived(unittest.TestCase):
    def setUp(self):
        self.root = Path(tempfile.mkdtemp(prefix="equistream_perceived_"))
        self.addCleanup(shutil.rmtree, self.root, ignore_errors=True)

    def sequence(self, name, offsets):
        """Grey frames, each brighter by its offset."""
        folder = self.root / name
        folder.mkdir()
        for number, offset in enumerate(offsets):
            Image.fromarray(np.full((*SIZE[::-1], 3), GREY + offset, np.uint8)).save(folder / f"frame.{number:04}.png")
        return folder

    def test_flip_is_of_what_differs(self):
        plain, bright = self.sequence("plain", [0, 0]), self.sequence("bright", [30, 30])
        self.assertEqual(perceived.flip(plain, plain, 20), 0)
        self.assertGreater(perceived.flip(bright, plain, 20), 0.05)
        self.assertAlmostEqual(perceived.pixels_a_degree(180 / math.pi), 1)


class Charts(unittest.TestCase):
    def test_marks_share_a_look_that_their_group_hands_down(self):
        """Opacity of a group is of what it holds as a whole."""
        def marks(look):
            return f'<g clip-path="url(#c)">{2 * f"<use style={chr(34)}{look}{chr(34)}/>"}</g>'
        drawn = kept.lean_svg(f'<svg xmlns="{kept.SVG}">{marks("fill: red")}{marks("fill: red; opacity: 0.9")}</svg>')
        self.assertEqual(drawn.count('class="a0"'), 1)
        self.assertEqual(drawn.count('class="a1"'), 2)


def interval(mean_square, half=0.0):
    low, high = mean_square - half, mean_square + half
    return {"mean_square": mean_square, "mean_square_low": low, "mean_square_high": high, "db": found.decibels(mean_square), "db_low": found.decibels(high),
            "db_high": found.decibels(low), "only_bounded": low <= 0}


def compared(kind, mean_square, half=0.0):
    """What `compare` says of both eyes."""
    both = {scale: interval(mean_square, half) for scale in ("linear", "display")}
    eye = {kind: both, f"{kind}_worst_percent": both, "gaps": {"fraction": 0.5, kind: both}, "flicker": {kind: both, "motion": "exact"}, "mean_square": 255 ** 2 * mean_square}
    return {"left": eye, "right": eye}


OLD = {"against_other_seed": compared("none", 1e-2), "noise_free": compared("noise_free", 1e-3), "perceived": {eye: {"flip": 0, "flicker": interval(1e-5)} for eye in ("left", "right")}}
NEW = {"whole": compared("whole", 1e-2, 1e-3), "noise_free": compared("noise_free", 1e-3), "perceived": {}}


class Kept(unittest.TestCase):
    def test_the_whole_error_comes_first_and_a_dash_where_there_is_none(self):
        self.assertEqual(pages.kinds_short(NEW), "20.0 / 30.0")
        self.assertEqual(pages.kinds_short(OLD), "- / 30.0")
        self.assertEqual(pages.kinds_text(NEW), "20.00 [19.59, 20.46] / 30.00 [30.00, 30.00]")
        self.assertEqual(pages.kinds_text(OLD), "- / 30.00 [30.00, 30.00]")
        for text in (systems.worst_text, systems.gaps_text):
            self.assertEqual([pages.both_kinds(text, entry) for entry in (NEW, OLD)], ["20.0 / 30.0", "- / 30.0"])

    def test_flicker_is_compares_or_of_older_results_what_stands_beside_flip(self):
        self.assertEqual(pages.both_kinds(systems.flicker_text, NEW), "20.0 / 30.0")
        older = {**OLD, "noise_free": {eye: {**figures, "flicker": None} for eye, figures in OLD["noise_free"].items()}}
        self.assertEqual(pages.both_kinds(systems.flicker_text, older), "- / 50.0")
        self.assertIsNone(systems.flicker_db({**NEW, "whole": {"left": {"flicker": None}, "right": {"flicker": None}}}, "whole"))

    def test_psnr_is_of_whichever_comparison_has_it(self):
        self.assertAlmostEqual(found.psnr(NEW), 20)
        self.assertAlmostEqual(found.psnr(OLD), 20)

    def test_no_depth_code_suffices_where_the_head_box_touches_a_triangle(self):
        info = {"triangles": 1000, "unique_triangles": 1000, "textures": 0, "path_length_m": 1, "turn_deg": 90, "nearest_m": 0.01, "sphere_width": 6032}
        self.assertEqual([systems.scene_row("mine", {**info, "depth_levels": levels})[-1] for levels in (None, 1234.0)], ["-", "1234"])

    def test_a_copied_work_folder_shows_its_own_pictures(self):
        with tempfile.TemporaryDirectory() as holder:
            work, copy, moved = (Path(holder).resolve() / name for name in ("work", "copy", "moved"))
            for eye, view in (("left", "a"), ("right", "b")):
                (work / f"views/{view}/{eye}").mkdir(parents=True)
            (work / "views/a-with-b").mkdir()
            (work / "views/a-with-b/left").symlink_to(work / "views/a/left")  # as it was made before
            shutil.copytree(work, copy, symlinks=True)
            for folder in (work, copy):
                self.assertEqual(Player(types.SimpleNamespace(folder=folder)).each_eye_of_its_own(["views/a", "views/b"]), "views/a-with-b")
            work.rename(moved)
            for folder in (copy, moved):
                self.assertEqual([os.path.realpath(folder / f"views/a-with-b/{eye}") for eye in ("left", "right")],
                                 [str(folder / "views/a/left"), str(folder / "views/b/right")])

    def test_how_well_whole_errors_are_known(self):
        errors = list(found.whole_errors({"systems": [NEW, OLD], "settings": {"crfs": [16, 24]}}))
        self.assertEqual(len(errors), 2, "each eye, once")
        self.assertAlmostEqual(found.known_within_db(errors[0]), (found.decibels(9e-3) - found.decibels(11e-3)) / 2)
        self.assertEqual(found.known_within_db(interval(1e-3, 2e-3)), math.inf)

    def told(self, *entries):
        out, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            study_run.tell_how_well_known({"systems": list(entries), "settings": {"truth_samples": 16}}, "systems/a.json")
        return out.getvalue(), errors.getvalue()

    def test_a_line_warns_where_they_are_not_known_well_enough(self):
        close = {"whole": compared("whole", 1e-2, 1e-4)}
        self.assertEqual(self.told(OLD), ("", ""))
        self.assertEqual(self.told(close), ("systems/a.json: whole errors known within 0.04 dB (the median of 2), 0.04 dB at most\n", ""))
        self.assertEqual(self.told(close, close, NEW)[1], "systems/a.json: warning: expected whole errors known within 0.3 dB, found 2 of 6 wider, with 16 samples a pixel "
                         "of the truth (truth_samples of the preset)\n")


class Truths(unittest.TestCase):
    def test_no_view_has_their_seed_or_noise(self):
        for preset in PRESETS.values():
            for scene in preset.scenes:
                renders = list(render_list.every_render(preset, scene))
                truths = [render for render in renders if render.name.startswith("truth-")]
                self.assertEqual(len({render.seed for render in truths}), 2)
                self.assertFalse({render.seed for render in truths} & {render.seed for render in renders if render not in truths})
                for render in truths:
                    self.assertIn("--unbiased", render.words())
                    self.assertEqual(render.samples, preset.truth_samples_of(scene))

    def test_samples_are_of_all_pictures(self):
        preset = PRESETS["small"]
        width, height = preset.eye
        self.assertEqual(render_list.truth(preset, "kitchen", 1).samples_a_frame(), 2 * width * height * 64)
        columns, across, high = preset.windows[0]
        around = preset.base_width ** 2 / 2
        self.assertAlmostEqual(render_list.window(preset, 1, *preset.windows[0]).samples_a_frame() / preset.sphere_samples,
                               around + columns ** 2 * across * high / 360 ** 2, delta=columns)
        self.assertIn(f"window-{columns}-1", {render.name for render in render_list.every_render(preset, "kitchen")})

    def test_scenes_may_ask_for_more_samples(self):
        self.assertEqual(PRESETS["small"].truth_samples_of("kitchen"), 64)
        self.assertEqual(PRESETS["small"].truth_samples_of("voxel-city"), 32)
        self.assertEqual(PRESETS["smoke"].truth_samples_of("pavilion"), PRESETS["smoke"].eye_samples)


FOCAL_PX, IPD_M = 320, 0.063
BY_NAME = {system.name: system for system in SYSTEMS}


def step(near_m, far_m, columns=8):
    return np.where(np.arange(columns) < columns // 2, near_m, far_m) * np.ones((5, 1))


class Kinds(unittest.TestCase):
    def test_each_pixel_is_of_exactly_one(self):
        random = np.random.default_rng(1)
        hidden, specular = random.random((2, 40, 60)) < 0.05
        kinds = where.kinds_of(hidden, specular, random.choice([1.0, 1.01, 3.0, np.inf], (40, 60), p=[0.5, 0.45, 0.03, 0.02]), FOCAL_PX, IPD_M)
        self.assertEqual(list(kinds), list(where.KINDS))
        np.testing.assert_array_equal(sum(mask.astype(int) for mask in kinds.values()), 1)
        np.testing.assert_array_equal(kinds["hidden"], hidden)
        self.assertTrue(all(mask.any() for mask in kinds.values()))

    def test_a_mirror_reaches_a_pixel_further(self):
        specular = np.zeros((5, 8), bool)
        specular[2, 4] = True
        kinds = where.kinds_of(np.zeros_like(specular), specular, np.ones(specular.shape), FOCAL_PX, IPD_M)
        self.assertEqual(kinds["mirrors"].sum(), 9)
        self.assertEqual(kinds["edges"].sum(), 0)

    def test_an_edge_begins_at_a_pixel_of_shift(self):
        near_m = 2.0
        at_one_pixel_m = 1 / (1 / near_m - where.EDGE_PX / (FOCAL_PX * IPD_M))
        found = where.edges(step(near_m, 1.01 * at_one_pixel_m), FOCAL_PX, IPD_M)
        np.testing.assert_array_equal(np.flatnonzero(found[2]), [3, 4])
        self.assertFalse(where.edges(step(near_m, 0.99 * at_one_pixel_m), FOCAL_PX, IPD_M).any())

    def test_the_sky_lies_still(self):
        near, far = (where.edges(step(FOCAL_PX * IPD_M / px, np.inf), FOCAL_PX, IPD_M).any() for px in (1.1, 0.9))
        self.assertEqual((near, far), (True, False))


def entry(**kinds):
    """Of both eyes alike: {kind: (share of the pixels, mean square over these)}; a share of 0 has no error."""
    figures = {kind: {"fraction": share, **({"noise_free": {"linear": {"mean_square": square}}} if share else {})} for kind, (share, square) in kinds.items()}
    return {"kinds": {kind: {"left": figure, "right": figure} for kind, figure in figures.items()}}


class Shares(unittest.TestCase):
    def test_they_are_of_all_of_the_error(self):
        found = entry(hidden=(0.1, 0.02), mirrors=(0, 0), edges=(0.3, 0.01), elsewhere=(0.6, 0.005))
        self.assertAlmostEqual(sum(square for _, square in kinds_of(found).values()), 0.1 * 0.02 + 0.3 * 0.01 + 0.6 * 0.005)
        for kind, share in {"hidden": 0.25, "mirrors": 0, "edges": 0.375, "elsewhere": 0.375}.items():
            self.assertAlmostEqual(shares(found)[kind], share)

    def test_what_noise_made_negative_is_none(self):
        self.assertEqual(shares(entry(hidden=(0.1, -0.001), elsewhere=(0.9, 0.01))), {"hidden": 0, "elsewhere": 1})


class Places(unittest.TestCase):
    def test_all_from_one_place_miss_what_its_geometry_says(self):
        self.assertEqual({name: getattr(where.that_knows_gaps(system), "name", None) for name, system in BY_NAME.items()}, {
            "perspective": "perspective", "pair": None, "sphere-left": "sphere-left", "two-spheres": None,
            **{name: "centre" for name in BY_NAME if name.startswith("centre") or name == "default"}})


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
            file.write_text(moved.path_text(moved.standing(there)))
            head, *rows = file.read_text().splitlines()
            self.assertEqual(head, "time_s,x,y,z,qw,qx,qy,qz")
            self.assertEqual(len({row.split(",", 1)[1] for row in rows}), 1)
            back = es.Pose([float(v) for v in rows[0].split(",")[1:4]], [float(v) for v in rows[0].split(",")[4:]])
            np.testing.assert_allclose(back.matrix, there.matrix, atol=1e-9)


class HeadsOfLater(unittest.TestCase):
    WALK = es.PosePath([(0, es.Pose((0, 0, 0))), (3, es.Pose((3, 0, 0)))])

    def test_they_walk_on_and_back_from_the_paths_end_and_look_about(self):
        heads = {head.late_s: head for head in window.later_heads(self.WALK, 1)}
        for late_s, along_m in {0: 1, 0.4: 1.4, 1: 2, 2: 3, 4: 1}.items():
            np.testing.assert_allclose(heads[late_s].position_m, (along_m, 0, 0), atol=1e-9)
        self.assertAlmostEqual(heads[0.1].turned_deg, 6, delta=0.02, msg="at up to 60 degrees a second")
        self.assertLessEqual(max(abs(head.turned_deg) for head in heads.values()), window.SWING_DEG)
        pose = heads[0.4].pose(TOLD)
        np.testing.assert_allclose(pose.position_m, (1.4, 0, 0), atol=1e-9)
        turned = TOLD.matrix[:3, :3].T @ pose.matrix[:3, :3]
        self.assertAlmostEqual(math.degrees(math.acos((np.trace(turned) - 1) / 2)), heads[0.4].turned_deg, places=4)

    def test_a_scenes_path_is_in_its_description_or_beside_it(self):
        with tempfile.TemporaryDirectory() as folder:
            description, (first, last) = Path(folder) / "a.json", self.WALK.keys
            (Path(folder) / "a.csv").write_text("# A walk.\n" + moved.path_text(self.WALK.keys))
            keys = [{"time_s": time_s, "position_m": list(pose.position_m), "orientation_wxyz": list(pose.orientation)} for time_s, pose in (first, last)]
            for camera in ({"path": "a.csv"}, {"keys": keys}):
                description.write_text(json.dumps({"camera": camera}))
                self.assertEqual(window.path_of_scene(description).keys, self.WALK.keys)

    def test_a_silence_is_as_bad_as_the_worst_that_was_seen_in_it(self):
        seen_db = {0: (30, 29), 0.4: (25, 28), 1: (20, 26), 2: (22, 18), 4: (15, 19)}
        later = [{"name": f"{late_s}", "late_s": late_s} for late_s in seen_db]
        elsewhere = [{"head": f"{late_s}", "source": source, "whole": compared("whole", 10 ** (-level / 10))}
                     for late_s, levels in seen_db.items() for source, level in zip(("window-8", "sphere-4"), levels)]
        result = {"settings": {"sphere_width": 4}, "titles": {"window-8": "window", "sphere-4": "sphere"}, "later": later, "elsewhere": elsewhere}
        rows = window_tables.silence_table({"a": result}).splitlines()[2:]
        self.assertEqual(rows, ["| a | window | 20.00 | 20.00 | 15.00 | -6.00 | +2.00 | -3.00 |", "| a | sphere | 26.00 | 18.00 | 18.00 | +0.00 | +0.00 | +0.00 |"])


if __name__ == "__main__":
    unittest.main()
