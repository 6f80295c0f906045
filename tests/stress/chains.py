"""From a breaker's value to what every method shows: renders by the program, reprojection by the Python package, scores."""

import math
import pathlib
import subprocess

import equistream as es
import numpy as np
from PIL import Image
from scipy.ndimage import maximum_filter

EYE_SIZE = (200, 112)
SPHERE_SIZE = (480, 240)
SMALL_SIZE = (120, 60)
FOCAL_PX = EYE_SIZE[0] / 2  # 90 degrees
EYES = ("left", "right")
WORST_SHARE = 0.01
FEWEST_GAPS = 20
"""Below so many gap pixels of both eyes their own PSNR says nothing."""
FLAGGED_BELOW = 0.5
AROUND = np.ones((3, 3), bool)
"""Pixels among which it is chance what one sphere has wrong and another has not: where their samples lie."""


# As in programs/study/steps.py, without which breakers run too: a program ends when what started it is killed.
ENDS_WITH_PARENT = "setpriv", "--pdeathsig", "TERM", "--"

SEED = {"render": 1}
"""Of all that is rendered; `run.py --seed` sets another."""

CEILING = "ceiling"
"""Beside the methods: a sphere at each eye's own place, turned, as wide as the others, of as many samples and coded alike, so that nothing is reprojected."""


def methods():
    """Every engine there is, from a sphere at the head's centre; and the paper's: `eye-depth` from one at the left eye."""
    return (*es.METHODS, "paper")


def chain():
    return "small,pushpull" if "pushpull" in es.FILL_PASSES else "small,spread"


