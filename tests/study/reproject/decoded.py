"""Pictures as a client has them after a stream: the program encodes, the package decodes."""

import pathlib
import subprocess
import tempfile

import equistream as es
import numpy as np

LEAST_SIDE = 64
# `--depth auto` holds depth to a tenth of the colour's bits, which spheres of full size reach with w12 at CRF 0 to 9 (depth_codes.md). A
# sphere of a tenth of that size spends the tenth on headers: it gets the quality, not the bits.
DEPTH = ("--depth", "w12", "--depth-crf", 6, "--depth-scale", 1)


def padded(plane):
    """To sides that streams allow, by its last row and column."""
    more = [(0, max(LEAST_SIDE, side + side % 2) - side) for side in plane.shape[:2]]
    return np.pad(plane, more + [(0, 0)] * (plane.ndim - 2), mode="edge")


def write(folder, frames):
    with es.SequenceWriter(folder / frames[0].info.eye) as writer:
        for index, frame in enumerate(frames):
            colour, depth = padded(frame["colour"][:, :, :3]), padded(frame["depth"])
            # Codecs do not know what camera it was; a flat one may have any size.
            camera = es.PerspectiveCamera(depth.shape[1], depth.shape[0], 1.0)
            info = es.frame_info(camera, like=frame.info, index=index, head_radius_m=frames[0].info.head_radius_m, seed=frames[0].info.seed)
            writer.write(es.Frame(info, {"colour": np.dstack([colour, np.ones_like(depth)]), "depth": depth}))


def decoded(program, frames, which, crf):
    """Colour, and depth from its track, of one of these frames after all of them went through one stream."""
    with tempfile.TemporaryDirectory() as work:
        folder, stream = pathlib.Path(work) / "frames", pathlib.Path(work) / "stream.mkv"
        write(folder, frames)
        words = ["encode", folder, "--out", stream, "--crf", crf, *DEPTH, "--progress", "none"]
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"equistream {' '.join(map(str, words))}: exit {done.returncode}: {done.stderr.strip()}")
        found = next(es.open_feed(stream, depth=True, first_frame=which)).main
    height, width = frames[which]["depth"].shape
    info = es.frame_info(frames[which].info.camera, like=found.info)
    return es.FeedPicture(info, np.ascontiguousarray(found.rgb[:height, :width]), np.ascontiguousarray(found.depth_m[:height, :width]))
