"""Streams and feeds: pictures, tags, ends, Ctrl-C, and threads."""

import concurrent.futures
import gc
import signal
import socket
import subprocess
import sys
import threading
import time

import equistream as es
import numpy as np
import pytest

from conftest import refusals_of_four_threads


def test_pictures(stream, sphere):
    reader = es.open_stream(stream)
    tracks = {track["role"]: track for track in reader.tracks}
    assert tracks["main"]["width"] == 512 and "small" in tracks and "h264" in repr(reader)
    pictures = list(reader)
    assert [p.info.index for p in pictures if p.role == "main"] == [0, 1, 2] and reader.truncation == ""
    truth = es.read_frame(sphere / "left" / "frame.0000.exr", "colour")
    error = np.abs(pictures[0].rgb.astype(int) - es.to_display(truth["colour"], truth.info.exposure))
    assert error.mean() < 6  # coded, 2 samples a pixel: noise


def test_pictures_of_an_hdr_stream(run, sphere, tmp_path):
    """Light of every pixel, against the frame's own: ST 2084 and BT.2020 (BT.2087's matrix) written out here."""
    run("encode", sphere, "--transfer", "pq", "--crf", 4, "--fill", "none", "--out", tmp_path / "hdr.mp4")
    picture = next(es.open_stream(tmp_path / "hdr.mp4"))
    assert picture.rgb is None and picture.pq.dtype == np.float32 and picture.pq.shape == (256, 512, 3)
    power = np.maximum(picture.pq, 0).astype(float) ** (32 / 2523)
    nits = 1e4 * (np.maximum(power - 107 / 128, 0) / (2413 / 128 - 2392 / 128 * power)) ** (8192 / 1305)
    to_2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
    light = nits / 203 @ np.linalg.inv(to_2020).T
    frame = es.read_frame(sphere / "left" / "frame.0000.exr", "colour")
    truth = np.minimum(np.maximum(frame["colour"][..., :3], 0) * frame.info.exposure, 1e4 / 203)
    # Chroma is at half the size: means of 2x2 pixels, on the scale on which eyes see them.
    half = [plane.reshape(128, 2, 256, 2, 3).mean(axis=(1, 3)) for plane in (light, truth)]
    assert np.abs(np.sqrt(np.maximum(half[0], 0)) - np.sqrt(half[1])).mean() < 0.01
    assert abs(light.mean() / truth.mean() - 1) < 0.01
    shown = next(es.open_feed(tmp_path / "hdr.mp4")).main.rgb
    assert np.abs(shown.astype(int) - es.to_display(frame["colour"], frame.info.exposure)).mean() < 4  # coded noise


def test_pictures_outlive_the_stream(stream):
    first = next(es.open_stream(stream)).rgb
    before = first.copy()
    for _ in range(5):
        list(es.open_stream(stream))
        gc.collect()
    np.testing.assert_array_equal(first, before)


def test_feed_of_a_folder_is_the_display_transform(sphere):
    frames = list(es.open_feed(sphere, depth=True))
    assert len(frames) == 3 and all(f.posed and f.small is not None for f in frames)
    frame = es.read_frame(sphere / "left" / "frame.0002.exr")
    np.testing.assert_array_equal(frames[2].main.rgb, es.to_display(frame["colour"], frame.info.exposure))
    np.testing.assert_array_equal(frames[2].main.depth_m, frame["depth"])
    assert es.open_feed(sphere, first_frame=1, last_frame=1).__next__().main.info.index == 1


