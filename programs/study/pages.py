"""Tables of result pages: written between markers, from JSON alone."""

import re

from found import KINDS, db, error, only_bounded

def cell(value, digits=2, missing="-"):
    return missing if value is None else f"{value:.{digits}f}"


def counts_text(n):
    """{"frames": 4, "seeds": 2} as "4 frames, 2 seeds"."""
    return ", ".join(f"{count} {what.removesuffix('s') if count == 1 else what}" for what, count in n.items())


def table(head, rows, labels=2):
    """The first `labels` columns are words, the others figures."""
    lines = ["| " + " | ".join(head) + " |", "|" + "|".join("---" if i < labels else "--:" for i in range(len(head))) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def error_text(figures):
    """dB with its 95 % interval, of one entry that `compare` wrote; - without one."""
    if figures is None:
        return "-"
    if figures["mean_square"] == 0 and figures["mean_square_low"] == figures["mean_square_high"]:
        return "identical"
    if figures["db_low"] is None:
        return "none found"
    if only_bounded(figures):
        return f"> {figures['db_low']:.1f}"
    return f"{figures['db']:.2f} [{figures['db_low']:.2f}, {figures['db_high']:.2f}]"


def kinds_text(scored):
    """dB of both eyes with their intervals."""
    return both_kinds(lambda kind: error_text(error(scored, kind=kind)))


def kinds_short(scored, eye=None, digits=1):
    """dB alone."""
    return both_kinds(lambda kind: cell(db(scored, eye, kind=kind), digits))


def error_short(figures):
    """dB alone; a bound where the interval reaches zero error; - without one."""
    if figures is None:
        return "-"
    if only_bounded(figures):
        return "-" if figures["db_low"] is None else f"> {figures['db_low']:.1f}"
    return f"{figures['db']:.1f}"


def both_kinds(text, *which):
    """"whole / noise-free", by text(*which, kind)."""
    return " / ".join(text(*which, kind=kind) for kind in KINDS)


def both_scales(texts):
    """"linear (display)", of {scale: text}: the figure to judge by and, in brackets, the one on display values."""
    return texts["linear"] if set(texts.values()) == {"-"} else f"{texts['linear']} ({texts['display']})"


def place(page, name, scene, text):
    """Puts `text` between `<!-- table NAME SCENE -->` and `<!-- end -->`; at the end where there is no such marker yet."""
    marker = f"<!-- table {name} {scene} -->"
    block = f"{marker}\n{text}\n<!-- end -->"
    assert page.count(marker) <= 1, f"{marker} twice"
    if marker not in page:
        return page.rstrip("\n") + f"\n\n{block}\n"
    return re.sub(re.escape(marker) + r".*?<!-- end -->", lambda _: block, page, flags=re.S)
