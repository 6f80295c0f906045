"""Reading the study's results, OUT/EXPERIMENT/SCENE.json: what charts, tables and the page share; and the whole and the noise-free error (docs/compare.md),
of one eye or of views together.
"""

import math
import pathlib

from presets import REAL_SCENES
from render_list import EYES
from steps import read_json

KINDS = WHOLE, NOISE_FREE = "whole", "noise_free"
"""Of error. Results from before the whole error have none of it."""


def titles_of(results):
    """Of all systems; those of a result that has the most come first."""
    most_first = sorted(results.values(), key=lambda result: -len(result["titles"]))
    return {name: title for result in most_first for name, title in result["titles"].items()}


def light_text(result):
    """How views and spheres of a result were rendered."""
    settings = result["settings"]
    return f" ({settings['eye_samples']} samples, {'denoised' if settings.get('denoise', 'off') != 'off' else 'as rendered'})"


def load(folder, experiment):
    """{scene: result}, in the presets' order, then by name."""
    files = {file.stem: file for file in sorted((pathlib.Path(folder) / experiment).glob("*.json"))}
    order = [scene for scene in REAL_SCENES if scene in files] + [scene for scene in files if scene not in REAL_SCENES]
    return {scene: read_json(files[scene]) for scene in order}


def error(scored, eye=None, scale="linear", kind=NOISE_FREE):
    """Of one eye, or of both together; None where this kind was not measured."""
    if kind not in scored:
        return None
    return together([scored[kind][name][kind][scale] for name in ([eye] if eye else EYES)])


def only_bounded(figures):
    """Whether the interval reaches zero error, so that its dB are a bound. Results say it where it is so."""
    return figures.get("only_bounded", False)


def db(scored, eye=None, scale="linear", kind=NOISE_FREE):
    """Of error(): a bound where its interval reaches zero; None where even that is unknown."""
    figures = error(scored, eye, scale, kind)
    return figures and figures["db_low" if only_bounded(figures) else "db"]


def whole_db(scored, eye=None):
    return db(scored, eye, kind=WHOLE)


def seen_db(scored):
    """What a viewer gets of both eyes: the whole error of display values."""
    return db(scored, scale="display", kind=WHOLE)


def seen_interval_db(scored):
    return interval_db(scored, scale="display", kind=WHOLE)


def interval_db(scored, eye=None, scale="linear", kind=NOISE_FREE):
    """The ends of error()'s interval; None where one is open."""
    figures = error(scored, eye, scale, kind)
    return (figures["db_low"], figures["db_high"]) if figures else (None, None)


def known_within_db(figures):
    """Half of an interval; infinite where an end is open."""
    low, high = figures["db_low"], figures["db_high"]
    return math.inf if low is None or high is None else (high - low) / 2


def whole_errors(result):
    """The linear whole error of every eye that a result holds, at any depth."""
    if isinstance(result, (list, tuple)):
        for each in result:
            yield from whole_errors(each)
    elif isinstance(result, dict):
        if "linear" in (result.get(WHOLE) or ()):
            yield result[WHOLE]["linear"]
        for key, each in result.items():
            if key not in ("gaps", "flicker"):
                yield from whole_errors(each)


def noisy(scored):
    """PSNR, SSIM and what goes with them, by eye: of one seed's views beside a truth whose noise they do not share."""
    return scored.get("against_other_seed") or scored[WHOLE]


def psnr(scored, eye=None):
    """Of one eye, or of both eyes' pooled squares; None where identical."""
    return together_psnr([noisy(scored)[name]["mean_square"] for name in ([eye] if eye else EYES)])


def ssim(scored, eye):
    return noisy(scored)[eye]["ssim"]


def together_psnr(squares):
    return together([{"mean_square": square / 255 ** 2, "mean_square_low": 0, "mean_square_high": 0} for square in squares])["db"]


def ceiling_psnr(result, eye=None):
    """Truth against truth."""
    return together_psnr([result["ceiling"][name]["mean_square"] for name in ([eye] if eye else EYES)])


def ms(entry):
    """A frame, all stages of the client; None before coding, where frames are read and not decoded."""
    return sum(entry["ms"].values()) if entry["codec"] else None


def all_bytes(entry):
    return sum(entry["bytes_a_frame"].values()) if "bytes_a_frame" in entry else None


def coding_name(entry):
    return f"{ {'h264': 'H.264', 'h265': 'H.265'}[entry['codec']] }, CRF {entry['crf']:g}" if entry["codec"] else "uncoded"


def decibels(mean_square):
    return -10 * math.log10(mean_square) if mean_square > 0 else None


def together(figures):
    """Of views as large as each other. One source's noise is in both eyes, so that intervals add rather than their squares."""
    pooled = {key: sum(figure[key] for figure in figures) / len(figures) for key in ("mean_square", "mean_square_low", "mean_square_high")}
    return {**pooled, "db": decibels(pooled["mean_square"]), "db_low": decibels(pooled["mean_square_high"]),
            "db_high": decibels(pooled["mean_square_low"]), "only_bounded": pooled["mean_square_low"] <= 0}


def gap_error(by_eye, kind=NOISE_FREE):
    """What lies in what the source did not see, and all of the error: linear mean squares of all eyes together. An eye without gaps says nothing of them."""
    eyes = by_eye.values()
    in_gaps = sum(eye["gaps"]["fraction"] * eye["gaps"][kind]["linear"]["mean_square"] for eye in eyes if "gaps" in eye)
    return max(0.0, in_gaps), sum(eye[kind]["linear"]["mean_square"] for eye in eyes)
