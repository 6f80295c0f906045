#!/usr/bin/env python3
"""Judges the confidence map as it is shipped by path-traced pairs: noisy, denoised and coded; loss is measured by references or by coding alone.

    PYTHONPATH=build/release/package confidence.py --bin build/release/bin --work FOLDER [--out FILE]

FOLDER is what reliability_pairs.py --path-traced filled. Every eye of every shot is reprojected from a clean source of 512 samples, from one
of 8 samples, and from that denoised; the last two also as a client has them from a stream. Gaps are filled from the other eye's view, by
push-pull and by spreading, or from a small view. Pixels are left out where the truth's noise may be more than a quarter of the tolerance. *Told by
references*: how visibly off the source is was measured where its pixels have 512 samples, as `encode` does; here that is everywhere, and over all
shots of a scene. *By coding*: the encoder compared its pictures with what it was given.
"""

import argparse
import concurrent.futures
import functools
import pathlib
import sys
import time
from dataclasses import replace

import equistream as es
import numpy as np
from equistream.reprojection import ORIGINS, RELIABILITY_TOLERANCE

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from reliability_model import REPOSITORY, calibration  # noqa: E402
from reliability_pairs import LIGHTS, RUN_FRAMES, RUN_SOURCE, SMALLER, STREAMED_COARSER  # noqa: E402
from reliability_samples import CRFS, NO_STREAM, NOISE_SHARE, SMALL_CRF_MORE, STREAMED, Chain, both_runs, coding_step, decoded, noise_of, rounded, smaller  # noqa: E402
from kept import result_text  # noqa: E402
from steps import provenance, run_as_program, write_whole  # noqa: E402

RESULTS = REPOSITORY / "docs/results/reproject/confidence.json"
CLEAN = "clean"
# How a source came to be: its light and its CRF.
KINDS = ((CLEAN, NO_STREAM), *((light, crf) for light in LIGHTS for crf in (NO_STREAM, *CRFS)))
REFERENCES, CODING = "by references", "by coding"
SHARED_CHAINS = (Chain("eye-depth", "small,pushpull", 0, only_filled=True), Chain("eye-depth", "spread", 6))
UNCODED_CHAINS = (Chain("eye-depth", "pushpull", 0), Chain("eye-depth", "earlier", 0, only_filled=True), Chain("eye-depth", "earlier,spread", 5), *SHARED_CHAINS)
CODED_CHAINS = (Chain("eye-depth", "earlier,pushpull", 0), Chain("mesh", "pushpull", STREAMED), *SHARED_CHAINS)
LAST_FRAMES = {"eyes-0": 1, "eyes-1": 1, "source-0": 0, "source-1": 0, **{f"small-{light}": 1 for light in LIGHTS},
               **{f"{name}-{light}-{factor}": last for name, last in (("eyes", 1), ("run", RUN_FRAMES - 1)) for light in LIGHTS for factor in STREAMED_COARSER}}


def read(folder, name, index):
    return es.read_frame(next(folder.glob(f"{name}/*/frame.{index:04d}.exr")))


def mean_of(frames, plane="colour"):
    return np.mean([frame[plane][:, :, :3] for frame in frames], axis=0)


def shown(colour, exposure):
    return es.DisplayTransform().to_display(np.ascontiguousarray(colour[:, :, :3], np.float32), exposure)


def shown_255(frames, plane="colour"):
    """The mean of frames, as it is shown."""
    return 255 * shown(mean_of(frames, plane), frames[0].info.exposure).astype(float)


def is_quiet(frames, plane):
    """Where the noise of two runs' mean is far below the tolerance."""
    return noise_of(frames, frames[0].info.exposure, plane) <= NOISE_SHARE * RELIABILITY_TOLERANCE


def truth_of(frames):
    """What an eye should see, and where that is known: as rendered where there is hardly any noise, else denoised where that helps."""
    as_rendered = is_quiet(frames, "raw")
    return np.where(as_rendered[..., None], shown_255(frames, "raw"), shown_255(frames)), as_rendered | is_quiet(frames, "colour")


