"""What the spherical sensor and its planes cost: rendering times beside the stock perspective sensor with `path` alone.

    python time_ratio.py BUILD [--variants scalar_rgb,llvm_ad_rgb] [--pixels 32768] [--spp 64] [--rounds 15] [--out ratio.json]

The room is a closed cube whose six sides are the same, a block and a lamp before each, with the camera in the middle: a
square perspective view of 90 degrees sees exactly one side, the sphere sees all six, so paths do the same work in both.
Every round renders each of the cases once, in an order that rotates; a ratio is taken within a round and the median of
all rounds is reported with the interval that holds the true median with 95 % probability (order statistics, no
distribution assumed). Ratios are per camera path, because pixel counts differ by a part in a thousand; `processor_ratio` counts all
threads' processor time, which a busy machine disturbs less.
"""

import argparse
import json
import math
import pathlib
import statistics
import sys
import time

import drjit as dr
import mitsuba as mi

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "programs/study"))
from steps import machine  # noqa: E402

STOCK = "perspective, path"
CASES = {
    STOCK: ("perspective", None),
    "equirect, path": ("equirect", None),
    "equirect, path and all planes": ("equirect", "all"),
    "perspective, path and all planes": ("perspective", "all"),
}


def room():
    """Six sides alike."""
    def at(turn, *steps):
        transform = mi.ScalarTransform4f().rotate(*turn) if turn else mi.ScalarTransform4f()
        for name, value in steps:
            transform = transform @ getattr(mi.ScalarTransform4f(), name)(value)
        return transform

    sides = [None, ([0, 1, 0], 90), ([0, 1, 0], 180), ([0, 1, 0], 270), ([1, 0, 0], 90), ([1, 0, 0], -90)]
    grey = [{"type": "diffuse", "reflectance": {"type": "rgb", "value": v}} for v in ([0.7, 0.5, 0.4], [0.4, 0.6, 0.7])]
    shapes = {}
    for i, turn in enumerate(sides):
        # A rectangle of Mitsuba's faces +Z; the side is at -Z.
        shapes[f"wall{i}"] = {"type": "rectangle", "bsdf": grey[0],
                              "to_world": at(turn, ("translate", [0, 0, -2]), ("scale", 2))}
        shapes[f"block{i}"] = {"type": "cube", "bsdf": grey[1],
                               "to_world": at(turn, ("translate", [0.5, -0.4, -1.5]), ("scale", 0.3))}
        shapes[f"lamp{i}"] = {"type": "sphere", "radius": 0.15,
                              "to_world": at(turn, ("translate", [-0.6, 0.6, -1.4])),
                              "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 6.0}}}
    return shapes


def scene(sensor, aovs, options):
    height = math.isqrt(options.pixels // 2)
    side = round(math.sqrt(2 * height * height))
    width, height = (2 * height, height) if sensor == "equirect" else (side, side)
    film = {"type": "hdrfilm", "width": width, "height": height, "component_format": "float32",
            "rfilter": {"type": "box"}}
    path = {"type": "path", "max_depth": options.depth}
    camera = {"type": sensor, "film": film, "sampler": {"type": "independent", "sample_count": options.spp}}
    if sensor == "perspective":
        camera["fov"] = 90.0
    integrator = {"type": "equirect_aov", "aovs": aovs, "nested": path} if aovs else path
    return mi.load_dict({"type": "scene", "sensor": camera, "integrator": integrator, **room()}), width * height


def seconds(loaded, seed):
    """From the call until the film holds everything, nothing developed: by the clock, and of all threads' work."""
    begun = time.perf_counter(), time.process_time()
    loaded.integrator().render(loaded, loaded.sensors()[0], seed=seed, develop=False)
    if not mi.variant().startswith("scalar"):
        dr.sync_thread()
    return time.perf_counter() - begun[0], time.process_time() - begun[1]


def median_interval(values):
    """95 % for the median: the ranks within which a fair coin's heads fall that often."""
    n, values = len(values), sorted(values)
    outside, rank = 0.0, 0
    while rank < n // 2 and outside + math.comb(n, rank) / 2**n <= 0.025:
        outside += math.comb(n, rank) / 2**n
        rank += 1
    return values[max(rank - 1, 0)], values[n - max(rank, 1)]


def measure(variant, options):
    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    mi.file_resolver().append(options.build)
    scenes = {name: scene(*case, options) for name, case in CASES.items()}
    for loaded, _ in scenes.values():
        seconds(loaded, 0)  # compiles kernels
    times = {name: [] for name in CASES}
    names = list(CASES)
    for r in range(options.rounds):
        for name in names[r % len(names):] + names[: r % len(names)]:
            times[name].append(seconds(scenes[name][0], r + 1))
        if sys.stderr.isatty():
            print(f"\r{variant}: round {r + 1} of {options.rounds}", end="", file=sys.stderr)
    if sys.stderr.isatty():
        print(file=sys.stderr)
    result = {}
    for name in names:
        pixels = scenes[name][1] / scenes[STOCK][1]
        result[name] = {"median_ms": round(1e3 * statistics.median(wall for wall, _ in times[name]), 2)}
        for kind, which in (("ratio", 0), ("processor_ratio", 1)):
            ratios = [own[which] / stock[which] / pixels for own, stock in zip(times[name], times[STOCK])]
            result[name][kind] = round(statistics.median(ratios), 4)
            result[name][f"{kind}_interval_95"] = [round(end, 4) for end in median_interval(ratios)]
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", help="the folder that holds plugins/equirect.so")
    parser.add_argument("--variants", default="scalar_rgb,llvm_ad_rgb")
    parser.add_argument("--pixels", type=int, default=32768, help="of the sphere, 2:1; the square view has as many")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--depth", type=int, default=6, help="bounces, as max_depth of path")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--out", help="also write the JSON here")
    options = parser.parse_args()
    report = {"command": f"tests/hosts/time_ratio.py --pixels {options.pixels} --spp {options.spp} --rounds {options.rounds}", "machine": machine(),
              "made": time.strftime("%Y-%m-%d", time.gmtime()), "versions": {"mitsuba": mi.__version__}, "mitsuba": mi.__version__, "pixels": options.pixels, "spp": options.spp, "max_depth": options.depth,
              "rounds": options.rounds,
              "variants": {variant: measure(variant, options) for variant in options.variants.split(",")}}
    text = json.dumps(report, indent=2)
    print(text)
    if options.out:
        with open(options.out, "w", encoding="utf-8") as file:
            file.write(text + "\n")


if __name__ == "__main__":
    main()
