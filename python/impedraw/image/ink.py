"""The tone of ink: what share of each pixel a pen of some width covers."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter

PEN = 8  # its width in the pixels that are painted


def coverage(strokes: list[np.ndarray], shape: tuple[int, int], pen: float) -> np.ndarray:
    """Share of ink, 0 … 1, of each pixel. Strokes: rows x, y [pixels, from the corner of the first]; ``pen``: the line's width [pixels]."""
    height, width = shape
    scale = min(PEN / pen, 8000 / max(shape))
    page = Image.new("L", (max(1, round(width * scale)), max(1, round(height * scale))))
    draw = ImageDraw.Draw(page)
    for stroke in strokes:
        draw.line([tuple(p) for p in (stroke * scale - 0.5).tolist()], fill=255, width=max(1, round(pen * scale)), joint="curve")
    return np.asarray(page.resize((width, height), Image.Resampling.BOX), np.float32) / 255


def blurred(tone: np.ndarray) -> np.ndarray:
    """As seen from afar: over a fiftieth of the longer side."""
    return gaussian_filter(tone, max(tone.shape) / 50, mode="nearest")


def correlation(tone: np.ndarray, inked: np.ndarray) -> float:
    """Of both when blurred; 1 where either is even."""
    a, b = blurred(tone).ravel(), blurred(inked).ravel()
    return float(np.corrcoef(a, b)[0, 1]) if min(a.std(), b.std()) > 1e-6 else 1.0
