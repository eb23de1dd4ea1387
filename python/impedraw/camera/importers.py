"""Captures from what others recorded: RGB-D folders in TUM's layout, ROS 2 bags, RealSense recordings."""

from __future__ import annotations

import bisect
import pathlib
import struct
from collections.abc import Callable, Iterator

import cv2
import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from .folder import Frame, Intrinsics
from .hand_eye import inverse, pose

# A view of an import: what the camera saw, through which lens, and its pose in the recording's world, if known.
Seen = tuple[Frame, Intrinsics, np.ndarray | None]
NEAR = 0.03  # most between an image and its pose or colour [s]
TUM_SCALE = 1.0 / 5000.0  # [m]
TUM_INTRINSICS = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)


class Trajectory:
    """Poses over time, interpolated; none further than NEAR from a known one."""

    def __init__(self, times: list[float], poses: list[np.ndarray]):
        order = np.argsort(times)
        keep = [k for n, k in enumerate(order) if n == 0 or times[k] > times[order[n - 1]]]
        self.times = np.asarray(times)[keep]
        self.p = np.asarray([poses[k][:3, 3] for k in keep])
        self.R = Rotation.from_matrix([poses[k][:3, :3] for k in keep])

    def at(self, time: float) -> np.ndarray | None:
        i = bisect.bisect_left(self.times, time)
        before, after = max(i - 1, 0), min(i, len(self.times) - 1)
        if min(abs(self.times[before] - time), abs(self.times[after] - time)) > NEAR:
            return None
        if before == after:
            return pose(self.R[before].as_matrix(), self.p[before])
        t = np.clip(time, self.times[before], self.times[after])
        p = [np.interp(t, self.times[[before, after]], self.p[[before, after], k]) for k in range(3)]
        return pose(Slerp(self.times[[before, after]], self.R[[before, after]])(t).as_matrix(), np.asarray(p))


def nearest(times: list[float], time: float) -> int | None:
    """Index in ascending times; None if none is near."""
    i = bisect.bisect_left(times, time)
    if not times:
        return None
    i = min((k for k in (i - 1, i) if 0 <= k < len(times)), key=lambda k: abs(times[k] - time))
    return i if abs(times[i] - time) <= NEAR else None


def evenly(count: int, wanted: int) -> list[int]:
    return sorted({round(k) for k in np.linspace(0, count - 1, min(count, wanted))})


def _tum_list(file: pathlib.Path, columns: int) -> list[list[str]]:
    try:
        rows = [line.split() for line in file.read_text().splitlines() if line.strip() and not line.startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file} cannot be read: {error}") from None
    for number, row in enumerate(rows, 1):
        try:
            [float(x) for x in (row if columns > 2 else row[:1])]
        except ValueError:
            row = []
        if len(row) < columns:
            raise ValueError(f"{file}: entry {number} has not {columns} columns, the first of them a time")
    return rows


def read_image(file: pathlib.Path, flags: int) -> np.ndarray:
    image = cv2.imread(str(file), flags)
    if image is None:
        raise ValueError(f"{file} is missing or is no whole image")
    return image


def read_depth(file: pathlib.Path) -> np.ndarray:
    depth = read_image(file, cv2.IMREAD_UNCHANGED)
    if depth.ndim != 2 or depth.dtype != np.uint16:
        raise ValueError(f"{file} is no 16-bit grey image")
    return depth


def tum(folder: pathlib.Path, views: int, intrinsics: Intrinsics | None, note: Callable[[str], None]) -> Iterator[Seen]:
    depths = _tum_list(folder / "depth.txt", 2)
    colors = sorted(_tum_list(folder / "rgb.txt", 2), key=lambda row: float(row[0])) if (folder / "rgb.txt").exists() else []
    trajectory = None
    if (folder / "groundtruth.txt").exists():
        rows = [[float(x) for x in row[:8]] for row in _tum_list(folder / "groundtruth.txt", 8)]
        trajectory = Trajectory([r[0] for r in rows], [pose(Rotation.from_quat(r[4:8]).as_matrix(), np.asarray(r[1:4])) for r in rows])
    if intrinsics is None:
        intrinsics = TUM_INTRINSICS
        note("the folder tells no intrinsics: TUM's default 525, 525, 319.5, 239.5 are taken; --intrinsics says others")
    color_times = [float(c[0]) for c in colors]
    for k in evenly(len(depths), views):
        time = float(depths[k][0])
        depth = read_depth(folder / depths[k][1])
        c = nearest(color_times, time)
        color = None if c is None else read_image(folder / colors[c][1], cv2.IMREAD_COLOR)[..., ::-1]
        if color is not None and color.shape[:2] != depth.shape:
            note(f"{colors[c][1]}: another size than its depth image; left out")
            color = None
        yield Frame(depth * TUM_SCALE, color, time), intrinsics, trajectory.at(time) if trajectory else None


