"""What other programs agree on, in one host: omnidirectional stereo by closed form and as a stream, Cryptomatte by a decoder and a hash of this test's own.

usage: standards_test.py BIN_DIR embree|mitsuba
"""

import json
import pathlib
import shutil
import struct
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from independent import *

PROGRAMS = Programs(sys.argv.pop(1))
HOST = sys.argv.pop(1)
IPD = 0.2
WIDTH, HEIGHT = 128, 64


def murmur3_32(data):
    """MurmurHash3_x86_32 with seed 0."""
    def rotated(x, r):
        return (x << r | x >> 32 - r) & 0xffffffff

    def mixed(k):
        return rotated(k * 0xcc9e2d51 & 0xffffffff, 15) * 0x1b873593 & 0xffffffff

    h, whole = 0, len(data) // 4 * 4
    for at in range(0, whole, 4):
        h = (rotated(h ^ mixed(int.from_bytes(data[at:at + 4], "little")), 13) * 5 + 0xe6546b64) & 0xffffffff
    h ^= mixed(int.from_bytes(data[whole:], "little")) ^ len(data)
    for factor in (0x85ebca6b, 0xc2b2ae35):
        h = (h ^ h >> (16 if factor == 0x85ebca6b else 13)) * factor & 0xffffffff
    return h ^ h >> 16


def id_bits(name):
    bits = murmur3_32(name.encode())
    return bits ^ 1 << 23 if bits >> 23 & 255 in (0, 255) else bits


