"""The second eye as what its reprojection lacks (difference streams, Levoy 1995), and what better motion vectors could save the encoder (Wallach et al. 1994)."""

import dataclasses
import hashlib
import subprocess

import numpy as np
from drawing import rgb
from presets import SEEDS
from render_list import EYES

from .related_video import coded, counted, ffmpeg, file_of, indices, mean_bytes, psnr, shown, write
from .systems import SYSTEMS, Coding, Player

# As the paper's first system, but that nothing comes along for gaps: the difference shows what is there.
REPROJECTED = dataclasses.replace(next(system for system in SYSTEMS if system.name == "perspective"), name="difference",
                                  play=("--method", "eye-depth", "--fill", "pushpull"), small=False)
DIFFERENCE_CRFS = -6
"""Beside the eye's: half the steps, because a difference is sent at half its size."""
SEARCHES = {"dia 4": "me=dia:merange=4", "hex 16": "me=hex:merange=16", "umh 64": "me=umh:merange=64", "esa 64": "me=esa:merange=64"}


# -- difference streams

def difference_code(true, shown_instead):
    """8 bits for -255 to 255, halved."""
    return np.clip(np.rint((true.astype(np.float64) - shown_instead) / 2) + 128, 0, 255).astype(np.uint8)


def with_difference(shown_instead, code):
    return np.clip(shown_instead.astype(np.float64) + 2 * (code.astype(np.float64) - 128), 0, 255)


def reprojected_right(work, crf):
    """Of each seed's left view after coding, before any difference: a folder of views, and the command that played it."""
    player, coding = Player(work), Coding("h264", crf)
    for seed in SEEDS:
        views, said = player.play(REPROJECTED, None, coding, seed)
        yield views, said[0]["command"]


def views_of(label):
    return [f"views/{label}-{seed}" for seed in SEEDS]


def direct_point(work, crf):
    label = f"related-right-crf{crf:g}"
    runs = []
    for seed in SEEDS:
        runs.append(coded(work, f"related/right-{seed}", crf, f"related/{label}-{seed}"))
        as_eye(work, f"related/{label}-{seed}", f"views/{label}-{seed}")
    return point(work, "direct", crf, label, views_of(label), runs)


def as_eye(work, pictures, view):
    """A folder of pictures as a view's right eye."""
    for index in indices(work):
        write(work, f"{view}/right", index, rgb(file_of(work, pictures, index)))


def difference_point(work, crf, reprojected):
    """The left view at `crf`, and the difference at as much finer a quality as it is sent smaller."""
    label = f"related-difference-crf{crf:g}"
    runs = []
    for seed, views in zip(SEEDS, reprojected):
        eye, codes, decoded = f"{views}/right", f"related/{label}-{seed}-codes", f"related/{label}-{seed}"
        for index in indices(work):
            write(work, codes, index, difference_code(rgb(file_of(work, f"related/right-{seed}", index)), rgb(file_of(work, eye, index))))
        runs.append(coded(work, codes, crf + DIFFERENCE_CRFS, decoded))
        for index in indices(work):
            write(work, f"views/{label}-{seed}/right", index, with_difference(rgb(file_of(work, eye, index)), rgb(file_of(work, decoded, index))))
    return point(work, "difference", crf, label, views_of(label), runs)


def together_point(work, crf):
    """Both eyes' views in turns in one stream, so that each may be foretold from the other; bytes are those beyond the left eye's stream alone."""
    label = f"related-together-crf{crf:g}"
    runs = []
    for seed in SEEDS:
        both, decoded = f"related/both-{seed}", f"related/{label}-{seed}"
        for index in indices(work):
            for place, eye in enumerate(EYES):
                write(work, both, in_turns(work, index, place), rgb(file_of(work, f"related/{eye}-{seed}", index)))
        whole, command = coded(work, both, crf, decoded)
        alone, _ = coded(work, f"related/left-{seed}", crf, f"related/left-crf{crf:g}-{seed}")
        for index in indices(work):
            write(work, f"views/{label}-{seed}/right", index, rgb(file_of(work, decoded, in_turns(work, index, 1))))
        runs.append((whole - alone, command))
    return point(work, "together", crf, label, views_of(label), runs)