def redwood(folder: pathlib.Path, views: int, intrinsics: Intrinsics | None, note: Callable[[str], None]) -> Iterator[Seen]:
    """The layout of Redwood's and Open3D's data: depth images in mm in the order of their names' numbers, and
    trajectory.log with five lines for each, the last four of them X_WC."""
    files = sorted([*folder.glob("depth_*.png"), *folder.glob("depth/*.png")], key=lambda f: int("".join(filter(str.isdigit, f.stem)) or 0))
    try:
        lines = [line for line in (folder / "trajectory.log").read_text().splitlines() if line.strip()]
        poses = [np.array([[float(x) for x in row.split()] for row in lines[k + 1 : k + 5]]).reshape(4, 4) for k in range(0, len(lines), 5)]
    except (OSError, ValueError) as error:
        raise ValueError(f"{folder / 'trajectory.log'} has not five lines for each image, a number and a 4 x 4 matrix: {error}") from None
    if len(poses) != len(files) or not files:
        raise ValueError(f"{folder} has {len(files)} depth images (depth_*.png, or depth/*.png), and trajectory.log {len(poses)} poses")
    if intrinsics is None:
        intrinsics = TUM_INTRINSICS
        note("the folder tells no intrinsics: PrimeSense's 525, 525, 319.5, 239.5 are taken; --intrinsics says others")
    for k in evenly(len(files), views):
        yield Frame(1e-3 * read_depth(files[k])), intrinsics, poses[k]


def realsense(file: pathlib.Path, views: int, note: Callable[[str], None]) -> Iterator[Seen]:
    from .realsense import RealSense

    camera = RealSense(recording=str(file))
    camera.open()
    # In one pass, by time: a playback may drop frames, and never the same ones.
    try:
        taken, last, first_time = 0, None, None
        while (frame := camera.frame()) is not None:
            first_time = frame.time if first_time is None else first_time
            last = frame
            if taken < views - 1 and frame.time - first_time >= taken * camera.duration / (views - 1):
                yield frame, camera.intrinsics, None
                taken, last = taken + 1, None
        if last is not None:
            yield last, camera.intrinsics, None
    finally:
        camera.close()


class Tree:
    """Frames of reference by their parents; the latest transform of each counts, within NEAR of a time if it moves."""

    def __init__(self) -> None:
        self.fixed: dict[str, tuple[str, np.ndarray]] = {}
        self.moving: dict[str, tuple[str, list[float], list[np.ndarray]]] = {}

    def add(self, message: object, fixed: bool) -> None:
        for t in message.transforms:
            child, parent = t.child_frame_id.lstrip("/"), t.header.frame_id.lstrip("/")
            p, q = t.transform.translation, t.transform.rotation
            X = pose(Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix(), np.array([p.x, p.y, p.z]))
            if fixed:
                self.fixed[child] = parent, X
            else:
                _, times, poses = self.moving.setdefault(child, (parent, [], []))
                times.append(seconds(t.header.stamp))
                poses.append(X)

    def up(self, frame: str, time: float) -> dict[str, np.ndarray]:
        """frame and all above it, each with X_(above, frame)."""
        found, X = {frame: np.eye(4)}, np.eye(4)
        while True:
            if frame in self.fixed:
                frame, step = self.fixed[frame]
            elif frame in self.moving:
                frame, times, poses = self.moving[frame]
                step = Trajectory(times, poses).at(time)
                if step is None:
                    return found
            else:
                return found
            if frame in found:
                raise ValueError(f"the recording's frames go in a circle at '{frame}'")
            X = step @ X
            found[frame] = X

    def between(self, base: str, camera: str, time: float) -> np.ndarray | None:
        """X_(base, camera)."""
        down, up = self.up(base, time), self.up(camera, time)
        common = next((f for f in up if f in down), None)
        return None if common is None else inverse(down[common]) @ up[common]


def seconds(stamp: object) -> float:
    return stamp.sec + 1e-9 * stamp.nanosec


