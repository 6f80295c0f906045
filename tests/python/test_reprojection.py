"""What Python reprojects is what `equistream play` writes, bit for bit; depth of any origin; hostile arguments."""

import subprocess
import sys

import equistream as es
import numpy as np
import pytest
from PIL import Image

from conftest import refusals_of_four_threads

CAMERA = es.PerspectiveCamera(96, 64, np.radians(80))


@pytest.fixture(scope="module")
def eyes(root, run):
    """A sphere at the left eye, and both eyes' perspective renders beside it: their depth makes `--depth exact` whole."""
    run("scene", "generate", "pavilion", "--out", root / "pavilion")
    scene = root / "pavilion" / "pavilion.json"
    out = root / "eyes"
    run("render", scene, "--frames", "0-1", "--size", "512x256", "--spp", 2, "--aovs", "depth", "--eye", "centre", "--ipd", 0.5, "--out", out)
    views = root / "views"
    run("render", scene, "--frames", "0-1", "--size", "96x64", "--camera", "perspective", "--fov", 80, "--spp", 2, "--aovs", "depth",
        "--eye", "both", "--ipd", 0.5, "--out", views)
    for eye in ("left", "right"):
        (out / eye).symlink_to(views / eye)
    return out


def eye_poses(info):
    return {eye: es.eye_pose(CAMERA, info.head, eye, info.ipd_m) for eye in ("left", "right")}


def picture(file):
    return np.asarray(Image.open(file))


def test_equals_play_with_exact_depth(eyes, run, tmp_path):
    run("play", eyes, "--depth", "exact", "--size", "96x64", "--fov", 80, "--out", tmp_path)
    reproject = es.Reprojector("eye-depth")
    filled, by_earlier, earlier = 0, 0, []
    for frame in es.open_feed(eyes, depth=True):
        for eye, pose in eye_poses(frame.main.info).items():
            view = reproject(frame, CAMERA, pose, earlier=earlier)
            by_earlier += view.filled["earlier"]
            name = f"frame.{frame.main.info.index:04}.png"
            np.testing.assert_array_equal(view.rgb, picture(tmp_path / eye / name))
            np.testing.assert_array_equal(view.gaps, picture(tmp_path / "gaps" / eye / name) > 0)
            assert view.depth_m.shape == (64, 96) and sum(view.filled.values()) == view.gaps.sum() and not (view.origin == 0).any()
            filled += view.gaps.sum()
        earlier = [frame.main]
    assert filled > by_earlier > 0


def test_each_eye_of_packed_video_has_its_own_picture(eyes, run, tmp_path):
    """As `play` takes them: of posed frames the nearer one."""
    scene = eyes.parent / "pavilion" / "pavilion.json"
    run("render", scene, "--frames", "0-1", "--size", "256x128", "--spp", 2, "--eye", "both", "--ipd", 0.5, "--out", tmp_path / "both")
    packed = tmp_path / "packed.mp4"
    run("encode", tmp_path / "both", "--stereo", "top-bottom", "--out", packed)
    run("play", packed, "--method", "rotation", "--size", "96x64", "--fov", 80, "--out", tmp_path / "played")
    for frame in es.open_feed(packed):
        views = {}
        for eye, pose in eye_poses(frame.main.info).items():
            views[eye] = es.reproject(frame, CAMERA, pose, method="rotation").rgb
            np.testing.assert_array_equal(views[eye], picture(tmp_path / "played" / eye / f"frame.{frame.main.info.index:04}.png"))
            own = es.reproject(frame.main if eye == "left" else frame.right, CAMERA, pose, method="rotation").rgb
            np.testing.assert_array_equal(views[eye], own)
        assert np.abs(views["left"].astype(int) - views["right"]).mean() > 1


def test_rungs_know_the_error_budget(eyes):
    """An earlier frame whose depth is far off fills little within a fourth of a pixel and much within eight."""
    first, second = es.open_feed(eyes, depth=True)
    pose = eye_poses(second.main.info)["right"]
    off = es.FeedPicture(first.main.info, first.main.rgb, first.main.depth_m * 1.3)
    filled = {}
    for budget_px in (0.25, 8):
        view = es.Reprojector("eye-depth", fill="earlier", error_budget_px=budget_px)(second, CAMERA, pose, earlier=[off])
        filled[budget_px] = view.filled["earlier"] / view.gaps.sum()
    assert filled[0.25] < 0.1 and filled[8] > 0.5


