"""Calibration boards, and their corners in images.

The board's frame B has its origin at the corner of the pattern's first square, x along its rows, y along its columns,
z into the board (OpenCV's).
"""

from __future__ import annotations

import dataclasses
import pathlib

import cv2
import numpy as np

KINDS = {"charuco": "DICT_5X5_100", "apriltag": "DICT_APRILTAG_36h11"}
LEAST_CORNERS = 8


@dataclasses.dataclass
class Board:
    kind: str
    columns: int
    rows: int
    square: float  # edge of a square, or of a tag and the gap after it [m]
    marker: float  # edge of a marker [m]

    @classmethod
    def parse(cls, text: str) -> Board:
        """As in charuco:7x5:40:30, with the edges of squares and markers in mm."""
        try:
            kind, size, square, marker = text.split(":")
            columns, rows = (int(n) for n in size.split("x"))
            board = cls(kind, columns, rows, 1e-3 * float(square), 1e-3 * float(marker))
            if kind not in KINDS or not (2 <= columns <= 40 and 2 <= rows <= 40 and 0 < board.marker < board.square < 1):
                raise ValueError
        except ValueError:
            raise ValueError(
                f"board '{text}' is not known; valid is KIND:COLUMNSxROWS:SQUARE:MARKER with KIND charuco or apriltag,"
                " 2 to 40 columns and rows, and edges in mm of which the marker's is the smaller, as in charuco:7x5:40:30"
            ) from None  # fmt: skip
        board.pattern()
        return board

    def pattern(self) -> cv2.aruco.Board:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, KINDS[self.kind]))
        markers = self.columns * self.rows // (2 if self.kind == "charuco" else 1)
        if markers > len(dictionary.bytesList):
            raise ValueError(f"a board of {markers} markers is too large; valid are at most {len(dictionary.bytesList)}")
        size = (self.columns, self.rows)
        if self.kind == "charuco":
            return cv2.aruco.CharucoBoard(size, self.square, self.marker, dictionary)
        return cv2.aruco.GridBoard(size, self.marker, self.square - self.marker, dictionary)

    def find(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Corners in B, (n, 3) [m], and in the image, (n, 2) [px]; None where too few are seen."""
        if self.kind == "charuco":
            pixels, ids, _, _ = cv2.aruco.CharucoDetector(self.pattern()).detectBoard(image)
            if ids is None or len(ids) < LEAST_CORNERS:
                return None
            points = np.asarray(self.pattern().getChessboardCorners())[ids.ravel()]
        else:
            settings = cv2.aruco.DetectorParameters()
            settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
            markers, ids, _ = cv2.aruco.ArucoDetector(self.pattern().getDictionary(), settings).detectMarkers(image)
            if ids is None or 4 * len(ids) < LEAST_CORNERS:
                return None
            points, pixels = self.pattern().matchImagePoints(markers, ids)
            if points is None or len(points) < LEAST_CORNERS:
                return None
        return np.reshape(points, (-1, 3)).astype(float), np.reshape(pixels, (-1, 2)).astype(float)

    def width(self, count: int) -> float:
        """Of so many columns, or rows [m]."""
        return count * self.square - (0.0 if self.kind == "charuco" else self.square - self.marker)

    def picture(self, pixels_per_mm: int) -> np.ndarray:
        size = [round(1e3 * self.width(n) * pixels_per_mm) for n in (self.columns, self.rows)]
        return self.pattern().generateImage(size, marginSize=0)

    def print_to(self, file: pathlib.Path, pixels_per_mm: int = 12) -> None:
        """Writes the board as a picture, to be printed at its true size."""
        if not cv2.imwrite(str(file), self.picture(pixels_per_mm)):
            raise ValueError(f"{file} cannot be written; valid is the name of a .png file in a folder that exists")
