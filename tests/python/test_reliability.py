"""The reliability map: what it says and how often that is so, on views that it was not fitted to and that render without noise."""

import equistream as es
import numpy as np
import pytest

EYE_SIZE = (240, 135)
SEAM_SIZES = ("256x128", "384x192", "768x384")


@pytest.fixture(scope="module")
def poles(root, run):
    """Spheres of a glowing room looked at straight up and down, and what both eyes should see. The map was not fitted to this room's view."""
    out = root / "reliability"
    run("scene", "generate", "poles", "--knob", 60, "--out", out)
    scene = out / "poles.json"
    glow = ("--frames", "0-1", "--max-bounces", 0, "--aovs", "depth", "--spp", 16)
    run("render", scene, *glow, "--size", "256x128", "--out", out / "sphere")
    run("render", scene, *glow, "--camera", "perspective", "--eye", "both", "--size", "{}x{}".format(*EYE_SIZE), "--out", out / "eyes")
    return out


@pytest.fixture(scope="module")
def seam(root, run):
    """The same for a room looked at on the level, as spheres of three densities: from a third of the eyes' to that of them."""
    out = root / "reliability-seam"
    run("scene", "generate", "seam", "--out", out)
    scene = out / "seam.json"
    glow = ("--frames", "0", "--max-bounces", 0, "--aovs", "depth", "--spp", 16)
    for size in SEAM_SIZES:
        run("render", scene, *glow, "--size", size, "--out", out / size)
    run("render", scene, *glow, "--camera", "perspective", "--eye", "both", "--size", "{}x{}".format(*EYE_SIZE), "--out", out / "eyes")
    return out


def eyes(poles):
    for index in (0, 1):
        source = es.read_frame(poles / f"sphere/centre/frame.{index:04d}.exr")
        for eye in ("left", "right"):
            yield source, es.read_frame(poles / f"eyes/{eye}/frame.{index:04d}.exr")


def picture_of(source, truth, method="eye-depth", fill="pushpull", **options):
    depths = {frame.info.camera_pose.position_m.tobytes(): frame["depth"] for frame in (source, truth)}
    return es.Reprojector(method, fill=fill)(source, truth.info.camera, truth.info.camera_pose,
                                             depth=lambda camera, pose: depths[pose.position_m.tobytes()], **options)


def good_pixels(picture, truth):
    difference = np.abs(picture.rgb.astype(int) - es.to_display(truth["colour"], truth.info.exposure))
    return difference.max(axis=2) <= es.RELIABILITY_TOLERANCE


def calibration_error(predicted, good):
    """Over ten bins of equal width: mean prediction against measured share, weighted by pixels."""
    entry = np.minimum(predicted * 10, 9).astype(int)
    return sum(abs(predicted[entry == i].mean() - good[entry == i].mean()) * (entry == i).mean() for i in range(10) if (entry == i).any())


def judged(views, method, fill):
    """Of all pixels of some views: what was predicted, and whether they are good."""
    predicted, good = [], []
    for source, truth in views:
        picture = picture_of(source, truth, method, fill, reliability=True)
        predicted.append(picture.reliability.ravel() / 255)
        good.append(good_pixels(picture, truth).ravel())
    predicted, good = np.concatenate(predicted), np.concatenate(good)
    assert 0.02 < 1 - good.mean() < 0.98, "a scene without good or without bad pixels judges nothing"
    return predicted, good


@pytest.mark.parametrize("method, fill", [("eye-depth", "pushpull"), ("splat", "spread")])
def test_it_promises_what_is_measured(seam, method, fill):
    """Within five points on a scene that it was not fitted to; a map some points off would be outside."""
    eyes = [es.read_frame(seam / f"eyes/{eye}/frame.0000.exr") for eye in ("left", "right")]
    sources = [es.read_frame(seam / size / "centre/frame.0000.exr") for size in SEAM_SIZES]
    predicted, good = judged([(source, truth) for source in sources for truth in eyes], method, fill)
    error = calibration_error(predicted, good)
    print(f"good {good.mean():.4f}, predicted {predicted.mean():.4f}, expected calibration error {error:.4f}")
    assert error <= 0.05
    assert calibration_error(np.clip(predicted - 0.08, 0, 1), good) > 0.05
    assert calibration_error(np.clip(predicted + 0.12, 0, 1), good) > 0.05


def test_towards_the_poles_it_does_not_promise_more_than_is_measured(poles):
    """It promises less there: a sphere's columns draw together, which the model knows only by the mean of rows and columns."""
    predicted, good = judged(eyes(poles), "eye-depth", "pushpull")
    entry = np.minimum(predicted * 10, 9).astype(int)
    beyond = sum(max(0, predicted[entry == i].mean() - good[entry == i].mean()) * (entry == i).mean() for i in range(10) if (entry == i).any())
    error = calibration_error(predicted, good)
    print(f"promised beyond what is measured {beyond:.4f}, expected calibration error {error:.4f}")
    assert beyond <= 0.05
    assert error <= 0.1
    # It tells pixels apart: those it trusts least are bad far more often than those it trusts most.
    order = np.argsort(predicted)
    tenth = len(order) // 10
    assert good[order[-tenth:]].mean() > good[order[:tenth]].mean() + 0.3


def test_the_source_itself_is_certain_and_a_gap_is_not(poles):
    source, truth = next(eyes(poles))
    same = es.Reprojector("rotation", fill="none")(truth, truth.info.camera, truth.info.camera_pose, reliability=True)
    assert (same.reliability == 255).all()
    gaps = 0
    for source, truth in eyes(poles):
        picture = picture_of(source, truth, fill="none", reliability=True)
        assert (picture.reliability[picture.gaps] == 0).all()
        gaps += int(picture.gaps.sum())
    assert gaps > 0


def test_only_what_is_asked_for(poles):
    source, truth = next(eyes(poles))
    plain = picture_of(source, truth)
    assert plain.reliability is None and plain.risks is None
    asked = picture_of(source, truth, risks=True, depth_tolerance_w=0.001)
    assert asked.risks.shape == (EYE_SIZE[1], EYE_SIZE[0], len(es.RISKS)) and asked.risks.dtype == np.float32
    assert asked.risk_groups.shape == asked.risks.shape[:2] and (asked.risk_groups[asked.origin > 0] < len(es.RISK_GROUPS)).all()
    assert (asked.risks >= 0).all() and asked.risks[:, :, es.RISKS.index("depth_error")].any()
    assert (asked.rgba == plain.rgba).all()
