"""One frame of a scene from each host, as planes by channel name, several independent colour renders each.

The embedded host is called as a program. Mitsuba is called from Python here, on what `equistream scene convert` wrote, with our plugins: what it knows
of ids and of moving objects is read from the converted files, not from the scene library.
"""

import pathlib
import re
import subprocess
import xml.etree.ElementTree

import numpy as np
import OpenEXR

AOVS = "depth,motion,normal,ids"


class Failed(Exception):
    pass


class Programs:
    def __init__(self, folder):
        self.program = pathlib.Path(folder).resolve() / "equistream"
        if not self.program.is_file():
            raise Failed(f"{self.program}: expected the built program, found nothing (give --bin)")

    def run(self, *words):
        words = [str(word) for word in words]
        result = subprocess.run([self.program, *words], capture_output=True, text=True)
        if result.returncode != 0:
            lines = result.stderr.strip().splitlines()
            raise Failed(f"equistream {' '.join(words)}: exit {result.returncode}: {lines[-1] if lines else 'no message'}")
        return result.stdout


def read_frame(file):
    """All channels of all parts by name, as float64 or unsigned arrays."""
    channels = {}
    for part in OpenEXR.File(str(file), separate_channels=True).parts:
        for name, channel in part.channels.items():
            channels[name] = channel.pixels if channel.pixels.dtype == np.uint32 else channel.pixels.astype(np.float64)
    return channels


def embedded(programs, scene, work, settings):
    """(planes of the first seed, colours of all seeds)."""
    planes, colours = None, []
    for seed in range(1, settings.seeds + 1):
        out = work / f"embedded-{seed}"
        programs.run("render", scene, "--frames", settings.frame, "--size", f"{settings.width}x{settings.height}", "--spp", settings.spp,
                     "--seed", seed, "--unbiased", "--aovs", AOVS, "--overwrite", "--out", out)
        frame = read_frame(out / "centre" / f"frame.{settings.frame:04d}.exr")
        planes = planes or frame
        colours.append(np.stack([frame[c] for c in "RGB"], -1))
    return planes, np.array(colours)


def matrix_of(node):
    return np.array([float(x) for x in node.find("transform/matrix").get("value").split()]).reshape(4, 4)


def ply_positions(file):
    data = file.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    count = int(re.search(r"element vertex (\d+)", header).group(1))
    floats = header.count("property float")
    return np.frombuffer(data, "<f4", count * floats, end).reshape(count, floats)[:, :3].astype(np.float64)


class Converted:
    """What a converted scene says of its camera and of every shape."""

    def __init__(self, programs, scene, file, frame, *options):
        programs.run("scene", "convert", scene, file, "--camera", "equirect", "--frame", frame, "--overwrite", *options)
        self.file = file
        root = xml.etree.ElementTree.parse(file).getroot()
        self.camera = matrix_of(root.find("sensor"))
        self.shapes = {s.get("id"): s for s in root.findall("shape") if s.get("type") != "shapegroup"}

    def moved(self, other, name):
        """Takes a world point of this frame to where it is in the other; None if nothing there moves."""
        here, there = self.shapes[name], other.shapes[name]
        if here.get("type") == "instance":
            if (matrix_of(here) == matrix_of(there)).all():
                return None
            return matrix_of(there) @ np.linalg.inv(matrix_of(here))
        if here.find("emitter") is None or here.get("type") != "ply":
            return None
        a, b = (ply_positions(c.file.parent / s.find("string").get("value")) for c, s in ((self, here), (other, there)))
        if (a == b).all():
            return None
        fitted = np.linalg.lstsq(np.column_stack([a, np.ones(len(a))]), b, rcond=None)[0].T
        return np.vstack([fitted, [0, 0, 0, 1]])


def mitsuba(programs, scene, work, settings):
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(settings.variant)
    mi.set_log_level(mi.LogLevel.Error)
    mi.file_resolver().append(str(pathlib.Path(settings.plugins).resolve().parent))
    frames = [max(settings.frame + step, 0) for step in (-1, 0, 1)]
    # Instances of what stands still would make a vectorised variant compile for minutes; of the neighbours only what moves is looked at.
    now = Converted(programs, scene, work / "now.xml", frames[1], "--bake")
    previous, next_ = (Converted(programs, scene, work / f"frame-{frame}.xml", frame) for frame in (frames[0], frames[2]))
    loaded = mi.load_file(str(now.file), optimize=False, width=settings.width, height=settings.height, spp=settings.spp)
    sensor = loaded.sensors()[0]
    pose = mi.traverse(sensor)
    for key, other in (("to_world_previous", previous), ("to_world_next", next_)):
        pose[key] = mi.AffineTransform4f(other.camera) if hasattr(mi, "AffineTransform4f") else mi.Transform4f(other.camera)
    pose.update()
    integrator = mi.load_dict({"type": "equirect_aov", "aovs": AOVS, "nested": loaded.integrator()})
    tables = mi.traverse(integrator)
    names = [shape.id() for shape in loaded.shapes()]
    number = [int(re.match(r"instance-(\d+)", n).group(1)) + 1 if n.startswith("instance-") else 0 for n in names]
    tables["instance_id"] = mi.UInt32(number) if settings.variant.startswith("llvm") else number
    for key, other in (("moved_previous", previous), ("moved_next", next_)):
        matrices = [now.moved(other, n) for n in names]
        if any(m is not None for m in matrices):
            flat = np.concatenate([(np.eye(4) if m is None else m)[:3].ravel() for m in matrices])
            tables[key] = mi.Float(flat) if settings.variant.startswith("llvm") else flat
    tables.update()
    planes, colours = None, []
    for seed in range(1, settings.seeds + 1):
        # The seeds of both hosts mean different random numbers, but not so obviously that it need not be made sure.
        image = np.array(mi.render(loaded, sensor=sensor, integrator=integrator, spp=settings.spp, seed=1000 + seed), dtype=np.float64)
        if planes is None:
            channels = ["R", "G", "B", "A", *integrator.aov_names()]
            if image.shape[2] != len(channels):
                channels = sensor.film().bitmap().channel_names() if False else channels[:image.shape[2]]
            planes = {name: image[..., i] for i, name in enumerate(channels)}
        colours.append(image[..., :3])
    return planes, np.array(colours)
