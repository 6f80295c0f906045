"""XML with a fault, and options that do not fit: one line, exit status 2, never a crash.

usage: bad_input_test.py BIN_DIR
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1))
SENSOR = """<sensor type="perspective"><float name="fov" value="60"/>
  <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film></sensor>"""
BALL = '<shape type="sphere" id="ball"><bsdf type="diffuse"/></shape>'
PATH = '<integrator type="path"/>'


def scene(*parts):
    return '<scene version="3.0.0">' + "\n".join(parts) + "</scene>"


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_bad_xml_"))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def render(self, text, *options):
        file = self.root / "scene.xml"
        file.write_text(text)
        return subprocess.run([BIN / "equistream", "render", file, "--host", "mitsuba", *([] if "--size" in options else ["--size", "32x16"]), "--spp", "1",
                               "--out", self.root / "out", "--overwrite", *options], capture_output=True, text=True, timeout=300)

    def assert_refused(self, result, *mentions):
        lines = [line for line in result.stderr.splitlines() if line.strip() and "render: note:" not in line]
        self.assertEqual(result.returncode, 2, result.stderr + result.stdout)
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("equistream render: "), lines[0])
        for mention in mentions:
            self.assertIn(mention, lines[0])

    def test_a_good_one_renders(self):
        result = self.render(scene(PATH, SENSOR, BALL))
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_xml_that_is_cut(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL)[:-20]), "scene.xml")

    def test_no_such_file(self):
        result = subprocess.run([BIN / "equistream", "render", self.root / "none.xml", "--host", "mitsuba", "--out", self.root / "x"],
                                capture_output=True, text=True)
        self.assert_refused(result, "none.xml", "no such file")

    def test_a_missing_property(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, '<shape type="ply" id="mesh"/>')), "filename")

    def test_a_wrong_type(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, '<shape type="sphere"><string name="radius" value="big"/></shape>')), "radius")

    def test_a_property_that_nobody_knows(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, '<shape type="sphere"><float name="radios" value="1"/></shape>')), "radios")

    def test_an_unknown_plugin(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, '<shape type="spere"/>')), "spere")

    def test_a_scene_of_mitsuba_06_is_told_all_that_must_change(self):
        result = self.render('<scene version="0.6.0"><integrator type="bdpt"/>' + BALL.replace("diffuse", "phong") + "\n"
                             '<texture type="bitmap" id="t"><string name="filterType" value="trilinear"/></texture></scene>')
        self.assert_refused(result, "scene.xml", "Mitsuba 3 needs 3 changes")
        for line, change in ((1, "the integrator path in place of bdpt"), (1, "the bsdf roughplastic in place of phong"),
                             (2, "the filterType bilinear in place of trilinear")):
            self.assertIn(f"render: note: {self.root}/scene.xml:{line}: write {change}\n", result.stderr)

    def test_an_unknown_parameter(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "-D", "nothing=1"), "nothing")
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "-D", "nothing"), "name=value")

    def test_a_reference_to_nothing(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, '<shape type="sphere"><ref id="gold"/></shape>')), "gold")

    def test_an_unknown_aov(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "--aovs", "depth,curvature"), "curvature", "depth")

    def test_integrators_that_do_not_follow_paths_from_the_camera(self):
        for integrator, *mentions in (("ptracer", 'expected a sampling integrator such as "path", found ParticleTracerIntegrator'),
                                      ("prb", "scene.xml", '"prb"', "not found")):  # a Python class, which a program without Python does not have
            self.assert_refused(self.render(scene(f'<integrator type="{integrator}"/>', SENSOR, BALL)), *mentions)

    def test_no_surface_at_all(self):
        result = self.render(scene(PATH, SENSOR, '<emitter type="constant"/>'))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("0 shapes", result.stdout)

    def test_films_of_an_odd_shape(self):
        """The XML's film gives way to ours: whatever it is, the frame has the size that was asked for."""
        for film in ("specfilm", "hdrfilm"):
            odd = SENSOR.replace("hdrfilm", film).replace('value="16"', 'value="1"', 1)
            result = self.render(scene(PATH, odd, BALL))
            self.assertEqual(result.returncode, 0, result.stderr)
        for size in ("1x1", "7x5", "1x64"):
            result = self.render(scene(PATH, SENSOR, BALL), "--size", size)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "--size", "0x16"), "0x16")

    def test_a_sensor_that_is_not_there(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "--sensor", "3"), "--sensor", "1 sensor")

    def test_variants(self):
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "--variant", "llvm_ad_mono"), "colour")
        self.assert_refused(self.render(scene(PATH, SENSOR, BALL), "--variant", "scalar_rbg"), "scalar_rgb")

    def test_xml_options_with_a_scene_of_ours(self):
        subprocess.run([BIN / "equistream", "scene", "generate", "sphere", "--out", self.root / "ours"], check=True, capture_output=True)
        result = subprocess.run([BIN / "equistream", "render", self.root / "ours/sphere.json", "--host", "mitsuba", "--up", "z",
                                 "--out", self.root / "y"], capture_output=True, text=True)
        self.assert_refused(result, "--up")

    def test_no_sensor_and_no_integrator(self):
        result = self.render(scene(BALL))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no sensor", result.stderr)


if __name__ == "__main__":
    unittest.main()
