"""Frames and sequences: what programs wrote, read; what Python wrote, read by programs; lifetimes; hostile arguments."""

import gc
import json
import threading

import equistream as es
import independent
import numpy as np
import OpenEXR
import pytest


@pytest.fixture
def file(sphere):
    return sphere / "left" / "frame.0001.exr"


def test_reads_what_openexr_reads(file):
    frame = es.read_frame(file)
    channels = independent.read_frame(file)
    seen = set()
    for name, plane in frame.planes.items():
        for k, channel in enumerate(es.AOVS[name]["channels"]):
            samples = plane if plane.ndim == 2 else plane[:, :, k]
            np.testing.assert_array_equal(samples, channels[channel])
            seen.add(channel)
    assert seen == set(channels)
    assert frame["object_id"].dtype == np.uint32 and frame["depth"].dtype == np.float32
    assert frame.info.eye == "left" and frame.info.scene == "motion" and frame.info.index == 1


def test_planes_are_not_copied_and_outlive_their_frame(file):
    frame = es.read_frame(file, ["depth", "colour"])
    assert set(frame) == {"depth", "colour"} and "normal" not in frame
    depth = frame["depth"]
    assert not depth.flags.owndata and depth.flags.writeable and depth.flags.c_contiguous
    before = depth.copy()
    view = depth[3:, 5:]
    del frame, depth
    for _ in range(20):
        gc.collect()
        es.read_frame(file)
    np.testing.assert_array_equal(view, before[3:, 5:])


def test_round_trip(file, tmp_path):
    frame = es.read_frame(file)
    assert es.write_frame(tmp_path / "copy.exr", frame) == 0
    again = es.read_frame(tmp_path / "copy.exr")
    assert repr(again.info) == repr(frame.info) and again.info.camera_pose == frame.info.camera_pose
    for name in frame:
        np.testing.assert_array_equal(again[name], frame[name])


def test_a_single_part_has_depth_as_z_too(file, tmp_path):
    frame = es.read_frame(file, ["colour", "depth"])
    parts = {}
    for single in (False, True):
        es.write_frame(tmp_path / "a.exr", frame, single_part=single)
        parts[single] = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).parts
    assert len(parts[False]) == 2 and len(parts[True]) == 1
    np.testing.assert_array_equal(parts[True][0].channels["Z"].pixels, frame["depth"])


def test_converts_what_loses_nothing(tmp_path):
    frame = es.Frame(es.frame_info(es.EquirectCamera(8, 4)))
    frame["colour"] = np.ones((8, 4, 4)).transpose(1, 0, 2)  # float64, not contiguous
    frame["depth"] = np.full((4, 8, 1), np.inf, np.float16)
    frame["object_id"] = np.arange(32).reshape(4, 8)
    frame["instance_id"] = [[1] * 8] * 4
    es.write_frame(tmp_path / "a.exr", frame)
    read = es.read_frame(tmp_path / "a.exr")
    np.testing.assert_array_equal(read["object_id"], np.arange(32).reshape(4, 8))
    assert np.isinf(read["depth"]).all()


def bad(name, plane):
    frame = es.Frame(es.frame_info(es.EquirectCamera(8, 4)))
    frame.planes[name] = plane
    return frame


@pytest.mark.parametrize("frame", [
    bad("depth", np.zeros((4, 9), np.float32)), bad("depth", np.zeros((8, 4), np.float32)), bad("depth", np.zeros(32, np.float32)),
    bad("depth", np.zeros((4, 8), int)), bad("depth", np.full((4, 8), np.nan)), bad("depth", np.full((4, 8), -1.0)),
    bad("depth", np.zeros((0, 0), np.float32)), bad("depth", "deep"), bad("depth", [[1, 2], [3]]), bad("depth", None),
    bad("colour", np.zeros((4, 8, 3), np.float32)), bad("colour", np.zeros((4, 8, 4), complex)), bad("depths", np.zeros((4, 8), np.float32)),
    bad("object_id", np.zeros((4, 8), np.float32)), bad("object_id", np.full((4, 8), -1)), bad("object_id", np.full((4, 8), 2**32)),
    bad("backward", np.full((4, 8, 2), np.inf, np.float32)), es.Frame(es.FrameInfo()), es.Frame(es.frame_info(es.EquirectCamera(8, 4)))])
def test_bad_frames_are_told_in_one_line(frame, tmp_path):
    with pytest.raises(es.InputError) as caught:
        es.write_frame(tmp_path / "bad.exr", frame)
    assert "expected" in str(caught.value) and "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_times_that_no_file_holds_are_refused():
    info = es.frame_info(es.EquirectCamera(8, 4))
    with pytest.raises(es.InputError, match="time_s: expected a number from -1e.10 to 1e.10"):
        info.time_s = 1e11


