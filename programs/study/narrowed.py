"""Narrower spheres of those that were rendered.

A box filter weighs all samples of a pixel alike. So where a pixel of a narrower sphere covers whole pixels of a wide one, their mean is what rendering it with
all their samples gives, up to where the samples happened to fall. Textures are filtered to the width of the wide sphere's pixels, so they come out a little
sharper. Geometry is not filtered: it comes from a render of the narrow sphere's own pixel centres.
"""

import shutil

import equistream as es
import numpy as np

from steps import write_whole


def times_wider(wide_size, size):
    """How many pixels of the wide picture lie along each side of a narrow one's."""
    times = wide_size[0] // size[0]
    if times < 1 or (size[0] * times, size[1] * times) != tuple(wide_size):
        raise ValueError(f"narrowed: expected a whole fraction of {wide_size[0]}x{wide_size[1]}, found {size[0]}x{size[1]}")
    return times


def narrowed(colour, size):
    """The mean of rows x columns x channels over the pixels of a narrower picture, size = (width, height)."""
    rows, columns = colour.shape[:2]
    times = times_wider((columns, rows), size)
    return colour.reshape(size[1], times, size[0], times, -1).mean(axis=(1, 3), dtype=np.float64)


def of_samples(info, samples):
    info.samples_per_pixel = samples
    return info


def narrow_sequence(wide, geometry, out):
    """Frames of `geometry` (a render with as few samples as there can be) with the colours of those of `wide`; `out` appears whole."""
    def frames():
        for full, thin in zip(es.Sequence(wide, "colour"), es.Sequence(geometry), strict=True):
            size = thin.info.camera.size
            samples = full.info.samples_per_pixel * times_wider(full.info.camera.size, size) ** 2
            yield of_samples(thin.info, samples), narrowed(full["colour"], size), thin

    make_sequence(out, frames())


def make_sequence(out, frames):
    aside = out.with_name(out.name + ".unfinished")
    shutil.rmtree(aside, ignore_errors=True)
    with es.SequenceWriter(aside) as writer:
        for info, colour, frame in frames:
            planes = {**frame.planes, "colour": colour.astype(np.float32)}
            writer.write(es.Frame(info, planes))
    shutil.rmtree(out, ignore_errors=True)
    aside.rename(out)


def made_once(out, inputs, make, by=""):
    """Calls make() unless `out` was made of these inputs as they are, and by this: a note beside it says so."""
    note = out.with_name(out.name + ".made-of")
    text = "".join(f"{path} {newest(path)}\n" for path in inputs) + by
    if out.exists() and note.exists() and note.read_text() == text:
        return
    make()
    write_whole(note, text)


def newest(folder):
    return max(file.stat().st_mtime_ns for file in folder.iterdir())
