"""A model relit: its own emission off, small lamps along the camera's path instead, so that interiors render with little noise.

Kitchen and Sibenik are lit through small openings: 16,000 samples a pixel would not bring their noise under the tolerance that
reliability is measured with. Geometry, textures and materials stay; light comes from square double-sided cards that hang in the
air where the head walks.
"""

import json
import pathlib
import struct

import numpy as np

JSON_CHUNK, BIN_CHUNK = 0x4E4F534A, 0x004E4942


def read_glb(file):
    data = pathlib.Path(file).read_bytes()
    if data[:4] != b"glTF":
        raise SystemExit(f"{file}: expected a binary glTF, found something else")
    chunks, at = {}, 12
    while at < len(data):
        length, kind = struct.unpack_from("<II", data, at)
        chunks[kind] = data[at + 8:at + 8 + length]
        at += 8 + length
    return json.loads(chunks[JSON_CHUNK]), chunks[BIN_CHUNK]


def write_glb(file, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    pathlib.Path(file).write_bytes(struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<II", len(text), JSON_CHUNK) + text
                                   + struct.pack("<II", len(binary), BIN_CHUNK) + binary)


def card(centre, side_m, towards):
    """Four corners of a square around a centre, and its two triangles."""
    normal = np.asarray(towards, float) / np.linalg.norm(towards)
    across = np.cross(normal, [0.0, 0.3, 1.0])
    across /= np.linalg.norm(across)
    along = np.cross(normal, across)
    corners = [centre + 0.5 * side_m * (s * across + t * along) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return np.asarray(corners, np.float32), np.asarray([0, 1, 2, 0, 2, 3], np.uint16)


def add(document, binary, values, target, component, kind):
    """Another accessor over bytes at the end of the buffer."""
    binary += b"\0" * (-len(binary) % 4)
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes, "target": target})
    accessor = {"bufferView": len(document["bufferViews"]) - 1, "componentType": component, "count": len(values), "type": kind}
    if kind == "VEC3":
        accessor.update(min=values.min(axis=0).tolist(), max=values.max(axis=0).tolist())
    document["accessors"].append(accessor)
    return binary + values.tobytes(), len(document["accessors"]) - 1


def relight(source, target, lamps):
    """`lamps`: (centre in metres, side in metres, radiance) each."""
    document, binary = read_glb(source)
    for material in document["materials"]:
        material.pop("emissiveFactor", None)
        material.get("extensions", {}).pop("KHR_materials_emissive_strength", None)
    used = set(document.get("extensionsUsed", [])) | {"KHR_materials_emissive_strength"}
    document["extensionsUsed"] = sorted(used)
    for index, (centre, side_m, radiance) in enumerate(lamps):
        corners, triangles = card(np.asarray(centre, float), side_m, (0.25, 1, 0.15 + 0.1 * index))
        binary, positions = add(document, binary, corners, 34962, 5126, "VEC3")
        binary, indices = add(document, binary, triangles, 34963, 5123, "SCALAR")
        document["materials"].append({"name": f"lamp {index}", "doubleSided": True, "emissiveFactor": [1, 1, 1],
                                      "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
                                      "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": radiance},
                                                     "KHR_materials_ior": {"ior": 1}}})
        document["meshes"].append({"name": f"lamp {index}", "primitives": [
            {"attributes": {"POSITION": positions}, "indices": indices, "material": len(document["materials"]) - 1}]})
        document["nodes"].append({"name": f"lamp {index}", "mesh": len(document["meshes"]) - 1})
        document["scenes"][document.get("scene", 0)]["nodes"].append(len(document["nodes"]) - 1)
    document["extensionsUsed"] = sorted(set(document["extensionsUsed"]) | {"KHR_materials_ior"})
    document["buffers"][0]["byteLength"] = len(binary)
    write_glb(target, document, binary)
