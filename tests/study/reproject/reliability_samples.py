"""Pixels that reliability is fitted to and judged by: risks from reprojected pairs, which a stream may have taken something of, and whether the true eye shows
the same.
"""

import pathlib
import subprocess
import tempfile
from dataclasses import replace

import equistream as es
import numpy as np
from equistream.reprojection import ORIGINS, RELIABILITY_TOLERANCE, RISK_GROUPS
from reliability_pairs import BREAKERS, RUN_FRAMES, RUN_SOURCE, SMALLER
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


COARSER = (1, 2, 3)
MIRRORED, NO_GROUP = RISK_GROUPS.index("mirrored"), 255
NOISE_SHARE = 1 / 4

# Of colours that went through no codec; of depth that came with those that did.
NO_STREAM, STREAMED = -1, None
CRFS = (16, 24)


class Chain:
    """A method, a fill chain with what it fills from, the bits of the depth's w (0: exact), and the CRF of the stream it came by."""

    def __init__(self, method, fill, depth_bits, only_filled=False, crf=NO_STREAM):
        self.method, self.fill, self.depth_bits, self.crf = method, fill, depth_bits, crf
        self.only_filled = only_filled  # another chain has the same pixels of the source


# What `earlier` brings, the other eye's view with its depth, stands for patches and hidden layers too: all of them are looked up
# by depth, at the source's density, in a picture from elsewhere.
CHAINS = (Chain("eye-depth", "small,pushpull", 0), Chain("eye-depth", "pushpull", 0, only_filled=True),
          Chain("eye-depth", "earlier", 0, only_filled=True), Chain("eye-depth", "spread", 6), Chain("eye-depth", "earlier,spread", 5),
          Chain("eye-depth", "pushpull", 4), Chain("rotation", "none", 0),
          # What play does with a scene beside the stream, with its depth track alone, and without depth.
          *(chain for crf in CRFS for chain in (
              Chain("eye-depth", "earlier,pushpull", 0, crf=crf), Chain("mesh", "pushpull", STREAMED, crf=crf),
              Chain("eye-depth", "small,pushpull", 0, only_filled=True, crf=crf), Chain("eye-depth", "spread", 6, crf=crf),
              Chain("rotation", "none", 0, crf=crf))))
# `encode` codes the small view so much coarser than the source.
SMALL_CRF_MORE = 8


