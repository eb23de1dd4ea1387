"""Cameras that go on after a capture was taken: their depths, into its folder, for a canvas that moves (docs/capture.md)."""

from __future__ import annotations

import collections
import pathlib
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import cv2
import numpy as np

from .folder import LEVELS, Frame

KEPT = 30  # newest frames of a camera that stay
DRIFT = 1e-4  # of a camera's clock, at most
OTHER = 3600.0  # further from this machine's clock, a stamp is by another one, which began at zero some time [s]


class LiveFrames:
    """Writes frames of the camera of ``views[number]``: ``live_<number>_<µs>.png``. A file takes its name once it is whole."""

    def __init__(self, folder: pathlib.Path, number: int, view: dict):
        self.folder, self.number, self.view = pathlib.Path(folder), number, view
        self.kept: collections.deque[pathlib.Path] = collections.deque()

    def add(self, frame: Frame, exposed: float) -> None:
        """exposed: by this machine's clock, time.time() [s]."""
        if frame.depth.shape != (self.view["height"], self.view["width"]):
            raise ValueError(f"a depth image has {frame.depth.shape[1]} x {frame.depth.shape[0]} px, the first one had"
                             f" {self.view['width']} x {self.view['height']}")  # fmt: skip
        values = np.rint(np.nan_to_num(frame.depth, posinf=0.0, neginf=0.0) / self.view["depth_scale"])
        values[(values < 0) | (values > LEVELS)] = 0
        file = self.folder / f"live_{self.number}_{round(1e6 * exposed)}.png"
        part = self.folder / f".live_{self.number}.part"
        part.write_bytes(cv2.imencode(".png", values.astype(np.uint16), [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes())
        part.replace(file)
        self.kept.append(file)
        while len(self.kept) > KEPT:
            self.kept.popleft().unlink(missing_ok=True)

    def remove(self) -> None:
        for file in [*self.kept, self.folder / f".live_{self.number}.part"]:
            file.unlink(missing_ok=True)


class StampClock:
    """A camera's stamps by this machine's clock. As a rule the SDK makes them by that clock already; otherwise the frame that came the
    fastest lately is taken to have come at once. A recording is played as fast as it was taken."""

    def __init__(self, recorded: bool = False):
        self.recorded = recorded
        self.offset: float | None = None  # of this machine's clock, beyond the camera's [s]
        self._last = 0.0

    def exposed(self, stamp: float | None, now: float) -> float:
        if stamp is None:
            return now
        late = now - stamp
        if self.offset is None:
            self.offset = 0.0 if abs(late) < OTHER and not self.recorded else late
        elif self.offset != 0.0 and not self.recorded:
            self.offset = min(self.offset + DRIFT * max(now - self._last, 0.0), late)
        self._last = now
        return stamp + self.offset


def stream(cameras: list[Any], folder: pathlib.Path, views: list[dict], note: Callable[[str], None]) -> bool:
    """Until interrupted, or until no camera gives a frame any more. ``views`` as in capture.json, ``cameras[i]`` gives those of
    ``views[i]``. Returns whether none failed."""
    ends = threading.Event()

    def follow(number: int) -> bool:
        camera, live = cameras[number], LiveFrames(folder, number, views[number])
        clock, count, begun = StampClock(bool(getattr(camera, "recording", None))), 0, time.monotonic()
        try:
            while not ends.is_set() and (frame := camera.frame(color=False)) is not None:
                exposed = clock.exposed(frame.time, time.time())
                time.sleep(max(0.0, exposed - time.time()))  # of a recording
                live.add(frame, exposed)
                count += 1
                if count == 1:
                    note(f"views[{number}] {camera.name} streams; " + (
                        f"its first frame came {1e3 * (time.time() - exposed):.0f} ms after its stamp" if not clock.offset else
                        "its stamps are not by this machine's clock, so that the quickest frame is taken to come at once"))  # fmt: skip
        except (ValueError, OSError) as error:
            note(f"views[{number}]: {error}")
            return False
        finally:
            live.remove()
            note(f"views[{number}] gave {count} frames, {count / max(time.monotonic() - begun, 1e-3):.1f} a second")
        return True

    with ThreadPoolExecutor(len(cameras)) as pool:
        running = [pool.submit(follow, number) for number in range(len(cameras))]
        try:
            return all([each.result() for each in running])
        except KeyboardInterrupt:
            ends.set()
            return all([each.result() for each in running])
