"""The commands, on rendered boards and on recordings that other libraries wrote."""

import json
import struct

import cv2
import numpy as np
import pytest
from made_up import about, difference, looking_at
from scipy.spatial.transform import Rotation

from impedraw.camera import importers
from impedraw.camera.__main__ import main
from impedraw.camera.board import Board
from impedraw.camera.folder import CaptureFolder, Frame, Intrinsics, pose_json, pose_of
from impedraw.camera.hand_eye import inverse, pose

K = np.array([[620.0, 0, 320], [0, 620.0, 240], [0, 0, 1]])
LENS = Intrinsics(640, 480, 620, 620, 320, 240)


def rendered(board, X_CB):
    """The printed board as the camera sees it: a homography of its plane, and its depth."""
    scale = 8
    picture = cv2.copyMakeBorder(board.picture(scale), 80, 80, 80, 80, cv2.BORDER_CONSTANT, value=255)
    # Pixel (80 - ½) of the picture is the board's edge.
    to_board = np.array([[1e-3 / scale, 0, -79.5e-3 / scale], [0, 1e-3 / scale, -79.5e-3 / scale], [0, 0, 1]])
    H = K @ np.column_stack([X_CB[:3, 0], X_CB[:3, 1], X_CB[:3, 3]]) @ to_board
    big = cv2.warpPerspective(picture, np.diag([3.0, 3.0, 1.0]) @ [[1, 0, 1 / 3], [0, 1, 1 / 3], [0, 0, 1]] @ H, (1920, 1440), borderValue=90)
    image = cv2.resize(big, (640, 480), interpolation=cv2.INTER_AREA)
    x, y = np.meshgrid(np.arange(640), np.arange(480))
    rays = np.stack([(x - 320) / 620, (y - 240) / 620, np.ones_like(x, float)])
    n = X_CB[:3, 2]
    return image, (n @ X_CB[:3, 3]) / np.tensordot(n, rays, 1)


@pytest.mark.parametrize("text", ["charuco:7x5:40:30", "apriltag:5x4:40:30"])
def test_a_camera_is_found_from_images_of_a_board(tmp_path, text, capsys):
    board, rng = Board.parse(text), np.random.default_rng(7)
    X_WC, X_EB = looking_at([1.3, 0.1, 0.7], [0.6, 0.0, 0.3]), pose(about(rng, 10), [-0.1, -0.08, 0.02])
    with CaptureFolder(tmp_path / "views") as folder:
        for _ in range(10):
            X_CB = pose(about(rng, 30), [*rng.uniform(-0.05, 0.05, 2), 0.6]) @ pose(np.eye(3), [-0.14, -0.1, 0])
            image, depth = rendered(board, X_CB)
            color = np.repeat(image[..., None], 3, 2)
            folder.add(LENS, Frame(depth, color), X_WE=pose_json(X_WC @ X_CB @ inverse(X_EB)))
    assert main(["calibrate-camera", str(tmp_path / "views"), "--board", text, "--into", str(tmp_path)]) == 0
    assert "10 used" in capsys.readouterr().out
    found = pose_of(json.loads((tmp_path / "commissioning.json").read_text())["camera"]["X_WC"])
    metres, degrees = difference(found, X_WC)
    assert metres < 1e-3 and degrees < 0.1


@pytest.mark.parametrize("text", ["charuco:7x5:30:40", "chess:7x5:40:30", "charuco:7x5", "charuco:7x5:nan:30", "charuco:99x5:40:30"])
def test_boards_that_do_not_exist(text):
    with pytest.raises((ValueError, SystemExit)):
        main(["calibrate-camera", "views", "--board", text])


def tum_folder(folder, count=4):
    (folder / "depth").mkdir(parents=True)
    rows, truth = [], []
    for k in range(count):
        cv2.imwrite(str(folder / f"depth/{k}.png"), np.full((480, 640), 5000 * (k + 1), np.uint16))
        rows.append(f"{100 + 0.1 * k:.6f} depth/{k}.png")
        for t in (-0.01, 0.01):
            truth.append(f"{100 + 0.1 * k + t:.4f} {k + 10 * t} 0 1 0 0 0 1")
    (folder / "depth.txt").write_text("# depth maps\n" + "\n".join(rows) + "\n")
    (folder / "groundtruth.txt").write_text("\n".join(truth) + "\n")


