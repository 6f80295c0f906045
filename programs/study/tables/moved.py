"""The table of heads that are not where the server thought (experiments/moved.py)."""

from figures.moved import by_head, head_text
from found import error
from pages import counts_text, noise_free_text, table


def rows(results):
    for scene, result in results.items():
        for system, title in result["titles"].items():
            if found := by_head(result, system):
                yield [scene, title, *(noise_free_text(error(entry)) for entry in found.values())]


def parts(results):
    if not results:
        return []
    first = next(iter(results.values()))
    return ["## The head elsewhere than told", f"Uncoded, spheres {first['settings']['sphere_width']} wide, n = {counts_text(first['n'])}: noise-free dB of both eyes on linear values [95 % of the noise].",
            table(["scene", "system", *map(head_text, first["heads"])], list(rows(results)))]
