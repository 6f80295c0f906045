"""The tables inside the study's conclusion, OUT.md beside OUT: one look at all scenes. Text around its markers is left alone; a page without them is, too."""

from figures.parity import REFERENCES, SPHERE, matching, parity_of
from found import all_bytes, db, ms
from pages import cell, place, table
from steps import write_whole

CODING = ("h264", 24)


def coded(entries, system, width):
    """At CODING."""
    return next((entry for entry in entries if entry["system"] == system and entry["width"] == width and (entry["codec"], entry["crf"]) == CODING), None)


def figures_text(entry):
    """"dB, kB, ms"."""
    return "-" if entry is None else f"{cell(db(entry), 1)}, {all_bytes(entry) / 1000:,.0f} kB, {cell(ms(entry), 0)} ms"


def systems_table(results):
    entries = [entry for result in results.values() for entry in result["systems"]]
    rows = []
    for system, title in next(iter(results.values()))["titles"].items():
        for width in dict.fromkeys(entry["width"] for entry in entries if entry["system"] == system):
            found = [coded(result["systems"], system, width) for result in results.values()]
            if any(found):
                rows.append([title, str(width or "-"), *map(figures_text, found)])
    return table(["system", "columns", *results], rows)


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
            for row in parity_of(result, "first", SPHERE, reference):
                rows.append([scene, title, f"{row['crf']:g}", cell(row["db"], 1), width_text(row), cell(row["width"] and row["width"] / matching(result["settings"])), ratio_text(row, 1)])
    return table(["scene", "equal to", "CRF of both", "dB", "columns [95 %]", "of 2 pi f", "bytes, times"], rows)


def fill(folder, systems, parity):
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