@pytest.mark.parametrize("yuv", [False, True])
def test_equals_play_of_a_stream(stream, run, tmp_path, yuv):
    run("play", stream, "--size", "96x64", "--fov", 80, "--out", tmp_path)
    for frame in es.open_feed(stream, yuv=yuv):
        assert (frame.main.rgb is None) == yuv and (frame.main.yuv is None) != yuv
        for eye, pose in eye_poses(frame.main.info).items():
            view = es.reproject(frame, CAMERA, pose)
            np.testing.assert_array_equal(view.rgb, picture(tmp_path / eye / f"frame.{frame.main.info.index:04}.png"))


def test_depth_by_a_function_is_the_same(eyes):
    frame = next(es.open_feed(eyes, depth=True))
    planes = [frame.main, *frame.depth_views]
    asked = []

    def depth(camera, pose):
        asked.append((camera, pose))
        return next(p.depth_m for p in planes if p.info.camera == camera and p.info.camera_pose == pose)
    pose = eye_poses(frame.main.info)["left"]
    by_function, by_planes = (es.reproject(frame, CAMERA, pose, depth=d) for d in (depth, None))
    np.testing.assert_array_equal(by_function.rgb, by_planes.rgb)
    assert len(asked) == 2


def test_depth_views_are_rows_by_columns_by_one_or_not(stream):
    """A base without depth of its own takes it from a view rendered beside it."""
    main, base = (next(es.open_feed(stream)).main for _ in range(2))
    main.depth_m = np.full((256, 512, 1), 2.0, np.float32)
    main.info.camera = es.EquirectCamera(512, 256, longitudes=(-0.5, 0.5), latitudes=(-0.3, 0.3))
    shift = main.info.camera_pose.position_m + [0.05, 0, 0]
    pose, base.info.camera_pose = es.Pose(shift), es.Pose(main.info.camera_pose.position_m + [0, 0.02, 0])
    seen = []
    for shape in ((256, 512, 1), (256, 512)):
        view = es.FeedPicture(base.info, base.rgb, np.full(shape, 2.0, np.float32))
        frame = es.FeedFrame(main, base=base, depth_views=[view])
        seen.append(es.Reprojector("mesh", fill="base,pushpull")(frame, CAMERA, pose))
    assert seen[0].filled["base"] > 0
    np.testing.assert_array_equal(seen[0].rgb, seen[1].rgb)


def test_planes_are_the_decoders_own_and_outlive_the_feed(stream):
    luma, cb, cr = next(es.open_feed(stream, yuv=True)).main.yuv
    assert luma.shape == (256, 512) and cb.shape == cr.shape == (128, 256) and not luma.flags.writeable
    rgb = next(es.open_feed(stream)).main.rgb.astype(float)
    # A mean colour is the same in both: chroma is a mean itself.
    y = 16 + 219 / 255 * (rgb @ [0.2126, 0.7152, 0.0722])
    assert abs(luma.mean() - y.mean()) < 0.5


def test_layers_and_patches_may_be_planes(stream):
    """A second layer from planes fills what its RGB fills, with the same colours."""
    pictures = [next(es.open_feed(stream, yuv=yuv)).main for yuv in (False, True)]
    depth = np.full((256, 512), 2.0, np.float32)
    filled = []
    for picture in pictures:
        picture.depth_m = depth
        hidden = es.FeedPicture(picture.info, picture.rgb, depth + 1, yuv=picture.yuv)
        pose = es.Pose(picture.info.camera_pose.position_m + [0.05, 0, 0], picture.info.camera_pose.orientation)
        eye_depth = np.full((64, 96), 3.0, np.float32)  # behind what the source saw: all of it is a gap
        filled.append(es.Reprojector("eye-depth", fill=" hidden, pushpull")(es.FeedFrame(picture, hidden=hidden), CAMERA, pose,
                                                               depth=lambda c, p: eye_depth if c == CAMERA else depth))
    assert filled[0].filled["hidden"] > 0
    np.testing.assert_array_equal(filled[0].rgba, filled[1].rgba)


def test_a_frame_is_a_source_too(eyes):
    frame = es.read_frame(eyes / "centre" / "frame.0000.exr")
    view = es.reproject(frame, CAMERA, frame.info.head)  # from the sphere's own centre: no depth of the eye is needed
    feed = next(es.open_feed(eyes))
    np.testing.assert_array_equal(view.rgb, es.reproject(feed, CAMERA, frame.info.head).rgb)
    needs = es.Reprojector().needs_depth(frame.info.camera_pose, frame.info.head)
    assert not needs and not needs.source and not needs.eye


def test_an_argument_that_is_gone_says_so():
    with pytest.warns(DeprecationWarning, match="the argument reference has no effect"):
        es.Reprojector(reference=True)


