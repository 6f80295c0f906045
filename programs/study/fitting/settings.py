"""The settings file of `equistream fit`: sections of each program, in the words of its options."""

from render_list import DEPTH, WITH_MIRRORS, size_text
from steps import write_whole

RENDERED = {"small": {"small": "right"}, "hidden": {"layers": "true"}, "patches": {"patches": "true"}}
"""Track -> what `render` makes it by."""


def section(name, values):
    return "\n".join([f"[{name}]", *(f"{key} = {value}" for key, value in values.items())])


def quoted(text):
    return f'"{text}"'


def settings_text(remarks, sections):
    """`remarks` come on top; sections are {program: {option: value}}."""
    return "\n\n".join(["\n".join(f"# {remark}" for remark in remarks), *(section(name, values) for name, values in sections.items() if values)]) + "\n"


def client_words(chosen):
    if chosen.depth_share:
        return {"method": "mesh"}
    return {"method": "eye-depth", "model" if chosen.model_px else "scene": quoted(chosen.geometry_file)}


def sections_of(chosen, asked, codec):
    """What each program needs to do as was measured; `chosen` is choice.py's."""
    track = chosen.fill.track
    sees = {"fill": quoted(chosen.fill.passes), "size": size_text(asked.eye), "fov": f"{asked.fov_deg:g}"}
    by_stream = {"depth": "auto", "depth-share": f"{chosen.depth_share:g}"} if chosen.depth_share else {"depth": "none"}
    return {"render": {"eye": "centre", "size": size_text((chosen.width, chosen.width // 2)), "spp": chosen.samples, "aovs": quoted((WITH_MIRRORS if chosen.told else DEPTH)[1]), **RENDERED.get(track, {})},
            "encode": {"codec": codec, "crf": chosen.crf, "fill": track or "none", **by_stream, **({"mirrors": "always"} if chosen.told else {})},
            "model": {"error-px": f"{chosen.model_px:g}", "focal": f"{asked.focal_px:g}"} if chosen.model_px else {},
            "play": {**client_words(chosen), **({"depth": "stream"} if chosen.depth_share else {}), **sees},
            "view": {**client_words(chosen), **sees}}


def write_settings(file, remarks, sections):
    write_whole(file, settings_text(remarks, sections))
