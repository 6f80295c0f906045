#!/usr/bin/env python3
"""How much of a sphere's other side must be denoised with each of its ends (docs/results/denoise.json, a table of denoise.md).

    seam.py --bin build/release/bin --work FOLDER          PYTHONPATH=build/release/package
    seam.py --page                                          the table alone
"""

import argparse
import json
import pathlib
import sys

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from denoise import Programs  # noqa: E402
from kept import result_text  # noqa: E402
from pages import place, table  # noqa: E402
from steps import machine, versions, write_whole  # noqa: E402

SCENES, SIZE, SAMPLES, QUALITIES = ("kitchen", "voxel-city"), "480x240", 4, ("fast", "balanced", "high")
MARGINS = (128, 96, 64, 32, 0)
NEAR, POLE = 32, 32
"""Columns on either side of the seam that are judged; rows beyond each pole, as the plugin takes."""


def wrapped(picture, margin):
    """With so many columns of its other side at both ends, and rows over the poles and down the other side."""
    height, width, _ = picture.shape
    rows, columns = np.arange(-POLE, height + POLE), np.arange(-margin, width + margin)
    inside = np.where(rows < 0, -1 - rows, np.where(rows >= height, 2 * height - 1 - rows, rows))
    turned = np.where(inside == rows, 0, width // 2)
    return np.ascontiguousarray(picture[inside[:, None], (columns[None] + turned[:, None]) % width], np.float32)


def denoised(device, pictures, margin, quality, exposure):
    """The sphere."""
    import pyoidn
    images = [wrapped(picture, margin) for picture in pictures]
    height, width, _ = pictures[0].shape
    with pyoidn.Filter(device, pyoidn.OIDN_FILTER_TYPE_RT) as filter:
        for name, image in zip((pyoidn.OIDN_IMAGE_COLOR, pyoidn.OIDN_IMAGE_ALBEDO, pyoidn.OIDN_IMAGE_NORMAL), images):
            filter.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
        out = np.empty_like(images[0])
        filter.set_image(pyoidn.OIDN_IMAGE_OUTPUT, out, pyoidn.OIDN_FORMAT_FLOAT3)
        filter.set_quality(getattr(pyoidn, f"OIDN_QUALITY_{quality.upper()}"))
        filter.set_bool("hdr", True)
        filter.set_bool("cleanAux", True)
        filter.set_float("inputScale", float(exposure))
        filter.commit()
        filter.execute()
    return out[POLE:POLE + height, margin:margin + width]


def measured(programs, device, scene, work):
    import equistream as es
    if not (work / "centre/frame.0000.exr").exists():
        programs.run("render", scene, "--frames", "0", "--size", SIZE, "--spp", SAMPLES, "--aovs", "guides", "--out", work)
    frame = es.read_frame(work / "centre/frame.0000.exr")
    pictures = [frame["colour"][..., :3], frame["guide_albedo"], frame["guide_normal"]]
    shown = lambda colour: es.to_display(np.ascontiguousarray(colour), frame.info.exposure).astype(float)  # noqa: E731
    found = []
    for quality in QUALITIES:
        whole = shown(denoised(device, pictures, pictures[0].shape[1] // 2, quality, frame.info.exposure))
        for margin in MARGINS:
            off = shown(denoised(device, pictures, margin, quality, frame.info.exposure)) - whole
            near = np.concatenate([off[:, :NEAR], off[:, -NEAR:]], 1)
            found.append({"quality": quality, "columns": margin, "rms": float(np.sqrt(np.mean(near ** 2)))})
            print(scene.stem, found[-1], flush=True)
    return found


def rows(scenes):
    for margin in MARGINS:
        of = {(name, entry["quality"]): entry for name, entries in scenes.items() for entry in entries if entry["columns"] == margin}
        width, height = map(int, SIZE.split("x"))
        pixels = (width + 2 * margin) * (height + 2 * POLE) / (width * height)
        yield [str(margin), f"{pixels:.2f}", *(f"{of[name, quality]['rms']:.2f}" for name in scenes for quality in QUALITIES)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, default=REPOSITORY / "build/release/bin")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("seam-work"))
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/denoise.json")
    options = parser.parse_args()
    kept = json.loads(options.out.read_text())
    if not options.page:
        import pyoidn
        programs = Programs(options.bin)
        with pyoidn.Device() as device:
            device.commit()
            scenes = {name: measured(programs, device, REPOSITORY / f"scenes/descriptions/{name}.json", options.work / name) for name in SCENES}
        kept["seam"] = {"scenes": scenes, "versions": versions(options.bin / "equistream", REPOSITORY), "machine": machine()}
        write_whole(options.out, result_text(kept))
    head = ["columns at each end", "pixels, of the sphere's", *(f"{name}, {quality}" for name in SCENES for quality in QUALITIES)]
    page = options.out.with_suffix(".md")
    write_whole(page, place(page.read_text(), "seam", "all", table(head, rows(kept["seam"]["scenes"]), 0)))


if __name__ == "__main__":
    main()
