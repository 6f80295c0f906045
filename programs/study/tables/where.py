"""The table of where each system's error lies (experiments/where.py)."""

from figures.where import parts as parts_of
from figures.where import shares
from found import db
from pages import cell, counts_text, table


def rows(results):
    for scene, result in results.items():
        for entry in result["systems"]:
            pixels = [fraction for fraction, _ in parts_of(entry).values()]
            yield [scene, result["titles"][entry["system"]], cell(db(entry)), *(f"{100 * share:.0f} ({100 * fraction:.1f})" for share, fraction in zip(shares(entry).values(), pixels))]


def parts(results):
    if not results:
        return []
    first = next(iter(results.values()))
    return ["## Where the error lies", f"Uncoded, spheres {first['settings']['sphere_width']} wide, n = {counts_text(first['n'])}: of the noise-free error on linear values, in brackets of the pixels, per cent.",
            table(["scene", "system", "dB", *first["kinds"].values()], list(rows(results)))]
