"""Pixels that reliability is fitted to and judged by: risks from reprojected pairs, noisy, denoised or coded ones too, and whether the
true eye shows the same.
"""

import concurrent.futures
import functools
import pathlib
import subprocess
import tempfile
from dataclasses import replace

import equistream as es
import numpy as np
from equistream.reprojection import ORIGINS, RELIABILITY_TOLERANCE, RISK_GROUPS, RISKS
from reliability_pairs import BREAKERS, COARSER, DIRECT_LIGHT, PATH_TRACED, RUN_FRAMES, RUN_SOURCE, SMALLER, SOURCES
from scipy.ndimage import uniform_filter

LEAST_SIDE = 64
# `--depth auto` holds depth to a tenth of the colour's bits, which spheres of full size reach with w12 at CRF 0 to 9 (depth_codes.md). A
# sphere of a tenth of that size spends the tenth on headers: it gets the quality, not the bits.
STREAMED_DEPTH = ("--depth", "w12", "--depth-crf", 6, "--depth-scale", 1)


def padded(plane):
    """To sides that streams allow, by its last row and column."""
    more = [(0, max(LEAST_SIDE, side + side % 2) - side) for side in plane.shape[:2]]
    return np.pad(plane, more + [(0, 0)] * (plane.ndim - 2), mode="edge")


def write_frames(folder, frames):
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
        write_frames(folder, frames)
        words = ["encode", folder, "--out", stream, "--crf", crf, *STREAMED_DEPTH, "--progress", "none"]
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"equistream {' '.join(map(str, words))}: exit {done.returncode}: {done.stderr.strip()}")
        found = next(es.open_feed(stream, depth=True, first_frame=which)).main
    height, width = frames[which]["depth"].shape
    info = es.frame_info(frames[which].info.camera, like=found.info)
    return es.FeedPicture(info, np.ascontiguousarray(found.rgb[:height, :width]), np.ascontiguousarray(found.depth_m[:height, :width]))


MIRRORED, NO_GROUP, TEXTURE = RISK_GROUPS.index("mirrored"), 255, RISKS.index("texture")
NOISE_SHARE = 1 / 4

# Of colours that went through no codec; of depth that came with those that did.
NO_STREAM, STREAMED = -1, None
CRFS = (16, 24)
# How a source came to be: in direct light without noise, or path traced, as rendered or denoised; and its CRF.
KINDS = tuple((source, crf) for source in (DIRECT_LIGHT, *SOURCES) for crf in (NO_STREAM, *CRFS))


class Chain:
    """A method, a fill chain with what it fills from, and the bits of the depth's w (0: exact)."""

    def __init__(self, method, fill, depth_bits, only_filled=False):
        self.method, self.fill, self.depth_bits = method, fill, depth_bits
        self.only_filled = only_filled  # another chain has the same pixels of the source


SHARED_CHAINS = (Chain("eye-depth", "small,pushpull", 0, only_filled=True), Chain("eye-depth", "spread", 6), Chain("rotation", "none", 0))
# What `earlier` brings, the other eye's view with its depth, stands for patches and hidden layers too: all of them are looked up
# by depth, at the source's density, in a picture from elsewhere.
UNCODED_CHAINS = (Chain("eye-depth", "pushpull", 0), Chain("eye-depth", "earlier", 0, only_filled=True), Chain("eye-depth", "earlier,spread", 5),
                  Chain("eye-depth", "pushpull", 4), *SHARED_CHAINS)
# What play does with a scene beside the stream, with its depth track alone, and without depth.
CODED_CHAINS = (Chain("eye-depth", "earlier,pushpull", 0), Chain("mesh", "pushpull", STREAMED), *SHARED_CHAINS)
# `encode` codes the small view so much coarser than the source.
SMALL_CRF_MORE = 8


