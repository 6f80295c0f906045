"""The plugins' pages (docs/mitsuba): every parameter of the tables is taken, with the default that stands there, and nothing else is exposed."""

import pathlib
import re
import subprocess
import sys

import mitsuba as mi
import pytest
from conftest import choose, pose, scene, sensor, sphere

ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs/mitsuba"))
import make_pages  # noqa: E402

# What a scene file may say where the table has no default that could stand there.
GIVEN = {"to_world": pose, "to_world_previous": pose, "to_world_next": pose, "aovs": lambda: "depth", "shutter_open": lambda: 0.0, "shutter_close": lambda: 1.0,
         "far_clip": lambda: 1e6}
OF_SPECTRAL_VARIANTS = {"srf"}
EXPOSED_BY_MITSUBA = {"shutter_open", "shutter_open_time"}


def rows(plugin):
    """Pairs of a name and its default, as text, of all parameters that a scene file may give."""
    for row in make_pages.parameters(plugin):
        stated = re.search(r"\(Default: ([^),]*(?:, [^),]*)?)\)", row["meaning"])
        defaults = stated[1].replace("``", "").split(", ") if stated else []
        for i, name in enumerate(row["names"]):
            if "not given in a scene file" not in row["meaning"] and "array" not in row["type"] and name not in OF_SPECTRAL_VARIANTS:
                yield name, defaults[min(i, len(defaults) - 1)] if defaults else None


def value_of(name, default):
    if name in GIVEN:
        return GIVEN[name]()
    return {"true": True, "false": False}.get(default, float(default) if re.fullmatch(r"-?[\d.]+", default) else default)


def loaded(plugin, **given):
    ball = {"ball": sphere((0, 0, -3))}
    return scene(ball, sensor(16, 8, **given)) if plugin == "equirect" else scene(ball, **{"aovs": "depth", **given})


PARAMETERS = [(plugin, *row) for plugin in make_pages.PICTURES for row in rows(plugin)]


@pytest.mark.parametrize("plugin,name,default", PARAMETERS)
def test_a_parameter_of_the_table_is_taken(plugin, name, default):
    choose("scalar_rgb")
    found = loaded(plugin, **{name: value_of(name, default)})
    exposed = dict(mi.traverse(found))
    key = f"{'sensor' if plugin == 'equirect' else 'integrator'}.{name}"
    if default is not None and re.fullmatch(r"-?[\d.]+", default) and key in exposed:
        assert float(dict(mi.traverse(loaded(plugin)))[key]) == pytest.approx(float(default)), key


@pytest.mark.parametrize("plugin", make_pages.PICTURES)
def test_what_is_exposed_stands_in_the_table(plugin):
    choose("scalar_rgb")
    prefix = "sensor." if plugin == "equirect" else "integrator."
    exposed = {key.removeprefix(prefix) for key, _ in mi.traverse(loaded(plugin)) if key.startswith(prefix)}
    ours = {key for key in exposed if "." not in key} - EXPOSED_BY_MITSUBA
    listed = {name for name, row in make_pages.documented(plugin).items() if row["exposed"]}
    assert ours <= listed, ours - listed
    under_another_name = {name for name, row in make_pages.documented(plugin).items() if "xposed as" in row["meaning"]}
    assert listed - exposed <= under_another_name, listed - exposed


def test_an_unknown_parameter_is_refused():
    choose("scalar_rgb")
    with pytest.raises(RuntimeError, match="longitude_minimum"):
        loaded("equirect", longitude_minimum=0.0)


def test_examples_of_the_pages_are_taken():
    """The XML of both manuals, in one scene."""
    choose("scalar_rgb")
    parts = [code for plugin in make_pages.PICTURES for code in re.findall(r"```xml\n(.*?)```", make_pages.page(plugin), re.S)]
    assert len(parts) == 2
    found = mi.load_string(f'<scene version="3.0.0">{"".join(parts)}<shape type="sphere"/></scene>')
    assert "Equirect" in str(found.sensors()[0]) and "EquirectAov" in str(found.integrator())


def test_a_parameter_without_a_row_is_found(monkeypatch):
    assert make_pages.asked_for("equirect") <= set(make_pages.documented("equirect"))
    lines = make_pages.manual("equirect")
    monkeypatch.setattr(make_pages, "manual", lambda name: [line.replace(" * - ipd", " * - other") for line in lines])
    assert make_pages.asked_for("equirect") - set(make_pages.documented("equirect")) == {"ipd"}


def test_pages_are_made_of_the_sources():
    done = subprocess.run([sys.executable, "-B", ROOT / "docs/mitsuba/make_pages.py", "--check"], text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
