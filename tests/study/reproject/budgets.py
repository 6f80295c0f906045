#!/usr/bin/env python3
"""How errors follow the engines' error budget: docs/results/reproject/budgets.json, and the tables of docs/decisions/0016.

    budgets.py --bin build/release/bin --work FOLDER [SCENE ...]
    budgets.py --bin build/release/bin --breakers COMMIT=RUN.json COMMIT=RUN.json
    budgets.py --bin build/release/bin --work FOLDER --look-ups [SCENE ...]

The first gives noise-free errors. Spheres of two seeds and truths of two others are rendered into FOLDER, where frames that are done are
kept. The second compares two runs of tests/stress/run.py --all, before and after. The third
tells what samples should be mixed by, and whether a prefilter (Nehab and Hoppe, "A fresh look at generalized sampling") pays. Needs the
Python package `equistream`; --look-ups needs ffmpeg too.
"""

import argparse
import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "programs/study"))
from results import EYES, REPOSITORY, keep  # noqa: E402
from pages import place, table  # noqa: E402
from steps import Failed, provenance, run_as_program  # noqa: E402

import equistream as es  # noqa: E402

FRAME, SPHERE, SPHERE_SPP, EYE, EYE_SPP, SEEDS = 10, "1920x960", 16, "640x360", 64, (1, 2)
RESULTS = REPOSITORY / "docs/results/reproject/budgets.json"
PAGE = REPOSITORY / "docs/decisions/0016-defaults.md"
ENGINES, BUDGETS_PX, FILL = ("mesh", "splat"), (0.25, 1, 2, 4, 8, 16), "pushpull"


class Budgets:
    def __init__(self, options, scene):
        self.program, self.scene, self.work = options.bin / "equistream", scene, options.work / scene

    def render_seeds(self):
        for seed in SEEDS:
            self.render(f"sphere-{seed}", "--aovs", "depth", "--size", SPHERE, "--spp", SPHERE_SPP, "--seed", seed)
            self.render(f"truth-{seed}", "--camera", "perspective", "--eye", "both", "--size", EYE, "--spp", EYE_SPP, "--seed", 100 + seed)

    def render(self, name, *words):
        self.render_frame(FRAME, name, *words)

    def render_frame(self, frame, name, *words):
        description = REPOSITORY / f"scenes/descriptions/{self.scene}.json"
        subprocess.run([str(word) for word in (self.program, "render", description, "--frames", f"{frame}-{frame}", *words, "--out", self.work / name)],
                       check=True)

    def differences(self, engine, seed):
        """Display values less the truth's, by eye."""
        frame = next(iter(es.Sequence(self.work / f"sphere-{seed}/centre")))
        to_display = es.DisplayTransform().to_display
        for eye in EYES:
            true = next(iter(es.Sequence(self.work / f"truth-{seed}/{eye}")))
            picture = engine(frame, true.info.camera, true.info.camera_pose)
            yield picture.rgb.astype(float) / 255 - to_display(np.ascontiguousarray(true["colour"][..., :3]))

    def noise_free_db(self, name, budget_px):
        """Noise of different seeds is independent: the mean product of their differences is the square of what they share."""
        engine = es.Reprojector(name, fill=FILL, error_budget_px=budget_px)
        first, second = (list(self.differences(engine, seed)) for seed in SEEDS)
        return {eye: round(float(-10 * np.log10(np.mean(a * b))), 3) for eye, a, b in zip(EYES, first, second)}


def breaker_points(before, after):
    """For each breaker and engine, means over its values: dB gained, per cent of pixels that fail and that the map misses."""
    for breaker, by_value in before.items():
        for engine in ENGINES:
            pairs = [(by_value[value][engine], after[breaker][value][engine]) for value in by_value]
            failing = [[100 * figures["failing_share"] for figures in pair] for pair in pairs]
            missed = [[share * (1 - (figures["failing_recall"] or 0)) for share, figures in zip(shares, pair)]
                      for shares, pair in zip(failing, pairs)]
            gains = [b["psnr_db"] - a["psnr_db"] for a, b in pairs]
            yield {"breaker": breaker, "engine": engine, "gain_db": round(float(np.mean(gains)), 2), "least_gain_db": round(min(gains), 2),
                   **{name: [round(float(mean), 2) for mean in np.mean(values, axis=0)]
                      for name, values in (("failing_percent", failing), ("missed_percent", missed))}}


LOOK_UP_FRAMES = {"voxel-city": 30, "sponza-crytek": 62}
LOOK_UP_CRF = 24
# Three taps each way, -a, 1 + 2a, -a: what quasi-interpolation and less of it take; and the exact inverse of linear reconstruction's samples.
PREFILTERS = {"1/24": 1 / 24, "1/12": 1 / 12, "1/8": 1 / 8}


def to_linear(v):
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def to_srgb(light):
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * np.maximum(light, 1e-12) ** (1 / 2.4) - 0.055)


