"""Curves that charts and tables share. Of parity (experiments/parity.py), from accuracy against bytes to the paper's open question: what sphere equals a
perspective render. Of parsimony (experiments/parsimony.py): (cost, dB, error budget in pixels or None) of what is swept.

Parity is of both eyes, by the whole error of display values. A sphere's width is given beside the width that matches the view's centre, 2 pi f columns (DESIGN's bound), so
that it can be read for any display. Parsimony's budget is that of the client's own choice or, of bits, stands for it.
"""

import math

from found import all_bytes, db, seen_db, seen_interval_db, together_psnr, whole_db
from presets import matching_width
from rates import crossing, fewest_bytes
from render_list import EYES

SPHERE, REFERENCES = "centre", {"perspective": "perspective view, the other eye reprojected", "pair": "both eyes rendered"}
"""The sphere that is put beside views, and those, by name (experiments/parity.py)."""


def matching(settings):
    return matching_width(settings["eye"], settings["fov_deg"])


def of(entries, system, width=None, coded=True):
    return [entry for entry in entries if entry["system"] == system and entry["width"] == width and (entry["codec"] is not None) == coded]


def points(entries):
    """(bytes a frame, dB)."""
    return [(all_bytes(entry), level) for entry in entries if (level := seen_db(entry)) is not None]


def widths(entries, system):
    return sorted({entry["width"] for entry in entries if entry["system"] == system})


def parity_width(entries, system, level, crf, end=None):
    """The least width whose sphere, coded at this CRF (None: uncoded), has `level` dB; of the ends of its intervals with end 0 or 1, of which an open upper
    one reaches any, so that what is wider than the width before may do. None: no width has."""
    ws, ys = widths(entries, system), []
    for width in ws:
        entry = next(e for e in entries if e["system"] == system and e["width"] == width and e["crf"] == crf)
        known = seen_db(entry) if end is None else seen_interval_db(entry)[end]
        ys.append(math.inf if known is None and end == 1 else known)
    return crossing(ws, ys, level)


def parity_of(result, system, reference):
    """One row for each of the reference's qualities that is known: its bytes and dB, the width that has as much at the same CRF, and the fewest bytes of any width, which are at most
    these where its coarsest coding has more dB. The width's interval is from a sphere at its best beside a reference at its worst to the opposite."""
    entries, rows = result["entries"], []
    for entry in of(entries, reference):
        level, (worst, best) = seen_db(entry), seen_interval_db(entry)
        if level is None:
            continue
        ends = [parity_width(entries, system, of_reference, entry["crf"], end) for of_reference, end in ((worst, 1), (best, 0)) if of_reference is not None]
        fewest, fewest_width, at_most = fewest_bytes({width: points(of(entries, system, width)) for width in widths(entries, system)}, level)
        rows.append({"crf": entry["crf"], "bytes": all_bytes(entry), "db": level, "width": parity_width(entries, system, level, entry["crf"]),
                     "width_interval": ends if len(ends) == 2 else [None, None],
                     "fewest_bytes": fewest, "fewest_bytes_width": fewest_width, "bytes_ratio": fewest / all_bytes(entry) if fewest else None, "at_most": at_most})
    return rows


CHOSEN_PX, CODE_BITS = 0.25, 10


def triangle_points(result):
    return [(point["triangles"], db(point), point["error_px"]) for point in result["triangles"] if point["triangles"]]


def bit_points(result):
    return [(point["bits"], db(point), CHOSEN_PX if point["bits"] == CODE_BITS else None) for point in result["depth_bits"] if point["bits"]]


def cell_points(result):
    return [(point["cells"], db(point), point["error_px"]) for point in result["mesh_cells"]]


def sample_points(result):
    """The whole error. Results from before it have what PSNR sees, less the truth's own noise."""
    return [(point["samples"], whole_db(point) if "whole" in point else together_psnr([point["against_truth"][eye]["mean_square"] - result["truth_noise"][eye] for eye in EYES]), None) for point in result["samples"]]


AXES = {"triangles of the client's model": triangle_points, "bits of depth (equal steps of w)": bit_points,
        "cells of the mesh": cell_points, "samples a pixel of the sphere (with its noise)": sample_points}
