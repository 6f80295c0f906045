"""Mirrors and glass, and patches whose depth was not sent: what Python shows is what `equistream play` writes, bit for bit."""

import json

import equistream as es
import numpy as np
import pytest
from PIL import Image

CAMERA = es.PerspectiveCamera(96, 64, np.radians(80))
VIEW = ("--size", "96x64", "--fov", 80)


@pytest.fixture(scope="module")
def pavilion(root, run):
    """Its pond, mirrors and panes from a sphere with all that fills gaps, and both eyes' own views, whose depth makes `--depth exact` whole."""
    out = root / "mirrors"
    run("scene", "generate", "pavilion", "--out", out)
    settings = ("--frames", "40-41", "--spp", 2, "--ipd", 0.2)
    run("render", out / "pavilion.json", *settings, "--size", "256x128", "--aovs", "depth,specular,virtual", "--layers", "--patches",
        "--patch-budget", 20, "--out", out / "frames")
    run("render", out / "pavilion.json", *settings, "--camera", "perspective", *VIEW, "--aovs", "depth", "--eye", "both", "--out", out / "views")
    for eye in ("left", "right"):
        (out / "frames" / eye).symlink_to(out / "views" / eye)
    return out


@pytest.fixture(scope="module")
def frames(pavilion):
    return pavilion / "frames"


class Planes:
    """A depth function that knows what was rendered, patches too: a ray caster without its rounding."""

    def __init__(self, frame):
        self.frame = frame

    def __call__(self, camera, pose):
        return next(p.depth_m for p in (self.frame.main, *self.frame.depth_views) if p.info.camera == camera and p.info.camera_pose == pose)

    def cast_patches(self, info):
        assert (info.patches.width, info.patches.height) == self.frame.patches.depth_m.shape[::-1]
        return np.where(np.isnan(self.frame.patches.depth_m), np.inf, self.frame.patches.depth_m)


def eye_poses(info):
    return {eye: es.eye_pose(CAMERA, info.head, eye, info.ipd_m) for eye in ("left", "right")}


def played(folder, eye, info, kind=""):
    return np.asarray(Image.open(folder / kind / eye / f"frame.{info.index:04}.png"))


def views(reproject, feed, depth_of=lambda frame: None, **options):
    """(eye, what it sees, info) of a feed, each frame with the one before it, as play keeps them."""
    earlier = []
    for frame in feed:
        depth = depth_of(frame)
        for eye, pose in eye_poses(frame.main.info).items():
            yield eye, reproject(frame, CAMERA, pose, depth=depth, earlier=earlier, **options), frame.main.info
        earlier = [frame.main]


def counted(report, eye):
    found = json.loads((report / "report.json").read_text())["eyes"][eye]["specular"]
    return {"kept": found["kept"], "by_image": found["by_virtual_depth"], "displaced": found["displaced"], "gaps": found["gaps"]}


def test_a_folder_with_mirrors_equals_play(frames, run, tmp_path):
    run("play", frames, "--depth", "exact", *VIEW, "--reliability", "--out", tmp_path)
    sums = {eye: dict.fromkeys(("kept", "by_image", "displaced", "gaps"), 0) for eye in ("left", "right")}
    filled = dict.fromkeys(es.FILL_PASSES, 0)
    for eye, view, info in views(es.Reprojector(), es.open_feed(frames, depth=True), reliability=True):
        np.testing.assert_array_equal(view.rgb, played(tmp_path, eye, info))
        np.testing.assert_array_equal(view.gaps, played(tmp_path, eye, info, "gaps") > 0)
        np.testing.assert_array_equal(view.reliability, played(tmp_path, eye, info, "reliability"))
        for sum_of, counts in ((sums[eye], view.mirrors), (filled, view.filled)):
            for name, count in counts.items():
                sum_of[name] += count
    assert sums == {eye: counted(tmp_path, eye) for eye in sums}
    assert all(sums[eye][what] > 10 for eye in sums for what in ("kept", "by_image", "gaps"))
    assert all(filled[each] > 10 for each in ("patches", "hidden", "earlier", "pushpull"))