class Standards(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_standards_"))

    def tearDown(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def render(self, scene, out, *options):
        PROGRAMS.run("render", scene, "--host", HOST, "--frames", 0, "--size", f"{WIDTH}x{HEIGHT}", *options, "--out", self.root / out)
        return self.root / out

    def test_omnidirectional_stereo_by_closed_form(self):
        """In a sphere of radius R each ray begins on the circle of radius IPD / 2, narrower towards the poles, and goes along its tangent."""
        radius, n = 2.0, 256
        scene = PROGRAMS.scene("sphere", self.root / "scene", "--option", f"radius={radius}", "--option", f"n={n}")
        out = self.render(scene, "ods", "--camera", "ods", "--ipd", IPD, "--spp", 4, "--aovs", "depth,motion")
        u, v = pixel_centres(WIDTH, HEIGHT)
        longitude, latitude = 2 * np.pi * (u / WIDTH - 0.5), np.pi * (0.5 - v / HEIGHT)
        fade = 0.5 + 0.5 * np.cos(np.pi * np.clip((np.degrees(np.abs(latitude)) - 60) / 15, 0, 1))
        exact = np.sqrt(radius ** 2 - (0.5 * IPD * fade) ** 2)
        sag = radius * (1 - np.cos(np.pi / n)) * 1.1
        for eye in ("left", "right"):
            frame = read_frame(out / eye / "frame.0000.exr")
            self.assertLess(np.max(frame["depth.Z"] - exact), 1e-5 * radius)
            self.assertLess(np.max(exact - frame["depth.Z"]), sag + 1e-5 * radius)
            for channel in ("backward.u", "backward.v", "forward.u", "forward.v"):
                self.assertLess(np.abs(frame[channel]).max(), 5e-3, channel)
        PROGRAMS.run("encode", out, "--stereo", "top-bottom", "--preset", "ultrafast", "--out", self.root / "ods.mp4")
        track = json.loads(PROGRAMS.run("info", self.root / "ods.mp4", "--json"))["tracks"][0]
        self.assertEqual((track["stereo"], track["equirect"], track["vexu"]), ("top-bottom", True, True))
        self.assertEqual(track["first_frame"]["camera"]["kind"], "ods")
        self.assertAlmostEqual(track["baseline_m"], IPD, 6)
        # Imported, frames of our own stay what they are.
        for eye in ("left", "right"):
            PROGRAMS.run("import", out / eye, "--ipd", IPD, "--lock", "world", "--out", self.root / "taken")
            manifest = json.loads((self.root / "taken" / eye / "manifest.json").read_text())
            self.assertEqual(manifest["camera"]["kind"], "ods")

    @unittest.skipIf(HOST != "embree", "nothing is rendered")
    def test_eyes_of_a_turned_head_see_what_cameras_beside_each_other_see(self):
        """From the plain spheres of both eyes, turned, they see it ahead alone: to the side these lie behind each other. A ball of 1 m around the head, whose
        colours are a smooth function of the place, imported."""
        width, height, ipd = 512, 256, 0.1

        def colour(origin, direction):
            along = np.sum(origin * direction, -1)
            point = origin + (np.sqrt(along ** 2 + 1 - np.sum(origin ** 2, -1)) - along)[..., None] * direction
            return 0.5 + 0.4 * np.sin(8 * point + np.array([0, 1, 2]))

        u, v = pixel_centres(width, height)
        longitude = 2 * np.pi * (u / width - 0.5)
        direction = equirect_direction(u, v, width, height)
        beside = np.stack([np.cos(longitude), 0 * longitude, np.sin(longitude)], -1)
        (self.root / "still.csv").write_text("".join(f"{t},0,0,0,1,0,0,0\n" for t in (0, 1)))
        for eye, side in (("left", -0.5 * ipd), ("right", 0.5 * ipd)):
            for kind, origin in (("ods", side * beside), ("both", np.array([side, 0, 0]) + 0 * beside)):
                picture = colour(origin, direction).astype(np.float32)
                header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
                source = self.root / f"{kind}.{eye}.0000.exr"
                OpenEXR.File(header, {c: np.ascontiguousarray(picture[..., k]) for k, c in enumerate("RGB")}).write(str(source))
                PROGRAMS.run("import", source, "--camera", "ods" if kind == "ods" else "equirect", "--eye", eye, "--ipd", ipd, "--lock", "world", "--path", self.root / "still.csv",
                             "--out", self.root / kind)
        turned = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]])  # -Z becomes +X
        (self.root / "side.csv").write_text("".join(f"{t},0,0,0,0.70710678,0,-0.70710678,0\n" for t in (0, 1)))
        rays = unit(perspective_direction(*pixel_centres(96, 64), 96, 64, np.radians(40))) @ turned.T
        true = {eye: srgb(colour(turned @ np.array([side, 0, 0]), rays)) for eye, side in (("left", -0.5 * ipd), ("right", 0.5 * ipd))}
        error = {}
        for kind in ("ods", "both"):
            PROGRAMS.run("encode", self.root / kind, "--stereo", "side-by-side", "--crf", 4, "--preset", "ultrafast", "--out", self.root / f"{kind}.mkv")
            views = self.root / f"{kind}-views"
            PROGRAMS.run("play", self.root / f"{kind}.mkv", "--head", self.root / "side.csv", "--fov", 40, "--size", "96x64", "--out", views)
            self.assertEqual(json.loads((views / "report.json").read_text())["method"], "rotation")
            seen = {eye: np.asarray(Image.open(next((views / eye).glob("*.png"))).convert("RGB")) / 255.0 for eye in true}
            error[kind] = np.sqrt(np.mean([(seen[eye] - true[eye]) ** 2 for eye in true]))
        print(f"root mean square error to the side: by ODS {error['ods']:.4f}, by turned spheres {error['both']:.4f}")
        self.assertLess(error["ods"], 0.02)
        self.assertGreater(error["both"], 2 * error["ods"])

    @unittest.skipIf(HOST != "embree", "Mitsuba's samples hang on the sensor")
    def test_without_a_distance_it_is_the_plain_sphere_bit_for_bit(self):
        scene = PROGRAMS.scene("furnace", self.root / "scene")
        common = ("--ipd", 0, "--spp", 4, "--eye", "left")
        plain = read_frame(self.render(scene, "plain", *common) / "left/frame.0000.exr")
        ods = read_frame(self.render(scene, "ods", "--camera", "ods", *common) / "left/frame.0000.exr")
        self.assertEqual(plain.keys(), ods.keys())
        for channel in plain:
            np.testing.assert_array_equal(plain[channel], ods[channel], channel)

    def test_a_file_has_one_part_for_readers_of_the_first_where_told(self):
        scene = PROGRAMS.scene("furnace", self.root / "scene")
        parts = {}
        for out, options in (("two", []), ("one", ["--single-part"])):
            file = self.render(scene, out, "--spp", 1, "--aovs", "depth", *options) / "centre/frame.0000.exr"
            parts[out] = OpenEXR.File(str(file), separate_channels=True).parts
        self.assertEqual([len(parts["two"]), len(parts["one"])], [2, 1])
        np.testing.assert_array_equal(parts["one"][0].channels["Z"].pixels, parts["two"][1].channels["depth.Z"].pixels)
        self.assertLessEqual(set("RGBA"), set(parts["one"][0].channels))

    def balls(self, model):
        """Of furnace, around the camera: the centre of each, its name and its material's."""
        data = model.read_bytes()
        gltf = json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])
        for node in gltf["nodes"]:
            material = gltf["meshes"][node["mesh"]]["primitives"][0]["material"]
            yield np.array(node["matrix"][12:15]), node["name"], gltf["materials"][material]["name"]

    def test_cryptomatte_covers_what_the_samples_met(self):
        scene = PROGRAMS.scene("furnace", self.root / "scene")
        spp = 64
        out = self.render(scene, "crypto", "--spp", spp, "--aovs", "ids,cryptomatte")
        file = out / "centre/frame.0000.exr"
        frame = read_frame(file)
        header = OpenEXR.File(str(file)).parts[0].header
        shown = {"CryptoObject": {}, "CryptoMaterial": {}}
        for place, name, material in self.balls(scene.with_suffix(".glb")):
            column, row = (int(x) for x in equirect_pixel(place, WIDTH, HEIGHT))
            column %= WIDTH  # one lies on the seam
            shown["CryptoObject"][frame["object_id"][row, column]] = name
            shown["CryptoMaterial"][frame["material_id"][row, column]] = material
        self.assertEqual([len(names) for names in shown.values()], [6, 3])
        for kind, key, plane in (("CryptoObject", "3ae39a5", "object_id"), ("CryptoMaterial", "be359d6", "material_id")):
            said = {name.split("/")[2]: text for name, text in header.items() if name.startswith(f"cryptomatte/{key}/")}
            self.assertEqual(said["name"], kind)
            self.assertEqual((said["hash"], said["conversion"]), ("MurmurHash3_32", "uint32_to_float32"))
            manifest = json.loads(said["manifest"])
            self.assertTrue(manifest)
            for name, bits in manifest.items():
                self.assertEqual(bits, f"{id_bits(name):08x}", name)
            ids = {np.float32(struct.unpack("<f", struct.pack("<I", int(bits, 16)))[0]): name for name, bits in manifest.items()}
            pairs = [(frame[f"{kind}{layer:02}.{i}"].astype(np.float32), frame[f"{kind}{layer:02}.{c}"])
                     for layer in range(3) for i, c in ("rg", "ba")]
            total = sum(coverage for _, coverage in pairs)
            # Colour's alpha says in how many samples something was met; Mitsuba's come from other random numbers.
            difference = np.abs(total - frame["A"])
            self.assertLess(difference.max(), 2e-3 if HOST == "embree" else 0.4)
            self.assertLess(difference.mean(), 1e-3 if HOST == "embree" else 0.02)
            for (_, larger), (_, smaller) in zip(pairs, pairs[1:]):
                self.assertTrue(np.all(larger >= smaller))
            found = {float(value) for value in np.unique(pairs[0][0][pairs[0][1] > 0])}
            self.assertTrue(found)
            self.assertTrue(all(np.float32(value) in ids for value in found))
            # Where all samples met one thing, the pixel's centre shows it, and the matte has its name.
            whole = pairs[0][1] == 1
            self.assertEqual(set(np.unique(frame[plane][whole])), set(shown[kind]))
            for number, name in shown[kind].items():
                value, = np.unique(pairs[0][0][whole & (frame[plane] == number)])
                self.assertEqual(ids[value], name)
                # The mean of its coverage over the picture is its solid share.
                coverage = sum(np.where(i == value, c, 0) for i, c in pairs)
                self.assertAlmostEqual(coverage.mean(), np.mean(frame[plane] == number), delta=0.01)


if __name__ == "__main__":
    unittest.main(verbosity=1)
