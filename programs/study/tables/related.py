"""Systems beside the paper's (experiments/related.py): picking points of a result, and tables of layouts, rows, difference streams, motion search, grids of blocks."""

from found import db
from pages import cell, counts_text, kinds_short, table
from rates import bd_db, bd_rate_percent

ANCHOR, DEFAULT_SEARCH = "e", "hex 16"
"""Layout and motion search that the others are put beside."""
SECOND_EYE = {"direct": "coded itself", "together": "in one stream with the first eye", "difference": "as a difference from what is reprojected"}
"""Ways to send it; the first is what the others are put beside."""


def of(points, **wanted):
    return [point for point in points if all(point[key] == value for key, value in wanted.items())]


def curve(points, eye):
    """(bytes a frame, dB) of what was coded."""
    return [(point["bytes_a_frame"], level) for point in points if point["crf"] is not None and (level := db(point, eye)) is not None]


def beside(points, keys, key, value):
    """(point, the point with `value` for `key` that has the same `keys`)."""
    for point in points:
        yield point, next(other for other in of(points, **{name: point[name] for name in keys}) if other[key] == value)


SAID = {True: "yes", False: "no"}


def layout_rows(results):
    for scene, result in results.items():
        anchor = curve(of(result["layouts"], layout=ANCHOR), "left")
        for point in of(result["layouts"], crf=None):
            tested = curve(of(result["layouts"], layout=point["layout"]), "left")
            width, height = point["size"]
            yield [scene, point["title"], f"{width}x{height}", kinds_short(point, "left", 2), cell(bd_rate_percent(anchor, tested), 1), cell(bd_db(anchor, tested)),
                   cell(100 * point["beyond_share"], 1), cell(result["lookup_check"]["ours_db"], 1), cell(result["lookup_check"]["v360_db"], 1)]


def latitude_rows(results):
    for scene, result in results.items():
        for point, whole in beside(result["latitudes"], ("crf",), "latitude_deg", 90):
            yield [scene, f"{point['latitude_deg']:g}", f"{point['crf']:g}", cell(100 * point["pixel_share"], 1), cell(100 * point["solid_angle_share"], 1),
                   cell(100 * point["bytes_a_frame"] / whole["bytes_a_frame"], 1)]


def difference_rows(results):
    for scene, result in results.items():
        direct, *others = (curve(of(result["differences"], kind=kind), "right") for kind in SECOND_EYE)
        beside_direct = [text for other in others for text in (cell(bd_rate_percent(direct, other), 1), cell(bd_db(direct, other)))]
        for crf in sorted({point["crf"] for point in result["differences"]}):
            points = [of(result["differences"], kind=kind, crf=crf)[0] for kind in (*SECOND_EYE, "reprojected")]
            sent = [text for point in points[:-1] for text in (f"{point['bytes_a_frame']:,.0f}", kinds_short(point, "right", 2))]
            yield [scene, f"{crf:g}", *sent, kinds_short(points[-1], "right", 2), *beside_direct]


def search_rows(results):
    for scene, result in results.items():
        heeded = result["let_through"]
        said = [SAID[heeded[key]] for key in ("frames_bring_vectors", "vectors_change_the_stream", "regions_change_the_stream")]
        for point, default in beside(result["searches"], ("source",), "search", DEFAULT_SEARCH):
            yield [scene, point["source"], point["search"], f"{point['bytes_a_frame']:,.0f}", f"{100 * (point['bytes_a_frame'] / default['bytes_a_frame'] - 1):+.2f}",
                   f"{point['psnr_db'] - default['psnr_db']:+.3f}", *said]


def block_rows(results):
    for scene, result in results.items():
        for point in result["blocks"]:
            setting = f"{point['error_px']:g} px" if "error_px" in point else f"every {point['step']}"
            yield [scene, point["title"], setting, f"{point['cells']:,}", kinds_short(point, digits=2)]


def parts(results):
    if not results:
        return []
    first = next(iter(results.values()))
    return ["## Related systems: layouts with as many pixels, left eye", f"n here and below, but for motion search = {counts_text(first['layouts'][0]['n'])}. dB are of the whole / the noise-free error.",
            table(["scene", "layout", "size", "uncoded, dB", "BD-rate, %", "BD, dB", "of the eye beyond it, %", "our lookup beside the client's, dB", "v360's, dB"],
                  list(layout_rows(results)), 3),
            "## Related systems: rows of the sphere",
            table(["scene", "up to, degrees", "CRF", "pixels, %", "solid angle, %", "bytes, %"], list(latitude_rows(results)), 1),
            "## Related systems: the second eye coded itself, with the first, and as a difference stream",
            table(["scene", "CRF", "coded itself, bytes a frame", "dB", "with the first eye, bytes a frame more", "dB", "as a difference, bytes a frame", "dB", "nothing sent, dB", "with the first: BD-rate, %", "BD, dB",
                   "difference: BD-rate, %", "BD, dB"],
                  list(difference_rows(results)), 1),
            "## Related systems: motion search of the encoder", f"n = {counts_text(first['searches'][0]['n'])} of all seeds' samples together.",
            table(["scene", "source", "search", "bytes a frame", "beside the default, %", "PSNR beside it, dB", "frames bring vectors", "vectors change the stream",
                   "regions change the stream"], list(search_rows(results)), 3),
            "## Related systems: grids of blocks", table(["scene", "grid", "setting", "cells", "both eyes, dB"], list(block_rows(results)), 3)]
