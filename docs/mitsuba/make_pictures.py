#!/usr/bin/env python3
"""Renders the pictures of the plugins' pages: equirect.jpg and equirect_aov.jpg, beside this file. Takes two minutes of a core.

    PYTHONPATH=build/release/package build/venv/bin/python3 docs/mitsuba/make_pictures.py
"""

import pathlib

import equistream as es
import mitsuba as mi
import numpy as np
from PIL import Image, ImageDraw, ImageFont

mi.set_variant("llvm_ad_rgb" if "llvm_ad_rgb" in mi.variants() else "scalar_rgb")
import equistream.mitsuba  # noqa: E402,F401

HERE = pathlib.Path(__file__).resolve().parent
HEAD = [0.1, 0, 0.8]
SPP = 256
LABEL = 18


def room():
    """The Cornell box, closed, with a ball of chrome in it."""
    scene = mi.cornell_box()
    scene["ball"] = {"type": "sphere", "center": [-0.5, -0.6, 0.35], "radius": 0.3, "bsdf": {"type": "conductor", "material": "Cr"}}
    scene["front"] = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 1]).rotate([0, 1, 0], 180), "bsdf": scene["white"]}
    return scene


def pose(origin):
    return mi.ScalarTransform4f().look_at(origin=origin, target=[origin[0], origin[1], -1], up=[0, 1, 0])


def rendered(width, height, aovs="none", **sensor):
    """Colour as display pixels, and the planes by name."""
    scene = room()
    scene["sensor"] = {"type": "equirect", "to_world": pose(HEAD), "sampler": {"type": "independent", "sample_count": SPP}, **sensor,
                       "film": {"type": "hdrfilm", "width": width, "height": height, "component_format": "float32", "rfilter": {"type": "box"}}}
    scene["integrator"] = {"type": "equirect_aov", "aovs": aovs, "nested": {"type": "path", "max_depth": 8}}
    scene = mi.load_dict(scene)
    image = np.array(mi.render(scene))
    names = scene.integrator().aov_names()
    return es.to_display(image[..., :3]), dict(zip(names, np.moveaxis(image[..., image.shape[2] - len(names):], -1, 0)))


def labelled(picture, text):
    """The picture below its name."""
    height, width = picture.shape[:2]
    canvas = Image.new("RGB", (width, height + LABEL), "#202226")
    canvas.paste(Image.fromarray(picture), (0, LABEL))
    ImageDraw.Draw(canvas).text((5, 2), text, "#e8e6e1", ImageFont.load_default(13))
    return np.asarray(canvas)


def hues(u, v):
    """Motion: hue by direction, brightness by length."""
    length = np.hypot(u, v)
    hsv = np.stack([(np.arctan2(v, u) / (2 * np.pi) % 1) * 255, np.full_like(u, 200), 255 * np.clip(length / np.quantile(length, 0.9), 0, 1) ** 0.5], axis=-1)
    return np.asarray(Image.fromarray(hsv.astype(np.uint8), "HSV").convert("RGB"))


def ids(plane):
    hue = 255 * (0.381966 * plane % 1)  # neighbours far from each other
    return np.asarray(Image.fromarray(np.stack([hue, np.full_like(hue, 150), np.full_like(hue, 220)], axis=-1).astype(np.uint8), "HSV").convert("RGB"))


def signed(*channels):
    return np.round(255 * (0.5 + 0.5 * np.stack(channels, axis=-1))).astype(np.uint8)


def save(rows, file):
    width = min(sum(picture.shape[1] for picture in row) for row in rows)
    whole = np.concatenate([np.concatenate(row, axis=1)[:, :width] for row in rows])
    Image.fromarray(whole).save(file, quality=82, optimize=True, progressive=True)
    print(f"{file}: {whole.shape[1]}x{whole.shape[0]}, {file.stat().st_size / 1000:.0f} kB")


def draw_sensor():
    half = {"longitude_min": -90.0, "longitude_max": 90.0}
    sphere, _ = rendered(640, 320)
    eyes = [labelled(rendered(200, 200, eye=eye, **half)[0], f"eye {eye}, longitudes -90 to 90") for eye in ("left", "right")]
    band = labelled(rendered(240, 200, latitude_min=-30.0, latitude_max=30.0, longitude_min=-36.0, longitude_max=36.0)[0], "latitudes -30 to 30")
    save([[labelled(sphere, "the whole sphere, eye centre")], [*eyes, band]], HERE / "equirect.jpg")


def draw_planes():
    colour, planes = rendered(320, 160, "all", to_world_previous=pose([HEAD[0], HEAD[1], HEAD[2] + 0.1]))
    pictures = {
        "colour, by the nested path": colour,
        "depth": es.false_colour(planes["depth.Z"]),
        "normal": signed(*(planes[f"normal.{axis}"] for axis in "XYZ")),
        "albedo": es.to_display(np.stack([planes[f"albedo.{c}"] for c in "RGB"], axis=-1)),
        "object_id": ids(planes["object_id"]),
        "backward (the head went 10 cm ahead)": hues(planes["backward.u"], planes["backward.v"]),
        "specular": np.repeat(np.uint8(255 * planes["specular"])[..., None], 3, axis=2),
        "virtual_depth": es.false_colour(planes["virtual_depth.Z"]),
    }
    drawn = [labelled(picture, name) for name, picture in pictures.items()]
    save([drawn[i:i + 2] for i in range(0, len(drawn), 2)], HERE / "equirect_aov.jpg")


if __name__ == "__main__":
    draw_sensor()
    draw_planes()
