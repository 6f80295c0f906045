"""`equistream scene convert`: what Mitsuba makes of our scenes, by rays and by closed forms. Runs the built program and the real wheel."""

import itertools
import json
import os
import pathlib
import resource
import signal
import subprocess

import numpy as np
import pytest

import mitsuba as mi
from conftest import choose
from small_gltf import Gltf

BIN = pathlib.Path(os.environ["EQUISTREAM_BUILD"]) / "bin"
REPEAT, CLAMP, MIRROR = 10497, 33071, 33648
NAMES = {REPEAT: "repeat", CLAMP: "clamp", MIRROR: "mirror"}
LAMBERT = {"KHR_materials_ior": {"ior": 1}}
GENERATED = ["pavilion", "orientation", "sphere", "furnace", "motion", "materials"]


@pytest.fixture
def scalar():
    """Rays one by one, without a kernel for each."""
    return choose("scalar_rgb")


def equistream(*words, **how):
    return subprocess.run([BIN / "equistream", *(str(w) for w in words)], capture_output=True, text=True, **how)


def done(*words):
    result = equistream(*words)
    assert result.returncode == 0, result.stderr
    return result


def load(file, **parameters):
    """The scene, and an error for every warning that Mitsuba has about it."""
    warnings = []

    class Listener(mi.Appender):
        def append(self, level, text):
            if level >= mi.LogLevel.Warn:
                warnings.append(text)

        def log_progress(self, *_):
            pass

    logger, listener = mi.logger(), Listener()
    level = logger.log_level()
    logger.set_log_level(mi.LogLevel.Warn)
    logger.add_appender(listener)
    try:
        scene = mi.load_file(str(file), optimize=False, **parameters)
    finally:
        logger.remove_appender(listener)
        logger.set_log_level(level)
    assert warnings == []
    return scene


def convert(scene, out, *options):
    done("scene", "convert", scene, out, *options)
    return load(out)


def shape(scene, name):
    return next(s for s in scene.shapes() if s.id() == name)


def shoot(scene, origins, directions):
    """Interactions of rays, one by one: the scalar variant has no arrays."""
    return [scene.ray_intersect(mi.Ray3f(mi.Point3f(*map(float, o)), mi.Vector3f(*map(float, d)))) for o, d in zip(origins, directions)]


def emitted(scene, points):
    """Radiance towards +Z at points of the plane z = 0."""
    points = np.asarray(points, float)
    hits = shoot(scene, np.c_[points, np.full(len(points), 1.0)], np.tile([0, 0, -1.0], (len(points), 1)))
    return np.array([np.array(h.emitter(scene).eval(h)).ravel() for h in hits])


def linear(byte):
    x = np.asarray(byte, float) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def wrapped(index, size, mode):
    if mode == REPEAT:
        return index % size
    if mode == CLAMP:
        return np.clip(index, 0, size - 1)
    m = index % (2 * size)
    return np.where(m < size, m, 2 * size - 1 - m)


def looked_up(pixels, uv, wrap, nearest):
    """glTF: v runs down, texel centres at half-integers, filtered in linear light."""
    height, width = pixels.shape[:2]
    at = uv * [width, height]
    texel = lambda x, y: linear(pixels[wrapped(y, height, wrap[1]), wrapped(x, width, wrap[0])])
    if nearest:
        i = np.floor(at).astype(int)
        return texel(i[:, 0], i[:, 1])
    low = np.floor(at - 0.5).astype(int)
    f = (at - 0.5 - low)[:, :, None]
    x, y = low.T
    top = (1 - f[:, 0]) * texel(x, y) + f[:, 0] * texel(x + 1, y)
    return (1 - f[:, 1]) * top + f[:, 1] * ((1 - f[:, 0]) * texel(x, y + 1) + f[:, 0] * texel(x + 1, y + 1))


