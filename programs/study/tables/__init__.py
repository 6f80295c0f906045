"""What the study's curves say in numbers, from its JSON and nothing else: OUT/tables.md, and the tables inside the study's conclusion, OUT.md beside OUT: one
look at all scenes. There text around its markers is left alone; a page without them is, too.
"""

from curves import AXES, REFERENCES, SPHERE, matching, parity_of
from found import all_bytes, db, light_text, load, ms, seen_db, titles_of
from pages import cell, counts_text, kinds_text, place, table
from rates import CLOSE_DB, cheapest_within, knee
from steps import write_whole

from .related import parts as related_parts
from .stability import parts as stability_parts
from .systems import parts as system_parts
from .where import moved_parts, where_parts


def pixels_times(settings, width, reference):
    """Of a sphere and of what the reference renders, small streams a sixteenth as large along."""
    width_px, height_px = settings["eye"]
    rendered = width_px * height_px * (17 / 16 if reference == "perspective" else 2)
    return width * width / 2 * 17 / 16 / rendered


def parity_rows(results):
    for scene, result in results.items():
        for reference in REFERENCES:
            for row in parity_of(result, SPHERE, reference):
                width, fewest = row["width"], row["fewest_bytes_width"]
                yield [scene, reference, f"{row['crf']:g}", cell(row["db"]), cell(row["bytes"], 0), width_text(row), cell(width and width / matching(result["settings"])), cell(row["fewest_bytes"], 0),
                       str(fewest or "-"), ratio_text(row), cell(fewest and pixels_times(result["settings"], fewest, reference))]


def counted(results, n):
    """n of each scene, once where it is the same of all."""
    by_n = {}
    for scene, result in results.items():
        by_n.setdefault(n(result), []).append(scene)
    return "n = " + "; ".join(text if len(by_n) == 1 else f"{text} ({', '.join(scenes)})" for text, scenes in by_n.items()) + "."


def knee_rows(results):
    for scene, result in results.items():
        for label, points_of in AXES.items():
            points = [(cost, db) for cost, db, _ in points_of(result)]
            yield [scene, label, f"{knee(points):,g}", f"{cheapest_within(points):,g}"]


def draw_rows(results):
    for scene, result in results.items():
        for entry in result["draws"]:
            yield [scene, entry["title"], cell(entry["depth_ms"], 1), kinds_text(entry)]


def write_tables(folder):
    systems, parity = load(folder, "systems"), load(folder, "parity")
    fill_conclusion(folder, systems, parity)
    parts = system_parts(systems)
    parts += where_parts(load(folder, "where")) + moved_parts(load(folder, "moved"))
    if parity:
        parts += ["## Parity, both eyes, whole error of display values", counted(parity, lambda result: f"{counts_text(result['n'])}, from frame {result['frames'].split('-')[0]} on"), table(["scene", "equal to", "CRF", "dB", "bytes a frame", "columns at that CRF [95 %]", "of 2 pi f", "fewest bytes of any width", "its columns", "bytes, times", "rendered pixels, times"], list(parity_rows(parity)))]
    if parsimony := load(folder, "parsimony"):
        n = counted(parsimony, lambda result: f"{result['settings']['frames']} frames x {len(result['settings']['seeds'])} seeds")
        parts += ["## The client's depth: milliseconds a frame of both eyes, uncoded; OpenGL in software", n, table(["scene", "depth by", "ms a frame", "whole / noise-free dB [95 %]"], list(draw_rows(parsimony))),
                  "## The knee", n.removesuffix(".") + ", one of each number of samples.", table(["scene", "of", "knee", f"least within {CLOSE_DB:g} dB of the dearest"], list(knee_rows(parsimony)))]
    parts += stability_parts(load(folder, "stability"), load(folder, "latency"))
    parts += related_parts(load(folder, "related"))
    if parts:
        write_whole(folder / "tables.md", "# The study in numbers\n\n" + "\n\n".join(parts) + "\n")
        print(folder / "tables.md")


CODING = ("h264", 24)


def coded_entry(result, system):
    """At CODING, of the widest sphere: results from before light was denoised have narrower ones too."""
    widths = None, result["settings"]["sphere_width"]
    return next((entry for entry in result["systems"] if entry["system"] == system and entry["width"] in widths and (entry["codec"], entry["crf"]) == CODING), None)


def figures_text(entry):
    """"whole error of display values / noise-free error of linear ones, kB, ms"."""
    return "-" if entry is None else f"{cell(seen_db(entry), 1)} / {cell(db(entry), 1)} dB, {all_bytes(entry) / 1000:,.0f} kB, {cell(ms(entry), 0)} ms"


def systems_table(results):
    rows = []
    for system, title in titles_of(results).items():
        found = [coded_entry(result, system) for result in results.values()]
        if any(found):
            rows.append([title, *map(figures_text, found)])
    return table(["system", *(f"{scene}{light_text(result)}" for scene, result in results.items())], rows, labels=1)


def width_text(row):
    low, high = row["width_interval"]
    if row["width"] is None and low is None:
        return "none"
    return f"{cell(row['width'], 0, 'none')} [{cell(low, 0)}, {cell(high, 0, 'wider')}]"


def ratio_text(row, digits=2):
    """Of bytes; a bound where the sphere's coarsest coding has more dB than it needs."""
    return ("≤ " if row["at_most"] else "") + cell(row["bytes_ratio"], digits)


def parity_table(results):
    rows = []
    for scene, result in results.items():
        for reference, title in REFERENCES.items():
            for row in parity_of(result, SPHERE, reference):
                rows.append([scene, title, f"{row['crf']:g}", cell(row["db"], 1), width_text(row), cell(row["width"] and row["width"] / matching(result["settings"])), ratio_text(row, 1)])
    return table(["scene", "equal to", "CRF of both", "dB", "columns [95 %]", "of 2 pi f", "bytes, times"], rows)


def fill_conclusion(folder, systems, parity):
    folder = folder.resolve()
    page = folder.with_name(f"{folder.name}.md")
    if not page.exists():
        return
    before = text = page.read_text()
    for name, results, make in (("systems", systems, systems_table), ("parity", parity, parity_table)):
        if results and f"<!-- table {name} all -->" in text:
            text = place(text, name, "all", make(results))
    if text != before:
        write_whole(page, text)
        print(page)
