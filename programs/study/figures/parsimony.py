"""Parsimony's curves: (cost, dB, error budget in pixels or None) of what is swept; the budget is that of the client's own choice or, of bits, stands for it."""

from found import db, together_psnr
from render_list import EYES

CHOSEN_PX, CODE_BITS = 0.25, 10


def triangle_points(result):
    return [(point["triangles"], db(point), point["error_px"]) for point in result["triangles"] if point["triangles"]]


def bit_points(result):
    return [(point["bits"], db(point), CHOSEN_PX if point["bits"] == CODE_BITS else None) for point in result["depth_bits"] if point["bits"]]


def cell_points(result):
    return [(point["cells"], db(point), point["error_px"]) for point in result["mesh_cells"]]


def sample_points(result):
    """Noise and all of the sphere, without the truth's own."""
    return [(point["samples"], together_psnr([point["against_truth"][eye]["mean_square"] - result["truth_noise"][eye] for eye in EYES]), None) for point in result["samples"]]


AXES = {"triangles of the client's model": triangle_points, "bits of depth (equal steps of w)": bit_points,
        "cells of the mesh": cell_points, "samples a pixel of the sphere (PSNR with its noise)": sample_points}
