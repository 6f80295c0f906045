"""A scene read from OBJ/MTL and the same one from GLB give the same depth, the same light and the same eyes.

usage: obj_test.py BIN_DIR
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

FLOOR = [[(-8, 0, -8), (-8, 0, 8), (8, 0, 8), (8, 0, -8)]]
BOX = [[(-1, 0, -3), (1, 0, -3), (1, 1.5, -3), (-1, 1.5, -3)], [(1, 0, -3), (1, 0, -5), (1, 1.5, -5), (1, 1.5, -3)],
       [(-1, 0, -5), (-1, 0, -3), (-1, 1.5, -3), (-1, 1.5, -5)], [(-1, 1.5, -3), (1, 1.5, -3), (1, 1.5, -5), (-1, 1.5, -5)]]
LEAF = [[(2, 0.25, -2), (3, 0.25, -2), (3, 2.25, -2), (2, 2.25, -2)]]
CORNERS = [(0, 0), (1, 0), (1, 1), (0, 1)]  # texture coordinates of every face, v upwards

# 3ds Max's habits: tabs, backslashes, another case, 0.588 under a map, Tr beside d, a bump map that is nowhere.
MTL = ("newmtl stone\r\n\tNs 10.0\r\n\tNi 1.5\r\n\td 1.0\r\n\tTr 0.0\r\n\tillum 2\r\n\tKa 0.588 0.588 0.588\r\n"
       "\tKd 0.588 0.588 0.588\r\n\tKs 0 0 0\r\n\tmap_Ka textures\\Stone.TGA\r\n\tmap_Kd textures\\Stone.TGA\r\n"
       "\tmap_bump textures\\Stone_ddn.TGA\r\n\r\nnewmtl paint\r\nKd 0.2 0.3 0.8\r\nKs 0.5 0.5 0.5\r\nNs 30\r\nNi 1.5\r\n"
       "newmtl leaf\r\nKd 0.1 0.5 0.2\r\nmap_d Textures\\LEAF.tga\r\n")


def stone():
    y, x = np.mgrid[0:64, 0:64]
    return np.stack([80 + 40 * ((x // 8 + y // 8) % 2) + x, 90 + y, 60 + (x * y) // 64], -1).astype(np.uint8)


def leaf():
    y, x = np.mgrid[0:32, 0:32]
    return np.where(((x - 16) / 12) ** 2 + ((y - 12) / 10) ** 2 < 1, 255, 0).astype(np.uint8)


def write_obj(folder):
    """Vertices as they come, faces that count back, objects by g; nothing but what a face needs is said twice."""
    lines = ["# made by hand", "mtllib My Yard.MTL", "s off"]
    for name, material, faces in (("floor", "stone", FLOOR), ("box", "paint", BOX), ("leaf", "leaf", LEAF)):
        lines += [f"g {name}", f"usemtl {material} "]
        for face in faces:
            lines += [f"v {x} {y} {z}" for x, y, z in face]
            lines += [f"vt {4 * u} {4 * v} 0" if name == "floor" else f"vt {u} {v}" for u, v in CORNERS]
            lines += ["f -4/-4 -3/-3 \\", "  -2/-2 -1/-1"]
    (folder / "yard.obj").write_bytes("\r\n".join(lines).encode())
    (folder / "my yard.mtl").write_bytes(MTL.encode())
    (folder / "textures").mkdir()
    Image.fromarray(stone()).save(folder / "textures/stone.tga")
    Image.fromarray(leaf()).save(folder / "textures/leaf.tga")
    return "yard.obj"


def png(pixels, scratch):
    Image.fromarray(pixels).save(scratch)
    return scratch.read_bytes()


def write_glb(folder):
    data = b""
    views, accessors, meshes, nodes = [], [], [], []

    def view(content):
        nonlocal data
        data += b"\0" * (-len(data) % 4)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(content)})
        data += content
        return len(views) - 1

    def accessor(values, kind, component, code):
        array = np.asarray(values, code)
        accessors.append({"bufferView": view(array.tobytes()), "componentType": component, "type": kind,
                          "count": len(array)})
        return len(accessors) - 1

    for number, (name, faces, repeat) in enumerate((("floor", FLOOR, 4), ("box", BOX, 1), ("leaf", LEAF, 1))):
        corners = [corner for face in faces for corner in face]
        uvs = [(repeat * u, 1 - repeat * v) for _ in faces for u, v in CORNERS]
        triangles = [4 * i + k for i in range(len(faces)) for k in (0, 1, 2, 0, 2, 3)]
        attributes = {"POSITION": accessor(corners, "VEC3", 5126, np.float32), "TEXCOORD_0": accessor(uvs, "VEC2", 5126, np.float32)}
        meshes.append({"primitives": [{"attributes": attributes, "material": number,
                                       "indices": accessor(triangles, "SCALAR", 5125, np.uint32)}]})
        nodes.append({"name": name, "mesh": number})
    masked = np.concatenate([np.full((32, 32, 3), 255, np.uint8), leaf()[..., None]], -1)
    images = [{"bufferView": view(png(p, folder / "scratch.png")), "mimeType": "image/png"} for p in (stone(), masked)]
    (folder / "scratch.png").unlink()
    matt = {"KHR_materials_ior": {"ior": 1}}
    materials = [{"doubleSided": True, "extensions": matt, "pbrMetallicRoughness":
                  {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 1}},
                 {"doubleSided": True, "pbrMetallicRoughness":
                  {"baseColorFactor": [0.2, 0.3, 0.8, 1], "metallicFactor": 0, "roughnessFactor": (2 / 32) ** 0.25}},
                 {"doubleSided": True, "extensions": matt, "alphaMode": "MASK", "pbrMetallicRoughness":
                  {"baseColorTexture": {"index": 1}, "baseColorFactor": [0.1, 0.5, 0.2, 1], "metallicFactor": 0,
                   "roughnessFactor": 1}}]
    text = json.dumps({"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_ior"], "scene": 0,
                       "scenes": [{"nodes": [0, 1, 2]}], "nodes": nodes, "meshes": meshes, "accessors": accessors,
                       "bufferViews": views, "buffers": [{"byteLength": len(data)}], "materials": materials,
                       "images": images, "textures": [{"source": 0}, {"source": 1}]}).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    (folder / "yard.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) +
                                      struct.pack("<I4s", len(text), b"JSON") + text +
                                      struct.pack("<I4s", len(data), b"BIN\0") + data)
    return "yard.glb"


def description(folder, model, unit=None):
    scene = {"model": model, "sun": {"azimuth_deg": 60, "elevation_deg": 40, "irradiance": [4, 3.6, 3]},
             "sky": {"radiance": [0.5, 0.6, 0.8]},
             "camera": {"keys": [{"time_s": 0, "position_m": [0.3, 1.6, 1]}, {"time_s": 0.1, "position_m": [0.4, 1.6, 0.9]}]},
             "head_box": {"lean_m": 0.05},
             "moving": [{"object": "box", "keys": [{"time_s": 0, "position_m": [0, 0, 0]},
                                                   {"time_s": 1, "position_m": [1, 0, 0]}]}]}
    if unit:
        scene["model_unit_m"] = unit
    file = folder / (pathlib.Path(model).suffix[1:] + ".json")
    file.write_text(json.dumps(scene))
    return file


class Obj(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_obj_"))
        self.obj = description(self.root, write_obj(self.root))
        self.glb = description(self.root, write_glb(self.root))

    def tearDown(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def render(self, scene, out, seed=1, spp=16, frames="0-1"):
        PROGRAMS.run("render", scene, "--frames", frames, "--size", "512x256", "--spp", spp, "--seed", seed, "--small",
                     "right", "--aovs", "depth,motion,normal,ids", "--out", self.root / out)
        return [read_frame(file) for file in sorted((self.root / out / "centre").glob("frame.*.exr"))]

    def test_geometry_is_the_same_to_the_last_bit(self):
        for frame, (obj, glb) in enumerate(zip(self.render(self.obj, "obj", spp=1), self.render(self.glb, "glb", spp=1))):
            for channel in ("depth.Z", "object_id", "material_id", "instance_id", "normal.X", "normal.Y", "normal.Z",
                            "backward.u", "forward.v"):
                self.assertTrue(np.array_equal(obj[channel], glb[channel]), f"{channel} of frame {frame}")
            self.assertEqual(set(np.unique(obj["object_id"])), {0, 1, 2, 3})

    def test_light_is_the_same_but_for_noise(self):
        obj, = self.render(self.obj, "obj", seed=1, spp=64, frames="0")
        again, = self.render(self.obj, "again", seed=2, spp=64, frames="0")
        glb, = self.render(self.glb, "glb", seed=3, spp=64, frames="0")
        surface = obj["object_id"] > 0  # the sun's disc in the sky would be all of the noise
        for channel in "RGB":
            noise = (obj[channel] - again[channel])[surface]
            difference = (obj[channel] - glb[channel])[surface]
            z = difference.mean() / (difference.std() / np.sqrt(difference.size))
            ratio = difference.std() / noise.std()
            print(f"{channel}: z {z:.2f}, difference {ratio:.3f} times the noise")
            self.assertLess(abs(z), 4)
            # The deviations of some 57,000 pixels' noise agree within a few percent, fat tails allowed for.
            self.assertTrue(0.9 < ratio < 1.1)

    def test_a_stream_plays_with_the_objs_depth(self):
        eyes = {}
        for scene in (self.obj, self.glb):
            name = scene.stem
            self.render(scene, name)
            PROGRAMS.run("encode", self.root / name, "--out", self.root / f"{name}.mp4", "--crf", 12)
            PROGRAMS.run("play", self.root / f"{name}.mp4", "--scene", scene, "--size", "320x240", "--out",
                         self.root / f"{name}-eyes")
            eyes[name] = {f.relative_to(self.root / f"{name}-eyes"): np.asarray(Image.open(f), float)
                          for f in sorted((self.root / f"{name}-eyes").rglob("*.png"))}
        self.assertGreaterEqual(len(eyes["obj"]), 4)
        self.assertEqual(eyes["obj"].keys(), eyes["glb"].keys())
        for file, picture in eyes["obj"].items():
            self.assertGreater(picture.std(), 5, file)
            self.assertLess(np.abs(picture - eyes["glb"][file]).mean(), 0.5, file)

    def test_a_unit_in_centimetres_scales_depth(self):
        metres = self.render(self.obj, "metres", spp=1, frames="0")[0]["depth.Z"]
        text = (self.root / "yard.obj").read_text()
        scaled = [" ".join(["v"] + [str(100 * float(x)) for x in line.split()[1:]]) if line.startswith("v ") else line
                  for line in text.splitlines()]
        (self.root / "yard.obj").write_text("\n".join(scaled))
        description(self.root, "yard.obj", 0.01)
        depth = self.render(self.obj, "centimetres", spp=1, frames="0")[0]["depth.Z"]
        both = np.isfinite(metres) & np.isfinite(depth)
        self.assertGreater(both.mean(), 0.3)
        self.assertLess(np.quantile(np.abs(depth[both] / metres[both] - 1), 0.999), 1e-5)

    def test_what_is_wrong_is_told_in_a_line(self):
        info = subprocess.run([PROGRAMS.folder / "equistream", "scene", "info", self.obj], capture_output=True, text=True)
        self.assertEqual(info.returncode, 0)
        self.assertEqual(info.stderr.splitlines(), [f"equistream scene: {self.root}/my yard.mtl:12: map_bump is not used"])
        (self.root / "yard.obj").write_text("v 0 0 0\nv 1 0 0\nf 1 2 7\n")
        for command in (["render", self.obj, "--out", self.root / "bad"], ["scene", "info", self.obj]):
            result = subprocess.run([PROGRAMS.folder / "equistream", *map(str, command)], capture_output=True, text=True)
            self.assertEqual(result.returncode, 2)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn("yard.obj:3: expected one of the 2 vertices so far", result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=1)
