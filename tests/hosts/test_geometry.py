"""Depth, ids, normals, albedo and the mirror flag against closed forms."""

import mitsuba as mi
import numpy as np
import pytest
from conftest import diffuse, film, hit_sphere, planes, pose, scene, sensor, sphere
from independent import equirect_direction, perspective_direction, pixel_centres, rotation, unit

WIDTH, HEIGHT = 64, 32


def directions(width=WIDTH, height=HEIGHT):
    return equirect_direction(*pixel_centres(width, height), width, height)


@pytest.mark.parametrize("near", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("filter", ["box", "gaussian", "lanczos"])
def test_inside_a_sphere_depth_is_its_radius(variant, near, filter):
    found = planes(scene({"ball": sphere(radius=2.0)}, sensor(filter=filter, near_clip=near)), spp=4)
    assert found["depth.Z"] == pytest.approx(2.0, rel=4e-7)


def test_depth_off_the_centre(variant):
    origin = np.array([0.7, -0.2, 0.4])
    found = planes(scene({"ball": sphere((1, 0, -2), 3.5)}, sensor(to_world=pose(origin), near_clip=0.3)))
    expected = hit_sphere(origin, directions(), [1, 0, -2], 3.5)
    assert found["depth.Z"] == pytest.approx(expected, rel=2e-6)


def test_nothing_is_infinitely_far_and_has_no_id(variant, tmp_path):
    loaded = scene({"ball": sphere((0, 0, -5)), "sky": {"type": "constant"}}, sensor(filter="gaussian"))
    found = planes(loaded, spp=4)
    expected = hit_sphere([0, 0, 0], directions(), [0, 0, -5], 1)
    assert (np.isinf(found["depth.Z"]) == np.isinf(expected)).all()
    miss = np.isinf(expected)
    for name in ("object_id", "material_id", "instance_id", "normal.X", "albedo.G", "specular"):
        assert np.abs(found[name][miss]).max() == 0
    assert not any(np.isnan(plane).any() for plane in found.values())


def test_far_clip_and_near_clip_bound_what_is_seen(variant):
    shapes = {"near": sphere((0, 0, 0), 1.0), "far": sphere((0, 0, 0), 4.0)}
    assert planes(scene(shapes, sensor(near_clip=0.99)))["depth.Z"] == pytest.approx(1.0, rel=1e-6)
    assert planes(scene(shapes, sensor(near_clip=1.01)))["depth.Z"] == pytest.approx(4.0, rel=1e-6)
    assert np.isinf(planes(scene(shapes, sensor(near_clip=1.01, far_clip=3.9)))["depth.Z"]).all()


def test_no_filter_reaches_the_geometry_planes(variant):
    shapes = {"a": sphere((0, 0, -3), bsdf=diffuse(0.9, 0.1, 0.2)), "b": sphere((0.5, 0.2, -6), 3),
              "sky": {"type": "constant"}}
    box = planes(scene(shapes), spp=4)
    for filter in ("gaussian", "mitchell", "lanczos", "catmullrom", "tent"):
        other = planes(scene(shapes, sensor(filter=filter)), spp=4)
        for name in set(box) - {"colour"}:
            assert np.array_equal(other[name], box[name]), (filter, name)


def test_holes_and_null_surfaces_are_passed_through_and_glass_is_not(variant):
    def depth(bsdf):
        return planes(scene({"front": sphere(radius=1.5, bsdf=bsdf), "back": sphere(radius=3.0)}), spp=2)["depth.Z"]

    nested = diffuse(0.5, 0.5, 0.5)
    assert depth({"type": "mask", "opacity": 0.49, "b": nested}) == pytest.approx(3.0, rel=1e-6)
    assert depth({"type": "mask", "opacity": 0.51, "b": nested}) == pytest.approx(1.5, rel=1e-6)
    assert depth({"type": "null"}) == pytest.approx(3.0, rel=1e-6)
    assert depth({"type": "mask", "opacity": 0.9, "b": {"type": "thindielectric"}}) == pytest.approx(1.5, rel=1e-6)
    for glass in ("thindielectric", "dielectric"):
        assert depth({"type": glass}) == pytest.approx(1.5, rel=1e-6)


def test_a_masks_texture_decides_pixel_by_pixel(variant):
    texture = {"type": "checkerboard", "color0": 0.0, "color1": 1.0,
               "to_uv": mi.ScalarTransform4f().scale([4, 2, 1])}
    leaf = sphere(radius=1.5, bsdf={"type": "mask", "opacity": texture, "b": diffuse(0.5, 0.5, 0.5)})
    depth = planes(scene({"leaf": leaf, "back": sphere(radius=3.0)}))["depth.Z"]
    assert 0.4 < (depth < 2).mean() < 0.6
    assert np.minimum(np.abs(depth - 1.5), np.abs(depth - 3)).max() < 5e-6


def test_many_layers_of_holes(variant):
    shapes = {f"layer{i}": sphere(radius=1 + 0.01 * i, bsdf={"type": "mask", "opacity": 0.1, "b": diffuse(1, 1, 1)})
              for i in range(60)}
    found = planes(scene({**shapes, "wall": sphere(radius=5.0)}))
    assert found["depth.Z"] == pytest.approx(5.0, rel=1e-6)


def test_ids_are_whole_numbers_under_any_filter(variant):
    cube = {"type": "cube", "to_world": mi.ScalarTransform4f().scale(0.5), "bsdf": diffuse(0.2, 0.3, 0.4)}
    group = {"type": "shapegroup", "shape": cube}
    placed = {"type": "ref", "id": "group"}
    shapes = {"a": sphere((0, 0, -3)), "group": group,
              "b": {"type": "instance", "to_world": mi.ScalarTransform4f().translate([3, 0, 0]), "shapegroup": placed},
              "c": {"type": "instance", "to_world": mi.ScalarTransform4f().translate([-3, 0, 0]), "shapegroup": placed}}
    loaded = scene(shapes, sensor(filter="gaussian"), aovs="ids")
    found = planes(loaded, spp=3)
    middle = {"a": (16, 32), "b": (16, 48), "c": (16, 16)}
    order = [shape.id() for shape in loaded.shapes()]
    for name, (row, column) in middle.items():
        assert found["object_id"][row, column] == order.index(name) + 1
        assert found["instance_id"][row, column] == order.index(name) + 1
    assert found["material_id"][middle["b"]] == found["material_id"][middle["c"]] != found["material_id"][middle["a"]]
    params = mi.traverse(loaded)
    given = [16777215, 70001, 3]
    params["integrator.object_id"] = given
    params["integrator.material_id"] = [0, 9, 0]
    params.update()
    again = planes(loaded, spp=3)
    for name, spot in middle.items():
        i = order.index(name)
        assert again["object_id"][spot] == given[i]
        assert again["material_id"][spot] == ([0, 9, 0][i] or found["material_id"][spot])
    assert set(np.unique(again["object_id"])) <= {0.0, *map(float, given)}


def test_triangles_have_ids_of_their_own_where_they_are_told(variant):
    loaded = scene({"cube": {"type": "cube"}}, sensor(), aovs="ids")
    plain = planes(loaded)
    assert set(np.unique(plain["object_id"])) == {1.0}
    params = mi.traverse(loaded)
    faces = 12
    params["integrator.first_face"] = [1]
    params["integrator.face_entry"] = list(range(1, 1 + faces))
    params["integrator.object_id"] = [0] + [100 + face for face in range(faces)]
    params.update()
    found = planes(loaded)
    assert len(np.unique(found["object_id"])) == faces
    for row, column in ((3, 5), (16, 33), (16, 10), (16, 60), (30, 40)):
        direction = mi.Vector3f(*map(float, directions()[row, column]))
        face = int(np.ravel(np.array(loaded.ray_intersect(mi.Ray3f(mi.Point3f(0), direction)).prim_index))[0])
        assert found["object_id"][row, column] == 100 + face
    assert set(np.unique(found["instance_id"])) == {1.0}


def test_normals_are_unit_in_the_world_and_face_the_camera(variant):
    origin = np.array([0.5, 0.1, -0.3])
    turned = rotation([0.9, 0.1, -0.3, 0.2])
    for flip in (False, True):
        ball = sphere(radius=2.0, flip_normals=flip)
        found = planes(scene({"ball": ball}, sensor(to_world=pose(origin, turned)), aovs="normal,depth"))
        d = directions() @ turned.T
        expected = -unit(origin + hit_sphere(origin, d, [0, 0, 0], 2.0)[..., None] * d)
        n = np.stack([found[f"normal.{c}"] for c in "XYZ"], -1)
        assert n == pytest.approx(expected, abs=3e-6)


def test_smooth_normals_never_look_away(variant):
    """Bumps so steep that their own normals point away from the camera in many places."""
    heights = mi.Bitmap(np.random.default_rng(1).random((32, 32, 1), np.float32))
    texture = {"type": "bitmap", "bitmap": heights, "raw": True}
    bsdf = {"type": "bumpmap", "scale": 5.0, "texture": texture, "bsdf": diffuse(1, 1, 1)}
    shapes = {"pillar": {"type": "cylinder", "p0": [0, -1, -3], "p1": [0, 1, -3], "radius": 1.0, "bsdf": bsdf}}
    loaded = scene(shapes, aovs="normal,depth")
    found = planes(loaded)
    n = np.stack([found[f"normal.{c}"] for c in "XYZ"], -1)
    hit = np.isfinite(found["depth.Z"])
    assert np.linalg.norm(n[hit], axis=-1) == pytest.approx(1, abs=1e-5)
    assert (-(n * directions()).sum(-1)[hit]).min() > 0.015


def test_albedo(any_variant):
    rgb = (0.7, 0.4, 0.2)
    found = planes(scene({"ball": sphere(radius=2.0, bsdf=diffuse(*rgb))}, aovs="albedo"))
    expected = rgb if "mono" not in any_variant else [np.dot(rgb, [0.212671, 0.715160, 0.072169])] * 3
    # Spectral variants upsample RGB to smooth spectra, which 32 wavelengths see again within this.
    tolerance = 0.012 if "spectral" in any_variant else 2e-3
    for channel, value in zip("RGB", expected):
        assert found[f"albedo.{channel}"] == pytest.approx(value, abs=tolerance)


def test_albedo_of_metal_and_glass_is_what_they_send_on(variant):
    def albedo(bsdf):
        found = planes(scene({"ball": sphere(radius=2.0, bsdf=bsdf, flip_normals=True)}, aovs="albedo"))
        return np.array([found[f"albedo.{c}"].mean() for c in "RGB"])

    gold = albedo({"type": "conductor", "material": "Au"})
    assert gold[0] > 0.9 and gold[2] < 0.5
    assert albedo({"type": "roughconductor", "alpha": 0.2, "material": "Au"}) == pytest.approx(gold, rel=0.03)
    tint = {"type": "rgb", "value": [0.9, 0.5, 0.3]}
    assert albedo({"type": "dielectric", "specular_transmittance": tint}) == pytest.approx([0.9, 0.5, 0.3], rel=1e-3)
    principled = {"type": "principled", "base_color": {"type": "rgb", "value": [0.9, 0.6, 0.1]}, "metallic": 1.0}
    assert albedo(principled) == pytest.approx([0.9, 0.6, 0.1], rel=1e-3)


@pytest.mark.parametrize("bsdf, mirrors", [
    ({"type": "diffuse"}, 0), ({"type": "conductor"}, 1), ({"type": "dielectric"}, 1), ({"type": "thindielectric"}, 1),
    ({"type": "plastic", "diffuse_reflectance": 0.5}, 0),
    ({"type": "plastic", "diffuse_reflectance": 0.0}, 1),
    ({"type": "roughconductor", "alpha": 0.03}, 1), ({"type": "roughconductor", "alpha": 0.07}, 0),
    ({"type": "roughconductor", "alpha": 0.03, "distribution": "ggx"}, 1),
    ({"type": "roughconductor", "alpha": 0.07, "distribution": "ggx"}, 0),
    ({"type": "roughdielectric", "alpha": 0.02, "distribution": "ggx"}, 1),
    ({"type": "roughdielectric", "alpha": 0.2, "distribution": "ggx"}, 0),
    ({"type": "principled", "metallic": 1.0, "roughness": 0.15}, 1),
    ({"type": "principled", "metallic": 1.0, "roughness": 0.4}, 0),
    ({"type": "principled", "roughness": 0.05}, 0), ({"type": "principled", "spec_trans": 1.0, "roughness": 0.1}, 1),
    ({"type": "twosided", "b": {"type": "conductor"}}, 1),
    ({"type": "mask", "opacity": 0.8, "b": {"type": "diffuse"}}, 0),
    ({"type": "blendbsdf", "weight": 0.8, "a": {"type": "diffuse"}, "b": {"type": "conductor"}}, 1),
    ({"type": "blendbsdf", "weight": 0.2, "a": {"type": "diffuse"}, "b": {"type": "conductor"}}, 0),
])
def test_specular_flag(variant, bsdf, mirrors):
    found = planes(scene({"ball": sphere((0, 0, -4), 2.0, bsdf=bsdf)}, aovs="specular,depth"))
    # Away from the silhouette, where Fresnel makes mirrors of everything.
    hit = np.isfinite(found["depth.Z"]) & (found["depth.Z"] < 2.6)
    assert hit.any() and (found["specular"][hit] == mirrors).all()


@pytest.mark.parametrize("kind", ["perspective", "thinlens"])
def test_perspective_depth_is_from_the_sensor_and_not_from_its_near_plane(variant, kind):
    lens = {"aperture_radius": 0.2, "focus_distance": 4.0} if kind == "thinlens" else {}
    camera = {"type": kind, "fov": 70.0, "near_clip": 1.0, "to_world": pose((0.1, 0.2, 0.3)),
              "film": film(48, 32, "gaussian"), **lens}
    found = planes(scene({"ball": sphere((0, 0, -3), 1.0)}, camera, aovs="depth"), spp=4)
    d = unit(perspective_direction(*pixel_centres(48, 32), 48, 32, np.radians(70)))
    expected = hit_sphere([0.1, 0.2, 0.3], d, [0, 0, -3], 1.0)
    assert found["depth.Z"] == pytest.approx(expected, rel=3e-6)


def test_hidden_lights_are_no_surfaces(variant):
    shapes = {"lamp": sphere(radius=1.0, emitter={"type": "area", "radiance": 1.0}), "wall": sphere(radius=3.0)}
    nested = {"type": "path", "max_depth": 2, "hide_emitters": True}
    assert planes(scene(shapes, nested=nested, hide_emitters=True))["depth.Z"] == pytest.approx(3.0, rel=1e-6)
    assert planes(scene(shapes))["depth.Z"] == pytest.approx(1.0, rel=1e-6)


def test_ods_depth_is_from_the_columns_own_eye(variant):
    for eye, side in (("ods_left", -1), ("ods_right", 1)):
        camera = sensor(eye=eye, ipd=0.4, near_clip=0.5)
        found = planes(scene({"ball": sphere((0.5, 0.3, -0.4), 3.0)}, camera, aovs="depth"))
        u, v = pixel_centres(WIDTH, HEIGHT)
        longitude, latitude = 2 * np.pi * (u / WIDTH - 0.5), np.pi * (0.5 - v / HEIGHT)
        fade = (1 + np.cos(np.pi * np.clip((np.degrees(np.abs(latitude)) - 60) / 15, 0, 1))) / 2
        origin = (side * 0.2 * fade)[..., None] * np.stack([np.cos(longitude), 0 * u, np.sin(longitude)], -1)
        d = directions()
        expected = np.array([[hit_sphere(origin[y, x], d[y, x], [0.5, 0.3, -0.4], 3.0) for x in range(WIDTH)]
                             for y in range(HEIGHT)])
        assert found["depth.Z"] == pytest.approx(expected, rel=3e-6)