@pytest.mark.parametrize("yuv", [False, True])
def test_a_stream_with_mirrors_equals_play(frames, pavilion, run, tmp_path, yuv):
    stream = pavilion / "lossless.mkv"
    if not stream.exists():
        run("encode", frames, "--depth", "lossless", "--mirrors", "always", "--out", stream)
    run("play", stream, "--method", "splat", "--depth", "stream", *VIEW, "--out", tmp_path)
    reworked = 0
    for eye, view, info in views(es.Reprojector("splat"), es.open_feed(stream, depth=True, yuv=yuv)):
        np.testing.assert_array_equal(view.rgb, played(tmp_path, eye, info))
        np.testing.assert_array_equal(view.gaps, played(tmp_path, eye, info, "gaps") > 0)
        reworked += view.mirrors["by_image"]
    assert reworked > 100


def test_an_atlas_is_written_as_it_was_read(frames, tmp_path):
    atlas = es.read_frame(frames / "patches/frame.0040.exr")
    es.write_frame(tmp_path / "atlas.exr", atlas)
    again = es.read_frame(tmp_path / "atlas.exr")
    assert again.info.patches.width == again.planes["colour"].shape[1] != again.info.camera.width
    for name, plane in atlas.planes.items():
        np.testing.assert_array_equal(again.planes[name], plane)


def test_mirrors_may_stay_as_the_engine_left_them(frames):
    frame = next(es.open_feed(frames, depth=True))
    pose = eye_poses(frame.main.info)["left"]
    anew, opened, left = (es.Reprojector(fill="none", mirrors=m)(frame, CAMERA, pose) for m in es.MIRRORS)
    assert not any(left.mirrors.values()) and left.gaps.sum() + anew.mirrors["gaps"] == anew.gaps.sum()
    changed = (anew.rgba != left.rgba).any(axis=2)
    assert 0 < changed.sum() <= anew.mirrors["by_image"] + anew.mirrors["gaps"]
    assert opened.mirrors["by_image"] == opened.mirrors["displaced"] == 0 and opened.mirrors["kept"] == anew.mirrors["kept"]
    assert opened.mirrors["gaps"] == sum(anew.mirrors.values()) - anew.mirrors["kept"] == opened.gaps.sum() - left.gaps.sum()
    assert (opened.rgba[~opened.gaps] == left.rgba[~opened.gaps]).all()
    with pytest.raises(es.InputError, match="^--mirrors: expected images, gaps or surface, found 'always'$"):
        es.Reprojector(mirrors="always")
    # Without the mask nobody knows of mirrors; without virtual depth they can only be kept or become gaps.
    plain = es.FeedPicture(frame.main.info, frame.main.rgb, frame.main.depth_m)
    depth = Planes(frame)
    assert (es.Reprojector(fill="none")(plain, CAMERA, pose, depth=depth).rgba == left.rgba).all()
    masked = es.FeedPicture(frame.main.info, frame.main.rgb, frame.main.depth_m, frame.main.specular)
    by_mask, all_opened = (es.Reprojector(fill="none", mirrors=m)(masked, CAMERA, pose, depth=depth).mirrors for m in ("images", "gaps"))
    assert by_mask["by_image"] == 0 and by_mask["gaps"] > anew.mirrors["gaps"]
    assert all_opened["gaps"] == sum(by_mask.values()) == sum(all_opened.values())


def test_a_frame_brings_its_mirrors_too(frames):
    frame, feed = es.read_frame(frames / "centre" / "frame.0040.exr"), next(es.open_feed(frames, depth=True))
    pose = eye_poses(frame.info)["right"]
    by_frame, by_feed = (es.Reprojector(fill="pushpull")(source, CAMERA, pose, depth=Planes(feed)) for source in (frame, feed.main))
    np.testing.assert_array_equal(by_frame.rgba, by_feed.rgba)
    assert by_frame.mirrors == by_feed.mirrors and by_frame.mirrors["by_image"] > 0


def test_a_frame_brings_the_base_around_its_window(pavilion, run, tmp_path):
    """The head looks away from the window's middle: what it sees beyond is the base's."""
    run("render", pavilion / "pavilion.json", "--frames", "40", "--spp", 2, "--size", "128x64", "--window", "0,0,80x60", "--density", 512, "--aovs", "depth", "--out", tmp_path / "frames")
    run("play", tmp_path / "frames", "--depth", "exact", "--method", "mesh", *VIEW, "--out", tmp_path / "played")
    frame = next(es.open_feed(tmp_path / "frames", depth=True))
    assert frame.base is not None and frame.base.info.camera == es.EquirectCamera(128, 64) and frame.main.info.camera.width < 512
    for eye, pose in eye_poses(frame.main.info).items():
        view = es.Reprojector("mesh")(frame, CAMERA, pose)
        assert view.filled["base"] > 100 and (view.origin == es.reprojection.ORIGINS.index("base")).sum() == view.filled["base"]
        np.testing.assert_array_equal(view.rgb, played(tmp_path / "played", eye, frame.main.info))


