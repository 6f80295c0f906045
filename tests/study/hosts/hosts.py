"""One frame of a scene from each host, as planes by channel name, with several independent renders of its colour; and how far two such frames agree."""

import pathlib
import subprocess
import sys

import numpy as np
from scipy import stats

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "programs"))
from independent import colour_of, read_frame  # noqa: E402

AOVS = "depth,motion,normal,ids"


class Failed(Exception):
    pass


class Programs:
    def __init__(self, folder):
        self.program = pathlib.Path(folder).resolve() / "equistream"
        if not self.program.is_file():
            raise Failed(f"{self.program}: expected the built program, found nothing (give --bin)")

    def run(self, *words):
        words = [str(word) for word in words]
        result = subprocess.run([self.program, *words], capture_output=True, text=True)
        if result.returncode != 0:
            lines = result.stderr.strip().splitlines()
            raise Failed(f"equistream {' '.join(words)}: exit {result.returncode}: {lines[-1] if lines else 'no message'}")
        return result.stdout


def frames(programs, host, scene, work, settings):
    """(planes of the first seed, colours of all seeds: seeds x height x width x 3). The hosts draw other random numbers from the same seeds."""
    # What the embedded host leaves out of the light on purpose Mitsuba does not.
    options = {"embree": ["--unbiased"], "mitsuba": ["--variant", settings.variant]}[host]
    planes, colours = None, []
    for seed in range(1, settings.seeds + 1):
        out = work / f"{host}-{seed}"
        programs.run("render", scene, "--host", host, *options, "--frames", settings.frame, "--size", f"{settings.width}x{settings.height}",
                     "--spp", settings.spp, "--seed", seed, "--aovs", AOVS, "--overwrite", "--out", out)
        frame = read_frame(out / "centre" / f"frame.{settings.frame:04d}.exr")
        planes = planes or frame
        colours.append(colour_of(frame))
    return planes, np.array(colours)


BLOCK = 8  # pixels a side, over which colour is averaged
FAMILY_WISE = 0.01  # chance that a picture of equal expectation fails


def directions(u, v, width, height):
    longitude, latitude = 2 * np.pi * (u / width - 0.5), np.pi * (0.5 - v / height)
    return np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)], -1)


def angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))


def share(ok):
    return float(np.mean(ok)) if ok.size else None


def quantiles(values):
    if not values.size:
        return None
    return {"median": float(np.median(values)), "p99.9": float(np.quantile(values, 0.999)), "worst": float(np.max(values))}


def geometry(a, b):
    """a, b: planes by channel name. Depth, motion and normals of pixels in which both see the same object."""
    height, width = a["depth.Z"].shape
    hit_a, hit_b = np.isfinite(a["depth.Z"]), np.isfinite(b["depth.Z"])
    both = hit_a & hit_b
    same = both & (a["object_id"] == b["object_id"])
    relative = np.abs(b["depth.Z"][same] / a["depth.Z"][same] - 1)
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    result = {"pixels": int(same.size), "hit_in_both": share(hit_a == hit_b), "same_object": int(same.sum()),
              "ids_agree": {kind: share((a[f"{kind}_id"] == b[f"{kind}_id"])[both]) for kind in ("object", "material", "instance")},
              "depth_within_1e-4": share(relative <= 1e-4), "depth": quantiles(relative)}
    for name in ("backward", "forward"):
        ends = [directions(u + planes[f"{name}.u"], v + planes[f"{name}.v"], width, height) for planes in (a, b)]
        apart = angle(*ends)[same] * width / (2 * np.pi)
        result[f"{name}_within_0.01_px"] = share(apart <= 0.01)
        result[name] = quantiles(apart)
    normals = [np.stack([planes[f"normal.{axis}"] for axis in "XYZ"], -1) for planes in (a, b)]
    turned = np.degrees(angle(*normals))[same]
    result["normal_within_0.1_deg"] = share(turned <= 0.1)
    result["normal_deg"] = quantiles(turned)
    return result


def blocks(colours):
    """Means over BLOCK x BLOCK pixels: seeds x rows x columns x 3."""
    seeds, height, width, _ = colours.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = colours[:, :rows * BLOCK, :columns * BLOCK]
    return cut.reshape(seeds, rows, BLOCK, columns, BLOCK, 3).mean((2, 4))


def z_test(a, b, hit):
    """Welch's test on block means of independent renders (seeds first), Sidak's correction over all blocks and channels.

    A frame's colours are stored as halves: what their rounding may add is part of the variance, so that noise-free pictures have one.
    `hit`: pixels that see a surface; how large the difference is, is told of blocks of such alone, for a pixel that sees the sun outshines the rest.
    """
    means_a, means_b = blocks(a), blocks(b)
    n_a, n_b = len(a), len(b)
    rounding = (np.maximum(means_a.mean(0), means_b.mean(0)) * 2 ** -11) ** 2 / 3 / BLOCK
    var_a, var_b = means_a.var(0, ddof=1) / n_a + rounding, means_b.var(0, ddof=1) / n_b + rounding
    difference = means_b.mean(0) - means_a.mean(0)
    spread = np.sqrt(var_a + var_b)
    lit = spread > 0
    t = np.divide(difference, spread, out=np.zeros_like(difference), where=lit)
    freedom = (var_a + var_b) ** 2 / np.maximum(var_a ** 2 / (n_a - 1) + var_b ** 2 / (n_b - 1), 1e-300)
    p = np.where(lit, 2 * stats.t.sf(np.abs(t), np.maximum(freedom, 1)), np.where(difference == 0, 1, 0))
    tests = int(p.size)
    threshold = 1 - (1 - FAMILY_WISE) ** (1 / tests)
    whole = blocks(hit[None, :, :, None].repeat(3, -1).astype(float))[0] == 1
    level = means_a.mean(0)[whole].mean() if whole.any() else 0
    variance = (var_a + var_b)[whole]
    rms = lambda squares: float(np.sqrt(max(0, squares.mean())) / level) if level > 0 else None
    return {"tests": tests, "p_threshold": threshold, "least_p": float(p.min()), "failing": int((p < threshold).sum()),
            "passes": bool((p >= threshold).all()), "mean_embedded": means_a.mean(0)[whole].mean() if whole.any() else None,
            "mean_mitsuba": means_b.mean(0)[whole].mean() if whole.any() else None,
            "relative_rms_difference": rms(difference[whole] ** 2 - variance), "relative_rms_noise": rms(variance)}, t
