"""What `equistream fit` chooses, on curves whose answers are known in closed form."""

import dataclasses
import json
import math
import os
import pathlib
import shlex
import tempfile
import types
import unittest
import unittest.mock

from fit import path_frames, require_place, require_same_scene, use_of, window_for
from fitting import report as fit_report
from fitting import search as fit_search
from fitting import trial as fit_trial
from fitting.choice import Chosen, Fit, Unreachable, best_for_bytes
from fitting.report import quoted, sections_of, settings_text
from fitting.work import NARROWEST, Asked, Fill, FitWork, Light, Point, base_width, by_scene, by_streamed_depth, density
from options import without_remark
from render_list import size_text
from steps import Failed


class Counted:
    """A function that remembers where it was asked."""

    def __init__(self, function):
        self.function, self.asked = function, []

    def __call__(self, value):
        self.asked.append(value)
        return self.function(value)


class Search(unittest.TestCase):
    def test_the_largest_crf_that_keeps_the_level(self):
        for slope in (0.1, 0.5, 2.0):
            for level in (26.0, 30.0, 33.3):
                db_of = Counted(lambda crf, slope=slope: 36 - slope * crf)
                wanted = min(fit_search.WORST_CRF, math.floor((36 - level) / slope + 1e-9))
                found = fit_search.coarsest_crf(db_of, level, 24)
                self.assertEqual(len(db_of.asked), len(set(db_of.asked)), "a CRF was measured twice")
                if wanted < fit_search.BEST_CRF:
                    self.assertIsNone(found)
                else:
                    self.assertLessEqual(found, wanted)
                    self.assertLess(36 - slope * found, 36 - slope * wanted + fit_search.CLOSE_DB)
                    self.assertLessEqual(len(db_of.asked), 6)

    def test_a_curve_that_bends_and_steps(self):
        bent = Counted(lambda crf: 27 - 0.02 * 1.15 ** crf)
        self.assertEqual(fit_search.coarsest_crf(bent, 25, 24), 32)  # 27 - 0.02 1.15^32 = 25.25, at 33 24.99
        self.assertLessEqual(len(bent.asked), 6)
        stepped = Counted(lambda crf: 30.0 if crf <= 17 else 20.0)
        self.assertEqual(fit_search.coarsest_crf(stepped, 25, 24), 17)

    def test_curves_that_do_not_fall_take_no_more(self):
        for curve in (lambda crf: 20 + 0.1 * crf, lambda crf: 20.0, lambda crf: 20 + 0.01 * math.sin(crf), lambda crf: 15.2 + 0.03 * math.sin(3 * crf) + 5 * (crf < 8)):
            for level in (18, 20.2, 22):
                db_of = Counted(curve)
                crf = fit_search.coarsest_crf(db_of, level, 24)
                self.assertTrue(crf is None or curve(crf) >= level)
                self.assertLessEqual(len(db_of.asked), 9)

    def test_the_last_that_holds(self):
        for start in range(4):
            for last in range(4):
                holds = Counted(lambda value, last=last: value <= last)
                self.assertEqual(fit_search.last_holding((0, 1, 2, 3), holds, start), last)
                self.assertEqual(len(holds.asked), len(set(holds.asked)))
            self.assertIsNone(fit_search.last_holding((0, 1, 2, 3), lambda value: False, start))

    def test_the_highest_level_that_has_something(self):
        for edge in (1, 1.1, 20, 27.9, 28, 33.3, 79.9, 80):
            asked = []

            def value_at(level):
                asked.append(level)
                return f"at {level}" if level <= edge else None

            level, value = fit_search.highest(value_at, 28, 4, 0.25, (1, 80))
            self.assertEqual(value, f"at {level}")
            self.assertTrue(edge - 0.25 <= level <= edge, (edge, level))
            self.assertLess(len(asked), 13)
        self.assertIsNone(fit_search.highest(lambda level: None, 28, 4, 0.25, (1, 80)))

    def test_the_cheapest_is_in_the_valley_and_the_far_side_is_not_measured(self):
        costs = {1: None, 2: (9, "b"), 3: (5, "c"), 4: (6, "d"), 5: (7, "e")}
        best_at = Counted(costs.get)
        self.assertEqual(fit_search.cheapest((1, 2, 3, 4, 5), best_at), (5, "c"))
        self.assertEqual(best_at.asked, [1, 2, 3, 4])
        self.assertIsNone(fit_search.cheapest((1,), best_at))

    def test_a_track_beside_finer_coding(self):
        self.assertTrue(fit_search.is_worth(0.3, 1.05, 1.20))
        self.assertFalse(fit_search.is_worth(0.3, 1.25, 1.20))
        self.assertFalse(fit_search.is_worth(0.05, 1.00, 1.20))
        self.assertTrue(fit_search.is_worth(0.3, 3.00, None))

    def test_half_of_the_error_is_three_decibels(self):
        self.assertAlmostEqual(fit_search.max_gain_db(0.5), 10 * math.log10(2))
        self.assertEqual(fit_search.max_gain_db(0), 0)

    def test_once_or_every_frame(self):
        each = {"model": (1000, 10), "depth": (0, 30)}
        self.assertEqual(fit_search.cheapest_over(49, each), "depth")
        self.assertEqual(fit_search.cheapest_over(51, each), "model")


