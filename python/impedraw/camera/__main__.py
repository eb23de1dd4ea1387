"""The commands ``impedraw calibrate-camera`` and ``impedraw capture``."""

from __future__ import annotations

import argparse
import contextlib
import json
import pathlib
import sys
import time

import numpy as np

from . import importers
from .board import Board
from .folder import CaptureFolder, Frame, Intrinsics, pose_json, pose_of, read_views
from .hand_eye import DEPTH_SIGMA, PIXEL_SIGMA, Calibration, Refused, View, calibrate, pose
from .realsense import RealSense, is_recording, median
from .stream import stream

RAW = argparse.RawDescriptionHelpFormatter


def note(text: str) -> None:
    print(f"impedraw: {text}\n", end="", file=sys.stderr)  # whole lines, whatever thread they come from


def tip_pose(arm: pathlib.Path | None, joints: list[float]) -> np.ndarray:
    import impedraw

    model = impedraw.ArmModel.from_urdf(arm) if arm else impedraw.ArmModel.standard()
    X = model.tip_pose(joints)
    return pose(np.asarray(X.R), np.asarray(X.p))


def view_of(folder: pathlib.Path, number: int, entry: dict, board: Board, arm: pathlib.Path | None, moves: bool) -> View | None:
    """The view as the calibration takes it; None where the board is not seen."""
    name = f"view {number}"
    try:
        image = importers.read_image(folder / entry.get("image", entry.get("color", "")), 0)
        K = np.array([[entry["fx"], 0, entry["cx"]], [0, entry["fy"], entry["cy"]], [0, 0, 1]], float)
        lens = entry.get("distortion", {"model": "none", "coefficients": []})
        if lens["model"] not in ("none", "brown_conrady"):
            raise ValueError(f"distortion {lens['model']} is not read here; valid are none and brown_conrady")
        X_WE = np.eye(4)
        if moves:
            if "X_WE" in entry:
                X_WE = pose_of(entry["X_WE"])
            elif "joints" in entry:
                X_WE = tip_pose(arm, entry["joints"])
            else:
                raise ValueError("the arm's 'joints' or the tip's pose 'X_WE' must be there")
        seen = board.find(image)
        if seen is None:
            note(f"{name}: the board is not seen; left out")
            return None
        points, pixels = seen
        depths, sigma = None, DEPTH_SIGMA
        if "depth" in entry:
            depth = importers.read_image(folder / entry["depth"], -1).astype(float) * entry.get("depth_scale", 1e-3)
            if depth.shape != image.shape:
                raise ValueError("image and depth differ in size; valid is depth that is aligned to the image")
            depths = np.full(len(points), np.nan)
            for k, (x, y) in enumerate(np.rint(pixels).astype(int)):
                around = depth[max(y - 2, 0) : y + 3, max(x - 2, 0) : x + 3]
                if (around > 0).mean() > 0.6:
                    depths[k] = np.median(around[around > 0])
            sigma = max(DEPTH_SIGMA, entry.get("noise", {}).get("sigma_at_1m", 0.0) * float(np.nanmedian(depths)) ** 2
                        if np.isfinite(depths).any() else 0.0)  # fmt: skip
        return View(name, X_WE, points, pixels, K, np.asarray([*lens["coefficients"]] or [0.0] * 5, float), depths, sigma)
    except KeyError as error:
        raise ValueError(f"{folder / 'capture.json'}: {name} lacks {error}") from None
    except (TypeError, ValueError) as error:
        raise ValueError(f"{folder / 'capture.json'}: {name}: {error}") from None


def touches_of(file: pathlib.Path) -> tuple[np.ndarray, np.ndarray]:
    try:
        found = json.loads(file.read_text())["page touches"]
        corners = np.array([(*t["mark"], 0.0)[:3] for t in found], float)
        return corners, np.array([t["p_WE"] for t in found], float)
    except (OSError, ValueError, KeyError, TypeError):
        raise ValueError(f"{file} has no touches of marks; ./impedraw arm touch --mark X,Y notes them (X, Y: a corner of the board in m)") from None


def printed(found: Calibration, camera: str, views: int) -> str:
    sigma = np.sqrt(np.diag(found.covariance))
    p = found.A[:3, 3]
    rows = [
        f"views      {views} used, {len(found.left_out)} left out",
        f"corners    {found.pixel_rms:.2f} px RMS, {1e3 * found.pixel_rms * found.distance / found.focal:.2f} mm at the board ({found.distance:.2f} m away)",
    ]
    if np.isfinite(found.depth_rms):
        rows.append(f"depth      {1e3 * found.depth_rms:.2f} mm RMS")
    if np.isfinite(found.touch_rms):
        rows.append(f"touches    {1e3 * found.touch_rms:.2f} mm RMS")
    rows += [
        f"{'X_WC' if camera == 'fixed' else 'X_EC'}       ({p[0]:.4f}, {p[1]:.4f}, {p[2]:.4f}) ± ({', '.join(f'{1e3 * s:.2f}' for s in sigma[3:])}) mm,"
        f" turned ± ({', '.join(f'{np.degrees(s):.3f}' for s in sigma[:3])})°",
        f"canvas     a point at the board's distance is known to ± {1e3 * found.at_canvas:.2f} mm",
    ]  # fmt: skip
    rows += [f"left out   {text}" for text in found.left_out]
    if found.alike:
        rows.append("too alike  " + ", ".join(f"{a} and {b}" for a, b in found.alike[:6]) + (" …" if len(found.alike) > 6 else ""))
    return "\n".join(rows)


