"""Tone as lines of one width. Lengths are in pixels, tone is height × width; strokes are rows of x, y."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates
from skimage.graph import MCP_Geometric
from skimage.measure import find_contours

from .ink import blurred, coverage
from .stipple import stipples, tour

Progress = Callable[[float], None]
STYLES = ("stipple", "hatch", "cross-hatch", "flow", "contour")
FAINTEST = 0.02  # tone that is left white
LEVELS = 8  # of tone that parallel lines show: line i is drawn where the tone is above its threshold
MOST = {"stipple": 4.0, "hatch": 1.0, "cross-hatch": 1.0, "flow": 2.5, "contour": 1.5}  # tone that a correction may ask for
ROUNDS = 3  # of drawing, measuring and correcting


def parallels(tone: np.ndarray, pen: float, degrees: float) -> list[np.ndarray]:
    """Lines one pen apart, so that black is full. Thresholds of the lines are bit-reversed (van der Corput), for an even spread."""
    along = np.array([math.cos(math.radians(degrees)), -math.sin(math.radians(degrees))])
    across = np.array([-along[1], along[0]])
    middle = np.array(tone.shape[::-1]) / 2
    reach = np.linalg.norm(middle)
    s = np.arange(-reach, reach, 0.5)
    strokes = []
    for i in range(-int(reach / pen), int(reach / pen) + 1):
        line = middle + i * pen * across + s[:, None] * along
        bits = int(f"{i % LEVELS:03b}"[::-1], 2)
        level = map_coordinates(tone, line.T[::-1] - 0.5, order=1, mode="nearest")
        inside = ((line >= 0) & (line <= 2 * middle)).all(1)
        on = np.concatenate([[False], inside & (level > (bits + 0.5) / LEVELS), [False]])
        edges = np.flatnonzero(on[1:] != on[:-1]).reshape(-1, 2)
        strokes += [line[[a, b - 1]] for a, b in edges if s[b - 1] - s[a] >= pen]
    return strokes


def hatch(tone: np.ndarray, pen: float, degrees: float, crossed: bool) -> list[np.ndarray]:
    """Crossed: up to four directions, each up to three tenths of what the ones before left white; the last takes the rest."""
    if not crossed:
        return parallels(tone, pen, degrees)
    strokes, left = [], np.clip(tone, 0, 1)
    for turn in (0, 90, 45, 135):
        share = np.minimum(left, 0.3) if turn != 135 else left
        strokes += parallels(share, pen, degrees + turn)
        left = (left - share) / np.maximum(1 - share, 1e-6)
    return strokes


def flow(tone: np.ndarray, pen: float, rng: np.random.Generator) -> list[np.ndarray]:
    """Lines along the picture's edges (the structure tensor's smaller eigenvector), pen / tone apart (after Jobard and Lefer, 1997)."""
    smooth = max(tone.shape) / 100
    gy, gx = np.gradient(gaussian_filter(tone, smooth / 3))
    xx, xy, yy = (gaussian_filter(g, smooth) + 0.02 * gaussian_filter(g, 6 * smooth) for g in (gx * gx, gx * gy, gy * gy))
    angle = 0.5 * np.arctan2(2 * xy, xx - yy) + math.pi / 2
    ux, uy = np.cos(angle).tolist(), np.sin(angle).tolist()
    apart = pen / np.clip(tone, FAINTEST, None)
    height, width = tone.shape
    far = int(apart.max()) + 1
    fine = 2  # cells a pixel, of where no line may come
    taken = np.zeros(((height + 2 * far) * fine, (width + 2 * far) * fine), bool)
    discs = []
    for radius in range(far * fine + 1):
        k = np.arange(-radius, radius + 1)
        discs.append(k[:, None] ** 2 + k**2 <= radius**2)
    gaps, drawn = apart.tolist(), (tone > FAINTEST).tolist()

    def take(x: float, y: float) -> None:
        radius = max(1, int(0.75 * gaps[min(int(y), height - 1)][min(int(x), width - 1)] * fine))
        i, j = int((y + far) * fine), int((x + far) * fine)
        taken[i - radius : i + radius + 1, j - radius : j + radius + 1] |= discs[radius]

    def grow(x: float, y: float, sign: float) -> list[tuple[float, float]]:
        line, own, dx, dy = [], 0, 0.0, 0.0
        for _ in range(4 * (height + width)):
            i, j = int(y), int(x)
            if not (0 <= x < width and 0 <= y < height) or not drawn[i][j] or taken[int((y + far) * fine), int((x + far) * fine)]:
                break
            line.append((x, y))
            vx, vy = ux[i][j], uy[i][j]
            if (vx * dx + vy * dy if line[1:] else sign) < 0:
                vx, vy = -vx, -vy
            if line[1:] and vx * dx + vy * dy < 0.3:
                break
            dx, dy = vx, vy
            x, y = x + dx, y + dy
            # What lies far enough behind is taken, so that a line does not meet itself.
            while len(line) - own > 3 * gaps[i][j] + 3:
                ends.append(line[own])
                take(*line[own])
                own += 1
        return line

    strokes = []
    rows, columns = np.nonzero(tone > FAINTEST)
    order = np.argsort(-tone[rows, columns] + 0.3 * rng.random(len(rows)), kind="stable")
    for i, j in zip(rows[order].tolist(), columns[order].tolist()):
        if taken[(i + far) * fine + 1, (j + far) * fine + 1]:
            continue
        ends: list[tuple[float, float]] = []
        x, y = j + 0.5, i + 0.5
        ahead, back = grow(x, y, 1.0), grow(x, y, -1.0)
        line = back[:0:-1] + ahead
        for p in line[::2]:
            take(*p)
        if len(line) >= max(6, 4 * pen):
            strokes.append(np.array(line))
    return strokes


def contour(tone: np.ndarray, pen: float) -> list[np.ndarray]:
    """Level lines of T with |∇T| = tone (the eikonal equation), one pen apart in T, so that they lie pen / tone apart."""
    seen = blurred(tone)
    start = np.unravel_index(np.argmax(seen), seen.shape)
    T = MCP_Geometric(np.maximum(tone, FAINTEST).astype(float)).find_costs([start])[0]
    T = gaussian_filter(T, 1.0)
    strokes = []
    for level in np.arange(0.5, T.max() / pen) * pen:
        strokes += [line[:, ::-1] + 0.5 for line in find_contours(T, level) if len(line) > 4]
    return strokes


def strokes_of(tone: np.ndarray, style: str, pen: float, points: int, degrees: float, seed: int, progress: Progress) -> list[np.ndarray]:
    """Lines whose ink, measured and seen from afar, has the picture's tone."""
    wanted, given = blurred(tone), np.where(tone > FAINTEST, tone, 0).astype(float)
    best, least = [], math.inf
    for turn in range(ROUNDS):
        rng = np.random.default_rng(seed)
        share = lambda s, turn=turn: progress((turn + s) / ROUNDS)  # noqa: E731
        if style == "stipple":
            made = [tour(stipples(given**2, points, rng, share))]
        elif style == "flow":
            made = flow(given, pen, rng)
        elif style == "contour":
            made = contour(given, pen)
        else:
            made = hatch(given, pen, degrees, style == "cross-hatch")
        share(1.0)
        if not made:
            break
        inked = blurred(coverage(made, tone.shape, pen))
        # A number of points gives an amount of ink; elsewhere the tone itself is asked for.
        amount = wanted.sum() / max(inked.sum(), 1e-9) if style == "stipple" else 1.0
        error = float(((amount * inked - wanted) ** 2).mean())
        if error < least:
            best, least = made, error
        given = np.clip(given * np.clip(wanted / np.maximum(amount * inked, 0.01), 0.6, 1.7), 0, MOST[style])
    return best