class Widths(unittest.TestCase):
    def asked(self, times):
        return Asked((640, 360), 90.0, 30, 31, 64, 64, times)

    def test_the_matching_one_is_among_them(self):
        for times in (1, 2 ** 0.5, 2, 4):
            widths = self.asked(times).widths
            self.assertLess(min(abs(width / (2 * math.pi * 320) - 1) for width in widths), 0.02)
            self.assertLessEqual(widths[-1], 2 * math.pi * 320 / 3.9)
            self.assertTrue(all(wide > narrow and narrow % 16 == 0 for wide, narrow in zip(widths, widths[1:])))

    def test_steps_of_half_an_octave(self):
        for times in (2, 4):
            widths = self.asked(times).widths
            for wide, narrow in zip(widths, widths[1:]):
                self.assertAlmostEqual(wide / narrow, 2 ** 0.5, delta=0.05)


class Use(unittest.TestCase):
    def test_a_shell_takes_the_names_as_they_are(self):
        scene, settings = pathlib.Path("my scenes/hall $1.json"), pathlib.Path("-mine.ini")
        words = [shlex.split(line, comments=False) for line in use_of(scene, settings).splitlines()]
        self.assertEqual(words[0], ["equistream", "render", str(scene), "--settings", "./-mine.ini", "--out", "frames"])
        self.assertEqual(words[1][-1], "hall $1.mp4")
        self.assertEqual(words[2][:3], ["equistream", "play", "hall $1.mp4"])


class MadeUp:
    """A scene with a mirror that holds the error at so many dB unless it is told of; width and CRF cost accuracy and bytes in closed form."""

    def __init__(self, mirror_db, told_bytes, window_bytes=1):
        self.mirror_db, self.told_bytes, self.window_bytes, self.folder = mirror_db, told_bytes, window_bytes, None

    def tells_of_mirrors(self, _place):
        return self.mirror_db is not None

    def at(self, way, width, crf):
        if way.window:  # sees a little less of the picture, of which it is a part
            point = self.at(dataclasses.replace(way, window=None), width, crf)
            return dataclasses.replace(point, way=way, db=point.db - 0.5, bytes=point.bytes and point.bytes * self.window_bytes)
        squares = 10 ** (-(36 + 4 * math.log2(width / 2016) - 0.2 * max(0, (crf or 0) - 12)) / 10) + (0 if way.told or self.mirror_db is None else 10 ** (-self.mirror_db / 10))
        db = -10 * math.log10(squares)
        return Point(way, width, crf, db, db, db, None if crf is None else width ** 2 / 1000 * 2 ** (-crf / 6) + (self.told_bytes if way.told else 0), None)