def test_tum(tmp_path):
    tum_folder(tmp_path / "rgbd")
    assert main(["capture", "import", str(tmp_path / "rgbd"), "--into", str(tmp_path / "c"), "--views", "2", "--world", "0,0,0.5,0,0,90"]) == 0
    views = json.loads((tmp_path / "c/capture.json").read_text())["views"]
    assert len(views) == 2
    depth = cv2.imread(str(tmp_path / "c" / views[1]["depth"]), -1) * views[1]["depth_scale"]
    assert np.allclose(depth, 4.0, atol=1e-4)  # of the last image
    assert np.allclose(pose_of(views[1]["X_WC"])[:3, 3], [0, 3, 1.5])


def test_redwood(tmp_path):
    for k in (2, 10):  # in the order of numbers, not of letters
        cv2.imwrite(str(tmp_path / f"depth_{k}.png"), np.full((480, 640), 100 * k, np.uint16))
    (tmp_path / "trajectory.log").write_text("".join(f"{k} {k} {k + 1}\n1 0 0 {k}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n" for k in range(2)))
    seen = list(importers.redwood(tmp_path, 5, None, lambda text: None))
    assert [s[0].depth[0, 0] for s in seen] == [0.2, 1.0] and seen[1][2][0, 3] == 1
    (tmp_path / "trajectory.log").write_text("0 0 1\n1 0 0\n")
    with pytest.raises(ValueError, match="trajectory.log"):
        list(importers.redwood(tmp_path, 5, None, lambda text: None))


def test_a_damaged_folder_is_one_line_and_leaves_nothing(tmp_path, capsys):
    tum_folder(tmp_path / "rgbd")
    (tmp_path / "rgbd/depth/3.png").write_bytes((tmp_path / "rgbd/depth/3.png").read_bytes()[:100])
    assert main(["capture", "import", str(tmp_path / "rgbd"), "--into", str(tmp_path / "c"), "--views", "4"]) == 2
    assert "3.png" in capsys.readouterr().err.strip().splitlines()[-1]
    assert [p.name for p in tmp_path.iterdir()] == ["rgbd"]
    (tmp_path / "x.mcap").write_bytes(b"no bag")
    assert main(["capture", "import", str(tmp_path / "x.mcap"), "--into", str(tmp_path / "c")]) == 2
    assert main(["capture", "import", str(tmp_path / "none"), "--into", str(tmp_path / "c")]) == 2


def test_large_damaged_bags_are_one_line_at_once(tmp_path, capsys):
    """1 GB of nothing: without a look at its records, the reader takes each byte for one."""
    magic, text = b"\x89MCAP0\r\n", lambda t: struct.pack("<I", len(t)) + t
    record = lambda opcode, content: struct.pack("<BQ", opcode, len(content)) + content
    begun = magic + record(1, text(b"ros2") + text(b""))
    chunk = struct.pack("<BQ28sIQ", 6, 2**29, b"", 0, 2**29 - 40)
    end = lambda summary: record(2, struct.pack("<QQI", summary, 0, 0)) + magic
    for name, head, tail in (("zeros.mcap", b"", b""), ("hole.mcap", begun, end(0)), ("summary.mcap", begun, end(len(begun))),
                             ("chunk.mcap", begun + chunk, end(0)), ("cut.mcap", begun + chunk[:20], b""), ("zeros.db3", b"", b"")):  # fmt: skip
        with (tmp_path / name).open("wb") as file:
            file.write(head)
            file.truncate(2**30 - len(tail))
            file.seek(0, 2)
            file.write(tail)
        assert main(["capture", "import", str(tmp_path / name), "--into", str(tmp_path / "c")]) == 2
        said = capsys.readouterr().err.strip().splitlines()
        assert len(said) == 1 and name in said[0] and "damaged" in said[0], said


