"""Our conventions once more, in numpy, from docs and not from our headers: what judges the programs.

Equirect: longitude l = 2 pi (u / W - 1/2), latitude p = pi (1/2 - v / H), direction (cos p sin l, sin p, -cos p cos l);
pixel centres at half-integers. Perspective: -Z forward, +X right, +Y up, horizontal field of view. Quaternions are
w x y z and turn camera vectors into world vectors.
"""

import pathlib
import subprocess
import sys
import time

try:
    import numpy as np
    import OpenEXR
    from PIL import Image
except ImportError as missing:
    sys.exit(f"{sys.argv[0]}: expected the packages of tests/requirements.txt, found no {missing.name}")


class Programs:
    """The built programs, run to their end; a failure shows what they said."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder).resolve()

    def run(self, *words):
        words = [str(word) for word in words]
        result = subprocess.run([self.folder / "equistream", *words], capture_output=True, text=True)
        if result.returncode != 0:
            raise RuntimeError(f"equistream {' '.join(words)}: exit {result.returncode}: {result.stderr.strip()}")
        return result.stdout

    def scene(self, name, out, *options):
        self.run("scene", "generate", name, "--overwrite", "--out", out, *options)
        return pathlib.Path(out) / f"{name}.json"


def read_frame(file):
    """All channels of all parts by name, as float64 or unsigned arrays."""
    channels = {}
    for part in OpenEXR.File(str(file), separate_channels=True).parts:
        for name, channel in part.channels.items():
            pixels = channel.pixels
            channels[name] = pixels if pixels.dtype == np.uint32 else pixels.astype(np.float64)
    return channels


def colour_of(frame):
    return np.stack([frame[c] for c in "RGB"], axis=-1)


def srgb(linear):
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def bytes_of(display):
    return np.floor(255 * display + 0.5).astype(np.uint8)


def psnr_db(a, b):
    """Of display values with peak 1."""
    error = np.mean((a - b) ** 2)
    return np.inf if error == 0 else -10 * np.log10(error)


def pixel_centres(width, height):
    return np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)


def equirect_direction(u, v, width, height):
    longitude = 2 * np.pi * (u / width - 0.5)
    latitude = np.pi * (0.5 - v / height)
    return np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)], -1)


def equirect_pixel(direction, width, height):
    x, y, z = np.moveaxis(direction, -1, 0)
    longitude = np.arctan2(x, -z)
    latitude = np.arctan2(y, np.hypot(x, z))
    return (longitude / (2 * np.pi) + 0.5) * width, (0.5 - latitude / np.pi) * height


def perspective_direction(u, v, width, height, fov_x):
    focal = 0.5 * width / np.tan(0.5 * fov_x)
    return np.stack([(u - 0.5 * width) / focal, (0.5 * height - v) / focal, -np.ones_like(u)], -1)


def rotation(quaternion):
    w, x, y, z = np.asarray(quaternion, float) / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def angle_between(a, b):
    """Exact for small angles too."""
    return 2 * np.arcsin(np.clip(0.5 * np.linalg.norm(unit(a) - unit(b), axis=-1), 0, 1))


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def sample(image, u, v, wrap=True):
    """Bilinear at continuous coordinates; columns wrap (or are held), rows are held at the poles."""
    height, width = image.shape[:2]
    x, y = u - 0.5, v - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]

    def at(column, row):
        column = column % width if wrap else np.clip(column, 0, width - 1)
        return image[np.clip(row, 0, height - 1), column]

    top = (1 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)
    bottom = (1 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1)
    return (1 - fy) * top + fy * bottom


def leave_behind(folder, name, image, reference):
    """What a failing image test leaves: the picture, its reference and their difference, eight times amplified."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for suffix, picture in (("image", image), ("reference", reference), ("difference", 8 * np.abs(image - reference))):
        Image.fromarray(bytes_of(np.clip(picture, 0, 1))).save(folder / f"{name}.{suffix}.png")
    return f"{folder / name}.*.png"


def wait_until(found, what, patience_s):
    """The first thing that found() gives which is not None or False."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        result = found()
        if isinstance(result, np.bool_):
            result = bool(result)  # which is not False itself
        if result is not None and result is not False:
            return result
        time.sleep(0.02)
    raise AssertionError(f"waited {patience_s} s for {what}")
