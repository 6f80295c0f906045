"""Narrower spheres, and less noisy ones, of those that were rendered.

A box filter weighs all samples of a pixel alike, whichever render they come from. So the mean over the area of a narrower sphere's pixel is what rendering
it with the samples of all the wide pixels below it gives, up to where the samples happened to fall; and renders of several seeds, weighted by their
samples, make one of them all. Geometry is not filtered: it comes from a render of the narrow sphere's own pixel centres.
"""

import math
import shutil

import equistream as es
import numpy as np
from scipy.sparse import csr_array

from steps import write_whole


def area_weights(wide, narrow):
    """narrow x wide, sparse: what share of each narrow pixel each wide one covers, along one axis."""
    edges = np.arange(narrow + 1) * (wide / narrow)
    pixels = np.arange(wide)
    overlap = np.minimum(edges[1:, None], pixels + 1) - np.maximum(edges[:-1, None], pixels)
    return csr_array(np.clip(overlap, 0, None) * (narrow / wide))


def narrowed(colour, size):
    """The mean of rows x columns x channels over the pixels of a narrower picture, size = (width, height)."""
    rows, columns = colour.shape[:2]
    width, height = size
    if width > columns or height > rows:
        raise ValueError(f"narrowed: expected at most {columns}x{rows}, found {width}x{height}")
    if columns % width == 0 and rows % height == 0:
        return colour.reshape(height, rows // height, width, columns // width, -1).mean(axis=(1, 3), dtype=np.float64)
    down = (area_weights(rows, height) @ colour.astype(np.float64).reshape(rows, -1)).reshape(height, columns, -1)
    across = area_weights(columns, width)
    return np.stack([(across @ down[:, :, channel].T).T for channel in range(down.shape[2])], axis=-1)


def samples_of(wide_samples, wide_size, size):
    """A pixel, rounded down: what a narrowed picture says of itself."""
    return math.floor(wide_samples * (wide_size[0] * wide_size[1]) / (size[0] * size[1]))


def of_samples(info, samples):
    info.samples_per_pixel = samples
    return info


def narrow_sequence(wide, geometry, out):
    """Frames of `geometry` (a render with as few samples as there can be) with the colours of those of `wide`; `out` appears whole."""
    make_sequence(out, ((of_samples(thin.info, samples_of(full.info.samples_per_pixel, full.info.camera.size, thin.info.camera.size)),
                         narrowed(full["colour"], thin.info.camera.size), thin)
                        for full, thin in zip(es.Sequence(wide, "colour"), es.Sequence(geometry), strict=True)))


def merge_sequences(folders, out):
    """The same frames of several seeds as one of all their samples; all but colours is the first one's."""
    def frames():
        for same in zip(*(es.Sequence(folder) for folder in folders), strict=True):
            samples = [frame.info.samples_per_pixel for frame in same]
            colour = sum(frame["colour"].astype(np.float64) * n for frame, n in zip(same, samples)) / sum(samples)
            yield of_samples(same[0].info, sum(samples)), colour, same[0]

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


def made_once(out, inputs, make):
    """Calls make() unless `out` was made of these inputs as they are: a note beside it says so."""
    note = out.with_name(out.name + ".made-of")
    text = "".join(f"{path} {newest(path)}\n" for path in inputs)
    if out.exists() and note.exists() and note.read_text() == text:
        return
    make()
    write_whole(note, text)


def newest(folder):
    return max(file.stat().st_mtime_ns for file in folder.iterdir())
