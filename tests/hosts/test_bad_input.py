"""What is wrong is refused in one clear line, and the process lives on."""

import mitsuba as mi
import numpy as np
import pytest
from conftest import film, planes, pose, scene, sensor, sphere

ROOM = {"room": sphere(radius=2.0)}
GROUPS = "albedo, depth, motion, normal, ids, specular, virtual, all or none"


def message_of(error):
    """All lines of an exception and of what caused it."""
    texts = []
    while error:
        texts.append(str(error))
        error = error.__cause__ or error.__context__
    return "\n".join(texts)


def refusal(make):
    with pytest.raises(Exception) as caught:
        make()
    # Still alive, and right.
    assert planes(scene(ROOM, sensor(8, 4), aovs="depth"))["depth.Z"] == pytest.approx(2.0, rel=1e-6)
    return message_of(caught.value)


def integrator(**properties):
    described = {"type": "equirect_aov", "aovs": "depth", "nested": {"type": "path"}, **properties}
    return lambda: mi.load_dict({name: value for name, value in described.items() if value is not None})


@pytest.mark.parametrize("properties, line", [
    (dict(aovs=None), 'Property "aovs" cannot be found'),
    (dict(aovs=3), '"aovs" has the wrong type (expected string, got integer)'),
    (dict(aovs="depth,colr"), f'equirect_aov: aovs: expected {GROUPS}, found "colr"'),
    (dict(aovs="depth,"), f'equirect_aov: aovs: expected {GROUPS}, found ""'),
    (dict(aovs="dd.y:depth"), 'found "dd.y:depth"'),
    (dict(aovs="x" * 5000), "equirect_aov: aovs: expected"),
    (dict(nested=None), 'equirect_aov: expected a nested integrator such as "path", found none'),
    (dict(nested={"type": "ptracer"}), 'nested: expected a sampling integrator such as "path", found ParticleTracer'),
    (dict(nested={"type": "diffuse"}), 'nested: expected a sampling integrator such as "path", found SmoothDiffuse'),
    (dict(other={"type": "direct"}), "expected one nested integrator, found two"),
    (dict(timeout=1.0), "equirect_aov: timeout: expected in the nested integrator, found in equirect_aov"),
    (dict(samples_per_pass=1), "equirect_aov: samples_per_pass: expected in the nested integrator, found in equirect_aov"),
    (dict(depht="x"), "depht"),
])
def test_integrators_properties(variant, properties, line):
    assert line in refusal(integrator(**properties))


def sensor_with(**properties):
    return lambda: mi.load_dict(sensor(8, 4, **properties))


@pytest.mark.parametrize("properties, line", [
    (dict(eye="middle"), 'equirect: eye: expected one of centre, left, right, ods_left, ods_right, found "middle"'),
    (dict(eye=1), '"eye" has the wrong type (expected string, got integer)'),
    (dict(ipd=-0.1), "equirect: ipd: expected a distance of 0 or more, found -0.1"),
    (dict(ipd=float("nan")), "equirect: ipd: expected a distance of 0 or more, found nan"),
    (dict(near_clip=-1.0), "equirect: near_clip: expected a distance of 0 or more, found -1"),
    (dict(near_clip="near"), '"near_clip" has the wrong type (expected float, got string)'),
    (dict(near_clip=2.0, far_clip=2.0), "equirect: far_clip: expected more than near_clip, found 2"),
    (dict(longitude_min=10.0, longitude_max=10.0), "equirect: longitude_max: expected more than longitude_min, found 10"),
    (dict(longitude_max=190.0), "equirect: longitude_max: expected at most longitude_min + 360, found 190"),
    (dict(latitude_max=91.0), "equirect: latitude_max: expected 90 or less, found 91"),
    (dict(latitude_min=float("nan")), "equirect: latitude_min: expected -90 or more, found nan"),
    (dict(ods_pole="fade"), 'equirect: ods_pole: expected one of merge, none, found "fade"'),
    (dict(ods_merge_from=80.0), "equirect: ods_merge_to: expected more than ods_merge_from, found 75"),
    (dict(to_world="here"), '"to_world" has the wrong type (expected transform, got string)'),
    (dict(neer_clip=1.0), "neer_clip"),
])
def test_sensors_properties(variant, properties, line):
    assert line in refusal(sensor_with(**properties))