def run_calibrate(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="impedraw calibrate-camera", formatter_class=RAW,
        description="Find where a camera stands, or how it sits on the tool, from images of a board (docs/commissioning.md).",
        epilog="FOLDER is a capture (docs/capture.md) whose views have colour or grey images ('color', or 'image'), 'joints' (or the tip's\n"
        "pose 'X_WE'), and no poses of the camera yet. 10 to 20 views, tilted to all sides, are good.\n\nExamples:\n"
        "  impedraw calibrate-camera --print-board board.png --board charuco:7x5:40:30\n"
        "  impedraw calibrate-camera views --board charuco:7x5:40:30                       # the arm holds the board\n"
        "  impedraw calibrate-camera views --camera tool --board-on table --board apriltag:6x4:40:30\n"
        "  impedraw calibrate-camera views --board-on table --touches commissioning/commissioning.json\n"
        "  impedraw capture import rgbd --into capture --calibration commissioning")  # fmt: skip
    parser.add_argument("folder", nargs="?", type=pathlib.Path)
    parser.add_argument("--board", type=Board.parse, required=True, help="KIND:COLUMNSxROWS:SQUARE:MARKER [mm], KIND charuco or apriltag")
    parser.add_argument("--camera", choices=["fixed", "tool"], default="fixed", help="where the camera is (default: fixed)")
    parser.add_argument("--board-on", choices=["tool", "table"], help="where the board is (default: where the camera is not)")
    parser.add_argument("--arm", type=pathlib.Path, help="URDF with the frame tip (default: the standard arm)")
    parser.add_argument("--touches", type=pathlib.Path, help="file of ./impedraw arm touch: corners of a board on the table, touched by the pen")
    parser.add_argument("--pixel-sigma", type=float, default=PIXEL_SIGMA, help=f"of a detected corner [px] (default: {PIXEL_SIGMA})")
    parser.add_argument("--into", type=pathlib.Path, default=pathlib.Path("commissioning"), help="folder of the result (default: commissioning)")
    parser.add_argument("--print-board", type=pathlib.Path, metavar="PNG", help="write the board as a picture of 12 px a mm, to be printed, and stop")
    options = parser.parse_args(arguments)
    if options.print_board:
        options.board.print_to(options.print_board)
        board = options.board
        print(f"{options.print_board}: print it {1e3 * board.width(board.columns):g} mm wide, flat on a plate, and measure a square")
        return 0
    if options.folder is None:
        parser.error("FOLDER is missing: the views of the board")
    if not options.pixel_sigma > 0:
        parser.error(f"--pixel-sigma {options.pixel_sigma:g}: valid are numbers above 0")
    on = options.board_on or ("table" if options.camera == "tool" else "tool")
    moves = options.camera == "tool" or on == "tool"
    entries = read_views(options.folder)
    views = [view_of(options.folder, n, e, options.board, options.arm, moves) for n, e in enumerate(entries, 1)]
    seen = [v for v in views if v is not None]
    touches = touches_of(options.touches) if options.touches else None
    found = calibrate(seen, options.camera, "tool" if on == "tool" else "fixed", touches, options.pixel_sigma)
    print(printed(found, options.camera, len(seen) - len(found.left_out)))
    file = options.into / "commissioning.json"
    whole = json.loads(file.read_text()) if file.exists() else {}
    whole["camera"] = {"X_WC" if options.camera == "fixed" else "X_EC": pose_json(found.A), "pixel_rms": found.pixel_rms,
                       "deviation_at_canvas_m": found.at_canvas, "covariance": found.covariance.tolist()}  # fmt: skip
    options.into.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(json.dumps(whole, indent=2) + "\n")
    part.replace(file)
    print(f"written to {file}; 'impedraw capture … --calibration {options.into}' takes it")
    return 0


def camera_pose(folder: pathlib.Path | None) -> dict:
    """X_WC or X_EC as calibrate-camera found it."""
    if folder is None:
        return {}
    try:
        found = json.loads((folder / "commissioning.json").read_text())["camera"]
        return {k: found[k] for k in ("X_WC", "X_EC") if k in found}
    except (OSError, ValueError, KeyError):
        raise ValueError(f"--calibration {folder}: holds no camera; impedraw calibrate-camera finds it") from None