def test_methods_that_find_the_eyes_depth(eyes):
    """They ask for the source's depth alone, show what `eye-depth` shows by the eye's true depth, and tell what they found."""
    frame = next(es.open_feed(eyes, depth=True))
    source = es.FeedPicture(frame.main.info, frame.main.rgb, frame.main.depth_m)  # nobody has the eye's
    pose = eye_poses(frame.main.info)["right"]
    true = es.Reprojector("eye-depth", fill="none")(frame, CAMERA, pose)
    for method in ("splat", "mesh"):
        reproject = es.Reprojector(method, fill="none")
        needs = reproject.needs_depth(source.info.camera_pose, pose)
        assert needs.source and not needs.eye
        view = reproject(source, CAMERA, pose)
        np.testing.assert_array_equal(np.isnan(view.depth_m), view.gaps)
        both = ~view.gaps & ~true.gaps
        assert both.mean() > 0.8
        with np.errstate(divide="ignore"):
            difference = np.abs(1 / view.depth_m[both] - 1 / true.depth_m[both])
        assert (difference * 0.25 > 2 / 57).mean() < 0.03  # two pixels, at the edges of things
    assert set(es.METHODS) >= {"rotation", "proxy-sphere", "eye-depth", "splat", "mesh"}
    leaning = es.Reprojector("proxy-sphere", fill="none")(es.FeedPicture(frame.main.info, frame.main.rgb), CAMERA, pose)
    assert not leaning.gaps.any() and leaning.depth_m is None
    turned = es.Reprojector("rotation", fill="none")(frame, CAMERA, pose)
    assert (leaning.rgb != turned.rgb).any()


def test_arrays_outlive_everything(eyes):
    views = [es.reproject(f, CAMERA, f.main.info.head) for f in es.open_feed(eyes)]
    copies = [v.rgb.copy() for v in views]
    for _ in range(3):
        list(es.open_feed(eyes, depth=True))
    for view, before in zip(views, copies):
        np.testing.assert_array_equal(view.rgb, before)


def test_bad_arguments_are_told_in_one_line(eyes):
    frame = next(es.open_feed(eyes, depth=True))
    pose = eye_poses(frame.main.info)["left"]
    beside = es.Pose(np.array([0.2, 0, 0]) + frame.main.info.head.position_m)
    for call in (lambda: es.Reprojector("magic"), lambda: es.Reprojector(fill="glue"), lambda: es.Reprojector(error_budget_px=0),
                 lambda: es.reproject(frame, es.EquirectCamera(4, 2), pose), lambda: es.reproject("frame", CAMERA, pose),
                 lambda: es.reproject(frame, CAMERA, beside),
                 lambda: es.reproject(frame, CAMERA, pose, depth=lambda c, p: np.zeros((3, 3), np.float32)),
                 lambda: es.reproject(frame, CAMERA, pose, depth=lambda c, p: np.full((c.height, c.width), np.nan, np.float32)),
                 lambda: es.reproject(frame, CAMERA, pose, depth=lambda c, p: np.zeros((c.height, c.width), int)),
                 lambda: es.reproject(es.Frame(frame.main.info), CAMERA, pose),
                 lambda: es.reproject(es.FeedPicture(frame.main.info, frame.main.rgb[:, :100]), CAMERA, pose),
                 lambda: es.reproject(es.FeedPicture(frame.main.info, frame.main.rgb.astype(float)), CAMERA, pose)):
        with pytest.raises(es.InputError) as caught:
            call()
        assert "expected" in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(ZeroDivisionError):
        es.reproject(frame, CAMERA, pose, depth=lambda c, p: 1 / 0)


def test_nothing_heavy_comes_along(eyes):
    """In a process of its own: other tests' Mitsuba has an Embree and a pugixml."""
    code = f"""
import equistream as es
frame = next(es.open_feed({str(eyes)!r}, depth=True))
es.reproject(frame, es.PerspectiveCamera(32, 32), frame.main.info.head)
maps = open('/proc/self/maps').read()
print('_core' in maps, [name for name in ('embree', 'OpenImageIO', 'pugixml', 'tinygltf') if name in maps])"""
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.strip() == "True []"


def test_a_second_thread_is_refused(eyes):
    """It works without Python's lock: two threads in one engine would write one picture."""
    frame = next(es.open_feed(eyes, depth=True))
    wide = es.PerspectiveCamera(4096, 4096)
    reproject = es.Reprojector("rotation", fill="none")
    problems = refusals_of_four_threads(lambda: reproject(frame, wide, frame.main.info.camera_pose))
    assert problems == ["Reprojector: expected one thread at a time, found a second one"] * len(problems) and problems
    assert reproject(frame, wide, frame.main.info.camera_pose).rgb.mean() > 0
