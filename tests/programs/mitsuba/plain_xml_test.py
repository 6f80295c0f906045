"""XML as people write it: nothing has an id, materials are inline, lamps are hidden, spectra lie in files.

usage: plain_xml_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
SIZE = ["--size", "128x64"]
SENSOR = """<sensor type="perspective"><transform name="to_world"><lookat origin="0,0,6" target="0,0,0" up="0,1,0"/></transform>
  <film type="hdrfilm"/></sensor>"""


def placed(kind, inside="", **move):
    scale = f'<scale value="{move.pop("scale")}"/>' if "scale" in move else ""
    shift = " ".join(f'{axis}="{value}"' for axis, value in move.items())
    return f'<shape type="{kind}">{inside}<transform name="to_world">{scale}<translate {shift}/></transform></shape>'


def mask(first, second, repeats):
    return f"""<bsdf type="mask"><texture type="checkerboard" name="opacity"><float name="color0" value="{first}"/><float name="color1" value="{second}"/>
      <transform name="to_uv"><scale x="{repeats}" y="{repeats}"/></transform></texture><bsdf type="diffuse"/></bsdf>"""


class PlainXml(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_plain_xml_"))
        self.addCleanup(shutil.rmtree, self.root, ignore_errors=True)

    def render(self, *parts, integrator='<integrator type="path"/>', sensor=SENSOR, out="out", options=()):
        (self.root / "scene.xml").write_text(f'<scene version="3.0.0">{integrator}{sensor}{"".join(parts)}</scene>')
        PROGRAMS.run("render", self.root / "scene.xml", "--host", "mitsuba", *(options if "--size" in options else [*SIZE, "--spp", 4, *options]), "--out", self.root / out)
        return read_frame(self.root / out / "centre/frame.0000.exr")

    def test_integrators_with_channels_of_their_own_leave_colour_as_it_is(self):
        """Four passes each, as a scalar variant makes them: of the first alone all channels are taken."""
        parts = ['<emitter type="constant"/>', placed("sphere", '<bsdf type="diffuse"/>')]
        path = '<integrator type="path"/>'
        passes = '<integrator type="path"><integer name="samples_per_pass" value="3"/></integrator>'
        options = ["--variant", "scalar_rgb", "--size", "1024x512", "--spp", 8, "--small", "right"]
        plain = self.render(*parts, options=options, out="plain")
        for kind, settings, of in (("aov", '<string name="aovs" value="dd:depth,albedo:albedo"/>', path), ("moment", "", passes),
                                   ("equirect_aov", '<string name="aovs" value="all"/>', path)):
            nested = self.render(*parts, integrator=f'<integrator type="{kind}">{settings}{of}</integrator>', options=options, out=kind)
            for channel in ("R", "G", "B", "A", "depth.Z"):
                np.testing.assert_array_equal(nested[channel], plain[channel], err_msg=f"{kind} {channel}")
            small, plain_small = (read_frame(self.root / name / "small/frame.0000.exr")["G"] for name in (kind, "plain"))
            np.testing.assert_array_equal(small, plain_small, err_msg=f"{kind}, small")

    def test_bounces_are_of_the_integrator_that_renders_colour(self):
        parts = [placed("sphere", x=0), placed("rectangle", scale=9, z=-4), '<emitter type="constant"/>']
        path = '<integrator type="path"/>'
        found = {name: self.render(*parts, integrator=integrator, options=["--max-bounces", bounces], out=name)["G"]
                 for name, integrator, bounces in (("wrapped", f'<integrator type="moment">{path}</integrator>', 1), ("path", path, 1), ("none", path, 0))}
        np.testing.assert_array_equal(found["wrapped"], found["path"])
        self.assertLess(found["none"].mean(), 0.95 * found["path"].mean())
        with self.assertRaisesRegex(RuntimeError, '(?s)exit 2.*--max-bounces: expected an integrator of paths.*found "direct"'):
            self.render(placed("sphere", x=0), integrator='<integrator type="direct"/>', out="direct", options=["--max-bounces", 1])

    def test_what_is_nearer_than_near_clip_is_in_no_layer(self):
        """The ball hides a part of the wall, unless it is cut away."""
        parts = [placed("sphere", z=4), placed("rectangle", scale=40, z=-9), '<emitter type="constant"/>']
        near = SENSOR.replace('type="perspective">', 'type="perspective"><float name="near_clip" value="3.2"/>')
        for sensor, nearest, hides in ((SENSOR, 1, True), (near, 15, False)):
            frame = self.render(*parts, sensor=sensor, out=str(nearest), options=["--layers", "--ipd", 1])
            self.assertAlmostEqual(frame["depth.Z"][32, 64], nearest, delta=0.02)
            hidden = read_frame(self.root / str(nearest) / "hidden/frame.0000.exr")["depth.Z"]
            self.assertEqual(np.isfinite(hidden).any(), hides)  # at the wall's own border it is the sky

    def test_clipping_distances_of_a_flat_view_are_along_its_axis(self):
        """The wall is 15 before it, and farther off in the corners."""
        parts = [placed("sphere", z=4), placed("rectangle", scale=40, z=-9), '<emitter type="constant"/>']
        clips = '<float name="near_clip" value="3.2"/><float name="far_clip" value="15.1"/>'
        for name, sensor, hides in (("all", SENSOR, True), ("cut", SENSOR.replace('"perspective">', f'"perspective">{clips}'), False)):
            frame = self.render(*parts, sensor=sensor, out=name, options=["--camera", "perspective", "--size", "128x96", "--spp", 4, "--layers", "--ipd", 1])
            hidden = read_frame(self.root / name / "hidden/frame.0000.exr")["depth.Z"]
            self.assertEqual(np.isfinite(hidden).any(), hides)
            self.assertTrue(np.isfinite(frame["depth.Z"][0, 0]))
            self.assertGreater(frame["depth.Z"][0, 0], 15.1)

    def test_streams_of_one_shape_are_streams_of_their_own(self):
        """A window and the other eye's view, both of 480x240 pixels: two sensors that are alike."""
        self.render(placed("sphere", x=0), '<emitter type="constant"/>', options=["--size", "1920x960", "--spp", 1, "--small", "right", "--window", "gaze,22x11"])
        small, window = (read_frame(self.root / "out" / name / "frame.0000.exr")["A"] for name in ("small", "window"))
        self.assertEqual(small.shape, window.shape)
        self.assertLess(small.mean(), 0.05)
        self.assertGreater(window.mean(), 0.5)

    def test_alpha_is_the_share_that_met_a_surface(self):
        """Without a sky too, and where paths end at the first surface."""
        lamp = placed("sphere", '<emitter type="area"><rgb name="radiance" value="3"/></emitter>', y=4, scale=0.5)
        for variant in ("scalar_rgb", "llvm_ad_rgb"):
            frame = self.render(placed("sphere", '<bsdf type="diffuse"/>'), lamp, options=["--variant", variant, "--max-bounces", 0], out=variant)
            hit = np.isfinite(frame["depth.Z"])
            self.assertGreater(frame["A"][hit].min(), 0)
            self.assertGreater((frame["A"][hit] == 1).mean(), 0.7)
            self.assertLess((frame["A"][~hit] > 0).mean(), 0.05)

    def cast(self):
        PROGRAMS.run("render", self.root / "out/scene.json", *SIZE, "--spp", 1, "--aovs", "depth,ids", "--out", self.root / "glb")
        return read_frame(self.root / "glb/centre/frame.0000.exr")

    def assert_same_geometry(self, frame, objects):
        cast = self.cast()
        self.assertEqual(len(np.unique(frame["object_id"])), objects)
        same = frame["object_id"] == cast["object_id"]
        self.assertGreater(same.mean(), 0.99)
        a, b = (f["depth.Z"][same] for f in (frame, cast))
        hit = np.isfinite(a)
        self.assertTrue((hit == np.isfinite(b)).all())
        self.assertGreater((np.abs(a[hit] - b[hit]) <= 1e-4 * a[hit]).mean(), 0.999)

    def test_light_that_is_no_number_is_not_accumulated(self):
        """A lamp whose radiance is NaN. Mitsuba's film makes black of it, but on its edge, where the sky shows too, NaN: without samples, and not black."""
        lamp = '<emitter type="area"><rgb name="radiance" value="nan"/></emitter>'
        frame = self.render('<emitter type="constant"/>', placed("sphere", lamp, scale=3), integrator='<integrator type="direct"/>', options=["--accumulate", 8, "--aovs", "depth,samples"])
        ball = frame["depth.Z"] < 1e3
        around = [np.roll(ball, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)]
        edge = np.any(around, axis=0) & ~np.all(around, axis=0)
        self.assertGreater((frame["samples"] == 0).sum(), 20)
        self.assertTrue((frame["samples"][~edge] > 0).all())

    def test_instances_and_masks_without_ids_are_told_apart(self):
        groups = "".join(f'<shape type="shapegroup" id="{name}"><shape type="{kind}"><bsdf type="diffuse"/></shape></shape>'
                         for name, kind in (("boxes", "cube"), ("balls", "sphere")))
        frame = self.render(groups, '<emitter type="constant"/>', placed("instance", '<ref id="boxes"/>', x=-3, y=0),
                            placed("instance", '<ref id="balls"/>', x=3, y=0), placed("instance", '<ref id="boxes"/>', x=0, y=3.5),
                            placed("rectangle", mask(0, 1, 1), x=-1, y=-2), placed("rectangle", mask(1, 0, 3), x=2, y=-2, z=1),
                            placed("rectangle", scale=9, x=0, y=0, z=-4))
        self.assert_same_geometry(frame, 7)

    def test_lamps_that_are_looked_through_are_no_surfaces(self):
        lamp = placed("rectangle", '<emitter type="area"><rgb name="radiance" value="3"/></emitter>', x=0, y=0)
        hidden = '<integrator type="path"><boolean name="hide_emitters" value="true"/></integrator>'
        nested = f'<integrator type="moment">{hidden}</integrator>'
        for i, integrator in enumerate((hidden, nested)):
            frame = self.render(lamp, placed("rectangle", scale=9, x=0, y=0, z=-4), integrator=integrator, options=["--overwrite"])
            self.assertAlmostEqual(frame["depth.Z"][32, 64], 10, delta=0.02)
            self.assertEqual(frame["object_id"][32, 64], 2)
            if i == 0:
                self.assertAlmostEqual(self.cast()["depth.Z"][32, 64], 10, delta=0.02)
        self.assertAlmostEqual(self.render(lamp, out="seen")["depth.Z"][32, 64], 6, delta=0.02)

    def test_sky_in_the_holes_of_a_mask_is_sky(self):
        """Alpha says whether a ray met a surface: 0 in the holes, also before a sky, and 1 beside them."""
        frame = self.render('<emitter type="constant"/>', placed("rectangle", mask(0, 1, 1), scale=3, x=0, y=0))
        holes = np.isinf(frame["depth.Z"])
        front = (slice(20, 44), slice(52, 76))
        deep = [np.roll(holes, shift, (0, 1)) for shift in ((0, 1), (0, -1), (1, 0), (-1, 0), (0, 0))]
        inside, outside = (np.all(deep, 0)[front], ~np.any(deep, 0)[front])
        self.assertGreater(inside.sum(), 20)
        self.assertGreater(outside.sum(), 20)
        self.assertEqual(frame["A"][front][inside].max(), 0)
        self.assertEqual(frame["A"][front][outside].min(), 1)

    def test_a_ball_is_as_fine_as_the_paths_nearest_point_wants(self):
        """Wherever that lies between two keys."""
        keys = {"long": ((0, -160), (1, 160)), "cut": ((0, -160), (0.46875, -10), (1, 160))}
        for name, times in keys.items():
            (self.root / f"{name}.csv").write_text("".join(f"{t},{x},0,0,1,0,0,0\n" for t, x in times))
            self.render(placed("sphere", x=-10, y=0, z=-8), out=name, options=["--path", self.root / f"{name}.csv", "--frames", "0"])
        self.assertEqual(*((self.root / name / "scene.glb").read_bytes() for name in keys))

    BALL_IN_THE_LIGHT = ['<shape type="sphere"/>', '<emitter type="constant"/>']

    def assert_a_ball_ahead(self, frame, away, unit_m=1):
        """Of radius 1 around the origin, seen from there on the z axis, by closed form."""
        direction = equirect_direction(*pixel_centres(128, 64), 128, 64)
        along = -away * direction[..., 2]
        inside = 1 - away ** 2 + along ** 2
        hit = (inside > 0) & (along > 0)
        self.assertGreater(hit.sum(), 20)
        np.testing.assert_array_equal(np.isfinite(frame["depth.Z"]), hit)
        np.testing.assert_allclose(frame["depth.Z"][hit], unit_m * (along[hit] - np.sqrt(inside[hit])), rtol=1e-4)

    def told(self, out="out"):
        return json.loads(PROGRAMS.run("info", self.root / out / "centre/frame.0000.exr", "--json"))["frame"]

    def test_a_unit_of_the_xml_is_as_many_metres_as_told(self):
        frame = self.render(*self.BALL_IN_THE_LIGHT, options=["--unit-m", 0.01])
        self.assert_a_ball_ahead(frame, 6, 0.01)
        np.testing.assert_allclose(self.told()["head"]["position_m"], [0, 0, 0.06], atol=1e-9)
        self.assert_same_geometry(frame, 2)

    def test_the_head_begins_at_the_sensor_of_that_number(self):
        """Of two that are the same but for their place."""
        sensors = SENSOR + SENSOR.replace("0,0,6", "0,0,4")
        for number, away in ((0, 6), (1, 4)):
            self.assert_a_ball_ahead(self.render(*self.BALL_IN_THE_LIGHT, sensor=sensors, options=["--sensor", number], out=str(number)), away)
            np.testing.assert_allclose(self.told(str(number))["head"]["position_m"], [0, 0, away], atol=1e-6)

    def test_the_axis_that_was_told_becomes_up_whatever_the_sensors_is(self):
        """From z = 6 the ball lies below where z is up, and above where -z is."""
        for axis, towards, away, sign in (("z", -1, 0, 1), ("-z", 0, -1, -1)):
            depth = self.render(*self.BALL_IN_THE_LIGHT, options=["--up", axis], out=axis)["depth.Z"]
            np.testing.assert_allclose(depth[towards], 5, atol=0.02)
            self.assertTrue(np.isinf(depth[away]).all())
            np.testing.assert_allclose(self.told(axis)["head"]["position_m"], [0, sign * 6, 0], atol=1e-6)

    def test_where_the_head_may_lean_is_in_the_frames_and_in_the_exported_scene(self):
        for out, options in (("still", []), ("out", ["--lean", 2])):
            self.render(*self.BALL_IN_THE_LIGHT, out=out, options=options)
        self.assertEqual((self.told("still")["lean_m"], self.told()["lean_m"]), (0, 2))
        self.assertEqual(json.loads((self.root / "out/scene.json").read_text())["head_box"]["lean_m"], 2)
        still, leaning = ((self.root / out / "scene.glb").stat().st_size for out in ("still", "out"))
        self.assertGreater(leaning, 1.2 * still)  # which is as fine as the nearest place of the head wants

    def test_the_scene_alone_is_that_of_a_run_with_frames(self):
        self.render(*self.BALL_IN_THE_LIGHT)
        PROGRAMS.run("render", self.root / "scene.xml", "--host", "mitsuba", *SIZE, "--spp", 4, "--scene-only", "--out", self.root / "alone")
        files = {file.name: file.read_bytes() for file in (self.root / "alone").iterdir()}
        self.assertEqual(files, {name: (self.root / "out" / name).read_bytes() for name in ("scene.glb", "scene.json")})

    def test_a_refused_run_leaves_the_geometry_of_the_frames_that_are_there(self):
        self.render(placed("cube", x=0, y=0))
        files = [self.root / "out/scene.glb", self.root / "out/scene.json"]
        before = [file.read_bytes() for file in files]
        with self.assertRaisesRegex(RuntimeError, "(?s)exit 2.*as in the frames there"):
            self.render(placed("sphere", x=0, y=0))
        self.assertEqual([file.read_bytes() for file in files], before)
        self.assertEqual(sorted(file.name for file in (self.root / "out").iterdir()), ["centre", "scene.glb", "scene.json"])

    def test_a_spectrum_that_changed_makes_another_scene(self):
        wall = placed("rectangle", '<bsdf type="diffuse"><spectrum name="reflectance" filename="grey.spd"/></bsdf>', x=0, y=0)
        spectrum = self.root / "grey.spd"
        spectrum.write_text("400 0.2\n700 0.2\n")
        self.render(wall)
        self.render(wall)
        spectrum.write_text("400 0.8\n700 0.8\n")
        with self.assertRaisesRegex(RuntimeError, "(?s)exit 2.*fingerprint"):
            self.render(wall)


if __name__ == "__main__":
    unittest.main()