def six(text: str) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    values = [float(x) for x in text.split(",")]
    if len(values) != 6 or not np.isfinite(values).all():
        raise ValueError
    return pose(Rotation.from_euler("xyz", values[3:], degrees=True).as_matrix(), np.asarray(values[:3]))


def four(text: str) -> list[float]:
    values = [float(x) for x in text.split(",")]
    if len(values) != 4 or not np.isfinite(values).all() or min(values) <= 0:
        raise ValueError
    return values


def run_import(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="impedraw capture import", formatter_class=RAW, description="Make a capture of what a camera recorded.",
        epilog="SOURCE is an RGB-D folder in TUM's layout (depth.txt, rgb.txt, groundtruth.txt) or Redwood's (depth_*.png, trajectory.log), a ROS 2\n"
        "bag (.mcap, .db3, or its folder), or a recording of the RealSense SDK (.db3, .bag). Poses come from the recording, or from --calibration.\n\nExamples:\n"
        "  impedraw capture import rgbd_dataset_freiburg1_xyz --into capture --views 5\n"
        "  impedraw capture import scan.mcap --into capture --base base_link\n"
        "  impedraw capture import d405.db3 --into capture --calibration commissioning\n"
        "  impedraw draw --set perception.source=capture --set perception.capture=capture")  # fmt: skip
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("--into", type=pathlib.Path, required=True, help="folder of the capture")
    parser.add_argument("--overwrite", action="store_true", help="replace the capture in that folder")
    parser.add_argument("--views", type=int, default=3, help="how many, spread over the recording (default: 3)")
    parser.add_argument("--base", help="ROS 2: frame that stands for W, the arm's base")
    parser.add_argument("--topic", help="ROS 2: of the depth images (default: all that have 'depth' in their name)")
    parser.add_argument("--intrinsics", type=four, metavar="FX,FY,CX,CY", help="TUM, Redwood: of the camera [px]")
    parser.add_argument("--size", type=lambda s: [int(n) for n in s.split("x", 1)], default=[640, 480], metavar="WxH", help="of its images [px] (default: 640x480)")
    parser.add_argument("--world", type=six, metavar="X,Y,Z,ROLL,PITCH,YAW", help="pose in W of the recording's own world [m, degrees]")
    parser.add_argument("--calibration", type=pathlib.Path, help="folder that calibrate-camera wrote the camera's pose to")
    options = parser.parse_args(arguments)
    if options.views < 1:
        parser.error(f"--views {options.views}: valid are numbers from 1")
    source, known = options.source, camera_pose(options.calibration)
    lens = options.intrinsics and Intrinsics(*options.size, *options.intrinsics)
    if (source / "depth.txt").exists():
        seen = importers.tum(source, options.views, lens, note)
    elif (source / "trajectory.log").exists():
        seen = importers.redwood(source, options.views, lens, note)
    elif source.is_file() and is_recording(source):
        seen = importers.realsense(source, options.views, note)
    elif source.exists():
        seen = importers.ros2(source, options.views, options.base, options.topic, note)
    else:
        raise ValueError(f"{source} does not exist; valid is a folder in TUM's or Redwood's layout, a ROS 2 bag, or a RealSense recording")
    with CaptureFolder(options.into, options.overwrite) as folder:
        for frame, lens, X in seen:
            where = dict(known)
            if not where and X is not None:
                where = {"X_WC": pose_json((np.eye(4) if options.world is None else options.world) @ X)}
            if not where:
                note(f"view {len(folder.views) + 1} has no pose of its camera; --calibration, --base or groundtruth.txt would tell it")
            folder.add(lens, frame, **where)
            print(f"view {len(folder.views)}  {int((frame.depth > 0).sum())} of {frame.depth.size} px measured", flush=True)
    print(f"{len(folder.views)} views in {options.into}")
    return 0


def numbers(text: str) -> list[float]:
    values = [float(x) for x in text.split(",")]
    if not np.isfinite(values).all():
        raise ValueError(f"'{text}': valid are finite numbers between commas")
    return values


def taken(camera: object, count: int) -> Frame | None:
    """The median of the next images; None at the end of a recording."""
    frames, begun = [], time.monotonic()
    while len(frames) < count and (frame := camera.frame()) is not None:
        frames.append(frame)
        if time.monotonic() - begun > 2 and sys.stderr.isatty():
            print(f"\r{len(frames)} of {count} images ", end="", file=sys.stderr)
    return median(frames) if frames else None