class Mirrors(unittest.TestCase):
    def fit(self, level, scene):
        fit = Fit(scene, Asked((640, 360), 90.0, 30, 31, 64, 64, 2 ** 0.5), "h264", level, 300)
        fit.light = Light(4)
        fit.at = scene.at
        return fit

    def test_a_scene_without_any_is_not_told(self):
        fit = self.fit(33, MadeUp(None, 0))
        self.assertFalse(fit.sphere()[0])
        self.assertNotIn("mirrors", " ".join(fit.why))

    def test_what_gains_nothing_is_not_tried(self):
        fit = self.fit(33, MadeUp(60, 0))
        self.assertFalse(fit.sphere()[0])
        self.assertIn("not taken", fit.why[0])

    def test_what_cannot_be_had_otherwise_is_told_whatever_it_takes(self):
        fit = self.fit(33, MadeUp(33, 10 ** 6))
        self.assertTrue(fit.sphere()[0])
        self.assertIn("else not to be had", " ".join(fit.why))

    def test_whichever_takes_fewer_bytes(self):
        for told_bytes, is_told in ((0, True), (10 ** 6, False)):
            self.assertEqual(self.fit(30, MadeUp(36, told_bytes)).sphere()[0], is_told)

    def test_the_most_found_is_the_better_ones(self):
        with self.assertRaises(Unreachable) as short:
            self.fit(45, MadeUp(33, 0)).sphere()
        self.assertTrue(short.exception.best.way.told)


class MostForBytes(unittest.TestCase):
    class Run(Fit):
        """Of a sphere alone, whose depth is sent once."""

        def run(self):
            self.light = Light(4)
            _, width, crf = self.sphere()
            return Chosen(self.at(by_scene(Fill(), False, self.light), width, crf), Fill(), 300_000)

    def fit_for(self, level):
        scene = MadeUp(None, 0)
        fit = self.Run(scene, Asked((640, 360), 90.0, 30, 31, 64, 64, 2 ** 0.5), "h264", level, 300)
        fit.at = scene.at
        return fit

    def test_the_highest_within_them(self):
        found = []
        for limit in (1_100, 1_200, 1_500, 10 ** 9):
            fit, chosen = best_for_bytes(limit, self.fit_for)
            self.assertLessEqual(chosen.bytes_a_frame(300), limit)
            self.assertGreaterEqual(chosen.point.db, fit.level)
            found.append(fit.level)
            if limit < 2000:
                self.assertGreater(self.fit_for(fit.level + 0.26).run().bytes_a_frame(300), limit)
        self.assertEqual(sorted(set(found)), found, "more bytes, more accuracy")
        with self.assertRaises(Unreachable):
            self.fit_for(found[-1] + 0.26).run()

    def test_fewer_than_any_accuracy_takes(self):
        with self.assertRaisesRegex(Failed, r"--kb 1: not to be had; the fewest found are 1,\d\d\d bytes a frame"):
            best_for_bytes(1000, self.fit_for)


