"""Other renderers' EXR files, made of our own frames by independent code, come back as our frames.

usage: import_test.py BIN_DIR   (the folder of the built programs)
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402
from independent import Programs, pixel_centres, perspective_direction, read_frame, rotation, unit  # noqa: E402

PROGRAMS = Programs(sys.argv.pop(1))
BIN = PROGRAMS.folder
FRAMES = range(3)
WIDTH, HEIGHT = 128, 64
Y_UP_FROM_Z_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def run(*words):
    return subprocess.run([BIN / "equistream", *(str(w) for w in words)], capture_output=True, text=True, timeout=120)


def write(file, channels, header=None, part=None):
    """Float and unsigned planes by name, one part."""
    file.parent.mkdir(parents=True, exist_ok=True)
    planes = {name: np.ascontiguousarray(p if p.dtype in (np.uint32, np.float16) else p.astype(np.float32))
              for name, p in channels.items()}
    settings = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **(header or {})}
    if part is None:
        OpenEXR.File(settings, planes).write(str(file))
    else:
        OpenEXR.File([OpenEXR.Part(settings, planes, part)]).write(str(file))


def info_of(file):
    header = OpenEXR.File(str(file), header_only=True).header()
    position = np.array([float(x) for x in np.ravel(header["equistream:position"])])
    return position, np.array([float(x) for x in header["equistream:orientation"].split()])


def multiplied(p, q):
    w, x, y, z = p
    a, b, c, d = q
    return np.array([w * a - x * b - y * c - z * d, w * b + x * a + y * d - z * c,
                     w * c - x * d + y * a + z * b, w * d + x * c - y * b + z * a])


def xyz_from_rgb(primaries, white):
    """Of linear RGB with these chromaticities, whose white has Y = 1."""
    whole = [np.array([x, y, 1 - x - y]) / y for x, y in (*primaries, white)]
    columns = np.stack(whole[:3], -1)
    return columns * np.linalg.solve(columns, whole[3])


def unwrapped(motion, width):
    """What a renderer gives that subtracts columns without the shortest way round."""
    u = pixel_centres(motion.shape[1], motion.shape[0])[0]
    return np.mod(u + motion, width) - u


class Import(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_import_"))
        scene = PROGRAMS.scene("motion", cls.root / "scene")
        common = ["--frames", "0-2", "--spp", "2", "--aovs", "all", "--lock", "path"]
        PROGRAMS.run("render", scene, *common, "--size", f"{WIDTH}x{HEIGHT}", "--out", cls.root / "sphere")
        PROGRAMS.run("render", scene, *common, "--size", "96x64", "--camera", "perspective", "--fov", "80", "--out", cls.root / "view")
        cls.sphere = [cls.root / "sphere" / "centre" / f"frame.{i:04}.exr" for i in FRAMES]
        cls.view = [cls.root / "view" / "centre" / f"frame.{i:04}.exr" for i in FRAMES]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def setUp(self):
        self.work = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    def path_csv(self, files, z_up):
        lines = ["time_s,x_m,y_m,z_m,qw,qx,qy,qz"]
        half = np.sqrt(0.5)
        for i, file in enumerate(files):
            position, q = info_of(file)
            if z_up:
                position, q = Y_UP_FROM_Z_UP.T @ position, multiplied([half, half, 0, 0], q)
            lines.append(",".join(repr(float(x)) for x in [i / 30, *position, *q]))
        file = self.work / "head.csv"
        file.write_text("\n".join(lines) + "\n")
        return file

    def imported(self, *words, view="centre"):
        out = self.work / "out"
        result = run("import", *words, "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout, [out / view / f"frame.{i:04}.exr" for i in FRAMES]

    def assert_same(self, original, found, planes, motion_tolerance=2e-5):
        a, b = read_frame(original), read_frame(found)
        for name in planes:
            hit = np.isfinite(a["depth.Z"])
            np.testing.assert_array_equal(hit, np.isfinite(b["depth.Z"]))
            if name.split(".")[0].removeprefix("virtual_") in ("backward", "forward"):
                np.testing.assert_allclose(b[name], a[name], atol=motion_tolerance, err_msg=name)
            elif name.startswith("normal"):
                np.testing.assert_allclose(b[name], a[name], atol=3e-7, err_msg=name)
            elif name == "depth.Z":
                np.testing.assert_allclose(b[name][hit], a[name][hit], rtol=3e-7, err_msg=name)
            else:
                np.testing.assert_array_equal(b[name], a[name], err_msg=name)

    def assert_same_pose(self, original, found):
        p, q = info_of(original)
        r, s = info_of(found)
        np.testing.assert_allclose(r, p, atol=1e-6)
        np.testing.assert_allclose(rotation(s), rotation(q), atol=1e-6)

    COLOUR = ["R", "G", "B", "A"]
    MIRRORS = ["specular", *(f"virtual_{name}" for name in ("depth.Z", "backward.u", "backward.v", "forward.u", "forward.v"))]
    GEOMETRY = ["depth.Z", "normal.X", "normal.Y", "normal.Z", "backward.u", "backward.v", "forward.u", "forward.v"]

    def cycles_channels(self, frame, planar=None):
        """As Blender names and fills its passes."""
        normal = np.stack([frame[f"normal.{c}"] for c in "XYZ"], -1) @ Y_UP_FROM_Z_UP
        depth = frame["depth.Z"] if planar is None else planar
        back, forth = frame["backward.u"], frame["forward.u"]
        if planar is None:
            back, forth = unwrapped(back, WIDTH), unwrapped(forth, WIDTH)
        layers = {"Combined.R": frame["R"], "Combined.G": frame["G"], "Combined.B": frame["B"], "Combined.A": frame["A"],
                  "Depth.Z": np.where(np.isfinite(frame["depth.Z"]), depth, 1e10),
                  "Normal.X": normal[..., 0], "Normal.Y": normal[..., 1], "Normal.Z": normal[..., 2],
                  "Vector.X": back, "Vector.Y": -frame["backward.v"], "Vector.Z": -forth, "Vector.W": frame["forward.v"],
                  "IndexOB.X": frame["object_id"].astype(float), "Mist.Z": frame["A"], "CryptoObject00.R": frame["R"]}
        # In camera space, averaged, and through mirrors: not the normal, though its name comes first.
        layers |= {f"Denoising Normal.{c}": frame["A"] for c in "XYZ"}
        return {f"ViewLayer.{name}": plane for name, plane in layers.items()}

    def test_cycles_sphere(self):
        for i, file in enumerate(self.sphere):
            write(self.work / f"shot_{i + 1:04}.exr", self.cycles_channels(read_frame(file)))
        # Frame numbers begin at 1, as Blender's do; the path's times with them.
        lines = self.path_csv(self.sphere, True).read_text().splitlines()
        shifted = [lines[0]] + [repr(float(line.split(",")[0]) + 1 / 30) + "," + line.split(",", 1)[1] for line in lines[1:]]
        (self.work / "head.csv").write_text("\n".join(shifted) + "\n")
        said, _ = self.imported(self.work / "shot_####.exr", "--path", self.work / "head.csv")
        for text in ("cycles", "Cryptomatte", "to-previous,pixels,y-up", "from-next"):
            self.assertIn(text, said)
        for i, original in enumerate(self.sphere):
            found = self.work / "out" / "centre" / f"frame.{i + 1:04}.exr"
            self.assert_same(original, found, self.COLOUR + self.GEOMETRY + ["object_id"])
            self.assert_same_pose(original, found)
        seam = max(np.abs(read_frame(f)["backward.u"] - unwrapped(read_frame(f)["backward.u"], WIDTH)).max() for f in self.sphere)
        self.assertGreater(seam, WIDTH / 2, "no motion crosses the seam: the test tests nothing there")

    def test_the_guides_path_goes_with_its_command(self):
        """A head in Blender's axes, upright, that looks along +Y: our -Z."""
        page = (pathlib.Path(__file__).resolve().parents[3] / "docs/guide/import.md").read_text()
        path = self.work / "head.csv"
        path.write_text(textwrap.dedent(re.search(r"```csv\n(.*?)```", page, re.S)[1]))
        fps = re.search(r"import blender/shot_####.exr --path head.csv --fps (\d+)", page)[1]
        for number in (1001, 1002, 1003):
            write(self.work / "blender" / f"shot_{number}.exr", self.cycles_channels(read_frame(self.sphere[0])))
        made = run("import", self.work / "blender/shot_####.exr", "--path", path, "--fps", fps, "--out", self.work / "out")
        self.assertEqual(made.returncode, 0, made.stderr)
        for number, x in ((1001, 0), (1003, 0.1)):
            position, q = info_of(self.work / "out" / "centre" / f"frame.{number}.exr")
            np.testing.assert_allclose(position, [x, 1.6, 4], atol=1e-3)
            np.testing.assert_allclose(rotation(q), np.eye(3), atol=1e-5)

    def test_frames_of_our_own_say_where_they_were_seen_from(self):
        """What a compositor makes of them is as dark, and stands in the same places, as long as it keeps their attributes."""
        said, found = self.imported(self.root / "sphere" / "centre")
        self.assertIn("equistream:headPosition", said)
        self.assertNotIn("left out", said)
        for original, file in zip(self.sphere, found):
            self.assert_same(original, file, self.COLOUR + self.GEOMETRY + self.MIRRORS + ["object_id"])
            self.assert_same_pose(original, file)
            ours, theirs = (OpenEXR.File(str(each), header_only=True).header() for each in (original, file))
            for name in ("exposure", "lock", "ipd", "headBoxRadius", "scene", "headPosition"):
                self.assertEqual(str(theirs[f"equistream:{name}"]), str(ours[f"equistream:{name}"]), name)
        manifest = json.loads((self.work / "out/centre/manifest.json").read_text())
        told = run("import", self.root / "sphere" / "centre", "--exposure", 3, "--out", self.work / "told")
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertEqual(json.loads((self.work / "told/centre/manifest.json").read_text())["exposure"], 3)
        self.assertNotEqual(manifest["exposure"], 3)

    def test_frames_of_our_own_say_which_camera_they_have(self):
        scene = self.root / "scene" / "motion.json"
        for name, words in (("flat", ["--camera", "perspective", "--fov", 70, "--size", "128x64"]), ("half", ["--range", "180,90", "--size", "128x64"])):
            PROGRAMS.run("render", scene, "--frames", 0, "--spp", 1, "--aovs", "depth", *words, "--out", self.work / name)
            told = run("import", self.work / name / "centre", "--out", self.work / f"{name}-out")
            self.assertEqual(told.returncode, 0, told.stderr)
            one, other = (json.loads((self.work / each / "centre/manifest.json").read_text())["camera"] for each in (name, f"{name}-out"))
            self.assertEqual(other, one)
            self.assert_same_pose(self.work / name / "centre/frame.0000.exr", self.work / f"{name}-out" / "centre/frame.0000.exr")
        PROGRAMS.run("render", scene, "--frames", 0, "--spp", 1, "--aovs", "depth", "--size", "128x64", "--window", "0,0,60x60", "--density", 512, "--out", self.work / "dense")
        refused = run("import", self.work / "dense" / "window", "--out", self.work / "dense-out")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("expected whole pictures (or --window X,Y and --density), found a window", refused.stderr)

    def test_a_path_has_to_have_the_frames(self):
        for number in (1001, 1002):
            write(self.work / f"shot.{number}.exr", self.cycles_channels(read_frame(self.sphere[0])))
        refused = run("import", self.work / "shot.####.exr", "--path", self.path_csv(self.sphere, True), "--fps", 25, "--out", self.work / "out")
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (2, 1), refused.stderr)
        self.assertIn("expected poses from 40.04 to 40.08 s, when frames 1001 to 1002 are at 25 a second (--fps), found 0 to 0.0666667 s", refused.stderr)
        self.assertFalse((self.work / "out").exists())
        for number in (2, 3):
            write(self.work / f"late.{number:04}.exr", self.cycles_channels(read_frame(self.sphere[0])))
        late = run("import", self.work / "late.####.exr", "--path", self.path_csv(self.sphere, True), "--out", self.work / "out")
        self.assertIn("1 of 2 frames lie outside the path's 0 to 0.0666667 s: they get the pose at its end", late.stdout, late.stderr)

    def test_cycles_perspective_planar_depth(self):
        for i, file in enumerate(self.view):
            frame = read_frame(file)
            u, v = pixel_centres(96, 64)
            cosine = -unit(perspective_direction(u, v, 96, 64, np.radians(80)))[..., 2]
            write(self.work / f"shot.{i:04}.exr", self.cycles_channels(frame, planar=frame["depth.Z"] * cosine))
        _, found = self.imported(self.work, "--fov", 80, "--path", self.path_csv(self.view, True), "--preset", "cycles")
        for original, file in zip(self.view, found):
            hit = np.isfinite(read_frame(original)["depth.Z"])
            self.assert_same(original, file, self.COLOUR + ["depth.Z", "normal.X", "object_id"])
            for name in ("backward.u", "forward.v"):
                np.testing.assert_allclose(read_frame(file)[name][hit], read_frame(original)[name][hit], atol=2e-5)
            self.assert_same_pose(original, file)

    def pbrt_frame(self, file):
        """pbrt-v4's gbuffer film behind its spherical camera: u = 0 is +X, u = 1/4 ahead, u = 1/2 -X; +Z ahead, left-handed."""
        frame = read_frame(file)
        position, q = info_of(file)
        turn = rotation(q)
        columns = np.arange(WIDTH)
        # Our column of each of theirs: mirrored, then a quarter round.
        ours = (WIDTH - 1 - columns - WIDTH // 4) % WIDTH
        u, v = pixel_centres(WIDTH, HEIGHT)
        longitude, latitude = 2 * np.pi * (u / WIDTH - 0.5), np.pi * (0.5 - v / HEIGHT)
        direction = np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)], -1)
        flip = np.array([1, 1, -1])
        hit = np.isfinite(frame["depth.Z"])[..., None]
        point = np.where(hit, direction * np.where(hit[..., 0], frame["depth.Z"], 0)[..., None], 0) * flip
        normal = (np.stack([frame[f"normal.{c}"] for c in "XYZ"], -1) @ turn) * flip
        planes = {"R": frame["R"], "G": frame["G"], "B": frame["B"], "dzdx": frame["A"], "dzdy": frame["A"]}
        for k, c in enumerate("XYZ"):
            planes |= {f"P.{c}": point[..., k], f"N.{c}": -normal[..., k], f"Albedo.{'RGB'[k]}": frame[f"albedo.{'RGB'[k]}"]}
        camera_from_world = np.eye(4)
        camera_from_world[:3, :3] = np.diag(flip) @ turn.T
        camera_from_world[:3, 3] = -camera_from_world[:3, :3] @ position
        return {name: plane[:, ours] for name, plane in planes.items()}, camera_from_world.astype(np.float32)

    def test_pbrt_sphere(self):
        for i, file in enumerate(self.sphere):
            planes, matrix = self.pbrt_frame(file)
            write(self.work / f"pbrt.{i:04}.exr", planes, {"worldToCamera": matrix})
        said, found = self.imported(self.work)
        self.assertIn("column vectors", said)
        quarter = WIDTH // 4
        for original, file in zip(self.sphere, found):
            a, b = read_frame(original), read_frame(file)
            hit = np.isfinite(a["depth.Z"])
            # The sphere is not resampled: it stays turned, and its pose says so.
            back = {name: np.roll(plane, -quarter, axis=1) for name, plane in b.items()}
            np.testing.assert_array_equal(np.isfinite(back["depth.Z"]), hit)
            np.testing.assert_allclose(back["depth.Z"][hit], a["depth.Z"][hit], rtol=5e-7)
            np.testing.assert_array_equal(back["G"], a["G"])
            for c in "XYZ":
                np.testing.assert_allclose(back[f"normal.{c}"], a[f"normal.{c}"], atol=2e-6)
            p, q = info_of(original)
            r, s = info_of(file)
            np.testing.assert_allclose(r, p, atol=1e-5)
            # Our longitude -90 degrees is where the imported sphere's middle... ahead lies at 3/4 of the width.
            ahead = rotation(s) @ [1, 0, 0]
            np.testing.assert_allclose(ahead, rotation(q) @ [0, 0, -1], atol=1e-5)
        again = run("import", self.work / "out/centre", "--out", self.work / "again")
        self.assertEqual(again.returncode, 0, again.stderr)
        for file in found:
            self.assert_same_pose(file, self.work / "again/centre" / file.name)

    def test_row_and_column_vectors_give_one_pose(self):
        planes, matrix = self.pbrt_frame(self.sphere[1])
        for name, m in (("column", matrix), ("row", matrix.T)):
            write(self.work / name / "a.0000.exr", planes, {"worldToCamera": np.ascontiguousarray(m)})
            result = run("import", self.work / name, "--out", self.work / f"{name}_out")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(f"{name} vectors", result.stdout)
        result = run("import", self.work / "row", "--depth-scale", 0.01, "--out", self.work / "cm_out")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(", 0.01 m a unit", result.stdout)
        metres, centimetres = (info_of(self.work / f"{name}_out" / "centre" / "frame.0000.exr")[0] for name in ("row", "cm"))
        np.testing.assert_allclose(centimetres, 0.01 * metres, atol=1e-9)
        metres, centimetres = (read_frame(self.work / f"{name}_out" / "centre" / "frame.0000.exr")["depth.Z"] for name in ("row", "cm"))
        np.testing.assert_allclose(centimetres, 0.01 * metres, rtol=1e-6)
        a, b = (info_of(self.work / f"{name}_out" / "centre" / "frame.0000.exr") for name in ("column", "row"))
        np.testing.assert_allclose(a[0], b[0])
        np.testing.assert_allclose(a[1], b[1])

    def test_fov_of_matrices(self):
        """worldToNDC from -1 or from 0, of row or of column vectors, with the camera looking along +Z."""
        position, q = info_of(self.view[1])
        camera = np.eye(4)
        camera[:3, :3] = np.diag([1, 1, -1]) @ rotation(q).T
        camera[:3, 3] = -camera[:3, :3] @ position
        focal = 1 / np.tan(np.radians(80) / 2)
        clip = np.array([[focal, 0, 0, 0], [0, focal * 96 / 64, 0, 0], [0, 0, 1.001, -0.01], [0, 0, 1, 0]])
        from_zero = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 1, 0], [0, 0, 0, 1]]) @ clip
        frame = read_frame(self.view[1])
        for name, ndc, turn in (("rows", clip, True), ("columns", clip, False), ("zero", from_zero, True)):
            matrices = {"worldToCamera": camera, "worldToNDC": ndc @ camera}
            matrices = {k: np.ascontiguousarray((m.T if turn else m).astype(np.float32)) for k, m in matrices.items()}
            write(self.work / name / "a.0001.exr", {c: frame[c] for c in "RGB"}, matrices)
            result = run("import", self.work / name, "--out", self.work / f"{name}_out")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("perspective, 80 degrees", result.stdout)
            self.assert_same_pose(self.view[1], self.work / f"{name}_out" / "centre" / "frame.0001.exr")

    def test_mitsuba_aov_integrator(self):
        near = 0.05
        for i, file in enumerate(self.view):
            frame = read_frame(file)
            u, v = pixel_centres(96, 64)
            cosine = -unit(perspective_direction(u, v, 96, 64, np.radians(80)))[..., 2]
            hit = np.isfinite(frame["depth.Z"])
            planes = {c: frame[c] for c in "RGBA"}
            planes |= {"dd.T": np.where(hit, np.where(hit, frame["depth.Z"], 0) - near / cosine, 0)}
            planes |= {f"nn.{c}": frame[f"normal.{c}"] for c in "XYZ"} | {"idx.I": frame["object_id"].astype(float)}
            write(self.work / f"m.{i:04}.exr", planes, {"generatedBy": "Mitsuba version 3.9.1"})
        said, found = self.imported(self.work, "--fov", 80, "--near", near, "--path", self.path_csv(self.view, False),
                                    "--channels", "object_id=idx.I")
        self.assertIn("mitsuba", said)
        for original, file in zip(self.view, found):
            self.assert_same(original, file, self.COLOUR + ["depth.Z", "normal.Y", "object_id"])

    def test_misses_begin_at_the_distance_that_is_given(self):
        frame = read_frame(self.sphere[0])
        distance = np.full(frame["R"].shape, np.nextafter(np.float32(5), np.float32(0)))
        distance[0] = 5
        write(self.work / "a.0000.exr", {**{c: frame[c] for c in "RGB"}, "Z": distance})
        _, found = self.imported(self.work, "--miss-above", 5)
        depth = read_frame(found[0])["depth.Z"]
        self.assertTrue(np.isinf(depth[0]).all() and np.isfinite(depth[1:]).all())

    def test_a_plain_z_beside_x_and_y_is_no_depth(self):
        """Films of Mitsuba's pixel format xyz."""
        frame = read_frame(self.view[0])
        distance = np.where(np.isfinite(frame["depth.Z"]), frame["depth.Z"], 0)
        planes = {**dict(zip("XYZ", (frame[c] for c in "RGB"))), "depth.T": distance}
        write(self.work / "xyz.exr", planes, {"generatedBy": "Mitsuba version 3.9.1"})
        said, found = self.imported(self.work, "--fov", 80, "--depth", "radial", "--near", 0)
        self.assertIn("depth.T", said)
        self.assert_same(self.view[0], found[0], ["depth.Z"])

    def test_mitsubas_near_plane_is_in_its_scenes_unit(self):
        frame = read_frame(self.view[0])
        u, v = pixel_centres(96, 64)
        cosine = -unit(perspective_direction(u, v, 96, 64, np.radians(80)))[..., 2]
        hit = np.isfinite(frame["depth.Z"])
        depth_mm = np.where(hit, 1000 * np.where(hit, frame["depth.Z"], 0) - 0.01 / cosine, 0)
        write(self.work / "m.0000.exr", {c: frame[c] for c in "RGBA"} | {"dd.T": depth_mm}, {"generatedBy": "Mitsuba version 3.9.1"})
        _, found = self.imported(self.work / "m.0000.exr", "--fov", 80, "--depth-scale", 0.001)
        self.assert_same(self.view[0], found[0], ["depth.Z"])

    def test_our_plugins_planes_are_ours_whoever_wrote_the_file(self):
        """Of a flat view: its depth begins at the sensor, and not at a near plane."""
        frame = read_frame(self.view[0])
        write(self.work / "m.0000.exr", {c: frame[c] for c in ("R", "G", "B", "A", "depth.Z")}, {"generatedBy": "Mitsuba version 3.9.1"})
        said, found = self.imported(self.work / "m.0000.exr", "--fov", 80)
        self.assertIn("conventions: equistream", said)
        self.assert_same(self.view[0], found[0], self.COLOUR + ["depth.Z"])

    def test_a_number_above_the_highest_is_no_frames(self):
        frame = read_frame(self.sphere[0])
        write(self.work / "shot-20261129120000.exr", {c: frame[c] for c in "RGBA"})
        for name, number in (("20261129120000", 0), ("00000000000007", 7)):
            write(self.work / f"shot-{name}.exr", {c: frame[c] for c in "RGBA"})
            done = run("import", self.work / f"shot-{name}.exr", "--out", self.work / name)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual([file.name for file in (self.work / name / "centre").glob("*.exr")], [f"frame.{number:04}.exr"])
        done = run("import", self.work, "--out", self.work / "all")
        self.assertEqual(done.returncode, 2)
        self.assertIn("expected a frame's number from 0 to 999999999, found a higher one", done.stderr)

    def test_mitsubas_depth_on_a_sphere_starts_at_its_centre(self):
        """Its only spherical sensor is ours: nothing is cut off unless near_clip says so."""
        frame = read_frame(self.sphere[0])
        hit = np.isfinite(frame["depth.Z"])
        for near, options in ((0, []), (0.25, ["--near", 0.25])):
            file = self.work / f"{near}" / "m.0000.exr"
            depth = np.where(hit, np.where(hit, frame["depth.Z"], 0) - near, 0)
            write(file, {c: frame[c] for c in "RGBA"} | {"dd.T": depth}, {"generatedBy": "Mitsuba version 3.9.1"})
            _, found = self.imported(file, *options, "--overwrite")
            self.assert_same(self.sphere[0], found[0], self.COLOUR + ["depth.Z"])

    def test_one_file_an_aov_and_told_conventions(self):
        """Normalised and NDC motion the other way round, depth in centimetres, encoded normals, ids as integers."""
        for i, file in enumerate(self.sphere):
            frame = read_frame(file)
            rgb = {c: frame[c] for c in "RGBA"}
            hit = np.isfinite(frame["depth.Z"])
            write(self.work / f"shot_beauty.{i:04}.exr", rgb)
            write(self.work / f"shot_depth.{i:04}.exr", {"Z": np.where(hit, 100 * np.where(hit, frame["depth.Z"], 0), -1)})
            write(self.work / f"shot_normal.{i:04}.exr", {c: np.where(hit, 0.5 + 0.5 * frame[f"normal.{c}"], 0) for c in "XYZ"})
            write(self.work / f"shot_motion.{i:04}.exr", {"R": -unwrapped(frame["backward.u"], WIDTH) / (WIDTH / 2),
                                                          "G": -frame["backward.v"] / (HEIGHT / 2)})
            write(self.work / f"shot_forward.{i:04}.exr", {"X": frame["forward.u"] / WIDTH, "Y": -frame["forward.v"] / HEIGHT})
            write(self.work / f"shot_object_id.{i:04}.exr", {"Y": frame["object_id"]})
        said, found = self.imported(self.work, "--depth-scale", 0.01, "--miss", -1, "--normals-encoded", "--backward",
                                    "from-previous,ndc,y-down", "--forward", "to-next,normalised,y-up")
        for original, file in zip(self.sphere, found):
            self.assert_same(original, file, self.COLOUR + [n for n in self.GEOMETRY if not n.startswith("normal")] + ["object_id"], 3e-5)
            for c in "XYZ":
                np.testing.assert_allclose(read_frame(file)[f"normal.{c}"], read_frame(original)[f"normal.{c}"], atol=1e-6)

    def test_luxcore_files(self):
        """A file an output, each of three channels; depth says the same in all of them; a sphere's rows lie one too low."""
        for i, file in enumerate(self.sphere):
            frame = {name: np.roll(plane, 1, axis=0) for name, plane in read_frame(file).items()}
            normals = np.stack([frame[f"normal.{c}"] for c in "XYZ"], axis=-1) @ Y_UP_FROM_Z_UP
            write(self.work / f"lux_RGB.{i:04}.exr", {c: frame[c] for c in "RGB"})
            write(self.work / f"lux_DEPTH.{i:04}.exr", {c: frame["depth.Z"] for c in "RGB"})
            write(self.work / f"lux_SHADING_NORMAL.{i:04}.exr", {c: np.ascontiguousarray(normals[..., k]) for k, c in enumerate("RGB")})
        _, found = self.imported(self.work, "--preset", "luxcore", "--path", self.path_csv(self.sphere, True))
        for original, file in zip(self.sphere, found):
            a, b = read_frame(original), read_frame(file)
            for name in (*"RGB", "depth.Z", *(f"normal.{c}" for c in "XYZ")):
                np.testing.assert_allclose(b[name][:-1], a[name][:-1], rtol=3e-7, atol=3e-7 if name.startswith("normal") else 0, err_msg=name)
                self.assertEqual(b[name].shape, a[name].shape)
            self.assert_same_pose(original, file)
        said = self.imported(self.work, "--channels", "depth=DEPTH.G", "--overwrite", "--preset", "luxcore", "--path", self.path_csv(self.sphere, True))[0]
        self.assertIn("--channels", said)

    def test_motion_of_unknown_convention_is_not_taken(self):
        frame = read_frame(self.sphere[0])
        write(self.work / "a.0000.exr", {"R": frame["R"], "G": frame["G"], "B": frame["B"], "motion.X": frame["backward.u"], "motion.Y": frame["backward.v"]})
        result = run("import", self.work, "--dry-run")
        self.assertEqual(result.returncode, 0)
        self.assertIn("motion of unknown convention", result.stdout)
        self.assertFalse((self.work / "out").exists())

    def test_views_parts_windows_and_primaries(self):
        """Two views in one file, a data window within the display window, ACEScg primaries, parts for layers."""
        frame = read_frame(self.sphere[0])
        window = (slice(8, 40), slice(16, 100))
        rgb = np.stack([frame[c] for c in "RGB"], -1)
        rec709_from_acescg = np.array([[1.705051, -0.621792, -0.083259], [-0.130257, 1.140805, -0.010548], [-0.024004, -0.128969, 1.152972]])
        acescg = rgb @ np.linalg.inv(rec709_from_acescg).T
        header = {"dataWindow": (np.array([16, 8], np.int32), np.array([99, 39], np.int32)),
                  "displayWindow": (np.array([0, 0], np.int32), np.array([WIDTH - 1, HEIGHT - 1], np.int32)),
                  "chromaticities": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)}
        parts = []
        for view in ("left", "center"):  # as OpenEXR spells the middle one
            for name, planes in (("rgba", {c: acescg[..., k] for k, c in enumerate("RGB")}), ("depth", {"Z": frame["depth.Z"]})):
                planes = {n: np.ascontiguousarray(p[window].astype(np.float32)) for n, p in planes.items()}
                parts.append(OpenEXR.Part({**header, "view": view, "type": OpenEXR.scanlineimage, "compression": OpenEXR.PIZ_COMPRESSION}, planes, f"{name}.{view}"))
        self.work.mkdir(exist_ok=True)
        OpenEXR.File(parts).write(str(self.work / "stereo.0000.exr"))
        result = run("import", self.work / "stereo.0000.exr", "--out", self.work / "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        for view in ("left", "centre"):
            found = read_frame(self.work / "out" / view / "frame.0000.exr")
            outside = np.ones((HEIGHT, WIDTH), bool)
            outside[window] = False
            self.assertTrue(np.isinf(found["depth.Z"][outside]).all())
            np.testing.assert_array_equal(found["depth.Z"][window], frame["depth.Z"][window])
            for k, c in enumerate("RGB"):
                np.testing.assert_allclose(found[c][window], rgb[window][..., k], rtol=2e-3, atol=2e-3)
                self.assertEqual(found[c][outside].max(), 0)

    def test_views_within_the_names_of_channels(self):
        """As Blender writes both eyes into one part: the view before the last word."""
        planes = {}
        for view, file in (("left", self.sphere[0]), ("right", self.sphere[1])):
            for name, plane in self.cycles_channels(read_frame(file)).items():
                first, _, last = name.rpartition(".")
                planes[f"{first}.{view}.{last}"] = np.ascontiguousarray(plane.astype(np.float32))
        header = {"type": OpenEXR.scanlineimage, "multiView": ["left", "right"]}
        OpenEXR.File([OpenEXR.Part(header, planes)]).write(str(self.work / "both.0000.exr"))
        result = run("import", self.work / "both.0000.exr", "--preset", "cycles", "--out", self.work / "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        for view, file in (("left", self.sphere[0]), ("right", self.sphere[1])):
            self.assert_same(file, self.work / "out" / view / "frame.0000.exr", ["R", "G", "B", "depth.Z"])

    def test_tiled_half_and_mip_mapped(self):
        frame = read_frame(self.sphere[0])
        flat = self.work / "flat" / "a.0000.exr"
        write(flat, {c: frame[c].astype(np.float16) for c in "RGBA"} | {"Z": frame["depth.Z"]})
        for option in (["-o"], ["-m"]):
            tiled = self.work / "tiled" / "a.0000.exr"
            tiled.parent.mkdir(exist_ok=True)
            subprocess.run(["exrmaketiled", *option, "-t", "32", "16", flat, tiled], check=True, capture_output=True)
            result = run("import", tiled.parent, "--out", self.work / "out", "--overwrite")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assert_same(self.sphere[0], self.work / "out" / "centre" / "frame.0000.exr", self.COLOUR + ["depth.Z"])

    def test_missing_frames_and_resume(self):
        for i in (0, 2):
            write(self.work / f"a.{i:04}.exr", {c: read_frame(self.sphere[i])[c] for c in "RGB"})
        said, found = self.imported(self.work)
        self.assertIn("missing and left out: frame 1", said)
        self.assertEqual(said.splitlines()[-1], f"{self.work}/out/centre: imported 2, kept 0 frames")
        tried = run("import", self.work, "--frames", "2-9", "--dry-run").stdout
        self.assertNotIn("missing", tried)
        self.assertEqual(tried.splitlines()[-1], "nothing is imported (--dry-run)")
        first = found[0].stat().st_mtime_ns
        write(self.work / "a.0001.exr", {c: read_frame(self.sphere[1])[c] for c in "RGB"})
        said, _ = self.imported(self.work)
        self.assertEqual(said.splitlines()[-1], f"{self.work}/out/centre: imported 1, kept 2 frames")
        self.assertEqual(json.loads(run("import", self.work, "--json", "--out", self.work / "out").stdout)["written"],
                         [{"folder": f"{self.work}/out/centre", "imported": 0, "kept": 3}])
        told = run("info", self.work / "out").stdout
        self.assertRegex(told, r"\n  rendered   imported.*; samples and seed not known\n")
        self.assertIn("\n  rate       30 frames/s\n", told)
        self.assertEqual(found[0].stat().st_mtime_ns, first, "a finished frame was imported again")
        self.assertTrue(found[1].exists())
        other = run("import", self.work, "--exposure", 2, "--out", self.work / "out")
        self.assertEqual(other.returncode, 2)
        self.assertIn("exposure", other.stderr)

    def test_a_second_run_with_other_conventions_is_refused(self):
        """Whatever decides a pixel: frames of two conventions in one folder would be told apart by nothing."""
        frame = read_frame(self.sphere[0])
        hit = np.isfinite(frame["depth.Z"])
        planes = {c: frame[c] for c in "RGB"} | {"Z": np.where(hit, frame["depth.Z"], 1e10)}
        planes |= {f"normal.{c}": frame[f"normal.{c}"] for c in "XYZ"} | {"motion.X": frame["backward.u"], "motion.Y": frame["backward.v"]}
        for i in (0, 1):
            write(self.work / f"a.{i:04}.exr", planes)
        words = [self.work / "a.####.exr", "--out", self.work / "out", "--miss", 0, "--backward", "to-previous"]
        self.assertEqual(run("import", *words, "--frames", 0).returncode, 0)
        for other in (["--backward", "from-previous"], ["--backward", "ndc"], ["--backward", "y-up"], ["--normals", "camera"], ["--normals-encoded"],
                      ["--miss-above", 5], ["--depth-scale", 1.0000001], ["--near", 1e-7], ["--mirrored"], ["--up", "z"], ["--forward-at", 0.25],
                      ["--colour-space", "acescg"]):
            changed = [word for word in words if other[0] != "--backward" or word not in ("--backward", "to-previous")]
            result = run("import", *changed, *other)
            self.assertEqual(result.returncode, 2, f"{other}: {result.stdout}")
            self.assertIn("fingerprint", result.stderr)
        self.assertFalse((self.work / "out" / "centre" / "frame.0001.exr").exists())
        self.assertEqual(run("import", *words).returncode, 0)

    def test_colours_of_a_space_that_was_told_come_as_rec709(self):
        """By the primaries that ITU-R BT.709 and BT.2020, the Academy's S-2014-004 and SMPTE ST 2065-1 publish, and Bradford's cone responses."""
        d65, aces = (0.3127, 0.3290), (0.32168, 0.33767)
        spaces = {"rec709": xyz_from_rgb([(0.640, 0.330), (0.300, 0.600), (0.150, 0.060)], d65),
                  "rec2020": xyz_from_rgb([(0.708, 0.292), (0.170, 0.797), (0.131, 0.046)], d65),
                  "acescg": xyz_from_rgb([(0.713, 0.293), (0.165, 0.830), (0.128, 0.044)], aces),
                  "aces2065-1": xyz_from_rgb([(0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.0770)], aces)}
        cones = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
        colour = np.array([0.6, 0.3, 0.1])
        write(self.work / "a.0000.exr", {c: np.full((HEIGHT, WIDTH), x) for c, x in zip("RGB", colour)})
        for name, space in spaces.items():
            result = run("import", self.work / "a.0000.exr", "--colour-space", name, "--out", self.work / name)
            self.assertEqual(result.returncode, 0, result.stderr)
            white, shown = (cones @ each @ np.ones(3) for each in (space, spaces["rec709"]))
            expected = np.linalg.solve(cones @ spaces["rec709"], shown / white * (cones @ space @ colour))
            frame = read_frame(self.work / name / "centre/frame.0000.exr")
            for c, x in zip("RGB", expected):
                np.testing.assert_allclose(frame[c], x, atol=1e-3, err_msg=f"{name}: {c}")

    def test_normals_of_the_camera_are_turned_with_it(self):
        q = multiplied([np.cos(0.5), 0, np.sin(0.5), 0], [np.cos(0.2), np.sin(0.2), 0, 0])
        (self.work / "head.csv").write_text(f"0,0,1,0,{','.join(repr(float(x)) for x in q)}\n")
        normal = np.array([0.48, 0.36, 0.8])
        for space, ahead in (("camera", -1), ("camera-z-forward", 1)):
            planes = {c: np.ones((64, 96)) for c in "RGB"} | {f"N.{c}": np.full((64, 96), x) for c, x in zip("XYZ", normal * (1, 1, -ahead))}
            write(self.work / f"{space}.0000.exr", planes)
            result = run("import", self.work / f"{space}.0000.exr", "--fov", 40, "--channels", "normal=N.X+N.Y+N.Z", "--normals", space,
                         "--path", self.work / "head.csv", "--out", self.work / space)
            self.assertEqual(result.returncode, 0, result.stderr)
            frame = read_frame(self.work / space / "centre/frame.0000.exr")
            for c, x in zip("XYZ", rotation(q) @ normal):
                np.testing.assert_allclose(frame[f"normal.{c}"], x, atol=1e-6, err_msg=f"{space}: {c}")

    def test_how_far_the_head_may_lean_is_in_the_frames(self):
        write(self.work / "a.0000.exr", {c: np.ones((HEIGHT, WIDTH)) for c in "RGB"})
        _, found = self.imported(self.work / "a.0000.exr", "--lean", 0.25)
        frame = json.loads(PROGRAMS.run("info", found[0], "--json"))["frame"]
        self.assertEqual(frame["lean_m"], 0.25)
        self.assertAlmostEqual(frame["head_box_radius_m"], 0.25 + frame["ipd_m"] / 2, 9)

    def test_normals_of_an_unknown_camera_stay_as_they_face(self):
        """Seen from behind in a world that is turned half round: no guessed pose may turn them."""
        frame = read_frame(self.sphere[0])
        turned = {f"normal.{c}": sign * frame[f"normal.{c}"] for c, sign in zip("XYZ", (-1, 1, -1))}
        write(self.work / "a.0000.exr", {c: frame[c] for c in "RGB"} | {"Z": np.where(np.isfinite(frame["depth.Z"]), frame["depth.Z"], 1e10)} | turned)
        result = run("import", self.work / "a.0000.exr", "--out", self.work / "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        found = read_frame(self.work / "out" / "centre" / "frame.0000.exr")
        for name, plane in turned.items():
            np.testing.assert_allclose(found[name], plane, atol=3e-7, err_msg=name)

    def test_frames_imported_by_parts_are_those_of_one_import(self):
        """What is missed moves with the camera: the neighbours are the source's, not those of --frames."""
        for i, file in enumerate(self.sphere):
            frame = read_frame(file)
            planes = {c: frame[c] for c in "RGB"} | {"Z": np.full((HEIGHT, WIDTH), 1e10)}
            planes |= {f"{name}.{c}": np.zeros((HEIGHT, WIDTH)) for name in ("backward", "forward") for c in "XY"}
            write(self.work / f"a.{i:04}.exr", planes)
        head = self.work / "head.csv"
        head.write_text("".join(f"{i / 30!r},0,1,0,{float(np.cos(0.02 * i))!r},0,{float(np.sin(0.02 * i))!r},0\n" for i in FRAMES))
        words = [self.work / "a.####.exr", "--path", head, "--backward", "to-previous", "--forward", "to-next"]
        _, whole = self.imported(*words)
        for i in FRAMES:
            self.assertEqual(run("import", *words, "--frames", i, "--out", self.work / "parts").returncode, 0)
            self.assert_same(whole[i], self.work / "parts" / "centre" / f"frame.{i:04}.exr", ["backward.u", "forward.u"], 0)
        # The camera turns to the left by 0.04 a frame; ends have no neighbour.
        pixels = 0.04 * WIDTH / (2 * np.pi)
        for i, (back, forth) in enumerate([(0, pixels), (-pixels, pixels), (-pixels, 0)]):
            found = read_frame(whole[i])
            np.testing.assert_allclose(found["backward.u"], back, atol=1e-4)
            np.testing.assert_allclose(found["forward.u"], forth, atol=1e-4)

    def test_result_encodes_and_plays(self):
        for i, file in enumerate(self.sphere):
            write(self.work / f"shot_{i:04}.exr", self.cycles_channels(read_frame(file)))
        self.imported(self.work / "shot_####.exr", "--path", self.path_csv(self.sphere, True))
        PROGRAMS.run("encode", self.work / "out", "--out", self.work / "walk.mp4")
        PROGRAMS.run("play", self.work / "walk.mp4", "--size", "64x64", "--out", self.work / "eyes")
        self.assertEqual(len(list((self.work / "eyes" / "left").glob("*.png"))), 3)
        self.assertEqual(run("info", self.work / "out").returncode, 0)

    def test_what_one_of_several_files_says(self):
        """Beauty by a plain name and its layer beside it, in capitals: primaries are of the file that has colour, and 0.1 is a miss as a float and as a half."""
        frame = read_frame(self.sphere[0])
        header = {"chromaticities": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)}
        write(self.work / "shot.0000.EXR", {c: frame[c] for c in "RGB"}, header)
        for kind in (np.float32, np.float16):
            depth = np.full((HEIGHT, WIDTH), 2, kind)
            depth[:, :40] = 0.1
            write(self.work / "shot_depth.0000.EXR", {"Z": depth})
            out = self.work / f"out-{kind.__name__}"
            result = run("import", self.work / "shot.####.EXR", self.work / "shot_depth.####.EXR", "--miss", 0.1, "--out", out)
            self.assertEqual(result.returncode, 0, result.stderr)
            found = read_frame(out / "centre/frame.0000.exr")
            np.testing.assert_array_equal(np.isinf(found["depth.Z"]), depth < 1)
            self.assertIn("converted to linear Rec.709", result.stdout)
        self.assertGreater(np.abs(found["R"] - frame["R"]).max(), 0.02)

    def test_names_of_paths_and_of_commands_decide_nothing(self):
        for i in range(2):
            write(self.work / f"a.{i:04}.exr", {c: np.ones((HEIGHT, WIDTH)) for c in "RGB"}, {"software": f"a program with frame {i}"})
        head = self.work / "head.csv"
        head.write_text("0,0,1,0,1,0,0,0\n1,0,1,1,1,0,0,0\n")
        for frame, path in ((0, head), (1, f"{head.parent}/./{head.name}")):
            result = run("import", self.work / "a.####.exr", "--frames", frame, "--path", path, "--out", self.work / "out")
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(list((self.work / "out/centre").glob("*.exr"))), 2)

    def test_a_sphere_from_0_degrees_has_no_windows_and_no_tiles(self):
        write(self.work / "a.0000.exr", {c: np.ones((256, 512)) for c in "RGB"})
        words = ["import", self.work / "a.####.exr", "--camera", "equirect", "--range", "0,360,-90,90", "--lock", "world", "--out", self.work / "out"]
        self.assertIn("begin at -180 degrees", run(*words, "--window", "auto").stderr)
        self.assertEqual(run(*words).returncode, 0)
        tiles = run("encode", self.work / "out", "--tiles", "4x2", "--base", 128, "--out", self.work / "a.mkv")
        self.assertEqual(tiles.returncode, 2)
        self.assertIn("begin at -180 degrees", tiles.stderr)

    def test_windows(self):
        """A part of a denser sphere, as pixels within the display window and as pictures of their own: one window, around an imported base."""
        path = self.path_csv(self.sphere, True)
        dense = read_frame(self.sphere[0])
        kept, whole = (slice(16, 48), slice(32, 112)), (slice(12, 48), slice(20, 114))  # whole blocks of what has pixels
        header = {"dataWindow": (np.array([20, 12], np.int32), np.array([113, 47], np.int32)),
                  "displayWindow": (np.array([0, 0], np.int32), np.array([WIDTH - 1, HEIGHT - 1], np.int32))}
        write(self.work / "part.0000.exr", {name: plane[whole] for name, plane in self.cycles_channels(dense).items()}, header)
        write(self.work / "cut.0000.exr", {name: plane[kept] for name, plane in self.cycles_channels(dense).items()})
        write(self.work / "base.0000.exr", {name: plane[::2, ::2] for name, plane in self.cycles_channels(dense).items()})
        frames = []
        for source, words in (("part", ["--window", "auto"]), ("cut", ["--window", "32,16", "--density", WIDTH])):
            out = self.work / f"out-{source}"
            for words in (words, []):
                result = run("import", self.work / f"{source if words else 'base'}.0000.exr", *words, "--path", path, "--lock", "path", "--out", out)
                self.assertEqual(result.returncode, 0, result.stderr)
            frames.append(read_frame(out / "window/frame.0000.exr"))
            for name in (*self.COLOUR, *self.GEOMETRY):
                np.testing.assert_allclose(frames[-1][name], dense[name][kept], atol=2e-5, err_msg=name)
        for name in frames[0]:
            np.testing.assert_array_equal(frames[1][name], frames[0][name], err_msg=name)
        # Across the seam.
        turned = {name: np.roll(plane, -96, axis=1)[16:48, :80] for name, plane in self.cycles_channels(dense).items()}
        write(self.work / "seam.0000.exr", turned)
        result = run("import", self.work / "seam.0000.exr", "--window", "96,16", "--density", WIDTH, "--path", path, "--lock", "path", "--out", self.work / "out-seam")
        self.assertEqual(result.returncode, 0, result.stderr)
        across = read_frame(self.work / "out-seam/window/frame.0000.exr")
        for name in (*self.COLOUR, *self.GEOMETRY):
            np.testing.assert_allclose(across[name], np.roll(dense[name], -96, axis=1)[16:48, :80], atol=2e-5, err_msg=name)
        # The same sphere flipped.
        flipped = {name: plane[:, ::-1] * (-1 if name.endswith(("Vector.X", "Vector.Z")) else 1) for name, plane in self.cycles_channels(dense).items()}
        write(self.work / "flipped.0000.exr", {name: plane[16:48, WIDTH - 112:WIDTH - 32] for name, plane in flipped.items()})
        result = run("import", self.work / "flipped.0000.exr", "--mirrored", "--window", f"{WIDTH - 112},16", "--density", WIDTH, "--path", path, "--lock", "path", "--out", self.work / "out-flipped")
        self.assertEqual(result.returncode, 0, result.stderr)
        mirrored = read_frame(self.work / "out-flipped/window/frame.0000.exr")
        for name in (*self.COLOUR, *self.GEOMETRY):
            np.testing.assert_allclose(mirrored[name], frames[0][name], atol=2e-5, err_msg=name)
        self.assert_same_pose(self.sphere[0], self.work / "out-part/window/frame.0000.exr")
        out = self.work / "out-part"
        PROGRAMS.run("play", out, "--size", "64x64", "--method", "rotation", "--out", self.work / "eyes")
        report = (self.work / "eyes/report.json").read_text()
        self.assertIn('"window"', report)
        narrow = self.work / "narrow.0000.exr"
        write(narrow, {name: plane[16:30, 20:60] for name, plane in self.cycles_channels(dense).items()}, {**header, "dataWindow": (np.array([20, 16], np.int32), np.array([59, 29], np.int32))})
        cut, refused = self.work / "cut.0000.exr", ["--out", self.work / "none"]
        self.assert_refused([narrow, "--window", "auto", *refused], "narrow.0000.exr", "whole blocks of 16")
        self.assert_refused([self.sphere[0], "--window", "auto", *refused], "less than the sphere's 128x64")
        self.assert_refused([self.view[0], "--window", "auto", "--fov", 80, *refused], "--window", "a perspective view")
        self.assert_refused([cut, "--window", "32,16", *refused], "--window 32,16", "--density COLUMNS as well")
        self.assert_refused([cut, "--window", "33,16", "--density", 128, *refused], "multiples of 16")
        self.assert_refused([cut, "--window", "32,16", "--density", 100, *refused], "--density")
        self.assert_refused([cut, "--window", "here", *refused], "auto, or X,Y in pixels")
        self.assert_refused([cut, "--window", "32,16", "--density", 128, "--fov", 80, *refused], "--fov", "none with --window X,Y")
        self.assert_refused([cut, "--density", 128, *refused], "--density", "--window X,Y as well")
        self.assertFalse((self.work / "none").exists())
        write(self.work / "around.0000.exr", self.cycles_channels(dense))
        for source, words in (("around", []), ("cut", ["--window", "32,16", "--density", WIDTH])):
            result = run("import", self.work / f"{source}.0000.exr", *words, "--path", path, "--lock", "path", "--out", self.work / "out-coarse")
            self.assertEqual(result.returncode, 0, result.stderr)
        result = run("encode", self.work / "out-coarse", "--out", self.work / "none.mp4")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(f"expected windows of a sphere of more columns than the {WIDTH} of", result.stderr)

    def assert_refused(self, words, *mentions):
        result = run("import", *words)
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        self.assertEqual(result.returncode, 2, result.stderr + result.stdout)
        self.assertEqual(len(lines), 1, result.stderr)
        for mention in mentions:
            self.assertIn(str(mention), lines[0])

    def test_bad_input(self):
        good = self.work / "good" / "a.0000.exr"
        frame = read_frame(self.sphere[0])
        write(good, {c: frame[c] for c in "RGB"} | {"Z": np.where(np.isfinite(frame["depth.Z"]), frame["depth.Z"], 1e10)})
        out = ["--out", self.work / "out"]
        self.assert_refused([self.work / "nowhere", *out], "nowhere", "no such file")
        self.assert_refused([good], "--out")
        self.assert_refused([good, "--preset", "povray", *out], "povray", "cycles")
        self.assert_refused([good, "--channels", "depht=Z", *out], "depht", "depth")
        self.assert_refused([good, "--channels", "depth=Q", *out], "Q")
        self.assert_refused([good, "--channels", "depth=R+G", *out], "1 channels", "2")
        self.assert_refused([good, "--backward", "sideways", *out], "sideways", "to-previous")
        self.assert_refused([good, "--depth", "planar", *out], "planar", "sphere")
        self.assert_refused([self.sphere[0], "--depth", "position", *out], "position", "equistream's own frames")
        self.assert_refused([good, "--camera", "perspective", *out], "--fov")
        self.assert_refused([good, "--range", "1,2", *out], "--range")
        self.assert_refused([good, "--colour-space", "cmyk", *out], "cmyk")
        odd = self.work / "odd.0000.exr"
        write(odd, {c: frame[c][:, :100] for c in "RGB"})
        self.assert_refused([odd, *out], "100x64", "--fov")
        negative = self.work / "negative.0000.exr"
        write(negative, {"R": frame["R"], "G": frame["G"], "B": frame["B"], "Z": np.full((HEIGHT, WIDTH), -3.0)})
        self.assert_refused([negative, *out], "negative.0000.exr", "depth at pixel 0,0")
        scaled = self.work / "scaled.0000.exr"
        write(scaled, {c: frame[c] for c in "RGB"}, {"worldToCamera": np.eye(4, dtype=np.float32) * 2})
        self.assert_refused([scaled, *out], "worldToCamera")
        out = ["--out", self.work / "untouched"]
        for number in ("20240501120000", "1" * 30):
            dated = self.work / number / f"shot.{number}.exr"
            dated.parent.mkdir()
            shutil.copy(good, dated)
            self.assert_refused([dated.parent / "shot.####.exr", *out], dated.name, "from 0 to 999999999", number)
        late = shutil.copy(good, self.work / "late.999999999.exr")
        self.assert_refused([late, "--fps", 0.001, *out], "time of frame 999999999", "1e+10")
        self.assert_refused([good, "--name", os.fsdecode(b"caf\xe9"), *out], "scene_name", "UTF-8")
        self.assertFalse((self.work / "untouched" / "centre").exists())

    def test_notes_of_many_frames_are_counted(self):
        frame = {name: plane[:16, :32] for name, plane in read_frame(self.sphere[0]).items()}
        for i in range(23):
            write(self.work / f"shot.{i:04}.exr", {c: frame[c] for c in "RGB"} | {"idx.I": frame["object_id"] + 0.25})
        result = run("import", self.work / "shot.####.exr", "--channels", "object_id=idx.I", "--json", "--out", self.work / "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        notes = json.loads(result.stdout)["notes"]
        self.assertEqual(sum("not whole numbers" in note for note in notes), 20)
        self.assertEqual(notes[-1], "3 more notes like these")

    def test_hostile_files(self):
        good = self.work / "a.0000.exr"
        write(good, {c: read_frame(self.sphere[0])[c] for c in "RGBA"})
        whole = good.read_bytes()
        bad = self.work / "bad.0000.exr"
        rng = np.random.default_rng(7)
        for length in [0, 3, 4, 40, 300, len(whole) // 2, len(whole) - 1]:
            bad.write_bytes(whole[:length])
            self.assert_refused([bad, "--out", self.work / "out"], "bad.0000.exr")
        # OpenEXR would go on behind what it reads of these, and take what follows for the next attribute.
        for mark, expected in ((b"screenWindowCenter\0v2f\0", "type v2f with 8 bytes"), (b"channels\0chlist\0", "type chlist with"), (b"dataWindow\0box2i\0", "type box2i with 16")):
            damaged = bytearray(whole)
            damaged[whole.index(mark) + len(mark)] += 1
            bad.write_bytes(bytes(damaged))
            self.assert_refused([bad, "--out", self.work / "out"], "bad.0000.exr", expected)
        for _ in range(60):
            damaged = bytearray(whole)
            for at in rng.integers(0, 500, 4):
                damaged[at] = rng.integers(0, 256)
            bad.write_bytes(bytes(damaged))
            result = run("import", bad, "--out", self.work / "out2", "--overwrite")
            self.assertIn(result.returncode, (0, 1, 2), result.stderr)
            self.assertLessEqual(len(result.stderr.splitlines()), 1, result.stderr)


if __name__ == "__main__":
    unittest.main()
