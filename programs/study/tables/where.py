"""Where each system's error lies (experiments/where.py), and heads that are not where the server thought (experiments/moved.py): their figures and tables."""

from found import db
from pages import cell, counts_text, kinds_text, table
from render_list import EYES


def kinds_of(entry):
    """{kind: (share of both eyes' pixels, mean square over all of both eyes' pixels)}."""
    found = {}
    for kind, by_eye in entry["kinds"].items():
        seen = [figures for figures in by_eye.values() if figures["fraction"]]
        found[kind] = (sum(figures["fraction"] for figures in seen) / len(EYES),
                       sum(figures["fraction"] * figures["noise_free"]["linear"]["mean_square"] for figures in seen) / len(EYES))
    return found


def shares(entry):
    """{kind: of the error, 0 to 1}; noise can make a kind's a little negative, which counts as none."""
    squares = {kind: max(0.0, square) for kind, (_, square) in kinds_of(entry).items()}
    whole = sum(squares.values())
    return {kind: square / whole if whole else 0.0 for kind, square in squares.items()}


def where_rows(results):
    for scene, result in results.items():
        for entry in result["systems"]:
            pixels = [fraction for fraction, _ in kinds_of(entry).values()]
            yield [scene, result["titles"][entry["system"]], cell(db(entry)), *(f"{100 * share:.0f} ({100 * fraction:.1f})" for share, fraction in zip(shares(entry).values(), pixels))]


def where_parts(results):
    if not results:
        return []
    first = next(iter(results.values()))
    return ["## Where the error lies", f"Uncoded, spheres {first['settings']['sphere_width']} wide, n = {counts_text(first['n'])}: of the noise-free error on linear values, in brackets of the pixels, per cent.",
            table(["scene", "system", "dB", *first["kinds"].values()], list(where_rows(results)))]


def head_text(head):
    """"as told", "20 degrees", "5 cm" or both of these."""
    said = [*([f"{head['turned_deg']:g} degrees"] if head["turned_deg"] else []), *([f"{100 * head['moved_m']:g} cm"] if head["moved_m"] else [])]
    return ", ".join(said) or "as told"


def by_head(result, system):
    """{head: entry}, of the heads in their order; empty where the scene has no such system."""
    found = {entry["head"]: entry for entry in result["systems"] if entry["system"] == system}
    return {head["name"]: found[head["name"]] for head in result["heads"] if head["name"] in found}


def moved_rows(results):
    for scene, result in results.items():
        for system, title in result["titles"].items():
            if found := by_head(result, system):
                yield [scene, title, *map(kinds_text, found.values())]


def moved_parts(results):
    if not results:
        return []
    first = next(iter(results.values()))
    return ["## The head elsewhere than told", f"Uncoded, spheres {first['settings']['sphere_width']} wide, n = {counts_text(first['n'])}: whole / noise-free dB of both eyes on linear values [95 % of the noise].",
            table(["scene", "system", *map(head_text, first["heads"])], list(moved_rows(results)))]