@pytest.mark.parametrize("name", GENERATED)
@pytest.mark.parametrize("options", [(), ("--bake",)], ids=["instances", "baked"])
def test_every_generated_scene_loads_without_a_warning(name, options, tmp_path, variant):
    done("scene", "generate", name, "--out", tmp_path)
    scene = convert(tmp_path / f"{name}.json", tmp_path / "out.xml", *options)
    model = json.loads(done("scene", "info", tmp_path / f"{name}.json", "--json").stdout)
    placed = {int(s.id().split("-")[1]) for s in scene.shapes() if s.id().startswith("instance-")}
    merged = [set(np.unique(np.array(mi.traverse(s)["face_instance"]))) for s in scene.shapes() if s.id().startswith("merged-")]
    parts = [placed, *merged]
    assert set().union(*parts) == set(range(model["instances"])) and sum(map(len, parts)) == model["instances"]


@pytest.mark.parametrize("nearest", [False, True], ids=["bilinear", "nearest"])
@pytest.mark.parametrize("wrap", list(itertools.product([REPEAT, CLAMP, MIRROR], repeat=2)), ids=lambda w: "-".join(NAMES[m] for m in w))
def test_textures_lie_where_gltf_says(wrap, nearest, tmp_path, scalar):
    random = np.random.default_rng(5)
    pixels = random.integers(0, 256, (5, 7, 3), dtype=np.uint8)
    gltf = Gltf()
    texture = gltf.texture(pixels, wrap, nearest)
    gltf.quad(gltf.material(emissiveFactor=[1, 1, 1], emissiveTexture={"index": texture}, pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 1]}),
              uv=((-0.7, -0.4), (1.9, 2.3)))
    scene = convert(gltf.write(tmp_path), tmp_path / "out.xml")
    at = random.uniform(0.01, 0.99, (200, 2))  # from the top left corner
    uv = [-0.7, -0.4] + at * [2.6, 2.7]
    found = emitted(scene, np.c_[at[:, 0] - 0.5, 0.5 - at[:, 1]])
    expected = looked_up(pixels, uv, wrap, nearest)
    # A light's image is stored in halves.
    assert np.abs(found - expected).max() < 1e-3


def reflected(scene, points):
    points = np.asarray(points, float)
    hits = shoot(scene, np.c_[points, np.full(len(points), 1.0)], np.tile([0, 0, -1.0], (len(points), 1)))
    return np.array([np.pi * np.array(h.bsdf().eval(mi.BSDFContext(), h, mi.Vector3f(0, 0, 1))).ravel() for h in hits])


@pytest.mark.parametrize("factor", [(1, 1, 1), (0.3, 0.7, 0.05)], ids=["plain", "tinted"])
def test_base_colours_are_texture_times_factor(factor, tmp_path, scalar):
    random = np.random.default_rng(6)
    pixels = random.integers(0, 256, (16, 16, 3), dtype=np.uint8)
    gltf = Gltf()
    gltf.quad(gltf.material(extensions=LAMBERT, pbrMetallicRoughness={"metallicFactor": 0, "baseColorFactor": [*factor, 1],
                                                                        "baseColorTexture": {"index": gltf.texture(pixels)}}))
    scene = convert(gltf.write(tmp_path), tmp_path / "out.xml")
    at = random.uniform(0.01, 0.99, (200, 2))
    found = reflected(scene, np.c_[at[:, 0] - 0.5, 0.5 - at[:, 1]])
    assert np.abs(found - looked_up(pixels, at, (REPEAT, REPEAT), False) * factor).max() < 1e-3


def test_masks_cut_texel_by_texel(tmp_path, scalar):
    random = np.random.default_rng(7)
    pixels = random.integers(0, 256, (32, 32, 4), dtype=np.uint8)
    gltf = Gltf()
    gltf.quad(gltf.material(alphaMode="MASK", alphaCutoff=0.3, extensions=LAMBERT,
                            pbrMetallicRoughness={"metallicFactor": 0, "baseColorFactor": [1, 1, 1, 0.8],
                                                  "baseColorTexture": {"index": gltf.texture(pixels)}}))
    scene = convert(gltf.write(tmp_path), tmp_path / "out.xml")
    x, y = np.meshgrid(np.arange(32), np.arange(32))
    kept = pixels[y, x, 3] / np.float32(255) * np.float32(0.8) >= np.float32(0.3)
    for dx, dy in ((0.5, 0.5), (0.02, 0.02), (0.98, 0.98)):  # all over the texel: nothing is filtered
        at = np.c_[(x.ravel() + dx) / 32 - 0.5, 0.5 - (y.ravel() + dy) / 32]
        hits = shoot(scene, np.c_[at, np.ones(1024)], np.tile([0, 0, -1.0], (1024, 1)))
        opacity = np.array([float(np.ravel(h.bsdf().eval_attribute_1("opacity", h))[0]) for h in hits])
        assert (opacity == kept.ravel()).all()
    assert 0.3 < kept.mean() < 0.7