def without_depth_of_patches(frame):
    """As a stream brings it; returns what knows that depth."""
    frame.patches = es.FeedPicture(frame.patches.info, frame.patches.rgb)
    return frame


def test_patches_are_cast_where_the_scene_is_known(frames, run, tmp_path):
    """What a depth function casts of patches fills what the renderer's own depth of them fills; a plain one leaves them out."""
    run("play", frames, "--depth", "exact", *VIEW, "--out", tmp_path / "all")
    run("play", frames, "--depth", "exact", *VIEW, "--fill", "hidden,earlier,pushpull", "--out", tmp_path / "without")
    knowing = {frame.main.info.index: Planes(frame) for frame in es.open_feed(frames, depth=True)}
    for folder, kind in (("all", lambda planes: planes), ("without", lambda planes: planes.__call__)):
        by_patches = 0
        feed = map(without_depth_of_patches, es.open_feed(frames, depth=True))
        for eye, view, info in views(es.Reprojector(), feed, lambda frame: kind(knowing[frame.main.info.index])):
            np.testing.assert_array_equal(view.rgb, played(tmp_path / folder, eye, info))
            by_patches += view.filled["patches"]
        assert (by_patches > 10) == (folder == "all")


def test_a_stream_whose_patches_play_casts(frames, pavilion, run, tmp_path):
    """play's rays and the renderer's differ by rounding: pixels on an edge may fall either way."""
    stream = pavilion / "for-those-with-the-scene.mkv"
    run("encode", frames, "--mirrors", "always", "--out", stream)
    run("play", stream, "--scene", pavilion / "pavilion.json", *VIEW, "--out", tmp_path)
    knowing = {frame.main.info.index: Planes(frame) for frame in es.open_feed(frames, depth=True)}

    def received():
        for frame in es.open_feed(stream, depth=True, yuv=True):
            assert frame.patches is not None and frame.patches.depth_m is None and frame.main.depth_m is None
            yield frame
            frame.main.depth_m = knowing[frame.main.info.index].frame.main.depth_m  # of a frame before

    by_patches = 0
    for eye, view, info in views(es.Reprojector(), received(), lambda frame: knowing[frame.main.info.index]):
        assert (view.rgb != played(tmp_path, eye, info)).any(axis=2).mean() < 2e-3
        by_patches += view.filled["patches"]
    assert by_patches > 10


def ball(origins, directions):
    """Closed form: the first of two balls along rays."""
    nearest = np.full(directions.shape[:-1], np.inf)
    for centre, radius in (((0, 1.5, 0), 1.0), ((-3, 1, 2), 1.5)):
        to_centre = np.asarray(centre) - origins
        along = np.sum(directions * to_centre, axis=-1)
        square = along**2 - np.sum(to_centre**2, axis=-1) + radius**2
        distance = along - np.sqrt(np.maximum(square, 0))
        nearest = np.where((square > 0) & (distance > 0), np.minimum(nearest, distance), nearest)
    return nearest.astype(np.float32)


def test_spheres_and_rays_of_patches_say_the_same(frames):
    """Patches of a SceneDepth, taken from whole spheres, against the closed form along the very rays."""
    asked = []

    def depth(camera, pose):
        asked.append((camera, pose))
        return ball(pose.position_m, pose.to_world(camera.directions()))

    for frame in es.open_feed(frames, depth=True):
        info = frame.patches.info
        rays = es.patch_rays(info)
        assert rays.used.any() and rays.directions.shape == (info.patches.height, info.patches.width, 3)
        cast = es.SceneDepth(depth).cast_patches(info)
        assert cast.dtype == np.float32 and np.isinf(cast[~rays.used]).all() and np.isfinite(cast[rays.used]).any()
        np.testing.assert_allclose(cast[rays.used], ball(rays.origins_m, rays.directions)[rays.used], rtol=1e-5)
    assert 0 < len(asked) <= 2 * len(info.patches.offsets_m) and {camera for camera, _ in asked} == {info.patches.sphere} == {frame.main.info.camera}