def smaller(image, factor):
    """Box filtered by a whole factor: what a coarser render of the same samples would be."""
    height, width = image.shape[0] // factor * factor, image.shape[1] // factor * factor
    return image[:height, :width].reshape(height // factor, factor, width // factor, factor, -1).mean(axis=(1, 3)).astype(np.float32)


def read(folder, name, index):
    return es.read_frame(next(folder.glob(f"{name}/*/frame.{index:04d}.exr")))


def both_runs(folder, name, index):
    return [read(folder, f"{name}-{run}", index) for run in (0, 1)]


def mean_of(frames, plane="colour"):
    return np.mean([frame[plane][:, :, :3] for frame in frames], axis=0)


def display(colour, exposure):
    return es.DisplayTransform().to_display(np.ascontiguousarray(colour[:, :, :3], np.float32), exposure)


def shown_255(frames, plane="colour"):
    """The mean of two runs, as it is shown."""
    return 255 * display(mean_of(frames, plane), frames[0].info.exposure).astype(float)


def noise_255(frames, plane):
    """Of the mean of two runs: standard deviation, over 5x5 pixels, of the worst channel."""
    first, second = (shown_255([frame], plane) for frame in frames)
    return np.sqrt(uniform_filter(((first - second) / 2) ** 2, (5, 5, 0)).max(axis=2).clip(0))


def truth_of(frames, noise_share=NOISE_SHARE):
    """What an eye should see, and where that is known: as rendered where there is hardly any noise, else denoised where that helps."""
    planes = ["raw", "colour"] if "raw" in frames[0] else ["colour"]
    quiet = [noise_255(frames, plane) <= noise_share * RELIABILITY_TOLERANCE for plane in planes]
    return np.where(quiet[0][..., None], shown_255(frames, planes[0]), shown_255(frames, planes[-1])), np.any(quiet, axis=0)


def coding_step(depth_m, box_m, bits):
    """Of w = B / (r - B), for its largest value to be the last code; 0 for exact depth."""
    return float((box_m / np.maximum(depth_m - box_m, 1e-3)).max()) / (2 ** bits - 1) if bits else 0.0


def rounded(depth_m, box_m, step):
    if step == 0:
        return depth_m
    with np.errstate(divide="ignore"):
        w = np.round(box_m / np.maximum(depth_m - box_m, 1e-3) / step) * step
        return (box_m + box_m / w).astype(np.float32)


def coarser(frames, factor):
    """The mean of frames, as if rendered so much less densely."""
    first = frames[0]
    camera = first.info.camera
    size = (camera.width // factor, camera.height // factor)
    less = (es.PerspectiveCamera(*size, camera.fov_x_rad) if isinstance(camera, es.PerspectiveCamera)
            else es.EquirectCamera(*size, camera.longitudes, camera.latitudes))
    # The middle one of an odd number of samples lies at the coarser pixel's centre; of an even number the nearest one does nearly.
    planes = {name: np.ascontiguousarray(first[name][factor // 2::factor, factor // 2::factor]) for name in ("depth", "specular") if name in first}
    return es.Frame(es.frame_info(less, like=first.info, head_radius_m=first.info.head_radius_m), {"colour": smaller(mean_of(frames), factor), **planes})


def for_eye(frame, eye):
    """For the leaning eye a source that was not rendered for it: its head box has no lean."""
    info = frame.info
    return es.Frame(es.frame_info(info.camera, like=info, head_radius_m=info.head_radius_m if eye == 0 else 0.0), frame.planes)


class Shot:
    """Two eyes, and their source as it is streamed."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program
        self.eyes = [both_runs(folder, "eyes", index) for index in (0, 1)]
        self.clean = both_runs(folder, "source", 0)
        self.received_as = {}

    def rendered(self, source, factor, eye):
        """The source, the other eye's view at its density, and one a quarter as dense as the eyes: the paper's small stream."""
        if source == DIRECT_LIGHT:
            other = self.eyes[1 - eye]
            return for_eye(coarser(self.clean, factor), eye), coarser(other, factor), coarser(other, SMALLER)
        return (for_eye(read(self.folder, f"run-{source}-{factor}", RUN_SOURCE), eye), read(self.folder, f"eyes-{source}-{factor}", 1 - eye),
                read(self.folder, f"small-{source}", 1 - eye))

    def around(self, source, factor, eye):
        """The frames of a stream, the source among them."""
        if source != DIRECT_LIGHT:
            return [for_eye(read(self.folder, f"run-{source}-{factor}", index), eye) for index in range(RUN_FRAMES)]
        frames = [for_eye(coarser([read(self.folder, "run", index)], factor), eye) for index in range(RUN_FRAMES)]
        frames[RUN_SOURCE] = self.rendered(source, factor, eye)[0]
        return frames

    def received(self, kind, factor, eye):
        """What is left of what was rendered after coding."""
        source, crf = kind
        views = self.rendered(source, factor, eye)
        if crf == NO_STREAM:
            return views
        if (kind, factor, eye) not in self.received_as:
            main = decoded(self.program, self.around(source, factor, eye), RUN_SOURCE, crf)
            main.specular = views[0]["specular"]  # as if no codec had been there
            self.received_as[kind, factor, eye] = main, decoded(self.program, [views[1]], 0, crf), decoded(self.program, [views[2]], 0, crf + SMALL_CRF_MORE)
        return self.received_as[kind, factor, eye]

    def add_loss(self, meter, kind, factor):
        """To what `encode` measures: here every pixel has a reference, which each run of the clean source gives once."""
        exposure, plane = self.clean[0].info.exposure, "raw" if "raw" in self.clean[0] else "colour"
        first, second = (es.quantise_8bit(display(smaller(frame[plane][:, :, :3], factor), exposure)) for frame in self.clean)
        main = self.received(kind, factor, 0)[0]
        seen = es.quantise_8bit(display(main["colour"], exposure)) if kind[1] == NO_STREAM else main.rgb
        meter.add_reference(seen, np.dstack([first, np.full(first.shape[:2], 255, np.uint8)]), second)

    def samples(self, kind, factor, mirrors_show):
        """(group, risks, good, exact) of the pixels of both eyes and all chains."""
        for eye, frames in enumerate(self.eyes):
            info = frames[0].info
            # Of sources in direct light noise would count as loss. Each has half as many samples as an eye; a look-up takes the mean of
            # 2.25 pixels or so, a coarser pixel that of factor^2.
            more = np.sqrt(1 + 2 / 2.25 / factor ** 2) if kind[0] == DIRECT_LIGHT else 1
            truth, quiet = truth_of(frames, NOISE_SHARE / more)
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
                # Mirrors as the engine leaves them: those are what the group `mirrored` is fitted to. Looked up anew, as play does,
                # they lie within the bound and count as any other pixel of the source.
                picture = es.Reprojector(chain.method, fill=chain.fill, mirrors="surface")(
                    main, info.camera, info.camera_pose, depth=None if by_track else depth, risks=True,
                    small=small if "small" in chain.fill else None, earlier=[earlier] if "earlier" in chain.fill else (),
                    depth_tolerance_w=None if by_track else step / 2)
                wanted = picture.risk_groups != NO_GROUP
                if chain.only_filled:
                    wanted &= picture.origin != ORIGINS.index("source")
                if not mirrors_show:
                    wanted &= picture.risk_groups != MIRRORED
                used = quiet & wanted
                worst = np.abs(picture.rgb.astype(float) - truth).max(axis=2)
                yield (picture.risk_groups[used], picture.risks[used], worst[used] <= RELIABILITY_TOLERANCE, np.full(used.sum(), chain.depth_bits == 0),
                       int((~quiet & wanted).sum()), int(wanted.sum()))


EYES_AND_SOURCE = {"eyes-0": 1, "eyes-1": 1, "source-0": 0, "source-1": 0}
LAST_FRAMES = {
    DIRECT_LIGHT: {**EYES_AND_SOURCE, "run": RUN_FRAMES - 1},
    PATH_TRACED: {**EYES_AND_SOURCE, **{f"small-{source}": 1 for source in SOURCES},
                  **{f"{name}-{source}-{factor}": last for name, last in (("eyes", 1), ("run", RUN_FRAMES - 1)) for source in SOURCES for factor in COARSER}}}


def shots(program, work, light, scene):
    """Those whose renders are finished."""
    return [Shot(folder, program) for folder in sorted((work / light / scene).glob("*-*"))
            if all(list(folder.glob(f"{name}/*/frame.{last:04d}.exr")) for name, last in LAST_FRAMES[light].items())]


def off_references(path_traced):
    """How far the truth is from reference tiles, where it is taken for known."""
    differences = []
    for frames in (frames for shot in path_traced for frames in shot.eyes):
        truth, quiet = truth_of(frames)
        known = quiet & (np.minimum(*(frame["reference"][:, :, 3] for frame in frames)) > 0)
        differences.append(np.abs(truth - shown_255(frames, "reference")).max(axis=2)[known])
    off = np.concatenate(differences)
    return {"pixels": len(off), "mean_255": round(float(off.mean()), 2) if len(off) else None}


def of_scene(program, seed, per_kind, work, scene):
    """Of a scene's shots: (group, risks, lost, good, exact, kind, how many pixels each stands for), and what noise left out."""
    rng = np.random.default_rng([seed, *scene.encode()])
    of_light = {light: shots(program, work, light, scene) for light in LAST_FRAMES}
    if not all(of_light.values()):
        return None, None
    parts, left_out, counted = [], 0, 0
    for index, kind in enumerate(KINDS):
        light = DIRECT_LIGHT if kind[0] == DIRECT_LIGHT else PATH_TRACED
        for factor in COARSER:
            meter = es.VisibleLossMeter()
            for shot in of_light[light]:
                shot.add_loss(meter, kind, factor)
            for shot in of_light[light]:
                group, risks, good, exact, noisy, all_pixels = zip(*shot.samples(kind, factor, light == PATH_TRACED or scene in BREAKERS))
                group, risks, good, exact = (np.concatenate(arrays) for arrays in (group, risks, good, exact))
                lost = np.interp(risks[:, TEXTURE], es.CODING_TEXTURES, meter.loss())
                left_out, counted = left_out + sum(noisy), counted + sum(all_pixels)
                share = np.minimum(1, per_kind / np.bincount(group, minlength=len(RISK_GROUPS)).clip(1))[group]
                chosen = rng.random(len(group)) < share
                parts.append((group[chosen], risks[chosen], lost[chosen], good[chosen], exact[chosen], np.full(chosen.sum(), index), 1 / share[chosen]))
    notes = {"shots": {light: len(found) for light, found in of_light.items()}, "left_out_for_noise": round(left_out / max(counted, 1), 4),
             "truth_off_references": off_references(of_light[PATH_TRACED])}
    return tuple(np.concatenate(arrays) for arrays in zip(*parts)), notes


class Samples:
    """All pixels, with their scene."""

    def __init__(self, program, work, seed, per_kind):
        self.scenes, self.notes, parts = [], {}, []
        names = sorted({folder.name for light in LAST_FRAMES for folder in (work / light).iterdir() if folder.is_dir()})
        with concurrent.futures.ProcessPoolExecutor() as pool:
            for name, (found, notes) in zip(names, pool.map(functools.partial(of_scene, program, seed, per_kind, work), names)):
                if found is None:
                    continue
                parts.append((np.full(len(found[0]), len(self.scenes)), *found))
                self.scenes.append(name)
                self.notes[name] = {"pixels": len(found[0]), **notes}
                print(f"{name}: {self.notes[name]}", flush=True)
        self.scene, self.group, self.risks, self.lost, self.good, self.exact, self.kind, self.stands_for = (np.concatenate(arrays) for arrays in zip(*parts))
