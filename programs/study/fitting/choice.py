"""What is measured in which order, and what is chosen of it: search.py's choices on work.py's measurements."""

import dataclasses
import math

from found import known_within_db
from presets import KNOWN_DB
from rates import bytes_for
from steps import Failed

from .search import BEST_CRF, CLOSE_DB, cheapest, cheapest_over, coarsest_crf, highest, is_worth, last_holding, max_gain_db
from .work import Fill, Light, Measurer, by_model, by_scene, by_streamed_depth, pair, perspective, windowed

TRACKS = {"small-wide": "small", "hidden": "hidden", "patches": "patches"}
"""Fill pass -> the track it fills from."""
FIRST_CRF = 24
ROOM_DB = 1
"""That coding may lose."""
DENOISERS = "off", "balanced"
BUDGETS_PX = (1 / 4, 1, 4, 16)
SHARES = (0.1, 0.05, 0.02)
SHARES_OF_WINDOWS = (0.2, 0.3)
"""Tried too: their colours take few bytes, of which a tenth is too little for depth."""
TRACKS_FROM = 512
"""Columns: small streams and patches of narrower spheres are too small to be coded."""
FINER = 4
"""Steps of the CRF by which finer coding is asked what it would gain."""
STEPS = {"light": 40, "sphere": 32, "gaps": 8, "depth": 56, "window": 8, "views": 15, "trial": 12}
"""Stages in their order, and how many programs each usually runs."""


class Unreachable(Exception):
    """What is nearest to it: the best point."""

    def __init__(self, best):
        super().__init__()
        self.best = best


@dataclasses.dataclass(eq=False)
class Chosen:
    point: object
    """As it is streamed and played."""
    fill: Fill
    bytes_once: int
    model_px: float = 0
    model_file: str = ""
    depth_share: float = 0
    told: bool = False
    """Of mirrors and glass."""
    geometry_file: object = None
    trials: int = 0
    """Seeds that its file was tried with."""

    def bytes_a_frame(self, path_frames):
        return self.point.bytes + self.bytes_once / path_frames

    @property
    def light(self):
        return self.point.way.light

    @property
    def width(self):
        return self.point.width

    @property
    def crf(self):
        return self.point.crf


def taken_text(is_taken):
    return "taken" if is_taken else "not taken"


FIRST_DB, STEP_DB, CLOSE_LEVEL_DB, LEVELS_DB = 28, 4, 0.25, (1, 80)
"""Accuracies that are tried for a number of bytes."""


def best_for_bytes(limit, fit_for):
    """(fit, chosen) of the highest accuracy within so many bytes a frame. What is sent once is shared out over the path. fit_for(level) makes a Fit. Failed
    where no accuracy is within them."""
    seen = []

    def within(level):
        fit = fit_for(level)
        try:
            chosen = fit.run()
        except Unreachable:
            return None
        seen.append(chosen.bytes_a_frame(fit.path_frames))
        return (fit, chosen) if seen[-1] <= limit else None

    found = highest(within, FIRST_DB, STEP_DB, CLOSE_LEVEL_DB, LEVELS_DB)
    if found is None:
        raise Failed(f"--kb {limit / 1000:g}: not to be had" + (f"; the fewest found are {min(seen):,.0f} bytes a frame" if seen else ""))
    return found[1]


