"""Of one system's entry of experiments/where.py: how much of the pixels, and of the error, is of each kind."""

from render_list import EYES


def parts(entry):
    """{kind: (share of both eyes' pixels, mean square over all of both eyes' pixels)}."""
    found = {}
    for kind, by_eye in entry["kinds"].items():
        seen = [figures for figures in by_eye.values() if figures["fraction"]]
        found[kind] = (sum(figures["fraction"] for figures in seen) / len(EYES),
                       sum(figures["fraction"] * figures["noise_free"]["linear"]["mean_square"] for figures in seen) / len(EYES))
    return found


def shares(entry):
    """{kind: of the error, 0 to 1}; noise can make a kind's a little negative, which counts as none."""
    squares = {kind: max(0.0, square) for kind, (_, square) in parts(entry).items()}
    whole = sum(squares.values())
    return {kind: square / whole if whole else 0.0 for kind, square in squares.items()}
