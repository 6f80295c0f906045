"""Systems beside the paper's that it names, each as small as it informs a choice: other layouts, difference streams, motion vectors, grids of blocks.

All of renders that the systems are given anyway (systems.py), so that it costs coding and looking up alone.
"""

from .related_blocks import block_points
from .related_layouts import latitude_points, layout_points
from .related_streams import difference_points, let_through, search_points


def run(work):
    crfs = work.preset.curve_crfs if work.preset.every_value else work.preset.crfs
    checked, layouts = layout_points(work, crfs)
    return {"lookup_check": checked, "layouts": layouts, "latitudes": latitude_points(work, work.preset.crfs), "differences": difference_points(work, crfs),
            "searches": search_points(work), "let_through": let_through(work), "blocks": block_points(work)}
