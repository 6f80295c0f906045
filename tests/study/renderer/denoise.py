#!/usr/bin/env python3
"""What denoising gains and costs (docs/results/denoise.json and the tables of denoise.md): whole error and bytes of one sphere of each real scene, as rendered
and denoised; what shows at the seam; processor time a megapixel.

    denoise.py --bin build/release/bin --work FOLDER [--scenes NAME,...] [--time]          --time with nothing else running; PYTHONPATH=build/release/package
    denoise.py --page                                                                       the tables alone

The view is the path's own at its first frame, from the sphere's centre, so that nothing but light and look-up counts. Truths are unbiased.
"""

import argparse
import json
import pathlib
import resource
import subprocess
import sys

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "programs/study"))
from kept import result_text  # noqa: E402
from pages import error_text, place, table  # noqa: E402
from steps import machine, versions, write_whole  # noqa: E402

TRUTH_SAMPLES = {"sponza-crytek": 256, "sibenik": 128, "voxel-city": 256, "kitchen": 128, "san-miguel": 128}
TRUTH_SEEDS = 101, 102
SPHERE, VIEW, FOV, CRF, SEED = "1920x960", "640x360", "90", 24, 1
SPHERES = [("off", 4), ("off", 16), ("off", 32), ("fast", 4), ("balanced", 1), ("balanced", 4), ("high", 4), ("balanced", 8), ("balanced", 16)]
CURVES, CRFS = [("off", 16), ("balanced", 4), ("balanced", 8)], (16, 20, 24, 28, 32, 36)


