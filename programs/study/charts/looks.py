"""How systems, codings and levels look on every chart of the study."""

import io
import textwrap

from drawing import STYLE, plain_number  # noqa: F401
from found import coding_name
from kept import lean_svg
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from pages import counts_text
from steps import write_whole

COLOURS = {"perspective": "#c0392b", "pair": "#d4ac0d", "sphere-left": "#2e86c1", "two-spheres": "#8e44ad", "centre": "#145a32", "centre-told": "#d81b60", "default": "#1a237e", "centre-mesh": "#28b463",
           "centre-turned": "#7f8c8d", "centre-plain-mesh": "#b9770e", "centre-gather": "#45b39d", "centre-splat": "#76d7c4", "centre-lean": "#aab7b8"}
MARKERS = {"uncoded": "*", "H.264, CRF 16": "o", "H.264, CRF 24": "s", "H.265, CRF 16": "^", "H.265, CRF 24": "D"}
PAGE_IN, SMALL = 11.5, 8.5
"""A chart is as wide as a page of documentation has points, 830, so that no letter there is smaller than SMALL."""
LEVEL = {"color": "#555555", "linewidth": 1, "linestyle": (0, (5, 3)), "zorder": 1}
"""What is no curve: a ceiling, a peer."""
HIGHEST_DB = 60
"""Beyond this an error is that of rounding: a picture that is the truth itself."""
MANY_TIMES = 100
"""Of the least on a logarithmic axis, where labels at 1, 2 and 5 would crowd it."""


def log_axis(axis, narrow=False):
    """Of an axis that has its points already; a narrow panel has room for three or four labels."""
    low, high = axis.get_view_interval()
    if narrow and high < 10 * low:
        axis.set_major_locator(MaxNLocator(3))
    elif narrow:
        axis.set_major_locator(LogLocator(subs=(1, 3) if high < 30 * low else (1,)))
    else:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < MANY_TIMES * low else (1, 3)))
    axis.set_major_formatter(FuncFormatter(plain_number))
    axis.set_minor_formatter(NullFormatter())


def point(axes, entry, x, y):
    axes.plot([x], [y], marker=MARKERS.get(coding_name(entry), "P"), color=COLOURS[entry["system"]], linestyle="none", markersize=6.5, alpha=0.9, zorder=3)


def interval(axes, x, ends, colour):
    """Of 95 %; an open end is left out."""
    low, high = ends
    if low is not None and high is not None:
        axes.plot([x, x], [low, min(high, HIGHEST_DB)], color=colour, linewidth=1, alpha=0.8, zorder=2)


def ceiling_note(axes, db):
    """Where a panel's own scale does not have it, above the panel."""
    axes.annotate(f"PSNR of truth against truth: {db:.1f} dB", (1, 1.02), xycoords="axes fraction", ha="right", fontsize=SMALL, color="#555555")


def front(axes, points):
    if points:
        axes.step(*zip(*points), where="post", color="#999999", linewidth=1, linestyle=(0, (2, 2)), zorder=2)


def legend(figure, systems, titles, codings):
    entries = [Line2D([], [], marker="o", linestyle="none", color=colour, label=titles[name]) for name, colour in COLOURS.items() if name in systems]
    entries += [Line2D([], [], marker=marker, linestyle="none", color="#444444", label=name) for name, marker in MARKERS.items() if name in codings]
    figure.legend(handles=entries, loc="outside lower center", ncol=max(1, int(figure.get_figwidth() / 3.6)), frameon=False, fontsize=SMALL)


def legend_above(axes, columns, above=1.12):
    """Over none of the curves of a row's first panel; it may be wider than that panel."""
    axes.legend(loc="lower left", bbox_to_anchor=(-0.1, above), ncol=columns, fontsize=SMALL, frameon=False, borderpad=0, columnspacing=1.2).set_in_layout(False)


def title(figure, finding, conditions, legend_lines=0):
    """Above all panels: what the chart shows, and below it how it was measured, in as many lines as it takes; and room for a legend above the first row."""
    width = figure.get_figwidth()
    figure.suptitle("\n\n" + "\n".join(textwrap.wrap(conditions, int(13 * width))) + "\n" * (legend_lines + (legend_lines > 0)), fontsize=SMALL, x=0.005, ha="left", color="#555555")
    figure.text(0.005, 1 - 0.06 / figure.get_figheight(), finding, fontsize=11.5, fontweight="bold", va="top")


def told(finding, otherwise, **found):
    """A finding with its figures; where a result lacks one of them, what the chart is about."""
    return otherwise if None in found.values() else finding.format(**found)


def span(values, digits=1):
    """"1.2 to 3.4", or one number where both are the same; None without any."""
    found = [value for value in values if value is not None]
    if not found:
        return None
    low, high = (f"{end:.{digits}f}" for end in (min(found), max(found)))
    return low if low == high else f"{low} to {high}"


def save(figure, file):
    drawn = io.StringIO()
    figure.savefig(drawn, format="svg", metadata={"Date": None})
    write_whole(file.with_suffix(".svg"), lean_svg(drawn.getvalue()))
    print(file.with_suffix(".svg"))


def provenance_line(result):
    """`n` is the result's own, where it is not the preset's. Samples differ from scene to scene: light_text says them."""
    settings, machine = result["settings"], result["machine"]
    is_parity = result["experiment"] == "parity"
    n = result["n"] if is_parity else {"frames": settings["frames"], "seeds": len(settings["seeds"])}
    spheres = "" if is_parity else f"; spheres rendered {settings['sphere_width']} wide"
    beside = "" if settings.get("timed", True) else "; milliseconds of runs beside each other"
    return f"{settings['eye'][0]}x{settings['eye'][1]} eyes at {settings['fov_deg']:g} degrees{spheres}; n = {counts_text(n)}; {machine['cpu']}, {machine['cores']} cores{beside}"