def depth_of(message: object) -> np.ndarray:
    """Metres, from sensor_msgs/Image or a CompressedImage of compressed_depth_image_transport."""
    if hasattr(message, "encoding"):
        kinds = {"16UC1": ("u2", 1e-3), "mono16": ("u2", 1e-3), "32FC1": ("f4", 1.0)}
        if message.encoding not in kinds:
            raise ValueError(f"depth images of encoding {message.encoding} are not read; valid are {', '.join(kinds)}")
        kind, scale = kinds[message.encoding]
        kind = np.dtype((">" if message.is_bigendian else "<") + kind)
        rows = np.asarray(message.data, np.uint8)
        if message.step < message.width * kind.itemsize or rows.size < message.step * message.height:
            raise ValueError(f"an image of {message.width} x {message.height} px has {rows.size} bytes, which are too few")
        rows = rows[: message.step * message.height].reshape(message.height, message.step)[:, : message.width * kind.itemsize]
        return scale * np.ascontiguousarray(rows).view(kind).astype(np.float64)
    # The transport puts twelve bytes before the PNG: a kind and, of 32FC1, two numbers of the inverse depth.
    data = np.asarray(message.data, np.uint8)
    image = cv2.imdecode(data[12:], cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim != 2:
        raise ValueError("a compressed depth image is damaged")
    if message.format.startswith("32FC1"):
        a, b = data[4:12].view("<f4")
        with np.errstate(divide="ignore"):
            return np.where(image > 0, a / (image - float(b)), 0.0)
    return 1e-3 * image.astype(np.float64)


def lens_of(message: object) -> Intrinsics:
    K, D = np.asarray(message.k), np.asarray(message.d)
    if message.distortion_model not in ("plumb_bob", "") and D.any():
        raise ValueError(f"a lens of model {message.distortion_model} is not read; valid is plumb_bob")
    model = "brown_conrady" if D.any() else "none"
    return Intrinsics(message.width, message.height, K[0], K[4], K[2], K[5], model, tuple(np.pad(D, (0, 5))[:5].tolist()))


def check_mcap(file: pathlib.Path) -> None:
    """Walks over the records of a file, so that a hole in it, which reads as 10⁸ empty ones, is found at once."""
    footer, chunk = 2, 6
    size, opcode = file.stat().st_size, 1
    with file.open("rb") as records:
        at = records.seek(8)  # after the magic
        while opcode != footer:
            head = records.read(9)
            opcode, length = struct.unpack("<BQ", head) if len(head) == 9 else (0, 0)
            if opcode == chunk:
                # Times, size and checksum; the compression's name; the size of the records; the first one's opcode.
                _, named = struct.unpack("<28sI", records.read(32).ljust(32, b"\0"))
                if named == 0 and length > 40 and records.read(9)[8:] in (b"\0", b""):
                    opcode = 0
            if opcode == 0 or at + 9 + length > size:
                raise ValueError(f"{file} is no ROS 2 bag, or is damaged: there is no valid record at byte {at}")
            at = records.seek(at + 9 + length)


def ros2(bag: pathlib.Path, views: int, base: str | None, topic: str | None, note: Callable[[str], None]) -> Iterator[Seen]:
    """Images are read one at a time, so that a bag may be larger than memory."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise ValueError("rosbags is not installed: pip install 'impedraw[camera]'") from None
    for file in [bag] if bag.suffix == ".mcap" else sorted(bag.glob("*.mcap")):
        check_mcap(file)
    try:
        reader = AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    except Exception as error:  # noqa: BLE001 - rosbags raises its own and those of SQLite, YAML and compressors
        raise ValueError(f"{bag} is no ROS 2 bag, or is damaged: {error}") from None
    try:
        kinds = {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"}
        there = sorted({c.topic for c in reader.connections})
        images = sorted({c.topic for c in reader.connections if c.msgtype in kinds and "depth" in c.topic})
        if topic is None and not images:
            raise ValueError(f"{bag} has no topic with depth images; its topics: {', '.join(there)}")
        topics = [topic] if topic else images
        tree, lenses, frames, counts = Tree(), {}, {}, {t: 0 for t in topics}
        for connection, _, raw in reader.messages([c for c in reader.connections if c.msgtype in (
                "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/CameraInfo")]):  # fmt: skip
            message = reader.deserialize(raw, connection.msgtype)
            if connection.msgtype.endswith("TFMessage"):
                tree.add(message, connection.topic.endswith("tf_static"))
            else:
                lenses[connection.topic] = lens_of(message)
                frames.setdefault(message.header.frame_id, connection.topic)
        for connection in reader.connections:
            if connection.topic in counts:
                counts[connection.topic] += connection.msgcount
        for name in topics:
            if name not in there:
                raise ValueError(f"{bag} has no topic {name}; with depth images: {', '.join(images) or 'none'}")
            info = name.removesuffix("/compressedDepth").rpartition("/")[0] + "/camera_info"
            wanted = set(evenly(counts[name], max(1, views // len(topics))))
            for k, (connection, _, raw) in enumerate(reader.messages([c for c in reader.connections if c.topic == name])):
                if k not in wanted:
                    continue
                message = reader.deserialize(raw, connection.msgtype)
                lens = lenses.get(info) or lenses.get(frames.get(message.header.frame_id, ""))
                if lens is None:
                    raise ValueError(f"{bag}: no camera_info beside {name}; its topics: {', '.join(sorted(lenses)) or 'none'}")
                time, frame = seconds(message.header.stamp), message.header.frame_id.lstrip("/")
                X = tree.between(base, frame, time) if base else None
                if base and X is None:
                    note(f"{name}: no transforms lead from '{base}' to '{frame}' at {time:.3f} s; the view has no pose")
                yield Frame(depth_of(message), None, time), lens, X
    except (ValueError, OSError):
        raise
    except Exception as error:  # noqa: BLE001 - as above, of a message
        raise ValueError(f"{bag} is damaged: {error}") from None
    finally:
        reader.close()
