"""What a system's milliseconds are put beside, on the same machine in the same run: FFmpeg's v360 turning the same sphere to the same views, and a copy of
the two views' bytes; and what ./bench prints, as a result with the machine and the version.
"""

import math
import statistics
import subprocess
import time

import numpy as np
from presets import focal_length_px
from steps import Failed, provenance

FEW_FRAMES, MANY_FRAMES = 100, 500
RUNS = 3


def ffmpeg_s(stream, frames, filters):
    """For so many times the stream's first frame, which is decoded once."""
    looped = f"[0:v:0]trim=end_frame=1,loop=loop={frames - 1}:size=1,{filters}"
    command = ["ffmpeg", "-hide_banner", "-loglevel", "error", "-i", str(stream), "-filter_complex", looped, "-f", "null", "-"]
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


def v360_ms(stream, size, fov_deg):
    """A frame, both eyes, without decoding and starting: by what more frames take longer."""
    turn = v360_flat(size, fov_deg)
    filters = f"split[a][b];[a]{turn}[left];[b]{turn}[right];[left][right]hstack"
    each = [ffmpeg_s(stream, MANY_FRAMES, filters) - ffmpeg_s(stream, FEW_FRAMES, filters) for _ in range(RUNS)]
    return 1000 * statistics.median(each) / (MANY_FRAMES - FEW_FRAMES)


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


def bench_result(programs, repository, figures_regex):
    """Every figure whose name matches, each beside its peers. To be run on a machine that does nothing else."""
    command = [programs.resolve() / "equistream_bench", f"--benchmark_filter={figures_regex}"]
    made = provenance(programs, repository)
    done = subprocess.run(command, cwd=repository, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise Failed(f"equistream_bench: exit {done.returncode}: {done.stderr.strip()}")
    figures = []
    for line in done.stdout.splitlines():
        name, value, unit, ratio, peer = line.split()
        figures.append({"name": name, unit: float(value), "ratio": None if ratio == "-" else float(ratio), "peer": peer})
    peers_alone = sorted({figure["name"] for figure in figures if "/" in figure["name"]})
    if peers_alone:
        raise Failed(f"equistream_bench: expected ours beside every peer, found alone: {', '.join(peers_alone)}")
    notes = [line[2:] for line in done.stderr.splitlines() if line.startswith("# ")]
    return {"command": f"./bench '{figures_regex}'", "notes": notes, "figures": figures, **made}
