"""What the streams weigh: the paper's Table 2 and Figure 5, of pictures with as little noise as the preset affords, and world-locked against path-locked.
What coding alone loses of a sphere is its WS-PSNR.

Noise costs bytes, so all seeds' renders and a further one's are made one (narrowed.merge_sequences) before coding.
"""

import itertools

import render_list
from presets import SEEDS

from .related_video import TO_RGB, ffmpeg
from .systems import Coding


PERSPECTIVE = "perspective"


def of_all_seeds(work, name, spec, samples, wanted):
    """One sequence of `wanted` samples a pixel: `spec(seed, samples, name)` renders, with `samples` for each of SEEDS, and what is missing."""
    parts = [work.render(spec(seed, samples, None)) for seed in SEEDS]
    if further := render_list.further_samples(wanted, samples):
        parts.append(work.render(spec(render_list.BYTES_SEED, further, f"{name}-{render_list.BYTES_SEED}")))
    return work.merged(parts, f"{name}-all")


def weighed(work, source, label, samples):
    """Bytes a frame of each track at each codec and quality."""
    found = []
    for codec, crf in itertools.product(work.preset.codecs, work.preset.crfs):
        coding = Coding(codec, crf)
        fill = ["--fill", "small", "--fill-crf", crf] if (work.folder / source / "small").exists() else ["--fill", "none"]
        stream, encoded = work.encode(f"{label}-{coding.name}", source, "--codec", codec, "--crf", crf, *fill)
        frames = work.preset.frames
        found.append({"source": label, "codec": codec, "crf": crf, "samples": samples, "n": {"frames": frames},
                      "bytes_a_frame": {track: count / frames for track, count in encoded["bytes"].items()}, "command": encoded["command"],
                      "ws_psnr_db": sphere_psnr(work, f"{label}-{coding.name}", stream, source) if label != PERSPECTIVE else None})
    return found


def sphere_psnr(work, label, stream, source):
    """WS-PSNR of the spheres that FFmpeg decodes, beside those that were coded."""
    out = f"decoded/{label}"
    (work.folder / out).mkdir(parents=True, exist_ok=True)
    ffmpeg(work, "-i", stream, "-map", "0:v:0", "-vf", TO_RGB, "-fps_mode", "passthrough", "-start_number", work.first, f"{out}/frame.%04d.png")
    (eye,) = work.compare(f"sphere-{label}", out, f"{source}/left", "--metrics", "ws-psnr")["eyes"].values()
    return eye["ws_psnr_db"]


def low_noise(work):
    """The left eye's view and the wide sphere there, each of all the samples that bytes are asked of."""
    preset = work.preset
    eyes = of_all_seeds(work, PERSPECTIVE, lambda *which: render_list.perspective(preset, *which), preset.eye_samples, preset.eye_bytes_samples)
    wide = of_all_seeds(work, "sphere-left", lambda *which: render_list.wide_sphere(preset, "left", *which), preset.sphere_samples,
                        preset.bytes_samples)
    return eyes, wide


def run(work):
    preset = work.preset
    eyes, wide = low_noise(work)
    rows = weighed(work, eyes, PERSPECTIVE, preset.eye_bytes_samples)
    for width in preset.system_widths:
        sphere = wide if width == preset.sphere_width else work.narrowed(wide, width, SEEDS[0])
        rows += weighed(work, sphere, f"sphere-left-{width}", preset.bytes_samples * (preset.sphere_width / width) ** 2)
    return {"rows": rows, "locks": locks(work)}


def locks(work):
    """The same sphere, world-locked and turning with its path, of one seed."""
    found = []
    for lock in ("world", "path"):
        spec = render_list.locked_sphere(work.preset, lock)
        found += [{**row, "lock": lock} for row in weighed(work, work.render(spec), spec.name, spec.samples)]
    return found