class Programs:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def run(self, command, *words):
        """Standard output and the processor seconds it took."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        ended = subprocess.run([self.folder / "equistream", command, *map(str, words), *([] if command == "info" else ["--progress", "none"])], capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if ended.returncode != 0:
            sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {ended.stderr.strip()}")
        return ended.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def rendered(programs, out, *words):
    """Once; a folder of one frame, and the processor seconds it took beside it."""
    if not (out / "centre/frame.0000.exr").exists():
        _, seconds = programs.run("render", *words, "--frames", "0", "--out", out)
        write_whole(out / "processor_s", f"{seconds:.2f}\n")
    return out


def truths(programs, scene, work):
    return [rendered(programs, work / f"truth-{seed}", scene, "--camera", "perspective", "--fov", FOV, "--size", VIEW, "--spp", TRUTH_SAMPLES[scene.stem], "--seed", seed,
                     "--unbiased", "--aovs", "none") / "centre" for seed in TRUTH_SEEDS]


def whole_error(programs, source, work, true, *chosen):
    """Of the view of a folder of frames or a stream: on display values, as `compare` says it."""
    views = work / "views" / source.stem
    programs.run("play", source, *chosen, "--method", "rotation", "--ipd", "0", "--size", VIEW, "--fov", FOV, "--fill", "none", "--overwrite", "--out", views)
    said, _ = programs.run("compare", views / "left", true[0], "--truth2", true[1], "--metrics", "none", "--json")
    return next(iter(json.loads(said)["eyes"].values()))["whole"]["display"]


def step_at_seam(programs, sphere):
    """Mean absolute step of display values across the seam, and across the eight columns on either side of it."""
    import equistream as es
    frame = es.read_frame(sphere / "centre/frame.0000.exr", "colour")
    shown = es.to_display(frame["colour"], frame.info.exposure).astype(float)[..., :3]
    steps = np.abs(np.diff(np.concatenate([shown[:, -9:], shown[:, :9]], 1), axis=1)).mean((0, 2))
    return {"at_seam": float(steps[8]), "beside": float(np.delete(steps, 8).mean())}


def coding(programs, sphere, stream, crf, true):
    said, _ = programs.run("encode", sphere / "centre", "--crf", crf, "--depth", "none", "--json", "--out", stream)
    return {"crf": crf, "bytes": sum(track["bytes"] for track in json.loads(said)["tracks"]), "whole": whole_error(programs, stream, stream.parent, true)}


def gains_at_bytes(entries, denoised):
    """dB that coded spheres so denoised have over one of 16 samples as rendered, for at most its bytes: {CRF of the latter: dB}."""
    curves = {(entry["denoise"], entry["samples"]): entry["curve"] for entry in entries if "curve" in entry}
    gains = {}
    for plain in curves.get(("off", 16), []):
        if affordable := [point["db"] for point in curves.get(denoised, []) if point["bytes"] <= plain["bytes"]]:
            gains[plain["crf"]] = max(affordable) - plain["db"]
    return gains


def measured(programs, scene, work):
    true = truths(programs, scene, work)
    entries = []
    for quality, samples in SPHERES:
        name = f"{quality}-{samples}"
        sphere = rendered(programs, work / name, scene, "--size", SPHERE, "--spp", samples, "--seed", SEED, "--aovs", "none", "--denoise", quality)
        coded = [coding(programs, sphere, work / f"{name}-{crf}.mp4", crf, true) for crf in (CRFS if (quality, samples) in CURVES else (CRF,))]
        chosen = next(one for one in coded if one["crf"] == CRF)
        entries.append({"denoise": quality, "samples": samples, "processor_s": float((sphere / "processor_s").read_text()), "bytes": chosen["bytes"],
                        "whole": whole_error(programs, sphere / "centre", work, true), "whole_coded": chosen["whole"], "seam": step_at_seam(programs, sphere)})
        if len(coded) > 1:
            entries[-1]["curve"] = [{"crf": one["crf"], "bytes": one["bytes"], "db": one["whole"]["db"]} for one in coded]
        print(f"{scene.stem} {name}: {entries[-1]['whole']['db']:.1f} dB, coded {entries[-1]['whole_coded']['db']:.1f} dB, {entries[-1]['bytes'] / 1000:.0f} kB", flush=True)
    return {"truth_samples": TRUTH_SAMPLES[scene.stem], "entries": entries}


def processor_seconds(programs, scene, work):
    """A megapixel: what three more frames of one sample cost, less what they cost as they are."""
    def cost(quality, frames):
        out = work / f"time-{quality}-{frames}"
        return programs.run("render", scene, "--size", SPHERE, "--spp", 1, "--aovs", "none", "--frames", f"0-{frames - 1}", "--denoise", quality, "--overwrite", "--out", out)[1]
    a_frame = {quality: (cost(quality, 4) - cost(quality, 1)) / 3 for quality in ("off", "fast", "balanced", "high")}
    return {quality: (seconds - a_frame["off"]) / (1.920 * 0.960) for quality, seconds in a_frame.items() if quality != "off"}


def rows(scenes):
    for name, scene in scenes.items():
        entries = {(entry["denoise"], entry["samples"]): entry for entry in scene.get("entries", [])}
        plain = entries.get(("off", 32))
        for (quality, samples), entry in entries.items():
            yield [name, "as rendered" if quality == "off" else quality, str(samples), error_text(entry["whole"]), error_text(entry["whole_coded"]),
                   f"{entry['processor_s']:.0f}" if "processor_s" in entry else "-", f"{entry['bytes'] / 1000:.0f}", f"{entry['bytes'] / plain['bytes']:.2f}" if plain else "-", f"{entry['seam']['at_seam'] / max(entry['seam']['beside'], 1e-9):.2f}"]


def time_rows(scenes):
    for name, scene in scenes.items():
        if seconds := scene.get("processor_s_a_megapixel"):
            yield [name, *(f"{seconds[quality]:.2f}" for quality in ("fast", "balanced", "high"))]


def write_page(file, kept):
    page = file.read_text()
    page = place(page, "denoise", "all", table(["scene", "denoised", "samples", "whole error, dB [95 %]", "the same, coded", "processor s", "kB", "of 32 samples'", "step at the seam, times"], list(rows(kept["scenes"])), 3))
    gains = [[name, *(f"{gains[CRF]:+.1f} ({min(gains.values()):+.1f})" if CRF in gains else "-" for gains in (gains_at_bytes(scene["entries"], denoised) for denoised in CURVES[1:]))]
             for name, scene in kept["scenes"].items() if any("curve" in entry for entry in scene.get("entries", []))]
    if gains:
        page = place(page, "denoise-bytes", "all", table(["scene", *(f"{quality}, {samples} samples" for quality, samples in CURVES[1:])], gains, 1))
    if times := list(time_rows(kept["scenes"])):
        page = place(page, "denoise-time", "all", table(["processor seconds a megapixel", "fast", "balanced", "high"], times, 1))
    file.write_text(page)


def draw(file, scenes):
    """Whole error against processor seconds (as rendered by one path) and against bytes."""
    import matplotlib.pyplot as plt
    from charts import looks
    from drawing import STYLE, plain_number
    drawn = {name: scene["entries"] for name, scene in scenes.items() if any("curve" in entry for entry in scene.get("entries", []))}
    with plt.rc_context(STYLE):
        figure, rows_of_axes = plt.subplots(2, len(drawn), figsize=(looks.PAGE_IN, 6.4), squeeze=False, sharey="row", layout="constrained")
        for (name, entries), upper, lower in zip(drawn.items(), *rows_of_axes):
            for kind, title, colour in (("off", "as rendered", "#7f8c8d"), ("balanced", "denoised", "#145a32")):
                chosen = sorted((entry["processor_s"], entry["whole"]["db"], entry["samples"]) for entry in entries if entry["denoise"] == kind)
                upper.plot(*zip(*[(seconds, db) for seconds, db, _ in chosen]), color=colour, marker="o", markersize=4, label=title)
                for seconds, db, samples in chosen:
                    upper.annotate(str(samples), (seconds, db), textcoords="offset points", xytext=(4, -9), fontsize=looks.SMALL, color=colour)
            for (kind, samples), colour, line in zip(CURVES, ("#7f8c8d", "#145a32", "#145a32"), ("-", "--", "-")):
                points = next((entry["curve"] for entry in entries if (entry["denoise"], entry["samples"]) == (kind, samples)), [])
                label = f"{samples} samples" + ("" if kind == "off" else ", denoised")
                lower.plot([point["bytes"] / 1000 for point in points], [point["db"] for point in points], color=colour, linestyle=line, marker="o", markersize=3, label=label)
            upper.set_title(name)
            for axes, what in ((upper, "processor seconds"), (lower, "kB")):
                axes.set_xscale("log")
                axes.set_xlabel(what)
                axes.xaxis.set_major_formatter(plain_number)
                axes.xaxis.set_minor_formatter("")
        for axes in (rows_of_axes[0][0], rows_of_axes[1][0]):
            axes.set_ylabel("whole error, dB")
            axes.legend(fontsize=looks.SMALL, loc="lower right")
        gains = looks.span([wholes["balanced", 4] - wholes["off", 4] for entries in drawn.values()
                            for wholes in [{(entry["denoise"], entry["samples"]): entry["whole"]["db"] for entry in entries}] if {("off", 4), ("balanced", 4)} <= set(wholes)])
        looks.title(figure, looks.told("Denoised, 4 samples a pixel have {gains} dB more than as rendered", "Denoising", gains=gains),
                    f"Spheres of {SPHERE}, views of {VIEW} at {FOV} degrees from their centre. Above: whole error against the time of one processor, uncoded; numbers are samples a pixel. Below: against bytes.")
        looks.save(figure, file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, default=REPOSITORY / "build/release/bin")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("denoise-work"))
    parser.add_argument("--scenes", default=",".join(TRUTH_SAMPLES))
    parser.add_argument("--time", action="store_true")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=REPOSITORY / "docs/results/denoise.json")
    options = parser.parse_args()
    programs = Programs(options.bin)
    kept = json.loads(options.out.read_text()) if options.out.exists() else {"scenes": {}}
    if options.page:
        draw(options.out.with_suffix(".svg"), kept["scenes"])
        return write_page(options.out.with_suffix(".md"), kept)
    settings = {"sphere": SPHERE, "view": VIEW, "fov_deg": float(FOV), "crf": CRF, "seed": SEED, "truth_seeds": TRUTH_SEEDS, "frame": 0}
    for name in options.scenes.split(","):
        scene = REPOSITORY / f"scenes/descriptions/{name}.json"
        found = {"processor_s_a_megapixel": processor_seconds(programs, scene, options.work / name)} if options.time else measured(programs, scene, options.work / name)
        kept["scenes"].setdefault(name, {}).update(found)
        kept |= {"settings": settings, "versions": versions(options.bin / "equistream", REPOSITORY), "machine": machine()}
        write_whole(options.out, result_text(kept))


if __name__ == "__main__":
    main()