class Renders:
    """One breaker at one value, rendered."""

    def __init__(self, program, breaker, value, folder):
        self.program, self.breaker, self.value = program, breaker, value
        self.folder = pathlib.Path(folder)
        settings = breaker.setting(value, FOCAL_PX) if breaker.setting else ()
        options = [word for setting in settings for word in ("--option", setting)]
        self.run("scene", "generate", breaker.scene, "--out", self.folder, *options)
        self.render_eyes("truth", breaker.samples, breaker.truth_head)
        if breaker.truth_head is not breaker.believed_head:
            self.render_eyes("believed", 1, breaker.believed_head)
        of_source = max(4, breaker.samples // 4) if breaker.source_samples is None else breaker.source_samples(value)
        for name, eye, size in (("sphere", "centre", SPHERE_SIZE), ("paper", "left", SPHERE_SIZE), ("small", "right", SMALL_SIZE)):
            self.render(name, "--eye", eye, "--size", size_text(size), "--spp", of_source)
        self.render("own", "--eye", "both", "--size", size_text(SPHERE_SIZE), "--spp", of_source, *self.path_words("truth", breaker.truth_head))
        if breaker.coding is not None:
            for source in ("sphere", "paper", *(f"own/{eye}" for eye in EYES)):
                self.run("encode", self.folder / source, "--fill", "none", *breaker.coding(value), "--progress", "none", "--out", self.stream(source))

    def run(self, *words):
        words = [str(word) for word in words]
        result = subprocess.run([*ENDS_WITH_PARENT, self.program, *words], capture_output=True, text=True)
        if result.returncode != 0:
            raise RuntimeError(f"equistream {' '.join(words)}: exit {result.returncode}: {result.stderr.strip()}")

    def render(self, name, *words):
        self.run("render", self.folder / f"{self.breaker.scene}.json", "--frames", 0, "--max-bounces",
                 self.breaker.max_bounces, "--seed", SEED["render"], "--aovs", "depth,specular,virtual", "--progress", "none", "--out", self.folder / name, *words)

    def render_eyes(self, name, samples, head):
        self.render(name, "--camera", "perspective", "--eye", "both", "--size", size_text(EYE_SIZE), "--fov", 90, "--spp", samples, *self.path_words(name, head))

    def path_words(self, name, head):
        return [] if head is None else ["--path", self.path_of(name, *head(self.value))]

    def path_of(self, name, offset_m, yaw_deg):
        """A head beside the origin, from which these scenes are seen looking ahead."""
        half = math.radians(yaw_deg) / 2
        pose = (*offset_m, math.cos(half), 0, math.sin(half), 0)
        file = self.folder / f"{name}.csv"
        file.write_text("time_s,x,y,z,qw,qx,qy,qz\n" + "".join(",".join(repr(float(v)) for v in (time_s, *pose)) + "\n" for time_s in (0, 1)))
        return file

    def eyes(self):
        """Where the client takes them to be, with their depth."""
        return [self.frame("truth" if self.breaker.truth_head is self.breaker.believed_head else "believed", eye) for eye in EYES]

    def frame(self, name, eye):
        return es.read_frame(self.folder / name / eye / "frame.0000.exr")

    def stream(self, source):
        return self.folder / f"{source.replace('/', '-')}.mkv"

    def own(self, eye):
        """A sphere where this eye is, coded as others are."""
        return self.frame("own", eye) if self.breaker.coding is None else next(es.open_feed(self.stream(f"own/{eye}"))).main

    def source(self, name, eye):
        """A sphere as methods get it: rendered, or through a stream. With what is left of its depth, and half a step of its code in w."""
        if self.breaker.coding is not None:
            picture = next(es.open_feed(self.stream(name), depth=True)).main
            return picture, picture.depth_m, picture.info.depth_tolerance_w
        frame = self.frame(name, eye)
        if self.breaker.damage is None:
            return frame, frame["depth"], 0.0
        return frame, *self.breaker.damage(frame["depth"], frame.info.box_radius_m, self.value)


def size_text(size):
    return f"{size[0]}x{size[1]}"


class Score:
    """Errors of one method over both eyes."""

    def __init__(self):
        self.errors, self.gaps, self.off, self.reliability = [], [], [], []

    def add(self, rgb, truth, gaps, reliability):
        """Of one eye: two pictures in 8 bits, where the first had gaps, and its map of how far to trust it, in 8 bits."""
        difference = rgb.astype(float) - truth
        self.errors.append((difference ** 2).sum(axis=2).ravel())
        self.gaps.append(gaps.ravel())
        self.off.append(np.abs(difference).max(axis=2))
        self.reliability.append(reliability.ravel() / 255)

    def figures(self, ceiling=None):
        """With the ceiling's score also of how much of what fails the map knew, and how much fails by chance: how many of the ceiling's pixels do beside this."""
        errors, gaps, reliability = np.concatenate(self.errors), np.concatenate(self.gaps), np.concatenate(self.reliability)
        worst = np.sort(errors)[-max(1, int(WORST_SHARE * len(errors))):]
        flagged, bad = reliability < FLAGGED_BELOW, flat(self.off) > es.RELIABILITY_TOLERANCE
        return {"psnr_db": psnr(errors), "worst_percent_db": psnr(worst), "gaps_db": psnr(errors[gaps]) if gaps.sum() >= FEWEST_GAPS else None,
                "gap_share": round(float(gaps.mean()), 5), "bad_share": round(float(bad.mean()), 5),
                "mean_reliability": round(float(reliability.mean()), 4), "flagged_share": round(float(flagged.mean()), 5),
                "flagged_precision": share(flagged & bad, flagged), "flagged_recall": share(flagged & bad, bad),
                **(failing_figures(flagged, self.off, ceiling.off) if ceiling else {})}


def flat(pictures):
    return np.concatenate([picture.ravel() for picture in pictures])


def failing(off, beside):
    """Pixels that are off by more than the map's tolerance beyond whatever the other is off by around them. Both are lists of pictures, of 255."""
    return flat([mine > maximum_filter(other, footprint=AROUND) + es.RELIABILITY_TOLERANCE for mine, other in zip(off, beside, strict=True)])


def failing_figures(flagged, off, ceiling):
    fails = failing(off, ceiling)
    return {"failing_share": round(float(fails.mean()), 5), "failing_recall": share(flagged & fails, fails),
            "failing_by_chance": round(float(failing(ceiling, off).mean()), 5)}


def psnr(squared_errors):
    mean = squared_errors.mean() / 3
    return 99.0 if mean == 0 else round(float(10 * np.log10(255 ** 2 / mean)), 3)


def share(part, whole):
    return round(float(part.sum() / whole.sum()), 4) if whole.any() else None


def reprojected(renders, method):
    """Both eyes' pictures by one method, each with the true eye in 8 bits."""
    source, depth_m, tolerance_w = renders.source(*(("paper", "left") if method == "paper" else ("sphere", "centre")))
    small = renders.frame("small", "right")
    truths = [renders.frame("truth", eye) for eye in EYES]
    eyes = renders.eyes()
    depths = [(source.info, depth_m), *((view.info, view["depth"]) for view in (small, *eyes))]

    def depth(camera, pose):
        return next(depth_m for info, depth_m in depths if info.camera == camera and info.camera_pose == pose)

    # Without mirrors thresholds are of what each method makes of mirrors and glass itself, and of whether the map knows.
    # The paper's has no virtual depth.
    engine = es.Reprojector("eye-depth" if method == "paper" else method, fill=chain(),
                            mirrors="images" if renders.breaker.mirrors and method != "paper" else "surface")
    for eye, truth in zip(eyes, truths):
        picture = engine(source, eye.info.camera, eye.info.camera_pose, depth=depth, small=small, reliability=True, depth_tolerance_w=tolerance_w)
        yield picture, displayed(truth)


def displayed(frame):
    return es.to_display(frame["colour"], frame.info.exposure).astype(float)


def ceiling(own_of, truth_of):
    """The score of spheres at the eyes' own places: functions of an eye's name that give its frames in time."""
    score, turn = Score(), es.Reprojector("rotation", fill="none")
    for eye in EYES:
        for own, truth in zip(own_of(eye), truth_of(eye), strict=True):
            picture = turn(own, truth.info.camera, truth.info.camera_pose, reliability=True)
            score.add(picture.rgb, displayed(truth), picture.gaps, picture.reliability)
    return score


def scores(renders):
    """Method -> figures."""
    best = ceiling(lambda eye: [renders.own(eye)], lambda eye: [renders.frame("truth", eye)])
    found = {CEILING: best.figures()}
    for method in methods():
        score = Score()
        for picture, truth in reprojected(renders, method):
            score.add(picture.rgb, truth, picture.gaps, picture.reliability)
        found[method] = score.figures(best)
    return found


# Of chains by `equistream play`: the program, and what it wrote.


def run_program(program, *words):
    words = [str(word) for word in words] + (["--overwrite"] if words[0] == "play" else [])
    result = subprocess.run([*ENDS_WITH_PARENT, program, *words], capture_output=True, text=True)
    if result.returncode != 0:
        raise RuntimeError(f"equistream {' '.join(words)}: exit {result.returncode}: {result.stderr.strip()}")


def played_picture(out, eye, number):
    return np.asarray(Image.open(out / eye / f"frame.{number:04}.png").convert("RGB"))


def played_plane(out, name, eye, number):
    return np.asarray(Image.open(out / name / eye / f"frame.{number:04}.png"))