def test_samples_of_patches_are_whole_blocks_of_spheres(frames):
    """Each slot shows a block of one sphere, or nothing in all of its pixels."""
    atlas = next(es.open_feed(frames, depth=True)).patches.info.patches
    side = atlas.block_side
    slots = atlas.samples().reshape(atlas.height // side, side, atlas.width // side, side, 3)
    slots = slots.swapaxes(1, 2).reshape(-1, side, side, 3)
    first = slots[:, 0, 0]
    row, column = np.indices((side, side))
    used = first[:, 0] >= 0
    within = np.stack([np.zeros_like(row), column, row], axis=-1)
    np.testing.assert_array_equal(slots[used], (first[:, None, None] + within)[used])
    assert (slots[~used, :, :, 0] == -1).all() and (first[used, 1:] % side == 0).all()
    assert set(first[used, 0]) == set(range(len(atlas.offsets_m)))


def test_rays_of_patches_are_the_renderers(frames):
    """Where they end lies on what the sphere sees, or behind it: hardly anywhere in the open (what is thinner than a pixel is there)."""
    frame = next(es.open_feed(frames, depth=True))
    info, main = frame.patches.info, frame.main
    rays = es.patch_rays(info)
    hits = rays.used & np.isfinite(frame.patches.depth_m)

    def judged(origins, directions):
        """How many end before, and how many on, what the sphere sees in their direction."""
        points = (origins + directions * frame.patches.depth_m[..., None])[hits] - main.info.camera_pose.position_m
        column, row = np.floor(main.info.camera.pixels(main.info.camera_pose.to_camera(points))).astype(int).T
        around = np.stack([main.depth_m[np.clip(row + j, 0, 127), (column + i) % 256] for j in (-1, 0, 1) for i in (-1, 0, 1)])
        distance = np.linalg.norm(points, axis=-1)
        return (distance < 0.98 * around.min(axis=0)).mean(), (np.abs(distance / around - 1).min(axis=0) < 0.01).mean()

    before, on = judged(rays.origins_m, rays.directions)
    before_if_turned, on_if_turned = judged(rays.origins_m, rays.directions[:, ::-1])
    print(f"before {before:.4f}, on {on:.4f}; turned: {before_if_turned:.4f}, {on_if_turned:.4f}")
    assert before < 0.05 and on > 0.3
    assert before_if_turned > 0.2 and on_if_turned < 0.15


def test_gaps_beyond_a_source_at_the_eye_itself(root, pavilion, run, tmp_path):
    """The left eye stands where its source does and sees past its border: filled by the depth that play casts for the right eye's sake."""
    out = root / "part"
    settings = (pavilion / "pavilion.json", "--frames", 40, "--spp", 2, "--ipd", 0.4, "--aovs", "depth")
    part = (*settings, "--range", "70,50", "--lock", "path")
    run("render", *part, "--size", "128x96", "--eye", "left", "--small", "right", "--out", out / "frames")
    run("render", *part, "--size", "32x24", "--eye", "right", "--out", out / "small")
    run("render", *settings, "--camera", "perspective", *VIEW, "--eye", "right", "--out", out / "views")
    known = [es.read_frame(out / view / "frame.0040.exr", "depth") for view in ("frames/left", "small/right", "views/right")]

    def depth(camera, pose):
        return next(frame["depth"] for frame in known if frame.info.camera == camera and frame.info.camera_pose == pose)

    filled = {}
    for each in ("small", "small-wide"):
        fill, target = f"{each},pushpull", tmp_path / each
        run("play", out / "frames", "--scene", pavilion / "pavilion.json", *VIEW, "--fill", fill, "--out", target)
        for eye, view, info in views(es.Reprojector(fill=fill), es.open_feed(out / "frames"), lambda frame: depth):
            assert (view.rgb != played(target, eye, info)).any(axis=2).mean() < 2e-3
            assert view.gaps.mean() > 0.1 and view.filled[each] > 10
            filled[each, eye] = view.filled[each]
    assert all(filled["small-wide", eye] <= filled["small", eye] for eye in ("left", "right"))


def test_bad_planes_and_casts_are_told_in_one_line(frames):
    frame = next(es.open_feed(frames, depth=True))
    pose = eye_poses(frame.main.info)["left"]
    good = Planes(frame)

    class Casts(Planes):
        def __init__(self, patches_depth):
            super().__init__(frame)
            self.cast_patches = lambda info: patches_depth

    main = frame.main
    bare = es.FeedFrame(main, patches=es.FeedPicture(frame.patches.info, frame.patches.rgb))
    height, width = frame.patches.depth_m.shape
    for call in (lambda: es.reproject(es.FeedPicture(main.info, main.rgb, main.depth_m, main.specular[:, 1:]), CAMERA, pose, depth=good),
                 lambda: es.reproject(es.FeedPicture(main.info, main.rgb, main.depth_m, main.specular, np.zeros((2, 2), np.float32)), CAMERA, pose, depth=good),
                 lambda: es.reproject(bare, CAMERA, pose, depth=Casts(np.ones((height, width + 1), np.float32))),
                 lambda: es.reproject(bare, CAMERA, pose, depth=Casts(np.full((height, width), np.nan, np.float32))),
                 lambda: es.patch_rays(main.info), lambda: es.SceneDepth(good).cast_patches(main.info),
                 lambda: es.SceneDepth(lambda c, p: np.zeros((2, 2), np.float32)).cast_patches(frame.patches.info)):
        with pytest.raises(es.InputError) as caught:
            call()
        assert "expected" in str(caught.value) and "\n" not in str(caught.value)


def test_reliability_knows_what_the_depth_code_may_be_off_by(frames, run, tmp_path):
    """Of a stream's own depth: what play writes, bit for bit, without a word about its code."""
    stream = tmp_path / "coarse.mkv"
    run("encode", frames, "--frames", 40, "--fill", "none", "--mirrors", "none", "--depth", "w8", "--depth-crf", 20, "--depth-scale", 1, "--out", stream)
    run("play", stream, "--method", "mesh", "--depth", "stream", *VIEW, "--fill", "pushpull", "--reliability", "--out", tmp_path / "eyes")
    mesh = es.Reprojector("mesh", fill="pushpull")
    for options, same in (({}, True), ({"depth_tolerance_w": 0.0}, False)):
        for eye, view, info in views(mesh, es.open_feed(stream, depth=True), reliability=True, **options):
            assert info.depth_tolerance_w > 1e-4
            expected = played(tmp_path / "eyes", eye, info, "reliability")
            assert (view.reliability == expected).all() == same, eye


def test_reliability_knows_how_coarsely_colours_were_coded(frames, run, tmp_path):
    """What the stream says of itself: play and the package trust it alike, and less than they would without its word."""
    stream = tmp_path / "coarse.mkv"
    run("encode", frames, "--frames", 40, "--fill", "none", "--mirrors", "none", "--depth", "none", "--crf", 30, "--out", stream)
    run("play", stream, "--method", "rotation", *VIEW, "--fill", "none", "--reliability", "--out", tmp_path / "eyes")
    engine = es.Reprojector("rotation", fill="none")
    for eye, view, info in views(engine, es.open_feed(stream), reliability=True):
        assert info.crf == 30
        assert (view.reliability == played(tmp_path / "eyes", eye, info, "reliability")).all(), eye
    feed = es.open_feed(stream)
    frame = next(feed)
    pose = es.Pose((0.1, 0, 0))
    told = engine(frame, CAMERA, pose, reliability=True, risks=True)
    measured, frame.main.info.visible_loss = frame.main.info.visible_loss, None
    usual = engine(frame, CAMERA, pose, reliability=True)
    frame.main.info.crf = None
    untold = engine(frame, CAMERA, pose, reliability=True, risks=True)
    assert told.reliability.mean() < untold.reliability.mean() and usual.reliability.mean() < untold.reliability.mean()
    lost = sum(share * plane for share, plane in zip(measured, np.moveaxis(hats(told.risks[:, :, es.RISKS.index("texture")]), 2, 0)))
    assert np.abs(told.reliability - untold.reliability * (1 - lost) * (1 - 0.3 * lost)).max() < 0.6
    with pytest.raises(es.InputError):
        frame.main.info.crf = 52
    with pytest.raises(es.InputError):
        frame.main.info.visible_loss = [1.5, *measured[1:]]


def test_a_stream_says_what_coding_took(frames, run, tmp_path):
    """What the encoder measured is what a decoder that has the frames finds: how many pixels are visibly off, by texture."""
    stream = tmp_path / "coarse.mkv"
    run("encode", frames, "--fill", "none", "--mirrors", "none", "--depth", "none", "--crf", 30, "--out", stream)
    lost, pixels = np.zeros((2, len(es.CODING_TEXTURES)))
    decoded = list(es.open_feed(stream))
    for frame, picture in zip(es.Sequence(frames / "centre"), (each.main for each in decoded), strict=True):
        before = es.to_display(frame["colour"][:, :, :3], frame.info.exposure).astype(int)
        off = np.abs(before - picture.rgb).max(axis=2) > es.RELIABILITY_TOLERANCE
        share = hats(texture(picture.rgb))
        lost += (share * off[:, :, None]).sum(axis=(0, 1))
        pixels += share.sum(axis=(0, 1))
    seen = pixels > 100
    assert seen.sum() >= 4 and (lost / pixels.clip(1))[seen].max() > 0.1
    for each in decoded:
        assert np.abs(np.array(each.main.info.visible_loss) - lost / pixels.clip(1))[seen].max() < 0.01


def test_a_stream_says_what_noise_and_denoising_and_coding_took(run, tmp_path):
    """Where frames have references, the encoder compares what is decoded with both; so does the package, of frames themselves."""
    frames, stream = tmp_path / "frames", tmp_path / "noisy.mkv"
    run("scene", "generate", "motion", "--out", tmp_path / "scene")
    run("render", tmp_path / "scene/motion.json", "--frames", "0-7", "--size", "512x256", "--spp", 4, "--aovs", "depth,reference", "--out", frames)
    run("encode", frames, "--fill", "none", "--mirrors", "none", "--depth", "none", "--crf", 20, "--out", stream)
    lost, pixels = np.zeros((2, len(es.CODING_TEXTURES)))
    decoded = list(es.open_feed(stream))
    for frame, picture in zip(es.Sequence(frames / "centre"), (each.main for each in decoded), strict=True):
        known = frame["reference"][:, :, 3] > 0
        both = np.stack([es.to_display(frame[name], frame.info.exposure).astype(int) for name in ("reference", "reference_repeat")])
        off = np.maximum(picture.rgb - both.max(axis=0), both.min(axis=0) - picture.rgb).max(axis=2) > es.RELIABILITY_TOLERANCE
        share = hats(texture(picture.rgb)) * known[:, :, None]
        lost += (share * off[:, :, None]).sum(axis=(0, 1))
        pixels += share.sum(axis=(0, 1))
    seen = pixels > 101
    assert 300 < pixels.sum() < 500 and seen.any()
    for each in decoded:
        assert np.abs(np.array(each.main.info.visible_loss) - lost / pixels.clip(1))[seen].max() < 0.01
    frame = es.read_frame(next((frames / "centre").glob("*.exr")))
    engine = es.Reprojector("rotation", fill="none")
    brighter = np.dstack([4 * frame["colour"][:, :, :3], np.ones(frame["depth"].shape[:2], np.float32)])
    wrong = es.Frame(frame.info, {**frame.planes, "reference": brighter, "reference_repeat": brighter[:, :, :3]})
    unknown = es.Frame(frame.info, {"colour": frame["colour"]})
    told, untold = (engine(each, CAMERA, es.Pose((0.1, 0, 0)), reliability=True).reliability.mean() for each in (wrong, unknown))
    assert told < 0.7 * untold


def texture(rgb):
    """Contrast to the four neighbours, where an axis has both of them; averaged over 9x9 pixels of what lies in the picture."""
    rgb = rgb.astype(int)
    contrast = np.zeros(rgb.shape[:2], int)
    for turned, seen in ((rgb, contrast), (rgb.swapaxes(0, 1), contrast.T)):
        step = np.abs(np.diff(turned, axis=0)).max(axis=2)
        seen[1:-1] = np.maximum(seen[1:-1], np.maximum(step[:-1], step[1:]))
    ones = np.ones_like(contrast)
    sums = [sum(np.pad(plane, 4)[y:y + plane.shape[0], x:x + plane.shape[1]] for y in range(9) for x in range(9)) for plane in (contrast, ones)]
    return np.log2(1 + 0.5 * sums[0] / sums[1])


def hats(values):
    """Shares of each value in what lies around it of CODING_TEXTURES."""
    knots = np.array(es.CODING_TEXTURES)
    return np.stack([np.interp(values, knots, one) for one in np.eye(len(knots))], axis=-1)