def to_light(v):
    """A polynomial that follows the sRGB curve up to a scale and a constant, which a mean keeps."""
    return (v * (v * 0.205 + 0.7725) + 0.0225) ** 2


def from_light(light):
    root = np.sqrt(light)
    return root * (root * (root * (root * -0.05090745 + 0.19698127) - 0.42717759) + 1.31026388) - 0.02921351


def prefiltered(picture, a):
    """Round the sphere along rows, to the poles along columns."""
    across = (1 + 2 * a) * picture - a * (np.roll(picture, 1, 1) + np.roll(picture, -1, 1))
    rows = np.pad(across, ((1, 1), (0, 0), (0, 0)), "edge")
    return (1 + 2 * a) * across - a * (rows[:-2] + rows[2:])


def coded(picture, work):
    """Encoded by x264 and decoded."""
    height, width, _ = picture.shape
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24"]
    coding = ["ffmpeg", "-v", "error", "-y", *raw, "-s", f"{width}x{height}", "-i", "-", "-vf", "scale=out_color_matrix=bt709", "-pix_fmt", "yuv420p",
              "-c:v", "libx264", "-crf", str(LOOK_UP_CRF), str(work / "coded.mp4")]
    subprocess.run(coding, input=np.round(picture * 255).astype(np.uint8).tobytes(), check=True)
    decoding = ["ffmpeg", "-v", "error", "-i", str(work / "coded.mp4"), "-vf", "scale=in_color_matrix=bt709", *raw, "-"]
    return np.frombuffer(subprocess.run(decoding, check=True, capture_output=True).stdout, np.uint8).reshape(picture.shape) / 255


class LookUps:
    """The left eye's pixels whose four samples all show the point that the pixel sees: what is measured is looking up alone."""

    def __init__(self, budgets, scene):
        self.budgets, self.work, frame = budgets, budgets.work, LOOK_UP_FRAMES[scene]
        self.to_display = es.DisplayTransform().to_display
        for name, words in {"d4": ("--spp", 4, "--seed", 1, "--aovs", "depth,guides", "--denoise", "balanced"), "n4": ("--spp", 4, "--seed", 1, "--aovs", "depth"),
                            "h256": ("--spp", 256, "--seed", 1, "--aovs", "depth")}.items():
            budgets.render_frame(frame, name, "--size", SPHERE, *words)
        for name, seed in (("truth", 101), ("truth2", 102)):
            budgets.render_frame(frame, name, "--spp", 256, "--seed", seed, "--camera", "perspective", "--eye", "left", "--size", EYE, "--aovs", "depth")
        truth, sphere = self.frame("truth/left"), self.frame("h256/centre")
        self.truths = [self.shown(truth), self.shown(self.frame("truth2/left"))]
        self.spheres = {"256 samples": self.shown(sphere), "4 samples": self.shown(self.frame("n4/centre")), "4 samples, denoised": self.shown(self.frame("d4/centre"))}
        self.find(sphere, truth)

    def frame(self, name):
        return next(iter(es.Sequence(self.work / name)))

    def shown(self, frame):
        return np.round(self.to_display(np.ascontiguousarray(frame["colour"][..., :3])) * 255) / 255

    def find(self, sphere, truth):
        def turned(q, v):
            return v + 2 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v)
        height, width, _ = self.truths[0].shape
        y, x = np.mgrid[0:height, 0:width] + 0.5
        rays = np.stack([(x - width / 2) / (width / 2), (height / 2 - y) / (width / 2), -np.ones_like(x)], -1)  # 90 degrees
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        finite = lambda plane: np.where(np.isfinite(plane), plane, 1e6).reshape(plane.shape[:2])
        eye, centre = truth.info.camera_pose, sphere.info.camera_pose
        point = np.array(eye.position_m) + turned(np.array(eye.orientation, float), rays) * finite(truth["depth"])[..., None] - np.array(centre.position_m)
        point = turned(np.array(centre.orientation, float) * [1, -1, -1, -1], point)
        depth, radius = finite(sphere["depth"]), np.linalg.norm(point, axis=-1)
        rows, columns = depth.shape
        u = (np.arctan2(point[..., 0], -point[..., 2]) / (2 * np.pi) + 0.5) * columns - 0.5
        v = (0.5 - np.arcsin(point[..., 1] / radius) / np.pi) * rows - 0.5
        left, top = np.floor(u).astype(int), np.floor(v).astype(int)
        a, b = (u - left)[..., None], (v - top)[..., None]
        self.taps = [(np.clip(top + j, 0, rows - 1), (left + i) % columns, (a if i else 1 - a) * (b if j else 1 - b)) for j in (0, 1) for i in (0, 1)]
        self.counts = np.all([abs(1 / depth[row, column] - 1 / radius) < 0.02 / radius for row, column, _ in self.taps], axis=0)

    def mixed(self, picture):
        return sum(weight * picture[row, column] for row, column, weight in self.taps)

    def noise_free_db(self, shown):
        scales = {"display": lambda v: v, "linear": to_linear}
        errors = {name: [(scale(np.clip(shown, 0, 1)) - scale(true))[self.counts] for true in self.truths] for name, scale in scales.items()}
        return {name: round(float(-10 * np.log10(np.mean(a * b))), 2) for name, (a, b) in errors.items()}

    def points(self):
        for name, sphere in self.spheres.items():
            for is_coded in (False, True):
                picture = coded(sphere, self.work) if is_coded else sphere
                plain, linear = self.mixed(picture), to_srgb(self.mixed(to_linear(picture)))
                ways = {"display": plain, "linear": linear, "light": from_light(self.mixed(to_light(picture))),
                        **{f"prefilter {key}": self.mixed(prefiltered(picture, a)) for key, a in PREFILTERS.items()}}
                means = {way: to_linear(np.clip(ways[way], 0, 1))[self.counts].mean() for way in ("display", "linear", "light")}
                yield {"sphere": name, "coded": is_coded, "noise_free_db": {way: self.noise_free_db(shown) for way, shown in ways.items()},
                       "mean_light_percent": {way: round(float(100 * (means[way] / means["linear"] - 1)), 3) for way in ("display", "light")}}