@pytest.mark.parametrize("double_sided", [False, True])
@pytest.mark.parametrize("mirrored", [False, True])
def test_lights_shine_on_the_side_that_gltf_says(double_sided, mirrored, tmp_path, scalar):
    gltf = Gltf()
    gltf.quad(gltf.material(emissiveFactor=[1, 0.5, 0.25], doubleSided=double_sided, extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 3}},
                            pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 1]}), scale=[-1 if mirrored else 1, 1, 1])
    scene = convert(gltf.write(tmp_path), tmp_path / "out.xml")
    front, back = shoot(scene, [[0.1, 0.2, 1], [0.1, 0.2, -1]], [[0, 0, -1], [0, 0, 1]])
    assert np.allclose(np.ravel(front.emitter(scene).eval(front)), [3, 1.5, 0.75])
    assert np.allclose(np.ravel(back.emitter(scene).eval(back)), [3, 1.5, 0.75] if double_sided else 0)
    assert abs(float(np.ravel(back.t)[0]) - 1) < 1e-4


@pytest.mark.parametrize("options", [(), ("--bake",)], ids=["instances", "baked"])
def test_fronts_stay_outside_where_a_transform_mirrors(options, tmp_path, scalar):
    gltf = Gltf()
    mesh = gltf.quad(gltf.material(extensions=LAMBERT, pbrMetallicRoughness={"metallicFactor": 0}))
    gltf.place(mesh, translation=[3, 0, 0], scale=[-1, 1, 1])
    gltf.place(mesh, translation=[6, 0, 0], scale=[1, 1, -1])  # seen from behind
    scene = convert(gltf.write(tmp_path), tmp_path / "out.xml", *options)
    hits = shoot(scene, [[x, 0.1, 1] for x in (0, 3, 6)], [[0, 0, -1]] * 3)
    assert [round(float(np.ravel(h.n[2])[0])) for h in hits] == [1, 1, -1]


def test_the_sphere_is_where_its_formula_says(tmp_path, scalar):
    done("scene", "generate", "sphere", "--option", "radius=2", "--option", "n=64", "--out", tmp_path)
    scene = convert(tmp_path / "sphere.json", tmp_path / "out.xml")
    random = np.random.default_rng(8)
    directions = random.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    hits = shoot(scene, np.zeros((300, 3)), directions)
    depth = np.array([float(np.ravel(h.t)[0]) for h in hits])
    assert (depth <= 2 * (1 + 1e-6)).all() and (depth >= 2 * np.cos(np.pi / 64) * (1 - 1e-6)).all()
    inwards = np.array([[float(np.ravel(h.n[i])[0]) for i in range(3)] for h in hits])
    assert (np.einsum("ij,ij->i", inwards, directions) < -np.cos(np.pi / 64)).all()


def sky_file(folder, random):
    pixels = random.uniform(0, 4, (6, 10, 3)).astype(np.float32)
    mi.Bitmap(pixels).write(str(folder / "sky.exr"))
    return pixels.astype(float)


