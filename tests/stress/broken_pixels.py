"""NaN, infinity and absurd numbers in colour and depth of rendered frames: nothing of it may reach an eye or stop a program.

Frames are damaged on disk and played by `equistream play --depth exact`, into linear EXR (where a NaN would show), and encoded.
"""

import numpy as np
import OpenEXR

import chains
import played
from breakers import Breaker, at_arm_length

BREAKERS = (Breaker("broken pixels", "near", "share of broken pixels in colour and depth", (0, 0.0001, 0.001, 0.01, 0.05, 0.2), (0, 0.001, 0.05),
                    at_arm_length),)
POISON = {"colour": (np.nan, np.inf, -np.inf, -3.0, 6e4), "depth": (np.nan, -np.inf, -1.0, 0.0, 1e-30, np.inf, 3e38)}
SEED = 5


def break_file(file, share, random):
    """Some pixels of every picture, each with one kind of poison in all its channels."""
    source = OpenEXR.File(str(file), separate_channels=True)
    for part in source.parts:
        for name, channel in part.channels.items():
            kind = "depth" if name.endswith("depth.Z") else "colour" if name in "RGB" else None
            if kind is None:
                continue
            pixels = channel.pixels
            hit = random.random(pixels.shape) < share
            pixels[hit] = random.choice(POISON[kind], hit.sum()).astype(pixels.dtype)
    OpenEXR.File(source.parts).write(str(file))


def scores(program, breaker, share, work):
    """Method -> figures, of what `play` made of a damaged folder."""
    renders = chains.Renders(program, breaker, share, work)
    truth = {eye: chains.es.read_frame(work / "truth" / eye / "frame.0000.exr") for eye in chains.EYES}
    # Exact depth of the eyes lies beside the sphere.
    for eye in chains.EYES:
        (work / "truth" / eye).rename(work / "sphere" / eye)
    random = np.random.default_rng(SEED)
    for file in sorted((work / "sphere").rglob("*.exr")):
        break_file(file, share, random)
    played.run(program, "encode", work / "sphere", "--out", work / "sphere.mp4", "--progress", "none")
    best = chains.ceiling(lambda eye: [renders.frame("own", eye)], lambda eye: [truth[eye]])
    return {chains.CEILING: best.figures(), **{method: score(program, work, method, truth).figures(best) for method in chains.es.METHODS}}


def score(program, work, method, truth):
    out = work / f"eyes-{method}"
    played.run(program, "play", work / "sphere", "--depth", "exact", "--method", method, "--fill", chains.chain(), "--size", chains.size_text(chains.EYE_SIZE),
               "--format", "exr", "--reliability", "--progress", "none", "--out", out)
    found = chains.Score()
    for eye, frame in truth.items():
        colour = chains.es.read_frame(out / eye / "frame.0000.exr")["colour"]
        if not np.isfinite(colour).all():
            raise RuntimeError(f"{method}: expected finite colours, found {int((~np.isfinite(colour)).sum())} others in the {eye} eye")
        shown, true = (chains.es.to_display(picture, frame.info.exposure) for picture in (colour, frame["colour"]))
        found.add(shown, true, played.plane(out, "gaps", eye, 0) != 0, played.plane(out, "reliability", eye, 0))
    return found