def draw(results):
    """The tables of the decision; report.py draws that of look-ups."""
    scenes = [name for name in results if name not in ("breakers", "look-ups")]
    found = {(scene, point["engine"], point["budget_px"]): point["noise_free_db"] for scene in scenes for point in results[scene]["points"]}
    rows = [[f"{budget:g}", *(", ".join(f"{found[scene, engine, budget][eye]:.2f}" for eye in EYES) for scene in scenes for engine in ENGINES)]
            for budget in BUDGETS_PX]
    page = place(PAGE.read_text(), "budgets", "all", table(["budget, px", *(f"{scene}, `{engine}`" for scene in scenes for engine in ENGINES)], rows, labels=1))
    by_breaker = {}
    for point in results["breakers"]["points"]:
        by_breaker.setdefault(point["breaker"], []).extend(
            [f"{point['gain_db']:+.2f} ({point['least_gain_db']:+.2f})",
             *(", ".join(f"{percent:.2f}" for percent in point[name]) for name in ("failing_percent", "missed_percent"))])
    heads = ["breaker", *(head for engine in ENGINES for head in (f"`{engine}`: gain, dB (least)", "failing, %", "missed, %"))]
    PAGE.write_text(place(page, "breakers", "all", table(heads, [[breaker, *cells] for breaker, cells in by_breaker.items()], labels=1)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["voxel-city", "sponza-crytek"])
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders; not in the repository")
    parser.add_argument("--breakers", nargs=2, metavar="COMMIT=RUN.json", help="runs of all breakers, before and after")
    parser.add_argument("--look-ups", action="store_true", help="what samples should be mixed by")
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS)
    options = parser.parse_args()
    if options.breakers:
        commits, files = zip(*(run.split("=", 1) for run in options.breakers))
        before, after = (json.loads(pathlib.Path(file).read_text())["found"] for file in files)
        keep(options.out, "breakers", {"command": "tests/study/reproject/budgets.py --bin BIN --breakers BEFORE=RUN.json AFTER=RUN.json",
                                       **provenance(options.bin, REPOSITORY), "commits": commits, "points": list(breaker_points(before, after))})
    elif options.work is None:
        raise Failed("budgets.py: expected --work FOLDER or --breakers, found neither")
    elif options.look_ups:
        keep(options.out, "look-ups", {
            "command": "tests/study/reproject/budgets.py --bin BIN --work FOLDER --look-ups " + " ".join(options.scenes), **provenance(options.bin, REPOSITORY),
            "sphere": SPHERE, "crf": LOOK_UP_CRF, "eye": EYE, "eye_spp": 256,
            "scenes": {scene: list(LookUps(Budgets(options, scene), scene).points()) for scene in options.scenes}})
    for scene in [] if options.breakers or options.look_ups else options.scenes:
        budgets = Budgets(options, scene)
        budgets.render_seeds()
        points = [{"engine": engine, "budget_px": budget, "noise_free_db": budgets.noise_free_db(engine, budget)}
                  for engine in ENGINES for budget in BUDGETS_PX]
        keep(options.out, scene, {
            "scene": scene, "command": f"tests/study/reproject/budgets.py --bin BIN --work FOLDER {scene}",
            **provenance(options.bin, REPOSITORY), "frame": FRAME, "sphere": SPHERE,
            "sphere_spp": SPHERE_SPP, "eye": EYE, "eye_spp": EYE_SPP, "seeds": SEEDS, "fill": FILL, "points": points})
    if options.out == RESULTS:
        draw(json.loads(RESULTS.read_text()))


if __name__ == "__main__":
    run_as_program(main)