def smaller(image, factor):
    """Box filtered by a whole factor: what a coarser render of the same samples would be."""
    height, width = image.shape[0] // factor * factor, image.shape[1] // factor * factor
    return image[:height, :width].reshape(height // factor, factor, width // factor, factor, -1).mean(axis=(1, 3)).astype(np.float32)


def middle(plane, factor):
    """The middle one of an odd number of samples lies at the coarser pixel's centre; of an even number the nearest one does nearly."""
    return np.ascontiguousarray(plane[factor // 2::factor, factor // 2::factor])


def both_runs(folder, name, index):
    frames = [es.read_frame(next(folder.glob(f"{name}-{run}/*/frame.{index:04d}.exr"))) for run in (0, 1)]
    return frames, np.mean([frame["colour"][:, :, :3] for frame in frames], axis=0)


def noise_of(frames, exposure, plane="colour"):
    """Standard deviation of the mean of two runs, display-referred, in 1/255, of the worst channel, over 5x5 pixels."""
    first, second = (255 * es.DisplayTransform().to_display(np.ascontiguousarray(frame[plane][:, :, :3]), exposure).astype(float) for frame in frames)
    variance = uniform_filter(((first - second) / 2) ** 2, (5, 5, 0))
    return np.sqrt(np.maximum(variance.max(axis=2), 0))


def coding_step(depth_m, box_m, bits):
    """Of w = B / (r - B), for its largest value to be the last code; 0 for exact depth."""
    return float((box_m / np.maximum(depth_m - box_m, 1e-3)).max()) / (2 ** bits - 1) if bits else 0.0


def rounded(depth_m, box_m, step):
    if step == 0:
        return depth_m
    with np.errstate(divide="ignore"):
        w = np.round(box_m / np.maximum(depth_m - box_m, 1e-3) / step) * step
        return (box_m + box_m / w).astype(np.float32)


class Shot:
    """One source and its eyes."""

    def __init__(self, folder):
        frames, colour = both_runs(folder, "source", 0)
        self.info, self.colour, self.planes = frames[0].info, colour, frames[0]
        self.eyes = [both_runs(folder, "eyes", index) for index in (0, 1)]
        self.run = [es.read_frame(next(folder.glob(f"run/*/frame.{index:04d}.exr"))) for index in range(RUN_FRAMES)]

    def display(self, colour, info):
        return es.quantise_8bit(es.DisplayTransform().to_display(np.ascontiguousarray(colour, np.float32), info.exposure))

    def source(self, factor, eye):
        """For the leaning eye one that was not rendered for it: its head box has no lean."""
        camera = self.info.camera
        coarse = es.EquirectCamera(camera.width // factor, camera.height // factor, camera.longitudes, camera.latitudes)
        planes = {"colour": smaller(self.colour, factor), "depth": middle(self.planes["depth"], factor),
                  "specular": middle(self.planes["specular"], factor)}
        return es.Frame(es.frame_info(coarse, like=self.info, head_radius_m=self.info.head_radius_m if eye == 0 else 0.0), planes)

    def small(self, eye):
        """The other eye, made coarser: the paper's small stream, from another place and with other noise."""
        frames, colour = self.eyes[1 - eye]
        camera = frames[0].info.camera
        info = es.frame_info(es.PerspectiveCamera(camera.width // SMALLER, camera.height // SMALLER, camera.fov_x_rad), like=frames[0].info)
        # No pixel lies in the middle of an even number: depth comes from the nearest one.
        return es.Frame(info, {"colour": smaller(colour, SMALLER), "depth": middle(frames[0]["depth"], SMALLER)})

    def other(self, eye, factor):
        """The other eye's view at the source's density: what an earlier frame, a patch or a hidden layer shows."""
        frames, colour = self.eyes[1 - eye]
        camera = frames[0].info.camera
        info = es.frame_info(es.PerspectiveCamera(camera.width // factor, camera.height // factor, camera.fov_x_rad), like=frames[0].info)
        return es.Frame(info, {"colour": smaller(colour, factor), "depth": middle(frames[0]["depth"], factor)})

    def streamed(self, program, source, factor, crf):
        """The source from a stream of the frames around it; what is mirror is known as if no codec had been there."""
        run = [es.Frame(es.frame_info(source.info.camera, like=frame.info, head_radius_m=source.info.head_radius_m),
                        {"colour": smaller(frame["colour"][:, :, :3], factor), "depth": middle(frame["depth"], factor)}) for frame in self.run]
        run[RUN_SOURCE] = source
        found = decoded(program, run, RUN_SOURCE, crf)
        found.specular = source["specular"]
        return found

    def samples(self, program, mirrors_show):
        """(group, risks, good, exact, CRF) of the pixels of all eyes, densities and chains; and how many noise left out."""
        parts, left_out, counted = [], 0, 0
        for eye, (frames, colour) in enumerate(self.eyes):
            info = frames[0].info
            truth = 255 * es.DisplayTransform().to_display(np.ascontiguousarray(colour, np.float32), info.exposure).astype(float)
            noise = noise_of(frames, info.exposure)
            for factor in COARSER:
                source, small, other = self.source(factor, eye), self.small(eye), self.other(eye, factor)
                views = {NO_STREAM: (source, other, small)}
                for crf in CRFS:
                    views[crf] = (self.streamed(program, source, factor, crf), decoded(program, [other], 0, crf),
                                  decoded(program, [small], 0, crf + SMALL_CRF_MORE))
                # The source has half as many samples; bilinear lookup averages 2.25 pixels or so, the filter factor^2.
                quiet = noise * np.sqrt(1 + 2 / 2.25 / factor ** 2) <= NOISE_SHARE * RELIABILITY_TOLERANCE
                for chain in CHAINS:
                    box_m = source.info.box_radius_m
                    main, earlier, little = views[chain.crf]
                    step = coding_step(source["depth"], box_m, chain.depth_bits)

                    def depth(camera, pose):
                        for frame in (source, small, frames[0]):
                            if frame.info.camera == camera and frame.info.camera_pose == pose:
                                return rounded(frame["depth"], box_m, step)
                        raise AssertionError("depth of an unknown view")

                    # Mirrors as the engine leaves them: those are what the group `mirrored` is fitted to. Looked up anew, as play does,
                    # they lie within the bound and count as any other pixel of the source.
                    by_track = chain.depth_bits is STREAMED
                    if chain.crf != NO_STREAM and not by_track:
                        main, earlier = replace(main, depth_m=source["depth"]), replace(earlier, depth_m=other["depth"])
                    picture = es.Reprojector(chain.method, fill=chain.fill, mirrors="surface")(
                        main, info.camera, info.camera_pose, depth=None if by_track else depth, risks=True,
                        small=little if "small" in chain.fill else None, earlier=[earlier] if "earlier" in chain.fill else (),
                        depth_tolerance_w=None if by_track else step / 2)
                    group = picture.risk_groups
                    wanted = group != NO_GROUP
                    if chain.only_filled:
                        wanted &= picture.origin != ORIGINS.index("source")
                    if not mirrors_show:
                        wanted &= group != MIRRORED
                    used = quiet & wanted
                    worst = np.abs(picture.rgb.astype(float) - truth).max(axis=2)
                    counted, left_out = counted + int(wanted.sum()), left_out + int((~quiet & wanted).sum())
                    parts.append((group[used], picture.risks[used], worst[used] <= RELIABILITY_TOLERANCE,
                                  np.full(used.sum(), chain.depth_bits == 0), np.full(used.sum(), chain.crf)))
        return tuple(np.concatenate(arrays) for arrays in zip(*parts)), left_out, counted


class Samples:
    """All pixels, with their scene."""

    def __init__(self, program, work, rng, per_shot):
        self.scenes, self.notes = [], {}
        parts = []
        for scene in sorted(folder for folder in work.iterdir() if folder.is_dir()):
            taken = left_out = counted = 0
            for folder in sorted(scene.glob("*-*")):
                last = {"eyes-0": 1, "eyes-1": 1, "source-0": 0, "source-1": 0, "run": RUN_FRAMES - 1}
                if not all(list(folder.glob(f"{name}/*/frame.{frame:04d}.exr")) for name, frame in last.items()):
                    continue
                (group, risks, good, exact, crf), noisy, seen = Shot(folder).samples(program, scene.name in BREAKERS)
                share = np.minimum(1, per_shot / np.bincount(group, minlength=len(RISK_GROUPS)).clip(1))[group]
                chosen = rng.random(len(group)) < share
                parts.append((np.full(chosen.sum(), len(self.scenes)), group[chosen], risks[chosen], good[chosen], exact[chosen], crf[chosen],
                              1 / share[chosen]))
                taken, left_out, counted = taken + int(chosen.sum()), left_out + noisy, counted + seen
            if taken:
                self.scenes.append(scene.name)
                self.notes[scene.name] = {"pixels": taken, "left_out_for_noise": round(left_out / counted, 4)}
                print(f"{scene.name}: {taken} pixels, {100 * left_out / counted:.1f} % left out for their noise", flush=True)
        self.scene, self.group, self.risks, self.good, self.exact, self.crf, self.stands_for = (np.concatenate(arrays) for arrays in zip(*parts))