def test_what_was_read_stays_when_another_is_set():
    info = es.frame_info(es.EquirectCamera(8, 4))
    camera, pose, head = info.camera, info.camera_pose, info.head
    info.camera = es.PerspectiveCamera(16, 8, 1.0)
    info.camera_pose = info.head = es.Pose([1, 2, 3], pose.orientation)
    assert isinstance(camera, es.EquirectCamera) and (camera.width, camera.height) == (8, 4)
    assert pose.position_m.tolist() == head.position_m.tolist() == [0, 0, 0]
    assert info.camera_pose.position_m.tolist() == [1, 2, 3]


def test_errors_of_files(file, tmp_path):
    with pytest.raises(es.InputError, match="nowhere.exr"):
        es.read_frame(tmp_path / "nowhere.exr")
    (tmp_path / "cut.exr").write_bytes(file.read_bytes()[:3000])
    with pytest.raises(ValueError, match="cut.exr: expected a whole EXR frame"):
        es.read_frame(tmp_path / "cut.exr")
    with pytest.raises(es.InputError, match="expected one of colour.* found 'z'"):
        es.read_frame(file, "z")
    with pytest.raises(KeyError, match="expected a plane of depth"):
        es.read_frame(file, "depth")["normal"]
    with pytest.raises(es.WorkError):
        es.write_frame(tmp_path / "no" / "folder" / "a.exr", es.read_frame(file))
    with pytest.raises(es.InputError, match="expected a Frame"):
        es.write_frame(tmp_path / "a.exr", {"depth": 1})


def test_sequences(sphere):
    sequence = es.Sequence(sphere / "left", planes="depth")
    assert len(sequence) == 3 and sequence.indices == [0, 1, 2] and "3 frames" in repr(sequence)
    assert [frame.info.index for frame in sequence] == [0, 1, 2]
    assert sequence[-1].info.index == 2 and list(sequence.read(1)) == ["depth"]
    assert sequence.manifest["shared"].camera == es.EquirectCamera(512, 256) and "render" in sequence.manifest["command"]
    with pytest.raises(es.InputError, match="frames"):
        es.Sequence(sphere)


def test_written_sequences_encode_and_play(sphere, run, tmp_path):
    source = es.Sequence(sphere / "left")
    with es.SequenceWriter(tmp_path / "left") as writer:
        for frame in source:
            frame["colour"][:, :, :3] *= 0.5
            writer.write(frame)
        with pytest.raises(es.InputError, match="in use"):
            es.SequenceWriter(tmp_path / "left").write(source[0])
    said = json.loads(run("info", tmp_path / "left", "--json"))
    assert said
    run("encode", tmp_path, "--out", tmp_path / "half.mp4")
    assert sum(1 for _ in es.open_stream(tmp_path / "half.mp4")) == 3
    assert es.SequenceWriter(tmp_path / "left").keeps(2) and not es.SequenceWriter(tmp_path / "left", overwrite=True).keeps(2)


def test_sequences_refuse_mixtures(sphere, tmp_path):
    frame = es.read_frame(sphere / "left" / "frame.0000.exr")
    writer = es.SequenceWriter(tmp_path / "out")
    writer.write(frame)
    frame.info.index, frame.info.seed = 1, 99
    with pytest.raises(es.InputError, match="expected seed 1 .* found 99"):
        writer.write(frame)
    frame.info.seed = 1
    del frame.planes["normal"]
    with pytest.raises(es.InputError, match="planes"):
        writer.write(frame)
    writer.close()
    with pytest.raises(es.InputError, match="closed"):
        writer.write(frame)
    with pytest.raises(es.InputError, match="overwrite"):
        es.SequenceWriter(tmp_path / "out").write(frame)
    es.SequenceWriter(tmp_path / "out", overwrite=True).write(frame)
    assert es.Sequence(tmp_path / "out").indices == [1]


def test_sequences_refuse_another_fingerprint(file, tmp_path):
    frame = es.read_frame(file, "depth")
    with es.SequenceWriter(tmp_path / "out", fingerprint="one scene") as writer:
        writer.write(frame)
    with pytest.raises(es.InputError, match="overwrite"):
        es.SequenceWriter(tmp_path / "out", fingerprint="another scene").begin(frame.info, frame)
    with es.SequenceWriter(tmp_path / "out", fingerprint="one scene") as writer:
        writer.begin(frame.info, frame)
        assert writer.keeps(1)


def test_reading_gives_up_the_lock(tmp_path):
    """Another Python thread goes on while a frame is written."""
    frame = es.Frame(es.frame_info(es.EquirectCamera(2048, 1024)))
    rng = np.random.default_rng(1)
    frame["normal"] = rng.normal(size=(1024, 2048, 3)).astype(np.float32)
    ticks, stop = [0], threading.Event()

    def tick():
        while not stop.is_set():
            ticks[0] += 1
            stop.wait(0.001)
    thread = threading.Thread(target=tick)
    thread.start()
    started = ticks[0]
    es.write_frame(tmp_path / "big.exr", frame)
    passed = ticks[0] - started
    stop.set()
    thread.join()
    assert passed > 5