def in_turns(work, index, place):
    return work.first + 2 * (index - work.first) + place


def point(work, kind, crf, label, views, runs):
    return {"kind": kind, "crf": crf, "bytes_a_frame": mean_bytes(runs), **work.scored(label, views, eyes="right"),
            "samples": work.preset.eye_samples, "n": counted(work), "command": runs[0][1]}


def difference_points(work, crfs):
    """Bytes of the second eye alone, and its error: coded itself, in one stream with the first, as a difference, and without one."""
    for seed in SEEDS:
        for eye, rendered in zip(EYES, work.pair(seed)):
            shown(work, rendered, f"related/{eye}-{seed}")
    points = []
    for crf in crfs:
        views, commands = zip(*reprojected_right(work, crf))
        points += [direct_point(work, crf), together_point(work, crf), difference_point(work, crf, views),
                   point(work, "reprojected", crf, f"related-reprojected-crf{crf:g}", views, [(0, commands[0])])]
    return points


# -- motion vectors

def motion_sources(work):
    """The left eye's view, which moves, and the sphere, which does not turn with the head."""
    width = work.preset.half_width
    return {"left view": shown(work, f"{work.perspective(SEEDS[0])}/left", "related/left-view"),
            f"sphere, {width} columns": shown(work, f"{work.sphere('left', width, SEEDS[0])}/left", f"related/sphere-{width}")}


def search_points(work):
    """Bytes and PSNR beside what was coded, at one CRF, by how hard the encoder looks for motion."""
    crf, points = work.preset.crfs[0], []
    for title, source in motion_sources(work).items():
        for name in SEARCHES if work.preset.every_value else list(SEARCHES)[1::2]:
            out = f"related/search-{source.rsplit('/', 1)[1]}-{name.replace(' ', '')}"
            count, command = coded(work, source, crf, out, "-x264-params", SEARCHES[name])
            points.append({"source": title, "search": name, "crf": crf, "bytes_a_frame": count, "psnr_db": psnr(work, out, source), "n": {"frames": work.preset.frames},
                           "command": command})
    return points


def digest(work, stream, *options, source="streams/vectors.h264", before=()):
    command = ffmpeg(work, *before, "-i", source, *options, stream)
    return hashlib.sha256((work.folder / stream).read_bytes()).hexdigest(), command


def let_through(work):
    """Whether libx264 by libavcodec heeds a decoded frame's motion vectors (AV_FRAME_DATA_MOTION_VECTORS), and, beside them, regions of interest: does the
    stream differ where frames bring them along? That vectors are there is seen where they are drawn."""
    coded(work, "related/left-view", work.preset.crfs[0], "related/vectors")
    again, vectors = ("-c:v", "libx264", "-crf", work.preset.crfs[0], "-threads", "1"), ("-flags2", "+export_mvs")
    plain, _ = digest(work, "streams/vectors-none.h264", *again)
    with_vectors, command = digest(work, "streams/vectors-along.h264", *again, before=vectors)
    with_regions, _ = digest(work, "streams/regions-along.h264", "-vf", "addroi=w=iw/2:h=ih:qoffset=-0.5", *again)
    drawn = [digest(work, "streams/drawn.yuv", "-vf", "codecview=mv=pf+bf+bb", before=before)[0] for before in ((), vectors)]
    told = subprocess.run(["ffmpeg", "-hide_banner", "-h", "encoder=libx264"], capture_output=True, text=True).stdout
    return {"frames_bring_vectors": drawn[0] != drawn[1], "vectors_change_the_stream": with_vectors != plain, "regions_change_the_stream": with_regions != plain,
            "options_about_motion": [line.split()[0] for line in told.splitlines() if line.strip().startswith("-") and ("motion" in line.lower() or " mv" in line.lower())],
            "n": {"frames": work.preset.frames, "seeds": 1}, "command": command}
