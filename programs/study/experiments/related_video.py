"""Pictures to H.264 and back by FFmpeg, for systems that are not ours.

Pictures are FOLDER/frame.NNNN.png, the preset's frames; names are relative to the work folder, so that commands do not depend on the machine. Bytes are those
of a bare stream without x264's own words about itself; one thread, so that they are the same everywhere.
"""

import pathlib
import subprocess

import equistream as es
import numpy as np
from drawing import rgb
from found import together_psnr
from PIL import Image
from presets import SEEDS
from steps import Failed

X264 = ("-c:v", "libx264", "-preset", "medium", "-g", "30", "-threads", "1", "-bsf:v", "filter_units=remove_types=6")
TO_YUV = "scale=out_color_matrix=bt709:flags=bicubic+accurate_rnd+full_chroma_int,format=yuv420p"
TO_RGB = "scale=in_color_matrix=bt709:flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp,format=gbrp"


def ffmpeg(work, *words):
    """Its command, as records have it."""
    command = ["ffmpeg", *(str(word) for word in words)]
    done = subprocess.run(["ffmpeg", "-hide_banner", "-loglevel", "error", "-y", *command[1:]], cwd=work.folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{' '.join(command)}: exit {done.returncode}: {done.stderr.strip()}")
    return " ".join(command)


def file_of(work, folder, index):
    return work.folder / folder / f"frame.{index:04}.png"


def indices(work):
    return range(work.first, work.last + 1)


def write(work, folder, index, picture):
    """8 bits a channel, rounded and clipped."""
    file = file_of(work, folder, index)
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.clip(np.rint(picture), 0, 255).astype(np.uint8)).save(file, compress_level=1)


def display(frame):
    return es.to_display(frame["colour"], frame.info.exposure)


def sequence(work, folder, *planes):
    """Of a render: each of the preset's frames."""
    for index in indices(work):
        yield es.read_frame(work.folder / folder / f"frame.{index:04}.exr", *planes)


def shown(work, folder, out):
    """A render as the display shows it, written to `out`."""
    for frame in sequence(work, folder, "colour"):
        write(work, out, frame.info.index, display(frame))
    return out


def coded(work, pictures, crf, out, *options):
    """Writes what comes back of a stream to `out`: bytes a frame, and the command."""
    stream = pathlib.PurePosixPath("streams") / f"{pathlib.PurePosixPath(out).name}.h264"
    (work.folder / stream).parent.mkdir(exist_ok=True)
    (work.folder / out).mkdir(parents=True, exist_ok=True)
    command = ffmpeg(work, "-framerate", 30, "-start_number", work.first, "-i", f"{pictures}/frame.%04d.png", "-vf", TO_YUV, *X264, "-crf", crf, *options, stream)
    ffmpeg(work, "-i", stream, "-vf", TO_RGB, "-fps_mode", "passthrough", "-start_number", work.first, f"{out}/frame.%04d.png")
    return (work.folder / stream).stat().st_size / work.preset.frames, command


def mean_bytes(runs):
    """Of coded() of every seed."""
    return float(np.mean([count for count, _ in runs]))


def psnr(work, folder, other):
    squares = [np.mean((rgb(file_of(work, folder, i)).astype(np.float64) - rgb(file_of(work, other, i))) ** 2) for i in indices(work)]
    return together_psnr(squares)


def counted(work):
    return {"frames": work.preset.frames, "seeds": len(SEEDS)}