@pytest.mark.parametrize("name", ["to_world", "to_world_previous", "to_world_next"])
@pytest.mark.parametrize("matrix, found", [
    (np.diag([2.0, 2, 2, 1]), "scale or shear"),
    (np.array([[1, 0.2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]), "scale or shear"),
    (np.diag([-1.0, 1, 1, 1]), "a mirroring"), (np.diag([np.nan, 1, 1, 1]), "nan"),
])
def test_poses_that_are_none(variant, name, matrix, found):
    transform = mi.ScalarTransform4f(matrix)

    def change():
        params = mi.traverse(mi.load_dict(sensor(8, 4)))
        params[name] = transform
        params.update()

    for make in (sensor_with(**{name: transform}), change):
        text = refusal(make)
        assert f"equirect: {name}: expected" in text and found in text


def test_neighbour_poses_of_a_stock_camera(variant):
    text = refusal(integrator(to_world_next=mi.ScalarTransform4f().scale(2)))
    assert "equirect_aov: to_world_next: expected a rotation and a translation, found scale or shear" in text


def test_light_tracing_is_refused(variant):
    lit = {**ROOM, "lamp": sphere((0, 0, -1), 0.1, emitter={"type": "area", "radiance": 1.0})}
    traced = {"type": "scene", "sensor": sensor(8, 4), "integrator": {"type": "ptracer"}, **lit}
    text = refusal(lambda: mi.render(mi.load_dict(traced), spp=2))
    assert "equirect: light tracing" in text and 'such as "path"' in text


def render_with(**camera):
    return lambda: planes(scene(ROOM, camera, aovs="depth"))


def test_sensors_without_a_known_formula_are_refused(variant):
    for kind in ("orthographic", "radiancemeter", "distant"):
        size = 8 if kind == "orthographic" else 1
        text = refusal(render_with(type=kind, film=film(size, size)))
        assert 'equirect_aov: expected a sensor "equirect", "perspective" or "thinlens", found' in text


def test_it_must_be_the_outermost(variant):
    nested = {"type": "equirect_aov", "aovs": "depth", "nested": {"type": "path"}}
    outer = {"type": "aov", "aovs": "d:depth", "inner": nested}
    text = refusal(lambda: mi.render(mi.load_dict({"type": "scene", "sensor": sensor(8, 4), "integrator": outer, **ROOM}), spp=1))
    assert "equirect_aov: expected to be the outermost integrator" in text


def test_tables_of_the_wrong_length_or_too_large(variant):
    def give(name, values, **others):
        loaded = scene({**ROOM, "ball": sphere((0, 0, -1), 0.8)}, sensor(8, 4))
        params = mi.traverse(loaded)
        for key, table in {name: values, **others}.items():
            params[f"integrator.{key}"] = table
        params.update()
        return planes(loaded)

    assert "object_id: expected 2 numbers" in refusal(lambda: give("object_id", [1, 2, 3]))
    assert "object_id: expected 2 numbers" in refusal(lambda: give("object_id", [7]))
    assert "moved_next: expected 24 numbers (12 for each of the scene's 2 shapes) or a single 0, found 12" in \
        refusal(lambda: give("moved_next", [0.5] * 12))
    assert "material_id: expected ids up to 16777215" in refusal(lambda: give("material_id", [1, 1 << 24]))
    assert give("object_id", [4, 5])["object_id"].max() == 5
    assert "first_face: expected 2 numbers" in refusal(lambda: give("first_face", [1, 0, 0]))
    assert "first_face: expected places on face_entry's 3 numbers, counted from 1, found 4" in \
        refusal(lambda: give("first_face", [4, 0], face_entry=[2, 3, 4]))
    assert "object_id: expected 5 numbers, for all entries of face_entry, or a single 0, found 3" in \
        refusal(lambda: give("object_id", [1, 2, 3], first_face=[1, 0], face_entry=[2, 3, 4]))
    assert "face_entry: expected entries up to 16777215" in refusal(lambda: give("first_face", [1, 0], face_entry=[0xFFFFFFFF]))
    # Fewer places than the mesh has triangles: the last one stands for the rest.
    assert set(np.unique(give("object_id", [1, 2, 6, 7, 8], first_face=[1, 1], face_entry=[2, 3, 4])["object_id"])) <= {0, 6, 7, 8}


def test_names_that_clash_are_found_out_before_rendering(variant):
    inner = {"type": "aov", "aovs": "depth:position", "img": {"type": "path"}}
    text = refusal(lambda: planes(scene(ROOM, sensor(8, 4), aovs="depth", nested=inner)))
    assert 'equirect_aov: expected channels of different names, found "depth.Z" twice' in text


@pytest.mark.parametrize("width, height", [(1, 1), (7, 1), (1, 9), (3, 5), (33, 2)])
def test_odd_films(variant, width, height):
    found = planes(scene(ROOM, sensor(width, height)), spp=2)
    assert found["depth.Z"].shape == (height, width)
    assert found["depth.Z"] == pytest.approx(2.0, rel=1e-6)


def test_mono_and_luminance_films(variant):
    for pixel_format, channels in (("luminance", 1), ("luminance_alpha", 2), ("rgb", 3), ("rgba", 4), ("xyz", 3), ("xyza", 4)):
        found = planes(scene(ROOM, sensor(8, 4, film_options={"pixel_format": pixel_format}), aovs="depth,ids"), spp=2)
        assert found["colour"].shape[2] == channels
        assert found["depth.Z"] == pytest.approx(2.0, rel=1e-6) and (found["object_id"] == 1).all()
