"""All the ways in which Mitsuba renders: variants, crops, passes, undeveloped films, cancelling, gradients, frames."""

import threading
import time

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from conftest import diffuse, film, hit_sphere, planes, pose, scene, sensor, sphere
from independent import equirect_direction, pixel_centres

ROOM = {"room": sphere((0.3, 0.1, 0), 3.0, diffuse(0.6, 0.5, 0.4), flip_normals=True),
        "lamp": sphere((0, 1.5, 0), 0.2, emitter={"type": "area", "radiance": 8.0})}


def expected_depth(width, height):
    d = equirect_direction(*pixel_centres(width, height), width, height)
    return np.minimum(hit_sphere([0, 0, 0], d, [0.3, 0.1, 0], 3.0), hit_sphere([0, 0, 0], d, [0, 1.5, 0], 0.2))


def test_every_variant_that_a_cpu_runs(any_variant):
    loaded = scene(ROOM, sensor(32, 16, filter="gaussian", near_clip=0.2), nested={"type": "path", "max_depth": 4})
    found = planes(loaded, spp=8)
    assert found["depth.Z"] == pytest.approx(expected_depth(32, 16), rel=2e-6)
    assert set(np.unique(found["object_id"])) == {1.0, 2.0}
    assert np.isfinite(found["colour"]).all() and found["colour"].mean() > 0.05
    assert all(not np.isnan(plane).any() for plane in found.values())


def test_every_variant_renders_omnidirectional_stereo(any_variant):
    found = planes(scene(ROOM, sensor(32, 16, eye="ods_left"), aovs="motion,depth"), spp=1)
    assert np.abs(found["backward.u"]).max() < 1e-3 and (found["depth.Z"] < 3.5).all()


def test_a_crop_is_a_part_of_the_whole(variant):
    crop = {"crop_width": 12, "crop_height": 6, "crop_offset_x": 20, "crop_offset_y": 9}
    moved = {"to_world_previous": pose((0.2, 0, 0))}
    whole = planes(scene(ROOM, sensor(64, 32, **moved)))
    part = planes(scene(ROOM, sensor(64, 32, film_options=crop, **moved)))
    for name in set(whole) - {"colour"}:
        assert part[name] == pytest.approx(whole[name][9:15, 20:32], rel=1e-5, abs=2e-5), name


def test_a_film_that_changes_its_size(variant):
    loaded = scene(ROOM, sensor(64, 32), aovs="depth")
    planes(loaded)
    params = mi.traverse(loaded)
    params["sensor.film.size"] = [20, 10]
    params.update()
    assert planes(loaded)["depth.Z"] == pytest.approx(expected_depth(20, 10), rel=2e-6)


def test_passes_and_a_border_of_samples(variant):
    passes = {"type": "path", "max_depth": 3, "samples_per_pass": 2}
    for options in ({}, {"sample_border": True}):
        found = planes(scene(ROOM, sensor(32, 16, "gaussian", film_options=options), nested=passes), spp=8)
        assert found["depth.Z"] == pytest.approx(expected_depth(32, 16), rel=2e-6)


def test_an_undeveloped_film_holds_everything(variant, tmp_path):
    loaded = scene(ROOM, sensor(32, 16, "gaussian"))
    developed = planes(loaded, spp=4, seed=5)
    loaded.integrator().render(loaded, loaded.sensors()[0], seed=5, spp=4, develop=False)
    late = planes(loaded, loaded.sensors()[0].film().develop())
    for name, plane in developed.items():
        # Threads add up filtered colour in no fixed order.
        assert late[name] == pytest.approx(plane, rel=1e-5, abs=1e-6), name
        assert name == "colour" or np.array_equal(late[name], plane), name
    file = tmp_path / "frame.exr"
    loaded.sensors()[0].film().write(str(file))
    written = mi.Bitmap(str(file))
    names = [field.name for field in written.struct_()]
    values = np.array(written)
    for name in loaded.integrator().aov_names():
        assert np.array_equal(values[..., names.index(name)], developed[name]), name


def test_rendering_again_gives_the_same(variant):
    loaded = scene(ROOM, sensor(32, 16, "gaussian"))
    first, second = planes(loaded, spp=4, seed=1), planes(loaded, spp=4, seed=1)
    for name, plane in first.items():
        # Threads add up filtered colour in no fixed order.
        assert second[name] == pytest.approx(plane, rel=1e-5, abs=1e-6), name


def test_cancelling_leaves_a_film_of_the_right_shape(variant):
    nested = {"type": "path", "max_depth": 16}
    loaded = scene(ROOM, sensor(256, 128), aovs="depth", nested=nested)
    integrator = loaded.integrator()
    result = {}
    spp = 64 if "llvm" in variant else 4096

    def render():
        result["image"] = np.array(integrator.render(loaded, loaded.sensors()[0], spp=spp))

    worker = threading.Thread(target=render)
    worker.start()
    time.sleep(0.3)
    integrator.cancel()
    begun = time.time()
    worker.join()
    assert result["image"].shape == (128, 256, 4)
    if "scalar" in variant:
        assert time.time() - begun < 10, "4,096 samples take minutes"
    assert planes(loaded)["depth.Z"] == pytest.approx(expected_depth(256, 128), rel=2e-6)


def test_a_timeout_of_the_nested_integrator(variant):
    loaded = scene(ROOM, sensor(256, 128), aovs="depth", nested={"type": "path", "max_depth": 4, "timeout": 0.2})
    found = planes(loaded, spp=512 if "scalar" in variant else 4)
    assert found["depth.Z"] == pytest.approx(expected_depth(256, 128), rel=2e-6)


