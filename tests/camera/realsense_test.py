"""Recordings that the SDK made of its own software device: the path of a real camera but for the USB."""

import json
import time

import cv2
import numpy as np
import pyrealsense2 as rs
import pytest

from impedraw.camera.__main__ import main
from impedraw.camera.folder import Frame
from impedraw.camera.realsense import RealSense, median

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
