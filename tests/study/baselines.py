"""What a system's milliseconds are put beside, on the same machine in the same run: FFmpeg's v360 turning the same sphere to the same views, and a copy of
the two views' bytes."""

import math
import statistics
import subprocess
import time

import numpy as np
from presets import focal_length_px
from steps import Failed

LOOPS = 40
"""Of the stream, so that starting FFmpeg does not count."""
RUNS = 3


def ffmpeg_s(stream, *filters):
    command = ["ffmpeg", "-hide_banner", "-loglevel", "error", "-stream_loop", str(LOOPS - 1), "-i", str(stream), "-map", "0:v:0", *filters, "-f", "null", "-"]
    began = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"ffmpeg: exit {done.returncode}: {done.stderr.strip()}")
    return time.monotonic() - began


def v360_flat(size, fov_deg):
    """FFmpeg's filter from a sphere to a view of `size`, `fov_deg` across."""
    width, height = size
    vertical_deg = math.degrees(2 * math.atan(height / 2 / focal_length_px(size, fov_deg)))
    return f"v360=e:flat:interp=linear:h_fov={fov_deg:.6g}:v_fov={vertical_deg:.6f}:w={width}:h={height}"


def v360_ms(stream, frames, size, fov_deg):
    """A frame, both eyes; decoding, which is timed alone too, left out."""
    turn = v360_flat(size, fov_deg)
    filters = ["-filter_complex", f"[0:v:0]split[a][b];[a]{turn}[left];[b]{turn}[right];[left][right]hstack"]
    each = [ffmpeg_s(stream, *filters) - ffmpeg_s(stream, "-vf", "null") for _ in range(RUNS)]
    return 1000 * statistics.median(each) / (LOOPS * frames)


def copy_ms(size):
    """Of both eyes, 4 bytes a pixel, from memory to memory."""
    source = np.ones((2, size[1], size[0], 4), np.uint8)
    target = np.empty_like(source)
    times = []
    for _ in range(200):
        began = time.perf_counter()
        np.copyto(target, source)
        times.append(time.perf_counter() - began)
    return 1000 * statistics.median(times)