@pytest.mark.parametrize("nested", ["path", "direct", "volpath", "volpathmis", "depth", "moment", "stokes"])
def test_nested_integrators(variant, nested):
    if nested == "stokes":
        mi.set_variant("scalar_spectral_polarized" if "scalar" in variant else "llvm_ad_mono_polarized")
    described = {"type": nested}
    if nested in ("moment", "stokes"):
        described["inner"] = {"type": "path", "max_depth": 3}
    loaded = scene(ROOM, sensor(16, 8), nested=described)
    found = planes(loaded, spp=2)
    assert found["depth.Z"] == pytest.approx(expected_depth(16, 8), rel=2e-6)
    assert loaded.integrator().aov_names()[-1] == "virtual_forward.v"


def test_stock_planes_pass_through_beside_ours(variant):
    nested = {"type": "aov", "aovs": "stock:depth,pp:position", "img": {"type": "path", "max_depth": 2}}
    loaded = scene(ROOM, sensor(32, 16, near_clip=0.5), nested=nested, aovs="depth")
    found = planes(loaded, spp=1)
    assert found["depth.Z"] == pytest.approx(expected_depth(32, 16), rel=2e-6)
    assert {"img.R", "stock.T", "pp.X"} <= set(found)
    # What is wrong with the stock one: it begins at the near plane.
    assert found["stock.T"].mean() == pytest.approx((found["depth.Z"] - 0.5).mean(), rel=0.02)


def test_gradients_of_colour(llvm):
    for nested in ({"type": "prb", "max_depth": 3}, {"type": "path", "max_depth": 3}, {"type": "direct"}):
        loaded = scene(ROOM, sensor(16, 8), nested=nested)
        stock = mi.load_dict({"type": "scene", "sensor": sensor(16, 8), "integrator": nested, **ROOM})
        gradients = []
        for each in (loaded, stock):
            params = mi.traverse(each)
            key = "room.bsdf.reflectance.value"
            dr.enable_grad(params[key])
            params.update()
            image = mi.render(each, params, spp=16, seed=2, seed_grad=7)
            dr.backward(dr.mean(image[..., :3]))
            gradients.append(np.array(dr.grad(params[key])).ravel())
        assert gradients[0] == pytest.approx(gradients[1], rel=1e-4) and np.abs(gradients[1]).min() > 0


def test_forward_gradients_have_all_channels(llvm):
    loaded = scene(ROOM, sensor(16, 8), nested={"type": "prb", "max_depth": 3}, aovs="depth")
    params = mi.traverse(loaded)
    key = "room.bsdf.reflectance.value"
    dr.enable_grad(params[key])
    dr.set_grad(params[key], 1.0)
    params.update()
    image = mi.render(loaded, params, spp=16)
    dr.forward_to(image)
    grad = np.array(dr.grad(image))
    assert grad.shape == (8, 16, 4) and grad[..., :3].mean() > 0 and np.abs(grad[..., 3]).max() == 0


def test_no_frame_after_the_first_compiles_a_kernel(llvm):
    """New poses of camera and shapes are data, not code."""
    nested = {"type": "path", "max_depth": 3}
    loaded = scene(ROOM, sensor(32, 16), nested=nested)
    params = mi.traverse(loaded)

    def frame(i):
        for name, place in (("previous", i - 1), ("next", i + 1)):
            params[f"sensor.to_world_{name}"] = pose((0.01 * place, 0.1, 0))
            step = np.eye(4)[:3]
            step[0, 3] = 0.02 * place
            params[f"integrator.moved_{name}"] = [*step.ravel(), *np.eye(4)[:3].ravel()]
        params["sensor.to_world"] = pose((0.01 * i, 0.1, 0))
        params["integrator.object_id"] = [i + 3, i + 4]
        params.update()
        return planes(loaded, spp=2, seed=i)

    frame(1)
    frame(2)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        seen = [frame(i) for i in range(3, 6)]
        kernels = [entry for entry in dr.kernel_history() if entry["type"] == dr.KernelType.JIT]
    assert len(kernels) >= 6 and all(kernel["cache_hit"] for kernel in kernels)
    assert [found["object_id"].min() for found in seen] == [6, 7, 8]
    assert seen[0]["forward.u"].std() > 0


def test_spectral_films(any_variant):
    if "spectral" not in any_variant:
        # Mitsuba itself says so, before our integrator is asked.
        with pytest.raises(Exception, match="spectral simulation"):
            mi.load_dict({"type": "specfilm", "width": 4, "height": 4})
        return
    bands = {"band1": {"type": "spectrum", "value": [(400, 0.0), (500, 1.0), (600, 0.0)]},
             "band2": {"type": "spectrum", "value": [(500, 0.0), (600, 1.0), (700, 0.0)]}}
    spectral = {"type": "specfilm", "width": 32, "height": 16, "component_format": "float32", "rfilter": {"type": "gaussian"}}
    camera = {**sensor(), "film": {**spectral, **bands}}
    found = planes(scene(ROOM, camera, aovs="depth,ids"), spp=4)
    assert found["colour"].shape[2] == 2 and np.isfinite(found["colour"]).all()
    assert found["depth.Z"] == pytest.approx(expected_depth(32, 16), rel=2e-6)
    assert set(np.unique(found["object_id"])) == {1.0, 2.0}


def test_a_film_of_halves_is_warned_of(variant, capfd):
    mi.set_log_level(mi.LogLevel.Warn)
    camera = {**sensor(8, 4), "film": {"type": "hdrfilm", "width": 8, "height": 4}}
    planes(scene(ROOM, camera, aovs="depth"))
    captured = capfd.readouterr()
    assert "component_format is float16" in captured.out + captured.err
