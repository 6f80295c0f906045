"""How many cells the client's adaptive mesh has: client/warp/mesh.h's rule once more, in numpy, for counting alone.

A sphere's pixels are a lattice of points (q, 1/r), q the unit direction. Blocks of 32x32 cells are quadtrees: a cell is whole if its four parts are and its
two triangles hold all its points within a tolerance of w. Which neighbours the mesh joins decides nothing here: that rule allows eight times as much.
"""

import equistream as es
import numpy as np

SIDE = 32
MESH_SHARE = 0.25
"""Of the error budget (bound.h), of which cells take half: those that fan out to meet smaller ones leave their triangles by as much again."""
LEAST_REACH_SHARE = 1e-3
AT_ONCE = 1 << 21
"""Points that are looked at together."""


class Lattice:
    """Rows -1 to H and columns 0 to W; over a pole lies the row itself, half a turn on."""

    def __init__(self, depth_m):
        rows, columns = depth_m.shape
        self.rows, self.columns = rows + 1, columns  # of cells
        y, x = np.arange(-1, rows + 1), np.arange(columns + 1)
        over = (y < 0) | (y >= rows)
        inner = np.where(y < 0, -1 - y, np.where(y >= rows, 2 * rows - 1 - y, y))
        column = (x[None, :] + over[:, None] * (columns // 2)) % columns
        with np.errstate(divide="ignore"):
            inverse = np.where(depth_m > 0, 1 / depth_m, np.nan)
        self.k = inverse[inner[:, None], column]
        self.q = es.EquirectCamera(columns, rows).directions()[inner[:, None], column]


def share_beyond_box(inverse, box_radius_m):
    return np.maximum(1 - box_radius_m * inverse, LEAST_REACH_SHARE)


def same(a, b, box_radius_m, tolerance):
    return box_radius_m * np.abs(a - b) <= tolerance * (share_beyond_box(a, box_radius_m) * share_beyond_box(b, box_radius_m))


def plane_through(q, k):
    """m of 1/r = m . q through three points: n x 3 x 3 and n x 3."""
    return np.linalg.solve(q, k[..., None])[..., 0]


def holds(lattice, y, x, size, box_radius_m, tolerance):
    """Both triangles of the cells at (y, x), split from the first corner to the opposite one."""
    step = np.arange(size + 1)
    j, i = np.meshgrid(step, step, indexing="ij")
    good = np.empty(len(y), bool)
    batch = max(1, AT_ONCE // (size + 1) ** 2)
    for begin in range(0, len(y), batch):
        part = slice(begin, begin + batch)
        rows, columns = y[part, None, None] + j, x[part, None, None] + i
        q, k = lattice.q[rows, columns], lattice.k[rows, columns]
        fine = np.ones(len(q), bool)
        for third, inside in (((0, -1), i >= j), ((-1, 0), i <= j)):
            corners = ((0, 0), third, (-1, -1))
            plane = plane_through(np.stack([q[:, r, c] for r, c in corners], axis=1), np.stack([k[:, r, c] for r, c in corners], axis=1))
            fine &= (same(np.einsum("nijc,nc->nij", q, plane), k, box_radius_m, tolerance) | ~inside).all(axis=(1, 2))
        good[part] = fine
    return good


def count_cells(depth_m, box_radius_m, budget_rad):
    """{side: cells} of a whole sphere's depth for an eye's error budget."""
    lattice = Lattice(np.asarray(depth_m, np.float64))
    within = 0.5 * np.sin(MESH_SHARE * budget_rad)
    flat = np.ones((lattice.rows, lattice.columns), bool)
    found, size = {}, 1
    while True:
        above = np.zeros((-(-flat.shape[0] // 2), -(-flat.shape[1] // 2)), bool)
        if 2 * size <= SIDE:
            whole = flat[:flat.shape[0] // 2 * 2, :flat.shape[1] // 2 * 2]
            y, x = np.nonzero(whole[::2, ::2] & whole[::2, 1::2] & whole[1::2, ::2] & whole[1::2, 1::2])
            fit = (2 * size * (y + 1) <= lattice.rows) & (2 * size * (x + 1) <= lattice.columns)
            y, x = y[fit], x[fit]
            above[y, x] = holds(lattice, 2 * size * y, 2 * size * x, 2 * size, box_radius_m, within)
        own = ~np.repeat(np.repeat(above, 2, axis=0), 2, axis=1)[:flat.shape[0], :flat.shape[1]]
        found[size] = int(np.count_nonzero(own & (flat | (size == 1))))
        if 2 * size > SIDE:
            return found
        flat, size = above, 2 * size