class Fit:
    def __init__(self, work, asked, codec, level, path_frames, measure=None):
        self.work, self.asked, self.level, self.path_frames = work, asked, level, path_frames
        self.codec, self.measure = codec, measure or Measurer(work, codec)
        self.at = self.measure.at
        self.why, self.told = [], False

    def begin(self, stage):
        """A stage of STEPS, from which the steps left are estimated."""
        names = [name for name in STEPS if name != "window" or self.asked.window]
        self.work.steps.progress.expect(sum(STEPS[name] for name in names[names.index(stage):]))

    def run(self):
        self.begin("light")
        self.light = self.cheapest_light()
        self.begin("sphere")
        self.told, width, crf = self.sphere()
        self.begin("gaps")
        fill = self.fill(width, crf)
        self.begin("depth")
        chosen = self.choose(fill, width, crf)
        if self.asked.window:
            self.begin("window")
            chosen = self.looked_at(chosen)
        self.begin("views")
        self.views = [(way, self.finest(way, None, crf)) for way in (perspective(self.light), pair(self.light))]
        self.say_how_well_known(chosen.point)
        return chosen

    def say_how_well_known(self, point):
        within = known_within_db({"db_low": point.low, "db_high": point.high})
        if within > KNOWN_DB:
            amount = "" if math.isinf(within) else f" to {within:.1f} dB"
            self.why.append(f"the error is not known well{amount}: more --truth-spp than {self.asked.truth_samples} or more --frames")

    # -- samples and denoiser

    def cheapest_light(self):
        """Of each denoiser the least samples a pixel that a sphere that matches the eyes takes uncoded, with ROOM_DB to spare; of these, whichever codes
        to fewer bytes."""
        found = [least for denoise in DENOISERS if (least := self.fewest_samples(denoise))]
        with_room = [light for light, db in found if db >= self.level + ROOM_DB]
        width = self.asked.matching_width
        coded = {light: self.finest(by_scene(Fill(), False, light), width, FIRST_CRF) for light in with_room}
        coded = {light: point.bytes for light, point in coded.items() if point}
        chosen = min(coded, key=coded.get) if coded else max(found, key=lambda each: each[1])[0]
        for light, db in found:
            coded_text = f", {coded[light]:,.0f} bytes a frame coded to {self.level:g} dB" if light in coded else ""
            self.why.append(f"{light.title}: {db:.2f} dB uncoded at {width} columns, {self.work.light_cpu_s(width, light):.1f} processor seconds{coded_text}: "
                            f"{taken_text(light is chosen)}")
        return chosen

    def fewest_samples(self, denoise):
        """(light, dB): the least with room, else the best; None without this denoiser."""
        best, samples = None, 1
        while samples <= self.asked.max_samples:
            light = Light(samples, denoise)
            try:
                db = self.at(by_scene(Fill(), False, light), self.asked.matching_width, None).db
            except Failed as failure:
                if denoise == "off" or "Open Image Denoise" not in str(failure):
                    raise
                self.why.append(f"denoised: not tried: {failure}")
                return best
            if best and db < best[1] + CLOSE_DB:
                break
            best = light, db
            if db >= self.level + ROOM_DB:
                break
            samples *= 2
        return best

    # -- the sphere

    def sphere(self):
        """Whether to tell of mirrors and glass, width and CRF: of the fewest bytes."""
        tried = (False, True) if self.helps_to_tell() else (False,)
        found, short = {}, []
        for told in tried:
            way = by_scene(Fill(), told, self.light)
            try:
                narrowest = self.narrowest(way)
                found[told] = self.fewest_bytes(way, narrowest), narrowest
            except Unreachable as unreachable:
                short.append(unreachable)
        if not found:
            raise max(short, key=lambda unreachable: unreachable.best.db)
        cheapest_told = min(found, key=lambda told: found[told][0].bytes)
        point, narrowest = found[cheapest_told]
        if len(tried) == 2:
            told_text, plain_text = (f"{found[told][0].bytes:,.0f} bytes a frame" if told in found else "not to be had" for told in (True, False))
            self.why.append(f"told of mirrors and glass: {told_text}, else {plain_text}: {taken_text(cheapest_told)}")
        self.why.append(f"{point.width} columns, {point.width / self.asked.matching:.2f} of 2 pi f, CRF {point.crf}: the fewest bytes; "
                        f"the narrowest that has it uncoded has {narrowest}")
        return cheapest_told, point.width, point.crf

    def helps_to_tell(self):
        """Whether it may, of mirrors and glass, by its interval: seen uncoded, on a sphere as dense as the eyes."""
        if not self.work.tells_of_mirrors("centre"):
            return False
        width = self.asked.matching_width
        told, plain = (self.at(by_scene(Fill(), told, self.light), width, None) for told in (True, False))
        helps = told.high is None or told.high >= plain.db + CLOSE_DB
        self.why.append(f"telling of mirrors and glass: {told.db - plain.db:+.2f} dB uncoded at {width} columns: {'tried' if helps else 'not taken'}")
        return helps

    def narrowest(self, way):
        """The narrowest sphere that has it uncoded."""
        widths = self.asked.widths
        found_width = last_holding(widths, lambda width: self.at(way, width, None).db >= self.level, widths.index(self.asked.matching_width))
        if found_width is None:
            raise Unreachable(self.at(way, widths[0], None))
        return found_width

    def finest(self, way, width, start):
        """The point of the largest CRF that has it; None where none has."""
        crf = coarsest_crf(lambda crf: self.at(way, width, crf).db, self.level, start)
        return None if crf is None else self.at(way, width, crf)

    def fewest_bytes(self, way, narrowest):
        """Its point, of all widths and CRFs."""
        start = FIRST_CRF

        def best_at(width):
            nonlocal start
            point = self.finest(way, width, start)
            if point is not None:
                start = point.crf
            return None if point is None else (point.bytes, point)

        least = cheapest([width for width in reversed(self.asked.widths) if width >= narrowest], best_at)
        if least is None:
            raise Unreachable(max((point for point in self.measure.tried.values() if point.way == way and point.crf is not None), key=lambda point: point.db))
        return least[1]

    # -- gaps

    def fill(self, width, crf):
        """The passes that are worth it, and the track they need."""
        fill = Fill()
        here = self.at(by_scene(fill, self.told, self.light), width, crf)
        in_gaps, all_of_it = self.measure.gap_error(here)
        share = min(1, in_gaps / all_of_it) if all_of_it > 0 else float(in_gaps > 0)  # of what noise made negative nothing is known
        left_db = max_gain_db(share)
        self.why.append(f"gaps hold {100 * share:.0f} % of the error: filling them better than by push-pull is worth {left_db:.2f} dB at most")
        if left_db >= CLOSE_DB and self.asked.last > self.asked.first:
            earlier = Fill("earlier,pushpull")
            gain_db = self.at(by_scene(earlier, self.told, self.light), width, crf).db - here.db
            self.why.append(f"pass earlier: {gain_db:+.2f} dB for no bytes: {taken_text(gain_db >= CLOSE_DB)}")
            if gain_db >= CLOSE_DB:
                fill, left_db = earlier, left_db - gain_db
        return self.with_track(fill, width, crf, share) if left_db >= CLOSE_DB else fill

    def with_track(self, fill, width, crf, share):
        """Of passes that tracks are sent for, the best that is worth its bytes. What part of the error in gaps each takes away, before
        push-pull, is found on the first frame of a sphere of half the width: renders with such tracks are slow."""
        trial_width = min((tried for tried in self.asked.widths if tried >= min(TRACKS_FROM, width)), key=lambda tried: abs(tried - width / 2))
        first = Measurer(self.work, self.codec, f"{self.asked.first}-{self.asked.first}")
        without = first.at(by_scene(Fill(on_trial=True), self.told, self.light), trial_width, crf)
        left_open, _ = first.gap_error(without)
        if left_open == 0:
            return fill
        gains = {}
        for fill_pass, track in TRACKS.items():
            if track != "hidden" and trial_width < TRACKS_FROM:
                continue
            point = first.at(by_scene(Fill(f"{fill_pass},pushpull", track, on_trial=True), self.told, self.light), trial_width, crf)
            left, times = first.gap_error(point)[0] / left_open, point.bytes / without.bytes
            gain_db = max_gain_db(share * (1 - left))
            worth = is_worth(gain_db, times, self.times_by_coding(width, crf, gain_db))
            self.why.append(f"pass {fill_pass}: {gain_db:+.2f} dB for {100 * (times - 1):.1f} % more bytes (by the first frame at {trial_width} columns): "
                            f"{'worth it' if worth else 'not worth it'}")
            if worth:
                gains[fill_pass] = gain_db
        if not gains:
            return fill
        best = max(gains, key=gains.get)
        return Fill(f"{best},{fill.passes}", TRACKS[best])

    def times_by_coding(self, width, crf, gain_db):
        """How much larger streams grow to gain as much by a finer CRF; None where they do not."""
        way = by_scene(Fill(), self.told, self.light)
        here = self.at(way, width, crf)
        self.at(way, width, max(BEST_CRF, crf - FINER))
        points = [(point.bytes, point.db) for point in self.measure.tried.values() if point.way == way and point.width == width and point.crf is not None]
        count = bytes_for(points, here.db + gain_db)
        return count / here.bytes if count else None

    # -- depth

    def choose(self, fill, width, crf):
        """The client's model, or depth that is streamed: whichever sends less along the whole path."""
        model, streamed = self.model(fill, width, crf), self.streamed(fill, width, crf)
        each = {chosen: (chosen.bytes_once, chosen.point.bytes) for chosen in (model, streamed) if chosen is not None}
        if not each:
            raise Unreachable(self.at(by_scene(fill, self.told, self.light), width, BEST_CRF))
        chosen = cheapest_over(self.path_frames, each)
        if len(each) == 2 and streamed.point.bytes > model.point.bytes:
            even = math.ceil(model.bytes_once / (streamed.point.bytes - model.point.bytes))
            self.why.append(f"geometry once sends less than depth with every frame from {even:,} frames on; the path has {self.path_frames}")
        for other, name in ((model, "depth by geometry"), (streamed, "streamed depth, mesh")):
            if other is None:
                self.why.append(f"{name}: does not come to it")
                continue
            along_mb = (other.bytes_once + self.path_frames * other.point.bytes) / 1e6
            self.why.append(f"{name}: {other.point.way.title.split(',')[0]}, {other.width} columns, CRF {other.crf}, {other.bytes_once:,} bytes once and {other.point.bytes:,.0f} a frame: "
                            f"{along_mb:,.1f} MB along the path's {self.path_frames} frames: {taken_text(other is chosen)}")
        return chosen

    def looked_at(self, chosen):
        """In a window, where that takes fewer bytes."""
        if chosen.fill.track:
            self.why.append(f"window: not tried: track {chosen.fill.track} goes with whole spheres")
            return chosen
        shares = (chosen.depth_share, *SHARES_OF_WINDOWS) if chosen.depth_share else (0,)
        ways = {share: by_streamed_depth(chosen.fill, self.told, self.light, share) if share else chosen.point.way for share in shares}
        points = {share: self.finest(windowed(way, self.asked.window), chosen.width, chosen.crf) for share, way in ways.items()}
        points = {share: point for share, point in points.items() if point is not None}
        if not points:
            self.why.append("window: does not come to it")
            return chosen
        share = min(points, key=lambda share: points[share].bytes)
        point = points[share]
        is_less = point.bytes < chosen.point.bytes
        self.why.append(f"window of {self.asked.window[0]:g}x{self.asked.window[1]:g} degrees: {point.bytes:,.0f} bytes a frame at CRF {point.crf}, "
                        f"{point.bytes / chosen.point.bytes:.2f} of the whole sphere's: {taken_text(is_less)}")
        return dataclasses.replace(chosen, point=point, fill=point.way.fill, depth_share=share) if is_less else chosen

    def model(self, fill, width, crf):
        """By the largest budget that costs less than CLOSE_DB; by the scene itself where none does."""
        scene, made = self.at(by_scene(fill, self.told, self.light), width, crf), {}

        def holds(budget_px):
            try:
                file, made[budget_px] = self.work.model(budget_px)
            except Failed as failure:
                print(failure)
                return False
            return self.at(by_model(fill, self.told, self.light, budget_px, file), width, crf).db > scene.db - CLOSE_DB

        budget_px = last_holding(BUDGETS_PX, holds, 2)
        if budget_px is None:
            once, way, file = self.work.scene_bytes(), by_scene(fill, self.told, self.light), ""
        else:
            file = made[budget_px]["model"]
            once, way = made[budget_px]["bytes"], by_model(fill, self.told, self.light, budget_px, file)
        point = self.finest(way, width, crf)
        return point and Chosen(point, fill, once, model_px=budget_px or 0, model_file=file, told=self.told, geometry_file=self.work.given)

    def streamed(self, fill, width, crf):
        """Of the smallest share of bits that costs less than CLOSE_DB; of this width or of a wider sphere, whose depth is finer too."""
        most = self.at(by_streamed_depth(fill, self.told, self.light, SHARES[0]), width, crf)
        share = last_holding(SHARES, lambda share: self.at(by_streamed_depth(fill, self.told, self.light, share), width, crf).db > most.db - CLOSE_DB)
        try:
            point = self.fewest_bytes(by_streamed_depth(fill, self.told, self.light, share), width)
        except Unreachable:
            return None
        return Chosen(point, fill, 0, depth_share=share, told=self.told)