def test_a_damaged_message_is_one_line(tmp_path, capsys):
    import sqlite3

    with sqlite3.connect(tmp_path / "x.db3") as bag:
        bag.execute("create table topics(id integer primary key, name text, type text, serialization_format text, offered_qos_profiles text)")
        bag.execute("create table messages(id integer primary key, topic_id integer, timestamp integer, data blob)")
        bag.execute("insert into topics values(1, '/camera/depth/image_rect_raw', 'sensor_msgs/msg/Image', 'cdr', '')")
        bag.execute("insert into messages values(1, 1, 0, zeroblob(1000))")
    assert main(["capture", "import", str(tmp_path / "x.db3"), "--into", str(tmp_path / "c")]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1 and "x.db3 is damaged" in said[0], said


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("encoding", ["16UC1", "32FC1"])
def test_ros2_bags(tmp_path, storage, encoding):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    T = store.types
    header = lambda frame, t: T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](int(t), round(t % 1 * 1e9)), frame)
    vector, quaternion = T["geometry_msgs/msg/Vector3"], T["geometry_msgs/msg/Quaternion"]
    q = Rotation.from_euler("z", 30, degrees=True).as_quat()
    link = lambda parent, child, p, q=(0, 0, 0, 1): T["geometry_msgs/msg/TransformStamped"](
        header(parent, 0), child, T["geometry_msgs/msg/Transform"](vector(*map(float, p)), quaternion(*map(float, q))))
    depth = np.linspace(0.5, 1.5, 640 * 480).reshape(480, 640)
    pixels = (1e3 * depth).astype("<u2") if encoding == "16UC1" else depth.astype("<f4")
    padded = np.hstack([pixels.view(np.uint8).reshape(480, -1), np.zeros((480, 8), np.uint8)])  # rows may be longer than the image
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3) as writer:
        def send(topic, kind, message, t=1.0):
            c = next((c for c in writer.connections if c.topic == topic), None) or writer.add_connection(topic, kind, typestore=store)
            writer.write(c, int(t * 1e9), store.serialize_cdr(message, kind))
        send("/tf_static", "tf2_msgs/msg/TFMessage", T["tf2_msgs/msg/TFMessage"]([
            link("base_link", "mount", [0.3, 0, 1], q), link("mount", "camera_depth_optical_frame", [0.1, 0, 0])]))  # fmt: skip
        send("/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", T["sensor_msgs/msg/CameraInfo"](
            header("camera_depth_optical_frame", 1), 480, 640, "plumb_bob", np.zeros(5), K.ravel(), np.eye(3).ravel(),
            np.zeros(12), 0, 0, T["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)))  # fmt: skip
        for k in range(3):
            send("/camera/depth/image_rect_raw", "sensor_msgs/msg/Image", T["sensor_msgs/msg/Image"](
                header("camera_depth_optical_frame", 1 + 0.1 * k), 480, 640, encoding, 0, padded.shape[1], padded.ravel()), 1 + 0.1 * k)  # fmt: skip
    assert main(["capture", "import", str(tmp_path / "bag"), "--into", str(tmp_path / "c"), "--base", "base_link", "--views", "2"]) == 0
    views = json.loads((tmp_path / "c/capture.json").read_text())["views"]
    assert len(views) == 2 and views[0]["fx"] == 620
    read = cv2.imread(str(tmp_path / "c" / views[0]["depth"]), -1) * views[0]["depth_scale"]
    assert np.abs(read - depth).max() < 1.1e-3
    X = pose_of(views[0]["X_WC"])
    assert np.allclose(X[:3, 3], [0.3 + 0.1 * np.cos(np.pi / 6), 0.05, 1])


def test_compressed_depth():
    class Message:
        format = "16UC1; compressedDepth png"
        data = np.hstack([np.zeros(12, np.uint8), cv2.imencode(".png", np.full((4, 6), 1234, np.uint16))[1].ravel()])

    assert np.allclose(importers.depth_of(Message), 1.234)
