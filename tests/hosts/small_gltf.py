"""glTF files made by hand: quads with images, so that what a converted texture says can be computed here."""

import base64
import io
import json

import numpy as np
from PIL import Image


def png(pixels):
    """8 bits a channel, rows from the top: height x width x channels."""
    data = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8).squeeze()).save(data, "png")
    return data.getvalue()


def uri(data, kind):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


class Gltf:
    """Quads in the XY plane around (x, y, 0), facing +Z, counter-clockwise; texture coordinates run from uv_low at the top left."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
                     "accessors": [], "bufferViews": [], "buffers": [], "textures": [], "images": [], "samplers": []}
        self.bytes = b""

    def add(self, key, value):
        self.json[key].append(value)
        return len(self.json[key]) - 1

    def accessor(self, array, kind):
        array = np.ascontiguousarray(array)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": array.nbytes})
        self.bytes += array.tobytes()
        entry = {"bufferView": view, "componentType": {"float32": 5126, "uint32": 5125}[array.dtype.name], "count": len(array), "type": kind}
        if kind == "VEC3":
            entry |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        return self.add("accessors", entry)

    def texture(self, pixels, wrap=(10497, 10497), nearest=False):
        image = self.add("images", {"mimeType": "image/png", "uri": uri(png(pixels), "image/png")})
        sampler = self.add("samplers", {"wrapS": wrap[0], "wrapT": wrap[1], "magFilter": 9728 if nearest else 9729})
        return self.add("textures", {"source": image, "sampler": sampler})

    def material(self, **values):
        return self.add("materials", values)

    def quad(self, material, uv=((0, 0), (1, 1)), size=1.0, **node):
        (u0, v0), (u1, v1) = uv
        h = size / 2
        mesh = self.add("meshes", {"primitives": [{
            "attributes": {"POSITION": self.accessor(np.array([[-h, h, 0], [-h, -h, 0], [h, -h, 0], [h, h, 0]], np.float32), "VEC3"),
                           "TEXCOORD_0": self.accessor(np.array([[u0, v0], [u0, v1], [u1, v1], [u1, v0]], np.float32), "VEC2")},
            "indices": self.accessor(np.array([0, 1, 2, 0, 2, 3], np.uint32), "SCALAR"), "material": material}]})
        self.place(mesh, **node)
        return mesh

    def place(self, mesh, **node):
        self.json["scenes"][0]["nodes"].append(self.add("nodes", {"mesh": mesh, **node}))

    def write(self, folder, name="model", **description):
        """Writes NAME.gltf and NAME.json; returns the latter."""
        self.json["buffers"] = [{"byteLength": len(self.bytes), "uri": uri(self.bytes, "application/octet-stream")}]
        (folder / f"{name}.gltf").write_text(json.dumps({k: v for k, v in self.json.items() if v != []}))
        scene = {"model": f"{name}.gltf", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 2]}]}, **description}
        (folder / f"{name}.json").write_text(json.dumps(scene))
        return folder / f"{name}.json"