def coarser(frames, factor):
    """The mean of two frames, as if rendered so much less densely."""
    first = frames[0]
    camera = first.info.camera
    size = (camera.width // factor, camera.height // factor)
    less = (es.PerspectiveCamera(*size, camera.fov_x_rad) if isinstance(camera, es.PerspectiveCamera)
            else es.EquirectCamera(*size, camera.longitudes, camera.latitudes))
    # The middle one of an odd number of samples lies at the coarser pixel's centre; of an even number the nearest one does nearly.
    planes = {name: np.ascontiguousarray(first[name][factor // 2::factor, factor // 2::factor]) for name in ("depth", "specular")}
    return es.Frame(es.frame_info(less, like=first.info, head_radius_m=first.info.head_radius_m), {"colour": smaller(mean_of(frames), factor), **planes})


def for_eye(frame, eye):
    """For the leaning eye a source that was not rendered for it: its head box has no lean."""
    info = frame.info
    return es.Frame(es.frame_info(info.camera, like=info, head_radius_m=info.head_radius_m if eye == 0 else 0.0), frame.planes)


class Shot:
    """Two eyes, and their source as it is streamed."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program
        self.eyes = [both_runs(folder, "eyes", index)[0] for index in (0, 1)]
        self.sources = both_runs(folder, "source", 0)[0]
        self.shown_as = {}

    def rendered(self, light, factor, eye):
        """The source, the other eye's view at its density, and one a quarter as dense as the eyes: the paper's small stream."""
        if light == CLEAN:
            other = self.eyes[1 - eye]
            return for_eye(coarser(self.sources, factor), eye), coarser(other, factor), coarser(other, SMALLER)
        return (for_eye(read(self.folder, f"run-{light}-{factor}", RUN_SOURCE), eye), read(self.folder, f"eyes-{light}-{factor}", 1 - eye),
                read(self.folder, f"small-{light}", 1 - eye))

    def received(self, kind, factor, eye):
        """What is left of it after coding."""
        light, crf = kind
        views = self.rendered(light, factor, eye)
        if crf == NO_STREAM:
            return views
        if (kind, factor, eye) not in self.shown_as:
            source, other, small = views
            run = [for_eye(read(self.folder, f"run-{light}-{factor}", index), eye) for index in range(RUN_FRAMES)]
            main = decoded(self.program, run, RUN_SOURCE, crf)
            main.specular = source["specular"]  # as if no codec had been there
            self.shown_as[kind, factor, eye] = main, decoded(self.program, [other], 0, crf), decoded(self.program, [small], 0, crf + SMALL_CRF_MORE)
        return self.shown_as[kind, factor, eye]

    def add_losses(self, meters, kind, factor):
        exposure = self.sources[0].info.exposure
        picture, reference = (es.quantise_8bit(shown(colour, exposure)) for colour in
                              (self.rendered(kind[0], factor, 0)[0]["colour"], smaller(mean_of(self.sources, "raw"), factor)))
        seen = picture if kind[1] == NO_STREAM else self.received(kind, factor, 0)[0].rgb
        for meter in meters.values():
            meter.add(picture, seen)
        meters[REFERENCES].add_reference(seen, np.dstack([reference, np.full(reference.shape[:2], 255, np.uint8)]))

    def judged(self, kind, factor, losses):
        """Of both eyes and all chains: (good, uncovered, whether the truth is known, a prediction for each way to measure loss) of each pixel with colour."""
        for eye, frames in enumerate(self.eyes):
            info = frames[0].info
            truth, quiet = truth_of(frames)
            rendered, received = self.rendered(kind[0], factor, eye), self.received(kind, factor, eye)
            box_m = rendered[0].info.box_radius_m
            for chain in CODED_CHAINS if kind[1] != NO_STREAM else UNCODED_CHAINS:
                step = coding_step(rendered[0]["depth"], box_m, chain.depth_bits)

                def depth(camera, pose):
                    for frame in (*rendered, frames[0]):
                        if frame.info.camera == camera and frame.info.camera_pose == pose:
                            return rounded(frame["depth"], box_m, step)
                    raise AssertionError("depth of an unknown view")

                by_track = chain.depth_bits is STREAMED
                main, earlier, small = received
                if kind[1] != NO_STREAM and not by_track:
                    main, earlier = replace(main, depth_m=rendered[0]["depth"]), replace(earlier, depth_m=rendered[1]["depth"])
                engine = es.Reprojector(chain.method, fill=chain.fill, mirrors="surface")
                predicted = []
                for loss in losses.values():
                    for view in received:
                        view.info.visible_loss = loss
                    picture = engine(main, info.camera, info.camera_pose, depth=None if by_track else depth, reliability=True,
                                     small=small if "small" in chain.fill else None, earlier=[earlier] if "earlier" in chain.fill else (),
                                     depth_tolerance_w=None if by_track else step / 2)
                    predicted.append(picture.reliability / np.float32(255))
                from_source = picture.origin == ORIGINS.index("source")
                wanted = picture.origin != ORIGINS.index("gap")
                if chain.only_filled:
                    wanted &= ~from_source
                worst = np.abs(picture.rgb.astype(float) - truth).max(axis=2)
                yield (worst <= RELIABILITY_TOLERANCE)[wanted], ~from_source[wanted], quiet[wanted], np.stack([each[wanted] for each in predicted])


def finished(folder):
    return all(list(folder.glob(f"{name}/*/frame.{last:04d}.exr")) for name, last in LAST_FRAMES.items())


def off_references(shots):
    """How far the truth is from reference tiles, among the pixels that are used."""
    differences = []
    for frames in (frames for shot in shots for frames in shot.eyes):
        truth, quiet = truth_of(frames)
        known = quiet & (np.minimum(*(frame["reference"][:, :, 3] for frame in frames)) > 0)
        differences.append(np.abs(truth - shown_255(frames, "reference")).max(axis=2)[known])
    off = np.concatenate(differences)
    return {"pixels": len(off), "mean_255": round(float(off.mean()), 2) if len(off) else None}


def figures(predicted, good):
    found = calibration(predicted, good, np.ones(len(good)))
    del found["bins"]
    return {**found, "predicted": round(float(predicted.mean()), 4)}


def judged_scene(program, folder):
    shots = [Shot(shot, program) for shot in sorted(folder.glob("*-*")) if finished(shot)]
    if not shots:
        return None
    kinds, uncovered, left_out, counted = {}, [], 0, 0
    for kind in KINDS:
        parts = []
        for factor in STREAMED_COARSER:
            meters = {REFERENCES: es.VisibleLossMeter(), CODING: es.VisibleLossMeter()}
            if kind[0] != CLEAN:
                for shot in shots:
                    shot.add_losses(meters, kind, factor)
            parts += [part for shot in shots for part in shot.judged(kind, factor, {name: meter.loss() for name, meter in meters.items()})]
        good, is_uncovered, quiet, predicted = (np.concatenate(arrays, axis=-1) for arrays in zip(*parts))
        left_out, counted = left_out + int((~quiet).sum()), counted + len(quiet)
        name = kind[0] if kind[1] == NO_STREAM else f"{kind[0]}_{kind[1]}"
        kinds[name] = {telling: figures(told[quiet], good[quiet]) for telling, told in zip((REFERENCES, CODING), predicted)}
        uncovered.append((predicted[0][quiet & is_uncovered], good[quiet & is_uncovered]))
    return {"shots": len(shots), "left_out_for_noise": round(left_out / counted, 4), "truth_off_references": off_references(shots), "kinds": kinds,
            "uncovered": figures(*(np.concatenate(arrays) for arrays in zip(*uncovered)))}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder that reliability_pairs.py --path-traced filled")
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS, help="where the figures go")
    return parser.parse_args()


def main():
    options = arguments()
    folders, scenes = sorted(folder for folder in options.work.iterdir() if folder.is_dir()), {}
    began = time.monotonic()
    with concurrent.futures.ProcessPoolExecutor() as pool:
        for folder, found in zip(folders, pool.map(functools.partial(judged_scene, options.bin.resolve() / "equistream"), folders)):
            if found is not None:
                scenes[folder.name] = found
                print(f"{folder.name}: {found['shots']} shots, {time.monotonic() - began:.0f} s, points off: "
                      + ", ".join(f"{kind} {100 * told[REFERENCES]['expected_calibration_error']:.1f}" for kind, told in found["kinds"].items()), flush=True)
    write_whole(options.out, result_text({"command": "tests/study/reproject/confidence.py --bin BIN --work WORK", **provenance(options.bin.resolve(), REPOSITORY),
                                          "tolerance_255": RELIABILITY_TOLERANCE, "noise_share": NOISE_SHARE, "scenes": scenes}))
    print(options.out)


if __name__ == "__main__":
    run_as_program(main)
