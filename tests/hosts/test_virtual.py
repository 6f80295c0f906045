"""What mirrors and glass show, against closed forms: mirror images, Coddington's equations, apparent depth, motion."""

import mitsuba as mi
import numpy as np
import pytest
from conftest import hit_sphere, planes, pose, scene, sensor, sphere
from independent import equirect_direction, equirect_pixel, pixel_centres

WIDTH, HEIGHT = 128, 64
MIRROR = {"type": "conductor", "material": "none"}
GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
ROOM = 6.0


def directions():
    return equirect_direction(*pixel_centres(WIDTH, HEIGHT), WIDTH, HEIGHT)


def wall(z, half_width, half_height, bsdf):
    """Upright in the plane z, facing +Z."""
    to_world = mi.ScalarTransform4f().translate([0, 0, z]).scale([half_width, half_height, 1])
    return {"type": "rectangle", "to_world": to_world, "bsdf": bsdf}


def seen(shapes, aovs="virtual,depth,specular,motion"):
    return planes(scene({"room": sphere(radius=ROOM), **shapes}, sensor(WIDTH, HEIGHT), aovs=aovs))


def reflected(d, normal):
    return d - 2 * (d * normal).sum(-1, keepdims=True) * normal


def test_a_plane_mirror(variant):
    found = seen({"mirror": wall(-2, 1.5, 1, MIRROR)})
    d = directions()
    mirrors = found["specular"] == 1
    assert mirrors.sum() > 200
    to_mirror = -2 / d[..., 2]
    beyond = hit_sphere_from(to_mirror[..., None] * d, d * [1, 1, -1])
    # Mitsuba's mirrored rays begin a ten-thousandth off the mirror, and meet the room's wall so much aside.
    assert found["virtual_depth.Z"][mirrors] == pytest.approx((to_mirror + beyond)[mirrors], rel=2e-5)
    assert np.array_equal(found["virtual_depth.Z"][~mirrors], found["depth.Z"][~mirrors])
    for name in ("backward", "forward"):
        for way in "uv":
            elsewhere = found[f"virtual_{name}.{way}"][~mirrors], found[f"{name}.{way}"][~mirrors]
            assert np.array_equal(*elsewhere)
            assert np.abs(found[f"virtual_{name}.{way}"][mirrors]).max() < 1e-3


def hit_sphere_from(origins, d):
    """From inside the room, origins of their own."""
    b = (origins * d).sum(-1)
    return -b + np.sqrt(b * b - (origins * origins).sum(-1) + ROOM * ROOM)


def test_the_sky_in_a_plane_mirror(variant):
    loaded = scene({"mirror": wall(-2, 1.5, 1, MIRROR), "sky": {"type": "constant"}}, sensor(WIDTH, HEIGHT), aovs="virtual,specular")
    found = planes(loaded)
    assert np.isinf(found["virtual_depth.Z"]).all() and (found["specular"] == 1).any()


def coddington(d, centre, radius, thing_from):
    """Harmonic mean of the two image distances of a ball that mirrors, where it is hit not too aslant."""
    hit = hit_sphere([0, 0, 0], d, centre, radius)
    ball = np.isfinite(hit)
    t = np.where(ball, hit, 1)
    at = t[..., None] * d
    normal = (at - centre) / radius
    cosine = -(d * normal).sum(-1)
    b = thing_from(at, reflected(d, normal))
    in_plane = t + 1 / (1 / b + 2 / (radius * cosine))
    across = t + 1 / (1 / b + 2 * cosine / radius)
    return ball & (cosine > 0.3), 2 / (1 / in_plane + 1 / across)


def test_a_ball(variant):
    centre = np.array([0.3, 0.2, -3.0])
    found = seen({"ball": sphere(centre, 1.0, MIRROR)})
    ball, expected = coddington(directions(), centre, 1.0, hit_sphere_from)
    assert ball.sum() > 80
    assert found["virtual_depth.Z"][ball] == pytest.approx(expected[ball], rel=1e-4)
    # The sky is near in a ball, too.
    loaded = scene({"ball": sphere(centre, 1.0, MIRROR), "sky": {"type": "constant"}}, sensor(WIDTH, HEIGHT), aovs="virtual")
    _, expected = coddington(directions(), centre, 1.0, lambda at, on: np.full(at.shape[:-1], 1e12))
    assert planes(loaded)["virtual_depth.Z"][ball] == pytest.approx(expected[ball], rel=1e-4)


