"""Tries a settings file with its own commands: render, encode, play. Both truths then say how accurate it is, which is what `fit` promises.

With noise of its own: the search takes what looks best on one noise, and on another that is worse.
"""

import dataclasses
import hashlib
import json
import statistics

import found
from steps import Failed, write_if_other

from .report import level_text, sections_of, settings_text
from .search import BEST_CRF, WORST_CRF, mean_is_known
from .work import known


SEEDS = tuple(range(101, 133))
"""None of the search's, none of a truth's."""


def with_point(chosen, trials=0, **figures):
    return dataclasses.replace(chosen, trials=trials, point=dataclasses.replace(chosen.point, **figures))


def measured(work, chosen, asked, codec):
    """`chosen` with the figures that its file's own commands have: of as many SEEDS together as it takes, and an interval that holds the interval of each."""
    model = work.folder / chosen.model_file if chosen.model_px else chosen.geometry_file
    sections = sections_of(dataclasses.replace(chosen, geometry_file=model), asked, codec)
    errors, sent = [], []
    for seed in SEEDS:
        entry, size = played(work, sections, seed)
        errors.append(found.error(entry, kind=found.WHOLE))
        sent.append(size)
        if mean_is_known([error["db"] for error in errors]):
            break
    all_of_them = found.together(errors)
    lows, highs = ([error[end] for error in errors] for end in ("db_low", "db_high"))
    frames = asked.last - asked.first + 1
    return with_point(chosen, db=known(all_of_them["db_low" if found.only_bounded(all_of_them) else "db"], frames), low=None if None in lows else min(lows),
                      high=None if None in highs else max(highs), bytes=statistics.mean(sent) / frames, trials=len(errors))


def played(work, sections, seed):
    """The whole error of what these settings show, and the stream's bytes."""
    light, name = (f"trial-{hashlib.sha256(settings_text([], part).encode()).hexdigest()[:12]}-{seed}" for part in ({"render": sections["render"]}, sections))
    frames, stream, views, settings = f"trials/{light}", f"trials/{name}.mp4", f"trials/{name}-views", f"trials/{name}.ini"
    rendering = f"trials/{light}.ini"
    write_if_other(work.folder / rendering, settings_text([], {"render": sections["render"]}))
    write_if_other(work.folder / settings, settings_text([], sections))
    words = "--progress", "none", "--out"
    work.steps.run(f"render-{light}", "render", work.given, "--frames", work.frames, "--seed", seed, "--settings", rendering, "--json", *words, frames, fresh=frames)
    work.steps.run(f"encode-{name}", "encode", frames, "--json", "--settings", settings, *words, stream)
    work.steps.run(f"play-{name}", "play", stream, "--settings", settings, *words, views)
    tracks = json.loads(work.steps.output_of(f"encode-{name}"))["tracks"]
    return work.wholly(name, [views], work.truths()), sum(track["bytes"] for track in tracks)


def tried_file(fit, chosen, level=None, limit=None):
    """Measured so; coded finer until it has `level`, or coarser until it takes at most `limit` bytes a frame, where one is asked for. Failed where no coding does."""
    def taken(each):
        return each.bytes_a_frame(fit.path_frames)

    tried = measured(fit.work, chosen, fit.asked, fit.codec)
    while level is not None and tried.point.db < level:
        if tried.crf <= BEST_CRF:
            raise Failed(f"--db {level:g}: not to be had: the search had {chosen.point.db:.2f} dB, on other noise the settings file's own commands have "
                         f"{tried.point.db:.2f} at CRF {tried.crf}")
        tried = measured(fit.work, with_point(tried, crf=tried.crf - 1), fit.asked, fit.codec)
    while limit is not None and taken(tried) > limit:
        if tried.crf >= WORST_CRF:
            raise Failed(f"--kb {limit / 1000:g}: the search had {taken(chosen):,.0f} bytes a frame, the settings file's own commands have {taken(tried):,.0f} at CRF {tried.crf}")
        tried = measured(fit.work, with_point(tried, crf=tried.crf + 1), fit.asked, fit.codec)
    other = f", coded {'finer' if tried.crf < chosen.crf else 'coarser'}: CRF {tried.crf} in place of {chosen.crf}" if tried.crf != chosen.crf else ""
    fit.why.append(f"by this file's own commands, with {tried.trials} seeds that the search did not use: {level_text(tried.point)} dB (the interval holds each of them) and "
                   f"{taken(tried):,.0f} bytes a frame, where the search had {chosen.point.db:.2f} and {taken(chosen):,.0f}{other}")
    return tried