def test_motion_carries_points_to_where_they_will_be(run, sphere, tmp_path):
    run("encode", sphere, "--fill", "none", "--motion", "auto", "--out", tmp_path / "moving.mp4")
    main = [p for p in es.open_stream(tmp_path / "moving.mp4") if p.role == "main"]
    frame = es.read_frame(sphere / "left" / "frame.0001.exr")
    camera, pose, ids = frame.info.camera, frame.info.camera_pose, frame["object_id"]
    assert len(main[1].info.moving) == 2 and repr(main[1].info.moving[0]).startswith("MovingRegion(")
    later = es.read_frame_info(sphere / "left" / "frame.0002.exr").camera_pose
    for body in main[1].info.moving:
        mask = body.mask(camera.width, camera.height) == 1
        assert mask.sum() == body.pixels and len(np.unique(ids[mask])) == 1
        depth = frame["depth"][mask]
        assert (body.near_m, body.far_m) == pytest.approx((depth.min(), depth.max()), rel=1e-6)
        points = pose.to_world(camera.directions())[mask] * frame["depth"][mask][:, None]
        moved = np.c_[points, np.ones(len(points))] @ np.array(body.movement(1 / 30)).T
        seen = moved + np.array(pose.position_m) - np.array(later.position_m)
        flow = frame["forward"][mask]
        centres = np.stack(np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5), -1)[mask] + flow
        longitude, latitude = 2 * np.pi * (centres[:, 0] / camera.width - 0.5), np.pi * (0.5 - centres[:, 1] / camera.height)
        expected = np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)], -1)
        off = np.linalg.norm(seen / np.linalg.norm(seen, axis=1, keepdims=True) - later.to_world(expected), axis=1)
        assert np.percentile(off, 95) < 1e-4
    with pytest.raises(es.InputError, match="MovingRegion.mask: .* in a moving region of 8x8 pixels"):
        main[1].info.moving[0].mask(8, 8)
    assert es.FrameInfo().moving == []


def test_feed_seeks_by_number(stream):
    found = [f.main.info.index for f in es.open_feed(stream, first_frame=1)]
    assert found == [1, 2]


def test_cut_streams_say_so(stream, tmp_path):
    cut = tmp_path / "cut.mp4"
    cut.write_bytes(stream.read_bytes()[:-1500])
    reader = es.open_stream(cut)
    count = sum(1 for _ in reader)
    assert count < 6 and "cut" in reader.truncation


def test_errors(tmp_path):
    with pytest.raises(es.InputError, match="no such file"):
        es.open_stream(tmp_path / "nothing.mp4")
    (tmp_path / "text.mp4").write_text("not a video")
    with pytest.raises(es.InputError, match="expected a video"):
        es.open_feed(tmp_path / "text.mp4")
    with pytest.raises(es.InputError):
        es.open_feed(tmp_path, first_frame=3, last_frame=1)
    with pytest.raises(es.InputError):
        es.open_feed(tmp_path)


def test_ctrl_c_ends_a_wait_for_a_silent_source():
    """A listening socket that never answers: only a signal can end this."""
    server = socket.socket()
    server.bind(("127.0.0.1", 0))
    server.listen()
    code = f"import equistream as es\nprint('waiting', flush=True)\nes.open_stream('tcp://127.0.0.1:{server.getsockname()[1]}')"
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert child.stdout.readline() == "waiting\n"
        time.sleep(0.5)
        child.send_signal(signal.SIGINT)
        began = time.monotonic()
        _, complaint = child.communicate(timeout=20)
        assert time.monotonic() - began < 5
        assert complaint.strip().endswith("KeyboardInterrupt"), complaint
    finally:
        child.kill()
        child.wait()
        server.close()


def test_a_second_thread_is_refused(tmp_path):
    reader = es.open_stream(make_long_video(tmp_path))
    problems = refusals_of_four_threads(lambda: list(reader))
    assert any("one thread at a time" in p for p in problems)


def test_another_thread_may_ask_what_there_is(tmp_path):
    """As a display of progress does, while the next picture is read without Python's lock."""
    reader = es.open_stream(make_long_video(tmp_path))
    seen, done = [0], threading.Event()

    def look():
        while not done.is_set():
            seen.append(reader.tracks[0]["pictures"])
            assert reader.container and reader.truncation == ""

    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        looking = pool.submit(look)
        try:
            for count, _ in enumerate(reader, 1):
                assert reader.tracks[0]["pictures"] == count
        finally:
            done.set()
        looking.result()
    assert count == 90 and seen == sorted(seen) and seen[-1] <= 90


def make_long_video(folder):
    file = folder / "long.mp4"
    subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", "testsrc2=size=1280x640:rate=30:duration=3", "-pix_fmt", "yuv420p", str(file)], check=True)
    return file


def test_foreign_video_is_a_sphere_around_nobody(tmp_path):
    frame = next(es.open_feed(make_long_video(tmp_path)))
    assert not frame.posed and frame.main.info.camera == es.EquirectCamera(1280, 640)
    view = es.reproject(frame, es.PerspectiveCamera(64, 64), es.Pose())
    assert view.gaps.sum() == 0
    with pytest.raises(es.InputError, match="pose"):
        es.reproject(next(es.open_stream(tmp_path / "long.mp4")), es.PerspectiveCamera(64, 64), es.Pose())