class Window(unittest.TestCase):
    @staticmethod
    def asked():
        return Asked((640, 360), 90.0, 30, 31, 64, 64, 2 ** 0.5, (120, 90))

    def chosen(self, window_bytes, fill=Fill(), level=30, depth_share=0.05):
        scene = MadeUp(None, 0, window_bytes)
        fit = Fit(scene, self.asked(), "h264", level, 300)
        fit.light, fit.at = Light(4), scene.at
        _, width, crf = fit.sphere()
        sphere = Chosen(fit.at(by_scene(fill, False, fit.light), width, crf), fill, 0, depth_share=depth_share)
        return sphere, fit.looked_at(sphere), fit

    def test_it_is_taken_where_it_has_fewer_bytes(self):
        sphere, chosen, fit = self.chosen(0.4)
        self.assertEqual(chosen.point.way.window, (120, 90))
        self.assertGreaterEqual(chosen.point.db, 30)
        self.assertLess(chosen.crf, sphere.crf, "half a decibel is made up for by finer coding")
        self.assertIn(f"{chosen.point.bytes / sphere.point.bytes:.2f} of the whole sphere's: taken", fit.why[-1])
        sections = sections_of(chosen, fit.asked, "h264")
        self.assertEqual(sections["play"]["fill"], '"base,pushpull"')
        render = sections["render"]
        self.assertEqual((render["window"], render["density"], render["size"]), ('"gaze,120x90"', density(chosen.width), size_text((base_width(chosen.width), base_width(chosen.width) // 2))))

    def test_depth_by_geometry_stays_so(self):
        _, chosen, _ = self.chosen(0.4, depth_share=0)
        self.assertEqual((chosen.depth_share, chosen.point.way.window), (0, (120, 90)))
        self.assertTrue(chosen.point.way.name.startswith("scene"))

    def test_densities_are_what_render_takes(self):
        for width in (NARROWEST, *self.asked().widths):
            self.assertEqual(density(width) % 32, 0)
            self.assertLess(density(width) - width, 32)
            self.assertGreater(density(width), base_width(width))
            self.assertGreaterEqual(base_width(width), 128, "streams have 64 rows at least")

    def test_a_window_for_the_view_and_the_heads_turn(self):
        still, turning = {"window_deg": [120, 78]}, {"window_deg": [140, 98]}
        self.assertEqual(window_for((640, 360), 90, still), (120, math.ceil(2 * math.degrees(math.atan(9 / 16)) / 0.75)))
        self.assertEqual(window_for((640, 640), 90, turning), (140, 140))
        self.assertEqual(window_for((640, 320), 60, turning), (100, math.ceil((2 * math.degrees(math.atan(math.tan(math.radians(30)) / 2)) + 15) / 0.75)))
        self.assertEqual(window_for((640, 640), 170, {"window_deg": [359, 180]}), (359, 180))

    def test_a_window_that_saves_nothing_is_not_taken(self):
        sphere, chosen, fit = self.chosen(1)
        self.assertIs(chosen, sphere)
        self.assertIn("not taken", fit.why[-1])
        self.assertNotIn("window", sections_of(chosen, fit.asked, "h264")["render"])

    def test_tracks_for_gaps_go_with_spheres(self):
        sphere, chosen, fit = self.chosen(0.1, Fill("hidden,pushpull", "hidden"))
        self.assertIs(chosen, sphere)
        self.assertIn("not tried", fit.why[-1])


class Gaps(unittest.TestCase):
    def test_where_noise_made_the_error_negative_nothing_is_filled(self):
        point = Point(by_scene(Fill(), False, Light(1)), 512, 30, 40, 40, None, 1000)
        measure = types.SimpleNamespace(at=lambda *_: point, gap_error=lambda _point: (0.0, -1e-9))
        fit = Fit(None, Asked((640, 360), 90.0, 30, 31, 64, 64, 1), "h264", 30, 300, measure)
        fit.light = Light(1)
        self.assertEqual(fit.fill(512, 30), Fill())
        self.assertIn("gaps hold 0 % of the error", fit.why[0])


class StreamedDepth(unittest.TestCase):
    """Depth errs the more the narrower the sphere is."""

    def test_a_sphere_wide_enough_for_its_depth_is_taken(self):
        fit = Fit(None, Asked((640, 360), 90.0, 30, 31, 64, 64, 1), "h264", 30, 300)
        fit.light = Light(1)
        wide = fit.asked.matching_width
        narrow = min(fit.asked.widths, key=lambda width: abs(width - wide / 2))

        def at(way, width, crf):
            db = 40 + 6 * math.log2(width / wide) - 0.1 * (crf or 0) - 2.5 * (wide / width) ** 2
            return Point(way, width, crf, db, db, db, None if crf is None else width ** 2 * 2 ** (-crf / 6), None)

        fit.at = at
        chosen = fit.streamed(Fill(), narrow, 24)
        self.assertGreater(chosen.width, narrow)
        self.assertGreaterEqual(chosen.point.db, fit.level)
        self.assertIsNone(fit.finest(by_streamed_depth(Fill(), False, fit.light, 0.1), narrow, 24))


class Rendered:
    """A scene whose error is noise, of which a denoiser takes most and adds a bias; a denoised sphere codes to half the bytes."""

    def __init__(self, bias_db, has_denoiser=True):
        self.bias_db, self.has_denoiser, self.rendered = bias_db, has_denoiser, []

    def at(self, way, width, crf):
        light = way.light
        self.rendered.append(light)
        squares = 10 ** (-20 / 10) / light.samples
        if light.denoise != "off":
            if not self.has_denoiser:
                raise Failed("expected Open Image Denoise, found none")
            squares = squares / 10 + 10 ** (-self.bias_db / 10)
        db = -10 * math.log10(squares)
        if crf is not None:
            db -= 0.1 * crf
        count = None if crf is None else 1000 * 2 ** (-crf / 6) * (0.5 if light.denoise != "off" else 1)
        return Point(way, width, crf, db, db, db, count, None)

    @staticmethod
    def light_cpu_s(_width, light):
        return light.samples


class LeastLight(unittest.TestCase):
    def chosen(self, level, scene):
        fit = Fit(scene, Asked((640, 360), 90.0, 30, 31, 64, 64, 1), "h264", level, 300)
        fit.at = scene.at
        return fit.cheapest_light(), fit

    def test_few_samples_are_denoised_where_that_takes_fewer_bytes(self):
        light, fit = self.chosen(30, Rendered(40))
        self.assertEqual((light.samples, light.denoise), (2, "balanced"))
        self.assertIn("bytes a frame coded to 30 dB: taken", fit.why[1])

    def test_as_rendered_where_the_bias_is_in_the_way(self):
        light, _ = self.chosen(30, Rendered(28))
        self.assertEqual((light.samples, light.denoise), (16, "off"))

    def test_as_rendered_without_a_denoiser(self):
        light, fit = self.chosen(30, Rendered(40, has_denoiser=False))
        self.assertEqual((light.samples, light.denoise), (16, "off"))
        self.assertEqual(len(fit.why), 2)
        self.assertIn("not tried: expected Open Image Denoise", fit.why[0])

    def test_the_best_where_none_has_it(self):
        light, _ = self.chosen(50, Rendered(40))
        self.assertEqual(light.denoise, "balanced")


class Words(unittest.TestCase):
    def test_sections(self):
        asked = Asked((640, 360), 90.0, 30, 31, 64, 64, 1)
        point = Point(by_scene(Fill(), False, Light(16, "balanced")), 1008, 30, 25.1, 25.0, 25.2, 9000, None)
        by_stream = sections_of(Chosen(point, Fill("hidden,pushpull", "hidden"), 0, depth_share=0.05), asked, "h264")
        self.assertEqual(by_stream["render"], {"eye": "centre", "size": "1008x504", "spp": 16, "denoise": "balanced", "aovs": '"depth"', "layers": "true"})
        self.assertEqual((by_stream["encode"]["depth"], by_stream["encode"]["fill"], by_stream["play"]["depth"]), ("auto", "hidden", "stream"))
        self.assertEqual(by_stream["view"]["method"], "mesh")
        self.assertNotIn("mirrors", by_stream["encode"])
        by_model = sections_of(Chosen(point, Fill(), 5, model_px=4, told=True, geometry_file="/a b/m.json"), asked, "h265")
        self.assertEqual((by_model["render"]["aovs"], by_model["encode"]["mirrors"]), ('"depth,specular,virtual"', "always"))
        self.assertEqual(by_model["play"]["model"], '"/a b/m.json"')
        self.assertEqual((by_model["encode"]["depth"], by_model["model"]), ("none", {"error-px": "4", "focal": "320"}))
        text = settings_text(["why"], by_stream)
        self.assertTrue(text.startswith("# why\n\n[render]\neye = centre\n"))
        self.assertNotIn("[model]", text)

    def test_any_path_and_remark_can_be_read_again(self):
        self.assertEqual(quoted('/a "b".json'), "'/a \"b\".json'")
        for path in ('/a "b".json', "/it's.json", "/a #1.json"):
            self.assertEqual(without_remark(quoted(path)), path)
        self.assertEqual(settings_text(["one\ntwo\r\n[play]", "three"], {}), "# one two [play]\n# three\n")

    def test_a_table_lines_up(self):
        self.assertEqual(fit_report.aligned([["a", "b"], ["ccc", "1"]]), ["a    b", "ccc  1"])


class Scene(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def written(self, name, content):
        (self.folder / name).write_text(content if isinstance(content, str) else json.dumps(content))
        return self.folder / name

    def test_frames_are_those_that_render_counts(self):
        for rate, count in ((None, {0.02: 1, 2.99: 90, 5.0: 151}), (24, {0.99: 24, 1.0: 25})):
            scene = self.written("a.json", {"frames_per_second": rate} if rate else {})
            for duration_s, frames in count.items():
                self.assertEqual(path_frames(types.SimpleNamespace(info={"path_duration_s": duration_s}, scene=scene)), frames)

    def test_a_byte_order_mark_is_no_part_of_the_scene(self):
        scene = self.written("a.json", "\ufeff" + json.dumps({"frames_per_second": 24}))
        self.assertEqual(path_frames(types.SimpleNamespace(info={"path_duration_s": 1.0}, scene=scene)), 25)
        self.written("a.png", "123")
        self.assertEqual(self.bytes_of("a.gltf", "\ufeff" + json.dumps({"images": [{"uri": "a.png"}]})), 3)

    def test_names_that_settings_files_cannot_have_are_told_before_the_work(self):
        def refuse(message):
            raise Failed(message)

        folder = self.folder / os.fsdecode(b"d\xff")
        folder.mkdir()
        options = types.SimpleNamespace(out=folder / "a.ini", scene=self.written("a.json", {}), work=self.folder / "work")
        with self.assertRaisesRegex(Failed, r"expected paths and words in UTF-8, as settings files are, found '.*/d\\xff/a\.ini'; rename"):
            require_place(types.SimpleNamespace(error=refuse), options)

    def test_one_that_has_changed_meanwhile_is_told(self):
        options = types.SimpleNamespace(bin=self.folder, scene=self.written("a.json", {}), info={"fingerprint": "1"})
        with unittest.mock.patch("fit.measured_json", lambda *_: {"fingerprint": "1"}):
            require_same_scene(options)
        with unittest.mock.patch("fit.measured_json", lambda *_: {"fingerprint": "2"}), self.assertRaisesRegex(Failed, "found it changed; run it again"):
            require_same_scene(options)

    def bytes_of(self, model, content):
        self.written(model, content)
        given = self.written("a.json", {"model": model, "camera": {"keys": []}})
        work = types.SimpleNamespace(given=given, info={"texture_bytes": 1000})
        return FitWork.scene_bytes(work) - given.stat().st_size - (self.folder / model).stat().st_size

    def test_what_is_sent_of_a_whole_scene_is_with_what_its_model_names(self):
        self.written("my buffer.bin", "12345")
        self.written("a.png", "123")
        gltf = {"buffers": [{"uri": "my%20buffer.bin"}, {"uri": "data:,1"}, {}],
                "images": [{"uri": "a.png"}, {"uri": "a.png"}, {"uri": "none.png"}, {"bufferView": 0}]}
        self.assertEqual(self.bytes_of("a.gltf", gltf), 8)
        self.assertEqual(self.bytes_of("a.obj", "mtllib a.mtl"), 1000)
        self.assertEqual(self.bytes_of("a.glb", "images lie in it"), 0)


class Trial(unittest.TestCase):
    """What the file's own commands have is what is promised."""

    def tried(self, db_of, level, limit=None):
        fit = types.SimpleNamespace(why=[], work=None, asked=None, codec="h264", path_frames=10)
        chosen = Chosen(Point(by_scene(Fill(), False, Light(1)), 512, 30, 25.2, 25.0, 25.4, 1000), Fill(), 0, depth_share=0.1)
        with unittest.mock.patch.object(fit_trial, "measured", lambda _work, chosen, *_: fit_trial.with_point(chosen, 3, db=db_of(chosen.crf), bytes=1600 - 20 * chosen.crf)):
            return fit_trial.tried_file(fit, chosen, level, limit), fit.why

    def measured(self, *squares):
        """What is promised where each of these is a seed's mean square, known within a tenth, of a stream of 900 bytes, 1,100 and so on."""
        def entry(square):
            return {"whole": {eye: {"whole": {"linear": {"mean_square": square, "mean_square_low": 0.9 * square, "mean_square_high": 1.1 * square}}} for eye in ("left", "right")}}

        of_seed = {seed: (entry(square), 900 + 200 * i) for i, (seed, square) in enumerate(zip(fit_trial.SEEDS, squares))}
        chosen = Chosen(Point(by_scene(Fill(), False, Light(1)), 512, 30, 25.2, 25.0, 25.4, 1000), Fill(), 0, depth_share=0.1)
        asked = Asked((640, 360), 90.0, 30, 31, 64, 64, 1)
        with unittest.mock.patch.object(fit_trial, "played", lambda _work, _sections, seed: of_seed[seed]):
            return fit_trial.measured(types.SimpleNamespace(), chosen, asked, "h264")

    def test_all_seeds_count_and_the_interval_has_each(self):
        tried = self.measured(*16 * (0.001, 0.003))
        for found, square in ((tried.point.db, 0.002), (tried.point.low, 0.0033), (tried.point.high, 0.0009)):
            self.assertAlmostEqual(found, -10 * math.log10(square))
        self.assertEqual((tried.trials, tried.point.bytes), (32, 2000))

    def test_there_are_no_more_seeds_than_the_mean_needs(self):
        self.assertEqual(self.measured(0.001, 0.001, 0.001).trials, 3)  # seeds that are not there are not asked for
        self.assertEqual(self.measured(0.001, 0.00101, 0.00099).trials, 3)  # 0.044 dB of deviation: known within 0.11
        self.assertEqual(self.measured(0.001, 0.00102, 0.00098, 0.001).trials, 4)  # within 0.22, and then within 0.11

    def test_frames_without_an_error_are_told(self):
        with self.assertRaisesRegex(Failed, "expected frames whose error is known, found 2 without"):
            self.measured(0, 0, 0)

    def test_the_figures_are_the_trials(self):
        chosen, why = self.tried(lambda crf: 25.1, 25)
        self.assertEqual((chosen.crf, chosen.point.db, chosen.point.bytes), (30, 25.1, 1000))
        self.assertIn("with 3 seeds that the search did not use: 25.10 [25.00, 25.40] dB", why[-1])
        self.assertIn("and 1,000 bytes a frame, where the search had 25.20", why[-1])

    def test_a_file_that_falls_short_is_coded_finer(self):
        chosen, why = self.tried(lambda crf: 24.8 + 0.1 * (30 - crf), 25)
        self.assertEqual(chosen.crf, 28)
        self.assertIn("CRF 28 in place of 30", why[-1])

    def test_what_no_coding_has_is_said(self):
        with self.assertRaisesRegex(Failed, f"own commands have 20.00 at CRF {fit_search.BEST_CRF}"):
            self.tried(lambda crf: 20, 25)

    def test_a_file_that_takes_too_much_is_coded_coarser(self):
        chosen, why = self.tried(lambda crf: 25, None, 950)
        self.assertEqual((chosen.crf, chosen.point.bytes), (33, 940))
        self.assertIn("coded coarser: CRF 33 in place of 30", why[-1])
        with self.assertRaisesRegex(Failed, rf"--kb 0.5: .* own commands have 720 at CRF {fit_search.WORST_CRF}"):
            self.tried(lambda crf: 25, None, 500)


if __name__ == "__main__":
    unittest.main()