def run_capture(arguments: list[str]) -> int:
    if arguments[:1] == ["import"]:
        return run_import(arguments[1:])
    parser = argparse.ArgumentParser(
        prog="impedraw capture", formatter_class=RAW,
        description="Take a capture with a camera that is plugged in, or import a recording ('impedraw capture import --help').",
        epilog="Each view is the median of --frames images. With --views more than one, the program waits for the enter key before each,\n"
        "or, with --ask-joints, for the arm's joints there. Several cameras each give one, or, with --stream, all that they see.\n\nExamples:\n"
        "  impedraw capture --camera realsense --into capture --calibration commissioning\n"
        "  impedraw capture --camera realsense --into /dev/shm/eyes --calibration commissioning --stream\n"
        "  impedraw capture --camera realsense --views 15 --ask-joints --into views\n"
        "  impedraw capture import d405.db3 --into capture --calibration commissioning")  # fmt: skip
    parser.add_argument("--camera", action="append", type=serial_of, metavar="realsense[:SERIAL]", help="once for each camera (default: realsense)")
    parser.add_argument("--recording", action="append", help="a file of the SDK in place of a camera, once for each")
    parser.add_argument("--into", type=pathlib.Path, required=True, help="folder of the capture")
    parser.add_argument("--overwrite", action="store_true", help="replace the capture in that folder")
    parser.add_argument("--frames", type=int, default=15, help="images of a view, of which the median is taken (default: 15)")
    parser.add_argument("--views", type=int, default=1, help="how many, one each time enter is pressed (default: 1)")
    parser.add_argument("--preset", help="of the camera, as in 'High Accuracy'")
    parser.add_argument("--laser", type=float, help="power of the camera's projector [mW]")
    parser.add_argument("--calibration", action="append", type=pathlib.Path, help="folder that calibrate-camera wrote the camera's pose to, once for each camera")
    parser.add_argument("--stream", action="store_true", help="go on until interrupted: keep the newest images in the folder, for a canvas that moves while it is drawn on")
    parser.add_argument("--joints", type=numbers, metavar="Q1,Q2,…", help="the arm's joints while it stands [rad]")
    parser.add_argument("--ask-joints", action="store_true", help="ask for the arm's joints at each view")
    options = parser.parse_args(arguments)
    if options.frames < 1 or options.views < 1:
        parser.error("--frames and --views: valid are numbers from 1")
    if options.stream and options.views > 1:
        parser.error("--stream: its cameras stand; valid is --views 1")
    sources = [{"recording": file} for file in options.recording or []] or [{"serial": serial} for serial in options.camera or [None]]
    known = [camera_pose(folder) for folder in options.calibration or [None] * len(sources)]
    if len(known) != len(sources):
        parser.error(f"--calibration: given {len(known)} times for {len(sources)} cameras; valid is once for each, in their order")
    if options.stream and any("X_WC" not in pose for pose in known):
        parser.error("--stream: valid are cameras that stand, where calibrate-camera found: a --calibration with X_WC for each")
    cameras = [RealSense(preset=options.preset, laser=options.laser, **source) for source in sources]
    with contextlib.ExitStack() as opened:
        with CaptureFolder(options.into, options.overwrite) as folder:
            for camera in cameras:
                camera.open()
                opened.callback(camera.close)
            take(cameras, known, folder, options)
        print(f"{len(folder.views)} views in {options.into}", flush=True)
        return int(options.stream and not stream(cameras, options.into, folder.views, note))


def take(cameras: list[RealSense], known: list[dict], folder: CaptureFolder, options: argparse.Namespace) -> None:
    for number in range(1, options.views + 1):
        joints = options.joints
        if options.ask_joints:
            joints = numbers(input(f"view {number}: the arm's joints [rad], between commas: "))
        elif options.views > 1:
            input(f"view {number} of {options.views}: enter takes it ")
        for camera, pose in zip(cameras, known):
            frame = taken(camera, options.frames)
            if frame is None:
                note(f"the recording ended before view {number}")
                return
            frame.time = None if options.stream else frame.time  # of before any run
            folder.add(camera.intrinsics, frame, joints=joints, **pose)
            print(f"view {number}  {camera.name}, {int((frame.depth > 0).sum())} of {frame.depth.size} px measured")


def serial_of(text: str) -> str | None:
    kind, _, serial = text.partition(":")
    if kind != "realsense":
        raise argparse.ArgumentTypeError(f"{text}: valid are realsense and realsense:SERIAL")
    return serial or None


COMMANDS = {"calibrate-camera": run_calibrate, "capture": run_capture}


def main(arguments: list[str] | None = None) -> int:
    first, *rest = sys.argv[1:] if arguments is None else arguments
    try:
        return COMMANDS[first](rest)
    except Refused as error:
        note(f"refused: {error}")
        return 1
    except (ValueError, OSError) as error:
        note(str(error))
        return 2
    except KeyboardInterrupt:
        note("interrupted; nothing is written")
        return 130


if __name__ == "__main__":
    sys.exit(main())
