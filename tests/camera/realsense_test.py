"""Recordings that the SDK made of its own software device: the path of a real camera but for the USB."""

import contextlib
import json
import time
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pyrealsense2 as rs
import pytest

from impedraw.camera.__main__ import main
from impedraw.camera.folder import Frame
from impedraw.camera.realsense import RealSense, median
from impedraw.camera.stream import KEPT, LiveFrames, StampClock, stream

WIDTH, HEIGHT, FRAMES = 64, 48, 40


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Frame k has 1000 + k % 5 units of 0.5 mm everywhere but in its first row."""
    device = rs.software_device()
    sensor = device.add_sensor("Stereo Module")
    lens = rs.intrinsics()
    lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy = WIDTH, HEIGHT, 60.0, 61.0, 31.0, 23.0
    lens.model, lens.coeffs = rs.distortion.inverse_brown_conrady, [0.01, 0.0, 0.0, 0.0, 0.0]
    stream = rs.video_stream()
    stream.type, stream.index, stream.uid, stream.fps = rs.stream.depth, 0, 1, 30
    stream.width, stream.height, stream.bpp, stream.fmt, stream.intrinsics = WIDTH, HEIGHT, 2, rs.format.z16, lens
    sensor.add_video_stream(stream)
    sensor.add_read_only_option(rs.option.depth_units, 0.0005)
    file = tmp_path_factory.mktemp("recording") / "camera.db3"
    recorder = rs.recorder(str(file), device)
    recorded, queue = recorder.query_sensors()[0], rs.frame_queue(FRAMES)
    profile = recorded.get_stream_profiles()[0]
    recorded.open(profile)
    recorded.start(queue)
    for k in range(FRAMES):
        image = np.full((HEIGHT, WIDTH), 1000 + k % 5, np.uint16)
        image[0] = 0
        frame = rs.software_video_frame()
        frame.pixels, frame.stride, frame.bpp, frame.timestamp = image, 2 * WIDTH, 2, 10.0 * k
        frame.domain, frame.frame_number = rs.timestamp_domain.system_time, k
        frame.profile = sensor.get_stream_profiles()[0].as_video_stream_profile()
        sensor.on_video_frame(frame)
        time.sleep(0.005)
    recorded.stop()
    recorded.close()
    del recorder, recorded
    return file


def test_a_recording_is_imported(recording, tmp_path):
    assert main(["capture", "import", str(recording), "--into", str(tmp_path / "c"), "--views", "2"]) == 0
    views = json.loads((tmp_path / "c/capture.json").read_text())["views"]
    assert len(views) == 2 and (views[0]["fy"], views[0]["cx"], views[0]["width"]) == (61.0, 31.0, WIDTH)
    assert views[0]["distortion"]["model"] == "inverse_brown_conrady"
    depth = cv2.imread(str(tmp_path / "c" / views[0]["depth"]), -1) * views[0]["depth_scale"]
    assert not depth[0].any() and np.allclose(depth[1:], 0.5, atol=1e-4)


def test_a_capture_is_the_median_of_frames(recording, tmp_path, capsys):
    call = ["capture", "--recording", str(recording), "--frames", "15", "--joints", "0,0.4,0,-1.6,0,1.1,0", "--into", str(tmp_path / "c")]
    assert main(call) == 0
    view = json.loads((tmp_path / "c/capture.json").read_text())["views"][0]
    assert view["joints"][3] == -1.6
    depth = cv2.imread(str(tmp_path / "c" / view["depth"]), -1) * view["depth_scale"]
    assert np.allclose(depth[1:], 0.501, atol=1e-4)
    assert main(call) == 2 and "--overwrite" in capsys.readouterr().err
    assert main([*call, "--overwrite"]) == 0
    assert main([*call, "--overwrite", "--laser", "150"]) == 2 and "has no laser" in capsys.readouterr().err
    assert main([*call, "--overwrite", "--preset", "High Accuracy"]) == 2 and "no presets" in capsys.readouterr().err


def test_a_recording_may_be_closed_at_any_time(recording):
    """Without the pause in close(), the SDK aborts in one of about fifty."""
    for k in range(60):
        camera = RealSense(str(recording))
        camera.open()
        assert all(camera.frame() for _ in range(1 + k % 5))
        camera.close()


def test_a_recording_that_is_refused_is_not_read(recording):
    """Once its thread reads, the SDK ends the process in one of about 180 of these."""
    for _ in range(60):
        with pytest.raises(ValueError, match="has no laser"):
            RealSense(str(recording), laser=150.0).open()


def test_the_median_leaves_out_what_is_seldom_measured():
    frames = [Frame(np.array([[1.0 + 0.1 * k, 2.0 if k < 2 else 0.0, 0.0]])) for k in range(5)]
    assert np.allclose(median(frames).depth, [[1.2, 0.0, 0.0]])


def test_no_camera_is_one_line(tmp_path, capsys):
    assert main(["capture", "--into", str(tmp_path / "c")]) == 2
    assert "no RealSense camera" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def calibrated(folder, z):
    folder.mkdir()
    pose = {"p": [0.6, 0.0, z], "q_wxyz": [0.0, 1.0, 0.0, 0.0]}
    (folder / "commissioning.json").write_text(json.dumps({"camera": {"X_WC": pose}}))
    return str(folder)


def test_two_cameras_stream_at_once(recording, tmp_path, capsys):
    """Into the folder of their capture, which stays as an ordinary one."""
    seen, into = {0: {}, 1: {}}, tmp_path / "c"
    call = ["capture", "--recording", str(recording), "--recording", str(recording), "--frames", "15", "--stream", "--into", str(into),
            "--calibration", calibrated(tmp_path / "a", 1.0), "--calibration", calibrated(tmp_path / "b", 1.1)]  # fmt: skip
    before = time.time()
    with ThreadPoolExecutor() as pool:
        ends = pool.submit(main, call)
        while not ends.done():
            for file in into.glob("live_*.png"):
                _, number, stamp = file.stem.split("_")
                with contextlib.suppress(OSError):
                    seen[int(number)].setdefault(1e-6 * int(stamp), file.read_bytes())
            time.sleep(0.001)
    assert ends.result() == 0
    views = json.loads((into / "capture.json").read_text())["views"]
    assert [v["X_WC"]["p"][2] for v in views] == [1.0, 1.1] and not any("time" in v for v in views)
    assert {f.name for f in into.iterdir()} == {"capture.json", "depth_0.png", "depth_1.png"}
    for number, frames in seen.items():  # some may have been missed here
        stamps = sorted(frames)
        assert len(stamps) > 5 and before < stamps[0] and stamps[-1] < time.time()
        steps = np.diff(stamps) / 0.01
        assert np.allclose(steps, np.rint(steps), atol=1e-3), "as far apart as they were taken"
        units = [cv2.imdecode(np.frombuffer(frames[s], np.uint8), -1)[1:].mean() * views[number]["depth_scale"] / 5e-4 for s in stamps]
        k = np.rint(units)
        assert np.allclose(units, k, atol=0.2) and np.array_equal(np.diff(k) % 5, np.rint(steps) % 5), "in their order"
    assert capsys.readouterr().err.count(f"gave {FRAMES - 15} frames") == 2


def test_a_stream_needs_cameras_that_stand(recording, tmp_path, capsys):
    call = ["capture", "--recording", str(recording), "--stream", "--into", str(tmp_path / "c")]
    known = ["--calibration", calibrated(tmp_path / "a", 1.0)]
    for more, why in ((), "that stand"), ((*known, "--views", "2"), "--views 1"), ((*known, *known), "2 times for 1 cameras"):
        with pytest.raises(SystemExit):
            main([*call, *more])
        assert why in capsys.readouterr().err
    assert not (tmp_path / "c").exists()


class Made:
    """A camera of the tests: `frames` are depths and stamps; an exception is raised."""

    name = "made"

    def __init__(self, frames):
        self.frames = iter(frames)

    def frame(self, color=True):
        frame = next(self.frames, None)
        if isinstance(frame, Exception):
            raise frame
        return frame


VIEW = {"width": 4, "height": 3, "depth_scale": 1e-4}


def test_a_stream_keeps_the_newest_frames(tmp_path):
    live = LiveFrames(tmp_path, 0, VIEW)
    for k in range(3 * KEPT):
        live.add(Frame(np.array([[0.5, np.nan, np.inf, 9.0]] * 3)), 1e9 + k)
        assert not list(tmp_path.glob("*.part")) and len(list(tmp_path.iterdir())) <= KEPT
    newest = max(tmp_path.iterdir())
    assert newest.name == f"live_0_{10**6 * (10**9 + 3 * KEPT - 1)}.png"
    assert np.array_equal(cv2.imread(str(newest), -1)[0], [5000, 0, 0, 0]), "beyond what the scale can say, nothing is measured"
    live.remove()
    assert not list(tmp_path.iterdir())


def test_one_camera_that_fails_leaves_the_other(tmp_path):
    notes = []
    good = Frame(np.full((3, 4), 0.5), None, None)
    failing = Made([good, ValueError("gave no frame for 5 s")])
    assert not stream([failing, Made([good] * 9), Made([Frame(np.ones((9, 9)))])], tmp_path, [VIEW] * 3, notes.append)
    told = "\n".join(notes)
    assert "views[0]: gave no frame" in told and "views[1] gave 9 frames" in told and "views[2]: a depth image has 9 x 9 px" in told


@pytest.mark.parametrize("ahead", [0.0, 0.03])
def test_stamps_come_by_this_machines_clock(ahead):
    """Its own clock is found by the quickest frames though it drifts; one that tells this machine's is believed."""
    random, own, clock = np.random.default_rng(3), StampClock(), StampClock()
    for k in range(20000):
        exposed = 1.7e9 + k / 30
        now = exposed + ahead + random.exponential(0.01)
        assert clock.exposed(exposed, now) == exposed
        late = own.exposed(77.0 + (1 + 5e-5) * k / 30, now) - exposed - ahead
        assert k < 300 or abs(late) < 3e-3