def test_a_sky_image_is_turned_as_ours(tmp_path, scalar):
    random = np.random.default_rng(9)
    pixels = sky_file(tmp_path, random)
    gltf = Gltf()
    gltf.quad(gltf.material(pbrMetallicRoughness={}))
    scene = convert(gltf.write(tmp_path, sky={"image": "sky.exr", "rotation_deg": 37, "scale": [2, 1, 0.5]}), tmp_path / "out.xml")
    world = random.normal(size=(300, 3))
    world /= np.linalg.norm(world, axis=1)[:, None]
    a = np.radians(-37)  # the image's direction is the world's turned back
    x, y, z = np.cos(a) * world[:, 0] + np.sin(a) * world[:, 2], world[:, 1], -np.sin(a) * world[:, 0] + np.cos(a) * world[:, 2]
    at = np.c_[(np.arctan2(x, -z) / (2 * np.pi) + 0.5) * 10, (0.5 - np.arcsin(y) / np.pi) * 6] - 0.5
    low = np.floor(at).astype(int)
    f = (at - low)[:, :, None]
    texel = lambda i, j: pixels[np.clip(j, 0, 5), i % 10]
    i, j = low.T
    expected = ((1 - f[:, 1]) * ((1 - f[:, 0]) * texel(i, j) + f[:, 0] * texel(i + 1, j)) +
                f[:, 1] * ((1 - f[:, 0]) * texel(i, j + 1) + f[:, 0] * texel(i + 1, j + 1))) * [2, 1, 0.5]
    sky = scene.environment()
    found = []
    for d in world:
        si = mi.SurfaceInteraction3f()
        si.wi = -mi.Vector3f(*d)
        found.append(np.ravel(sky.eval(si)))
    assert np.abs(np.array(found) / expected - 1).max() < 3e-3  # halves, and floats in atan2


def shadow_scene(folder, radius_deg):
    """A white floor facing +Z, and above it a wide black screen whose edge is the line x = 0."""
    gltf = Gltf()
    white = gltf.material(extensions=LAMBERT, pbrMetallicRoughness={"metallicFactor": 0})
    black = gltf.material(extensions=LAMBERT, pbrMetallicRoughness={"metallicFactor": 0, "baseColorFactor": [0, 0, 0, 1]})
    gltf.quad(white, size=4)
    gltf.quad(black, size=40, translation=[-20, 0, 1])
    return gltf.write(folder, sun={"towards": [0, 0, 1], "irradiance": [2, 3, 4], "angular_radius_deg": radius_deg})


def test_the_suns_irradiance_and_penumbra(tmp_path, llvm):
    radius = 4.0
    scene = convert(shadow_scene(tmp_path, radius), tmp_path / "out.xml")
    # Where the floor sees the edge at x / 1 from straight up, the visible part of the disc is a circular segment.
    r = np.tan(np.radians(radius))
    x = np.array([-1.5 * r, -0.6 * r, 0, 0.4 * r, 1.5 * r])
    t = np.clip(x / r, -1, 1)
    visible = 1 - (np.arccos(t) - t * np.sqrt(1 - t * t)) / np.pi
    n = 1 << 17
    integrator = mi.load_dict({"type": "path", "max_depth": 2})
    for place, expected in zip(x, visible):
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(3, n)
        ray = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(mi.Float([place] * n), 0.0, 0.5), mi.Vector3f(0, 0, -1)))
        light, _, _ = integrator.sample(scene, sampler, ray)
        values = np.array(light)[0] * np.pi
        error = values.std() / np.sqrt(n) + 2e-4
        assert abs(values.mean() - 2 * expected) < 5 * error, (place, values.mean(), 2 * expected, error)
    centre = np.array(light).mean(1) * np.pi
    assert np.allclose(centre, [2, 3, 4], rtol=2e-3)


def test_the_camera_looks_where_the_path_does(tmp_path, scalar):
    gltf = Gltf()
    gltf.quad(gltf.material(pbrMetallicRoughness={}))
    turn = np.array([0.8, 0.2, 0.4, 0.4])
    keys = [{"time_s": 0, "position_m": [0, 0, 2]}, {"time_s": 1, "position_m": [3, 4, 5], "orientation_wxyz": (turn / np.linalg.norm(turn)).tolist()}]
    scene = convert(gltf.write(tmp_path, camera={"keys": keys}), tmp_path / "out.xml", "--frame", 30, "--size", "300x200")
    sensor = scene.sensors()[0]
    w, x, y, z = turn / np.linalg.norm(turn)
    rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
    for u, v in ((0.5, 0.5), (10.5, 20.5), (299.5, 0.5), (150, 199.5)):
        expected = rotation @ [(u - 150) / 150, (100 - v) / 150, -1]
        ray, _ = sensor.sample_ray(0, 0.5, mi.Point2f(u / 300, v / 200), mi.Point2f(0.5))
        found = np.ravel(ray.d)
        assert np.abs(found - expected / np.linalg.norm(expected)).max() < 1e-5
        assert np.abs(np.ravel(ray.o) - [3, 4, 5]).max() < 2e-3


