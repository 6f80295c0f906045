"""Everything that the study has rendered of a scene, as specifications: what the experiments take, and what a plan counts."""

import dataclasses
import math

from presets import SEEDS, TRUTH_SEEDS

EYES = ("left", "right")
PLACES = ("left", "centre", "right")
SAMPLES_SEED = 11
MARGIN_VIEW_DEG = 120
UNBIASED = ("--unbiased",)
"""What eyes are compared with leaves nothing out of the light; what is streamed is rendered as users do."""
WHOLE = ("--layers", "--patches")
"""Beside render's own planes: the tracks that `play` fills gaps from unless told otherwise."""
DEPTH, WITH_MIRRORS, WITH_MOTION = ("--aovs", "depth"), ("--aovs", "depth,specular,virtual"), ("--aovs", "depth,motion")


def size_text(size):
    return f"{size[0]}x{size[1]}"


@dataclasses.dataclass(frozen=True)
class Render:
    """One call of `render`: a main picture for each of `eyes`, and a small one."""
    name: str
    seed: int
    samples: int
    size: tuple
    eye: str
    small: bool = False
    fov_deg: float = 0
    """Of a perspective view; 0: a sphere."""
    options: tuple = DEPTH
    frames: int = 0
    """Of the first ones; 0: all the preset's."""
    denoise: str = "off"
    window_pixels: int = 0
    """Of a window beside it."""

    def words(self):
        view = ["--camera", "perspective", "--fov", f"{self.fov_deg:g}"] if self.fov_deg else []
        return [*view, "--eye", self.eye, "--size", size_text(self.size), *(["--small", "right"] if self.small else []), "--spp", self.samples,
                "--seed", self.seed, *(["--denoise", self.denoise] if self.denoise != "off" else []), *self.options]

    def samples_a_frame(self):
        eyes = 2 if self.eye == "both" else 1
        pixels = self.size[0] * self.size[1] * (17 / 16 if self.small else 1)
        return (eyes * pixels + self.window_pixels) * self.samples


def truth(preset, scene, seed):
    """Both eyes, which views of `seed` are compared with; motion is what flicker goes along."""
    own = TRUTH_SEEDS[seed]
    return Render(f"truth-{own}", own, preset.truth_samples_of(scene), preset.eye, "both", fov_deg=preset.fov_deg, options=(*WITH_MOTION, *UNBIASED))


def whole_sphere(preset, place, seed):
    """With all that render's defaults and its tracks for gaps give: what the default way of playing takes."""
    return Render(f"whole-{place}-{seed}", seed, preset.sphere_samples, (preset.sphere_width, preset.sphere_width // 2), place, options=WHOLE,
                  denoise=preset.denoise)


def perspective(preset, seed):
    """The paper's first system: the left eye and a small right one."""
    return Render(f"perspective-{seed}", seed, preset.eye_samples, preset.eye, "left", small=True, fov_deg=preset.fov_deg,
                  denoise=preset.denoise)


def right_eye(preset, seed):
    return Render(f"right-{seed}", seed, preset.eye_samples, preset.eye, "right", fov_deg=preset.fov_deg, denoise=preset.denoise)


def wide_sphere(preset, place, seed):
    """As wide as the preset renders them, with a small right eye."""
    size = (preset.sphere_width, preset.half_width)
    return Render(f"sphere-{place}-{seed}", seed, preset.sphere_samples, size, place, small=place != "right", denoise=preset.denoise)


def parity_sphere(preset, place, seed, width):
    """Of a width that is not filtered from the wide one, and few frames of it."""
    return dataclasses.replace(wide_sphere(preset, place, seed), name=f"sphere-{place}-{seed}-of-{width}", size=(width, width // 2),
                               frames=preset.parity.frames)


def window(preset, seed, columns, across_deg, high_deg):
    """What the head looks at, of a sphere of so many columns, and a coarse sphere around it."""
    options = (*DEPTH, "--window", f"gaze,{across_deg:g}x{high_deg:g}", "--density", columns)
    pixels = round(columns / 360 * across_deg) * round(columns / 360 * high_deg)
    return Render(f"window-{columns}-{seed}", seed, preset.sphere_samples, (preset.base_width, preset.base_width // 2), "centre", options=options,
                  denoise=preset.denoise, window_pixels=pixels)


def base(preset, seed):
    """The coarse sphere alone."""
    return Render(f"base-{seed}", seed, preset.sphere_samples, (preset.base_width, preset.base_width // 2), "centre", denoise=preset.denoise)


def margin_view(preset, seed):
    """As dense as an eye's, and wider by a margin on every side."""
    wider = math.tan(math.radians(MARGIN_VIEW_DEG) / 2) / math.tan(math.radians(preset.fov_deg) / 2)
    size = tuple(2 * round(side * wider / 2) for side in preset.eye)
    return Render(f"margin-{seed}", seed, preset.eye_samples, size, "centre", fov_deg=MARGIN_VIEW_DEG, denoise=preset.denoise)


def geometry(name, place, seed, width, small, options):
    """Of the pixel centres of a sphere whose colours come from elsewhere (narrowed.py): without light."""
    return Render(f"geometry-{name}", seed, 1, (width, width // 2), place, small=small, options=(*options, "--max-bounces", "0"))


def eyes_geometry(preset):
    """Of the pixel centres of both eyes: how far what they see is, and whether it is a mirror."""
    return Render("geometry-eyes", SEEDS[0], 1, preset.eye, "both", fov_deg=preset.fov_deg, options=("--aovs", "depth,specular"))


def moved_eyes(preset, scene, name, seed, path):
    """The truth of a head that follows another path."""
    own = TRUTH_SEEDS[seed]
    return dataclasses.replace(truth(preset, scene, seed), name=f"eyes-{name}-{own}", options=("--path", path, "--aovs", "none", *UNBIASED))


def noisy_sphere(preset, samples):
    width = preset.half_width
    return Render(f"samples-{samples}", SAMPLES_SEED, samples, (width, width // 2), "centre", denoise=preset.denoise)


def every_render(preset, scene):
    """Of one scene, but for geometry, which takes one sample, and for single frames of heads that have moved or of windows that follow them."""
    for seed in SEEDS:
        yield perspective(preset, seed)
        yield right_eye(preset, seed)
        yield truth(preset, scene, seed)
        yield whole_sphere(preset, "centre", seed)
        for place in PLACES:
            yield wide_sphere(preset, place, seed)
    for width in preset.parity.widths:
        if not preset.is_filtered(width):
            yield parity_sphere(preset, "centre", SEEDS[0], width)
    for samples in preset.samples_swept:
        yield noisy_sphere(preset, samples)
    if preset.windows and "window" not in preset.left_out:
        for seed in SEEDS:
            yield base(preset, seed)
            yield margin_view(preset, seed)
            for spec in preset.windows:
                yield window(preset, seed, *spec)
