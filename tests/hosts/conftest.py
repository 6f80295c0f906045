"""What every test here shares: the plugins found, one variant at a time, scenes as small dictionaries."""

import os
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "programs"))
import mitsuba as mi  # noqa: E402

BUILD = os.environ.get("EQUISTREAM_BUILD") or sys.exit("EQUISTREAM_BUILD: expected the build folder, found nothing")
COMPILED = os.environ["EQUISTREAM_MITSUBA_VARIANTS"].split(",")
CPU_VARIANTS = [v for v in COMPILED if not v.startswith("cuda")]
RGB_VARIANTS = [v for v in ("scalar_rgb", "llvm_ad_rgb") if v in COMPILED]


def pytest_generate_tests(metafunc):
    """Tests that ask for a variant run in the two that people use most; `any_variant` means each that a CPU runs."""
    if "variant" in metafunc.fixturenames:
        metafunc.parametrize("variant", RGB_VARIANTS, indirect=True)
    if "any_variant" in metafunc.fixturenames:
        metafunc.parametrize("any_variant", CPU_VARIANTS, indirect=True)


def choose(name):
    mi.set_variant(name)
    mi.set_log_level(mi.LogLevel.Error)
    if BUILD not in [str(path) for path in mi.file_resolver()]:
        mi.file_resolver().append(BUILD)
    return name


@pytest.fixture
def variant(request):
    return choose(request.param)


@pytest.fixture
def any_variant(request):
    return choose(request.param)


@pytest.fixture
def llvm():
    return choose("llvm_ad_rgb")


def pose(position=(0, 0, 0), rotation=np.eye(3)):
    """Mitsuba's to_world of a camera whose frame is ours: +X right, -Z forward."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.asarray(rotation) @ np.diag([-1.0, 1.0, -1.0])
    matrix[:3, 3] = position
    return mi.ScalarTransform4f(matrix)


def film(width, height, filter="box", **others):
    return {"type": "hdrfilm", "width": width, "height": height, "component_format": "float32",
            "rfilter": {"type": filter}, **others}


def sensor(width=64, height=32, filter="box", film_options={}, **others):
    return {"type": "equirect", "to_world": pose(), "film": film(width, height, filter, **film_options),
            "sampler": {"type": "independent", "sample_count": 1}, **others}


def scene(shapes, camera=None, aovs="all", nested=None, **integrator):
    return mi.load_dict({"type": "scene", "sensor": camera or sensor(),
                         "integrator": {"type": "equirect_aov", "aovs": aovs,
                                        "nested": nested or {"type": "path", "max_depth": 2}, **integrator}, **shapes})


def planes(loaded, image=None, **render):
    """Rendered channels by name, as numpy arrays."""
    if image is None:
        image = mi.render(loaded, **{"spp": 1, **render})
    values = np.array(image)
    names = loaded.integrator().aov_names()
    base = values.shape[2] - len(names)
    named = {name: values[..., base + i] for i, name in enumerate(names)}
    named["colour"] = values[..., :base]
    return named


def diffuse(*rgb):
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(rgb)}}


def sphere(centre=(0, 0, 0), radius=1.0, bsdf=None, **others):
    return {"type": "sphere", "center": list(centre), "radius": radius, "bsdf": bsdf or diffuse(0.5, 0.5, 0.5), **others}


def hit_sphere(origin, direction, centre, radius):
    """Nearest distance along unit directions at which a ray meets a sphere; inf where it does not."""
    towards = np.asarray(origin, float) - centre
    b = direction @ towards
    inside = b * b - (towards @ towards - radius * radius)
    root = np.sqrt(np.maximum(inside, 0))
    near, far = -b - root, -b + root
    distance = np.where(near > 0, near, np.where(far > 0, far, np.inf))
    return np.where(inside > 0, distance, np.inf)
