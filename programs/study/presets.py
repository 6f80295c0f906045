"""How much of the study is done: sizes, frames, samples and scenes of each preset. One table; nothing else knows such a number.

Spheres are rendered once, as wide as `sphere_width`, and those that are a whole fraction of it as wide are filtered from them (narrowed.py): a sphere of
half the width has four times the samples a pixel. Others are rendered by themselves.
"""

import dataclasses
import math

REAL_SCENES = ("sponza-crytek", "sibenik", "voxel-city", "kitchen", "san-miguel")
BUNDLED_SCENES = ("pavilion",)
OF_SCENES = ("systems", "parity", "parsimony", "where", "moved", "related", "window")
OF_THEIR_OWN = ("stability", "latency")
EXPERIMENTS = (*OF_SCENES, *OF_THEIR_OWN)
"""Each a module of experiments/, of every scene or of scenes of its own."""
SEEDS = (1, 2)
TRUTH_SEEDS = {1: 21, 2: 22}
"""Of truths, by the seed of the views that are put beside them: the whole error wants noise that no view has."""
KNOWN_DB = 0.3
"""How well the whole error of what is judged is to be known: half of its interval of 95 %."""
# Scene -> the middle of the frames that are studied. san-miguel's branch hangs before the left eye there (tests/study/reproject/renders.py).
MIDDLE_FRAMES = {"kitchen": 30, "san-miguel": 41, "sibenik": 30, "sponza-crytek": 62, "voxel-city": 30, "pavilion": 30}


def focal_length_px(eye, fov_deg):
    """Of a view of `eye` (width, height) pixels, `fov_deg` across."""
    return eye[0] / (2 * math.tan(math.radians(fov_deg) / 2))


def matching_width(eye, fov_deg):
    """Of the sphere that is as dense as the view's middle: 2 pi f columns (DESIGN's bound)."""
    return 2 * math.pi * focal_length_px(eye, fov_deg)


@dataclasses.dataclass(frozen=True)
class Parity:
    """The spheres that are put beside views."""
    widths: tuple
    """With as many samples a pixel as all others; all but the sphere of sphere_width are rendered for this alone."""
    frames: int
    """The first of the preset's: the widest spheres take long."""


@dataclasses.dataclass(frozen=True)
class Preset:
    name: str
    scenes: tuple
    frames: int
    """In a row, at the scene's rate."""
    eye: tuple
    sphere_width: int
    """As rendered."""
    eye_samples: int
    sphere_samples: int
    """A pixel of those that are rendered and not filtered, each seed."""
    parity: Parity
    codecs: tuple
    crfs: tuple
    """The paper's two."""
    curve_crfs: tuple
    """Of curves of accuracy against bytes: at least four, for BD-rates."""
    coarse_crfs: tuple
    """Further ones, of spheres alone: what a wide one has at its worst, a view has at its best."""
    repeat: int
    """Timings of depth, reprojection and fill of each frame."""
    budgets_px: tuple
    """Error budgets of the client's model and of mesh cells, for their knees."""
    model_rounds: int
    breakers: tuple
    """Empty: all."""
    every_value: bool
    """Of the knobs of breakers and networks; else few."""
    latency_seconds: int
    samples_swept: tuple
    """A pixel, of spheres of half the width, whose noise is charted."""
    model_words: tuple = ()
    """Of `equistream model`, beside: how many rays, where its own are too many."""
    fov_deg: float = 90
    timed: bool = True
    """What is charted in milliseconds runs alone."""
    steps: int = 0
    """Programs that it runs in all, as it comes: what is left is told by it. 0: not counted."""
    left_out: tuple = ()
    """Experiments that are measured only where --experiments names them."""
    windows: tuple = ()
    """Of experiment window: columns of the sphere that each is part of, and the degrees that it is wide and high."""
    base_width: int = 480
    """Of the sphere around them."""
    denoise: str = "off"
    """Of all that is streamed, as `render --denoise`; truths are never denoised."""
    truth_samples: dict = dataclasses.field(default_factory=dict)
    """Scene -> samples a pixel of each truth, so that the whole error is known within KNOWN_DB; of others eye_samples."""

    @property
    def half_width(self):
        return self.sphere_width // 2

    @property
    def focal_px(self):
        return focal_length_px(self.eye, self.fov_deg)

    def truth_samples_of(self, scene):
        return self.truth_samples.get(scene, self.eye_samples)

    def is_filtered(self, width):
        """From the sphere of sphere_width, or that itself."""
        return self.sphere_width % width == 0

    def frame_range(self, scene):
        first = max(0, MIDDLE_FRAMES.get(scene, self.frames // 2) - self.frames // 2)
        return first, first + self.frames - 1


SMOKE_STEPS = 264
"""Counted of the experiments; a test says when it is off by more than a tenth."""
PRESETS = {preset.name: preset for preset in (
    # As small as small streams allow, which are a quarter as high and coded at 64 pixels or more.
    Preset("smoke", BUNDLED_SCENES, frames=2, eye=(448, 256), sphere_width=1024, eye_samples=2, sphere_samples=1,
           parity=Parity((640, 1024), frames=1), codecs=("h264",), crfs=(24,), curve_crfs=(16, 20, 24, 28), coarse_crfs=(), repeat=1, budgets_px=(1 / 4, 4),
           model_rounds=2, samples_swept=(1, 2), breakers=("near",), every_value=False,
           latency_seconds=2, steps=SMOKE_STEPS, windows=((1024, 120, 90),), base_width=256, model_words=("--visibility-rays", 2 ** 22, "--rays", 2 ** 18), timed=False, left_out=("where", "moved", "related", "window")),
    Preset("small", REAL_SCENES, frames=4, eye=(640, 360), sphere_width=1920, eye_samples=8, sphere_samples=8, denoise="balanced",
           parity=Parity((976, 1360, 1920, 2720, 3840), frames=1), codecs=("h264",), crfs=(16, 24), curve_crfs=(16, 20, 24, 28), coarse_crfs=(34, 40), repeat=2, budgets_px=(1 / 16, 1 / 4, 1, 4, 16),
           model_rounds=40, samples_swept=(1, 2, 4, 8, 16, 32), breakers=(), every_value=True, latency_seconds=7,
           windows=((1920, 120, 90), (2880, 112, 80), (3840, 96, 72)),
           truth_samples={"kitchen": 64, "sibenik": 64, "sponza-crytek": 32, "voxel-city": 32, "san-miguel": 32}),
    Preset("paper", REAL_SCENES, frames=150, eye=(1920, 1080), sphere_width=3840, eye_samples=1000,
           sphere_samples=250, parity=Parity((2000, 3840, 5760, 7680, 11520), frames=2), codecs=("h264", "h265"), crfs=(16, 24), curve_crfs=(12, 16, 20, 24, 28, 32), coarse_crfs=(38, 44), repeat=3,
           budgets_px=(1 / 16, 1 / 4, 1, 4, 16), model_rounds=40, samples_swept=(1, 4, 16, 64, 256, 1024), breakers=(), every_value=True, latency_seconds=30,
           windows=((5760, 120, 90), (11520, 96, 72)), base_width=1440),
)}
