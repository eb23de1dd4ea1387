"""RealSense cameras and their recordings, through the SDK (pyrealsense2)."""

from __future__ import annotations

import contextlib
import pathlib
import sqlite3
from collections.abc import Callable
from typing import Any

import numpy as np

from .folder import Frame, Intrinsics

WAIT = 5000  # for one set of frames [ms]
MODELS = {"brown_conrady": "brown_conrady", "inverse_brown_conrady": "inverse_brown_conrady",
          "modified_brown_conrady": "inverse_brown_conrady", "none": "none"}  # fmt: skip


class RealSense:
    """Depth in the depth stream's pixels; colour, if the camera has it, aligned to them. ``recording`` is a file of the
    SDK, .db3 or, of SDKs before 2.58, .bag; ``serial`` names one camera of several."""

    def __init__(self, recording: str | None = None, preset: str | None = None, laser: float | None = None, serial: str | None = None):
        self.recording, self._preset, self._laser, self._serial = recording, preset, laser, serial

    def open(self) -> None:
        try:
            import pyrealsense2
        except ImportError as error:
            raise ValueError(f"RealSense's SDK cannot be loaded ({error}); it needs pip install 'impedraw[camera]', and of Debian"
                             " libusb-1.0-0") from None  # fmt: skip
        self._rs = rs = pyrealsense2
        self._pipeline = rs.pipeline()
        config = rs.config()
        if self.recording:
            rs.config.enable_device_from_file(config, self.recording, repeat_playback=False)
        elif self._serial:
            config.enable_device(self._serial)
        # What is refused is refused before the SDK's thread reads a recording: to end it at once could end the process.
        profile = self._reached(lambda: config.resolve(rs.pipeline_wrapper(self._pipeline)))
        self._read(profile)
        self.duration = 0.0  # of a recording [s]
        self._playback = profile.get_device().as_playback() if self.recording else None
        if self._playback:
            self._playback.set_real_time(False)  # before the thread reads, which leaves out frames in real time
            self.duration = self._playback.get_duration().total_seconds()
        self._reached(lambda: self._pipeline.start(config))

    def _reached(self, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except RuntimeError as error:
            if self.recording:
                raise ValueError(f"{self.recording} is no recording of the RealSense SDK: {error}") from None
            raise ValueError(f"no RealSense camera{f' {self._serial}' if self._serial else ''} answers: {error}; is it plugged in, and does no other program use it?") from None

    def _read(self, profile: Any) -> None:
        rs = self._rs
        device = profile.get_device()
        self.name = device.get_info(rs.camera_info.name) if device.supports(rs.camera_info.name) else "RealSense"
        sensor = device.first_depth_sensor()
        self._set(sensor)
        self._scale = sensor.get_option(rs.option.depth_units) if sensor.supports(rs.option.depth_units) else 1e-3
        streams = {s.stream_type() for s in profile.get_streams()}
        if rs.stream.depth not in streams:
            raise ValueError(f"{self.name} has no depth stream")
        i = profile.get_stream(rs.stream.depth).as_video_stream_profile().get_intrinsics()
        model = MODELS.get(str(i.model).rpartition(".")[2])
        if model is None:
            raise ValueError(f"{self.name}: distortion {i.model} is not known; valid are {', '.join(MODELS)}")
        self.intrinsics = Intrinsics(i.width, i.height, i.fx, i.fy, i.ppx, i.ppy, model, tuple(i.coeffs))
        self._align = rs.align(rs.stream.depth) if rs.stream.color in streams else None

    def _set(self, sensor: object) -> None:
        rs = self._rs
        if self._preset is not None:
            option = rs.option.visual_preset
            names = {}
            if sensor.supports(option):
                limits = sensor.get_option_range(option)
                names = {sensor.get_option_value_description(option, float(v)): float(v)
                         for v in np.arange(limits.min, limits.max + 1)}  # fmt: skip
            if self._preset not in names:
                raise ValueError(f"--preset {self._preset}: {self.name} has {', '.join(names) or 'no presets'}")
            sensor.set_option(option, names[self._preset])
        if self._laser is not None:
            if not sensor.supports(rs.option.laser_power):
                raise ValueError(f"--laser {self._laser:g}: {self.name} has no laser")
            limits = sensor.get_option_range(rs.option.laser_power)
            if not limits.min <= self._laser <= limits.max:
                raise ValueError(f"--laser {self._laser:g}: valid are {limits.min:g} to {limits.max:g} mW")
            sensor.set_option(rs.option.laser_power, self._laser)

    def frame(self, color: bool = True) -> Frame | None:
        """The next one; None at the end of a recording. color: whether it is wanted."""
        rs = self._rs
        try:
            ok, frames = self._pipeline.try_wait_for_frames(WAIT)
        except RuntimeError:
            ok = False
        if not ok:
            if self.recording:
                return None
            raise ValueError(f"{self.name} gave no frame for {WAIT / 1000:g} s")
        if self._align and color:
            frames = self._align.process(frames)
        depth = frames.get_depth_frame()
        image = None
        if color and (seen := frames.get_color_frame()):
            image = np.asanyarray(seen.get_data()).copy()
            if seen.profile.format() in (rs.format.bgr8, rs.format.bgra8):
                image = image[..., 2::-1]
            image = image[..., :3] if image.ndim == 3 and image.shape[2] >= 3 else None
        return Frame(self._scale * np.asanyarray(depth.get_data()).astype(np.float64), image, 1e-3 * depth.get_timestamp())

    def close(self) -> None:
        # A recording that is stopped while the SDK's thread reads from it ends the process about once in a hundred times.
        if self._playback:
            self._playback.pause()
        self._pipeline.stop()


def is_recording(file: pathlib.Path) -> bool:
    """Whether the SDK wrote the file: its topics begin with its devices."""
    if file.suffix != ".db3":
        return file.suffix == ".bag"
    try:
        with contextlib.closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as base:
            return any(name.startswith("/device_") for (name,) in base.execute("select name from topics"))
    except sqlite3.Error:
        return False


def median(frames: list[Frame]) -> Frame:
    """The median of each pixel over the frames that measured it; none where fewer than half of them did."""
    stack = np.stack([np.where(f.depth > 0, f.depth, np.nan) for f in frames])
    measured = np.isfinite(stack).sum(axis=0)
    depth = np.zeros(stack.shape[1:])
    often = 2 * measured >= len(frames)
    depth[often] = np.nanmedian(stack[:, often], axis=0)
    return Frame(depth, frames[-1].color, frames[-1].time)