def test_the_report_counts_what_is_there(tmp_path, scalar):
    done("scene", "generate", "furnace", "--out", tmp_path)
    report = json.loads(done("scene", "convert", tmp_path / "furnace.json", tmp_path / "out.xml", "--json").stdout)
    assert (report["triangles"], report["shapes"], report["instances"], report["groups"], report["images"]) == (54144, 0, 6, 3, 0)
    assert report["bytes"] == sum(path.stat().st_size for path in (tmp_path / "out.files").iterdir())
    assert not any("thindielectric" in note for note in report["notes"])  # a pane is a pane


class TestBadInput:
    @pytest.fixture
    def scene(self, tmp_path):
        done("scene", "generate", "orientation", "--out", tmp_path)
        return tmp_path / "orientation.json"

    @staticmethod
    def refused(code, *words, **how):
        result = equistream("scene", "convert", *words, **how)
        assert result.returncode == code and result.stderr.count("\n") == 1, result.stderr
        return result.stderr

    def test_a_folder_that_is_not_there(self, scene, tmp_path):
        assert "expected a folder to write to, found none" in self.refused(2, scene, tmp_path / "none/out.xml")

    def test_another_extension(self, scene, tmp_path):
        assert "expected a name that ends in .xml" in self.refused(2, scene, tmp_path / "out.json")

    def test_what_is_there_stays_unless_it_may_go(self, scene, tmp_path):
        out = tmp_path / "out.xml"
        done("scene", "convert", scene, out)
        before = out.read_bytes()
        assert "--overwrite" in self.refused(2, scene, out)
        assert out.read_bytes() == before
        done("scene", "convert", scene, out, "--overwrite", "--spp", 3)
        assert out.read_bytes() != before

    def test_somebody_elses_folder_is_not_deleted(self, scene, tmp_path):
        (tmp_path / "out.files").mkdir()
        (tmp_path / "out.files/notes.txt").write_text("mine")
        assert "notes.txt" in self.refused(2, scene, tmp_path / "out.xml", "--overwrite")
        assert (tmp_path / "out.files/notes.txt").read_text() == "mine"

    def test_a_scene_that_cannot_be_written_leaves_what_was_there(self, scene, tmp_path):
        out = tmp_path / "out.xml"
        done("scene", "convert", scene, out)
        files = {path.name: path.read_bytes() for path in (tmp_path / "out.files").iterdir()}
        out.unlink()
        (out / "in the way").mkdir(parents=True)
        before = sorted(path.name for path in tmp_path.iterdir())
        assert "out.xml" in self.refused(1, scene, out, "--overwrite")
        assert {path.name: path.read_bytes() for path in (tmp_path / "out.files").iterdir()} == files
        assert sorted(path.name for path in tmp_path.iterdir()) == before

    @pytest.mark.parametrize("limit", [0, 256, 65536])
    def test_a_write_that_fails_leaves_nothing(self, scene, tmp_path, limit):
        """A limit on files' sizes fails a write where a full disk does, at the start or in the middle, and needs no rights."""
        def files_end_early():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        out = tmp_path / "new"
        out.mkdir()
        assert "cannot be written" in self.refused(1, scene, out / "out.xml", preexec_fn=files_end_early)
        assert list(out.iterdir()) == []
        # Where mounting is allowed, a disk that is really full too.
        if limit and subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={limit}", "tmpfs", out], stderr=subprocess.DEVNULL).returncode == 0:
            try:
                assert "cannot be written" in self.refused(1, scene, out / "out.xml")
                assert list(out.iterdir()) == []
            finally:
                subprocess.run(["umount", out], check=True)
