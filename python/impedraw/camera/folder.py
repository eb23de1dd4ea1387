"""Writes a capture (docs/capture.md): depth images and capture.json."""

from __future__ import annotations

import dataclasses
import json
import pathlib
import shutil
import tempfile

import cv2
import numpy as np

FORMAT = {"format": "impedraw-capture", "version": 1}
LEVELS = 65535


@dataclasses.dataclass
class Intrinsics:
    """Pixel (0, 0) is the centre of the top-left one; colour images have been aligned to depth."""

    width: int
    height: int
    fx: float  # [px]
    fy: float
    cx: float
    cy: float
    model: str = "none"  # "brown_conrady" (ideal to distorted), or "inverse_brown_conrady"
    coefficients: tuple[float, ...] = ()  # k1, k2, p1, p2, k3

    def json(self) -> dict:
        found = {k: getattr(self, k) for k in ("width", "height", "fx", "fy", "cx", "cy")}
        if self.model != "none" and any(self.coefficients):
            found["distortion"] = {"model": self.model, "coefficients": list(self.coefficients)}
        return found


@dataclasses.dataclass
class Frame:
    depth: np.ndarray  # along z_C, 0 or NaN where nothing was measured, (height, width) [m]
    color: np.ndarray | None = None  # RGB, (height, width, 3), 8 bits
    time: float | None = None  # of the exposure [s]


class CaptureFolder:
    """``with CaptureFolder(folder) as capture: capture.add(…)``. Views are gathered in a folder beside it, which takes its
    place when the block ends, and goes when it fails. A capture that is there is replaced only if asked."""

    def __init__(self, folder: pathlib.Path, overwrite: bool = False):
        self.folder = pathlib.Path(folder)
        if (self.folder / "capture.json").exists():
            if not overwrite:
                raise ValueError(f"{self.folder} holds a capture; valid are another folder, or --overwrite")
        elif self.folder.exists() and (not self.folder.is_dir() or any(self.folder.iterdir())):
            raise ValueError(f"{self.folder} is not empty and holds no capture; valid is another folder")
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        self.part = pathlib.Path(tempfile.mkdtemp(prefix=f".{self.folder.name}-", dir=self.folder.parent))
        self.views: list[dict] = []

    def __enter__(self) -> CaptureFolder:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            if kind is None:
                if not self.views:
                    raise ValueError("no view was taken; nothing is written")
                (self.part / "capture.json").write_text(json.dumps({**FORMAT, "views": self.views}, indent=1) + "\n")
                shutil.rmtree(self.folder, ignore_errors=True)
                self.part.chmod(0o755)
                self.part.rename(self.folder)
        finally:
            shutil.rmtree(self.part, ignore_errors=True)

    def add(self, intrinsics: Intrinsics, frame: Frame, **more: object) -> None:
        """more: X_WC, X_EC (see pose_json), joints [rad], noise. Depths are rounded to 0.1 mm, more coarsely beyond 6.5 m."""
        if frame.depth.shape != (intrinsics.height, intrinsics.width):
            raise ValueError(f"a depth image of {frame.depth.shape[1]} x {frame.depth.shape[0]} px is not the camera's"
                             f" {intrinsics.width} x {intrinsics.height}")  # fmt: skip
        depth = np.nan_to_num(frame.depth, posinf=0.0, neginf=0.0)
        if not (depth > 0).any():
            raise ValueError(f"view {len(self.views) + 1} has no measured depth")
        scale = max(1e-4, float(depth.max()) / LEVELS)
        index = len(self.views)
        view = {"depth": f"depth_{index}.png", "depth_scale": scale, **intrinsics.json()}
        self._write(view["depth"], np.clip(np.rint(depth / scale), 0, LEVELS).astype(np.uint16))
        if frame.color is not None:
            view["color"] = f"color_{index}.png"
            self._write(view["color"], frame.color[..., ::-1])
        if frame.time is not None:
            view["time"] = frame.time
        self.views.append({**view, **{k: v for k, v in more.items() if v is not None}})

    def _write(self, name: str, image: np.ndarray) -> None:
        if not cv2.imwrite(str(self.part / name), image):
            raise OSError(f"{self.part / name} cannot be written")


def pose_json(X: np.ndarray) -> dict:
    from .hand_eye import quaternion_wxyz

    return {"p": X[:3, 3].tolist(), "q_wxyz": quaternion_wxyz(X)}


def pose_of(value: dict) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    from .hand_eye import pose

    return pose(Rotation.from_quat(np.roll(value["q_wxyz"], -1)).as_matrix(), np.asarray(value["p"], float))


def read_views(folder: pathlib.Path) -> list[dict]:
    """The views of a capture whose poses may be missing yet."""
    file = pathlib.Path(folder) / "capture.json"
    try:
        found = json.loads(file.read_text())
        if found.get("format") != FORMAT["format"] or not isinstance(found.get("views"), list) or not found["views"]:
            raise ValueError("it has no list of views of the format impedraw-capture")
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror}; valid is the folder of a capture (docs/capture.md)") from None
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None
    return found["views"]