def ball_mesh(centre, radius, uvs, flipped=False):
    """Latitudes and longitudes, smooth normals, with texture coordinates that are not barycentrics."""
    rows, columns = 96, 192
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij")
    normals = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    faces = []
    for y in range(rows):
        for x in range(columns):
            a = y * (columns + 1) + x
            faces += [[a, a + 1, a + columns + 1], [a + 1, a + columns + 2, a + columns + 1]]
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(MIRROR)
    if flipped:
        props["flip_normals"] = True
    mesh = mi.Mesh("ball", len(normals), len(faces), has_vertex_normals=True, has_vertex_texcoords=uvs, props=props)
    params = mi.traverse(mesh)
    params["vertex_positions"] = (np.asarray(centre) + radius * normals).ravel().astype(np.float32)
    params["vertex_normals"] = (-normals if flipped else normals).ravel().astype(np.float32)
    params["faces"] = np.array(faces, np.uint32).ravel()
    if uvs:
        params["vertex_texcoords"] = np.stack([3 * phi.ravel(), 0.2 * theta.ravel()], -1).ravel().astype(np.float32)
    params.update()
    return mesh


@pytest.mark.parametrize("uvs", [False, True])
def test_a_ball_that_is_a_mesh(variant, uvs):
    centre = np.array([0.3, 0.2, -3.0])
    found = seen({"ball": ball_mesh(centre, 1.0, uvs)})
    ball, expected = coddington(directions(), centre, 1.0, hit_sphere_from)
    ball &= found["specular"] == 1
    # In w = B / (r - B), as far as facets go: most pixels within a hundredth, none far off.
    off = np.abs(found["virtual_depth.Z"][ball] / expected[ball] - 1)
    assert np.median(off) < 0.004 and np.quantile(off, 0.98) < 0.03


def test_a_slab_of_glass(variant):
    slab = {"type": "cube", "to_world": mi.ScalarTransform4f().translate([0, 0, -2]).scale([1.5, 1.0, 0.25]), "bsdf": GLASS}
    found = seen({"slab": slab})
    d = directions()
    front, back = -1.75 / d[..., 2], -2.25 / d[..., 2]
    at_front = front[..., None] * d
    cosine = -d[..., 2]
    inside = np.sqrt(1 - (1 - cosine ** 2) / 2.25)
    within = np.stack([d[..., 0] / 1.5, d[..., 1] / 1.5, -inside], -1)
    length = 0.5 / inside
    at_back = at_front + length[..., None] * within
    through = (found["specular"] == 1) & (np.abs(at_back[..., 0]) < 1.4) & (np.abs(at_back[..., 1]) < 0.9) & (back > 0)
    assert through.sum() > 150
    behind = hit_sphere_from(at_back, d)
    across = front + length / 1.5 + behind
    in_plane = front + length / 1.5 * (cosine / inside) ** 2 + behind
    assert found["virtual_depth.Z"][through] == pytest.approx((2 / (1 / across + 1 / in_plane))[through], rel=1e-5)


def test_a_thin_pane_is_the_path_straight_on(variant):
    found = seen({"pane": wall(-1, 1, 1, {"type": "thindielectric"})})
    panes = found["specular"] == 1
    assert panes.any() and found["virtual_depth.Z"][panes] == pytest.approx(ROOM, rel=2e-6)


def test_what_moves_in_a_mirror(variant):
    """A card behind the eye steps aside; the eye moves, too."""
    card = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 3]).rotate([0, 1, 0], 180).scale([2, 1, 1])}
    camera = sensor(WIDTH, HEIGHT, to_world=pose(), to_world_previous=pose((0.1, -0.05, 0.2)), to_world_next=pose((-0.1, 0.1, 0)))
    loaded = scene({"room": sphere(radius=ROOM), "mirror": wall(-2, 1.2, 0.8, MIRROR), "card": card}, camera, aovs="virtual,specular")
    steps = {"previous": np.array([0.2, -0.1, 0.1]), "next": np.array([-0.15, 0.05, -0.2])}
    eyes = {"previous": np.array([0.1, -0.05, 0.2]), "next": np.array([-0.1, 0.1, 0])}
    order = [shape.id() for shape in loaded.shapes()]
    params = mi.traverse(loaded)
    for name, step in steps.items():
        matrices = [np.eye(4)[:3].copy() for _ in order]
        matrices[order.index("card")][:, 3] = step
        params[f"integrator.moved_{name}"] = [float(v) for matrix in matrices for v in matrix.ravel()]
    params.update()
    found = planes(loaded)
    d = directions()
    image = (-7 / d[..., 2])[..., None] * d  # the card stands at z = 3, its image at -7
    inside = (found["specular"] == 1) & (np.abs(image[..., 0]) < 1.9) & (np.abs(image[..., 1]) < 0.9)
    assert inside.sum() > 50
    u, v = pixel_centres(WIDTH, HEIGHT)
    for plane, name in (("backward", "previous"), ("forward", "next")):
        there = image + steps[name] * [1, 1, -1] - eyes[name]
        u1, v1 = equirect_pixel(there, WIDTH, HEIGHT)
        assert found[f"virtual_{plane}.u"][inside] == pytest.approx((u1 - u)[inside], abs=2e-3)
        assert found[f"virtual_{plane}.v"][inside] == pytest.approx((v1 - v)[inside], abs=2e-3)
