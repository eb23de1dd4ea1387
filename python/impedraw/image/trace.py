"""Centre lines of what is drawn, with widths: a skeleton without spurs, led straight through crossings, and smoothed."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Iterable

import numpy as np
from scipy import ndimage
from skimage.filters import threshold_otsu
from skimage.morphology import remove_small_objects, skeletonize

SPUR = 1.6  # a free branch up to so many half widths long is a corner of the outline
SLOPE = 0.5  # a free end along which the half width grows faster leads to a corner of the outline, where it grows by √½
STEP = 4  # over so many pixels
THROUGH = -0.5  # two branches are one line through a crossing where the cosine between them is below
Point = tuple[int, int]


def ink_of(tone: np.ndarray, times: int) -> np.ndarray:
    """What is drawn, at ``times`` the resolution: darker than the paper around, whose shade may change."""
    small = ndimage.zoom(tone, 0.125, order=1) if min(tone.shape) >= 64 else tone
    paper = ndimage.gaussian_filter(ndimage.grey_opening(small, max(3, min(small.shape) // 4)), max(small.shape) / 16)
    paper = ndimage.zoom(paper, [a / b for a, b in zip(tone.shape, paper.shape)], order=1) if paper.shape != tone.shape else paper
    level = tone - paper
    if np.ptp(level) < 0.1:
        return np.zeros([times * side for side in tone.shape], bool)
    level = ndimage.zoom(level, times, order=1, grid_mode=True, mode="nearest")
    return remove_small_objects(level > threshold_otsu(level), max_size=4 * times**2)


def ink_on_white(tone: np.ndarray) -> np.ndarray:
    """What a rendering shows on white paper, in any colour: pixels that are covered by half, next to ones that are covered whole."""
    return (tone > 0.02) & (tone > 0.5 * ndimage.maximum_filter(tone, 3))


def _neighbours(mask: np.ndarray) -> dict[Point, list[Point]]:
    """Of each pixel of a skeleton; over a corner only where no pixel beside it leads there."""
    pixels = set(zip(*(k.tolist() for k in np.nonzero(mask))))
    found = {}
    for i, j in pixels:
        near = [(i + a, j + b) for a, b in ((0, 1), (1, 0), (0, -1), (-1, 0)) if (i + a, j + b) in pixels]
        near += [(i + a, j + b) for a in (-1, 1) for b in (-1, 1) if (i + a, j + b) in pixels and (i + a, j) not in pixels and (i, j + b) not in pixels]
        found[i, j] = near
    return found


def _branches(near: dict[Point, list[Point]]) -> list[list[Point]]:
    """Runs of pixels between ends and junctions, both included; a ring's first pixel is its last."""
    branches, seen = [], set()

    def walk(start: Point, second: Point) -> list[Point]:
        line = [start, second]
        while len(near[line[-1]]) == 2:
            seen.add(line[-1])
            one, other = near[line[-1]]
            line.append(other if one == line[-2] else one)
            if line[-1] == start:
                break
        return line

    for pixel, around in near.items():
        if len(around) == 2:
            continue
        if not around:
            branches.append([pixel])
        for second in around:
            if second not in seen and (len(near[second]) == 2 or pixel < second):
                branches.append(walk(pixel, second))
    for pixel, around in near.items():
        if len(around) == 2 and pixel not in seen:
            seen.add(pixel)
            branches.append(walk(pixel, around[0]))
    return branches


def _length(line: Iterable) -> float:
    a = np.array(line, float)
    return float(np.linalg.norm(np.diff(a, axis=0), axis=1).sum())


def _skeleton(ink: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Without the spurs towards corners of the outline."""
    mask = skeletonize(ink)
    for _ in range(4):
        near = _neighbours(mask)
        spurs = []
        for line in _branches(near):
            ends = [len(near[line[k]]) for k in (0, -1)]
            if sorted(ends)[0] != 1 or max(ends) < 3:
                continue
            line = line if ends[0] == 1 else line[::-1]
            if _length(line) < SPUR * half[line[-1]] + 1:
                spurs.append(line)
        if not spurs:
            break
        for line in spurs:
            for pixel in line[:-1]:
                mask[pixel] = False
        mask = skeletonize(mask)
    return mask


def _beyond(line: list[Point], half: np.ndarray) -> int:
    """How many pixels of a free end lie beyond the line's own."""
    k = 0
    while line[0] != line[-1] and k < len(line) // 3 - STEP and half[line[k + STEP]] - half[line[k]] > SLOPE * math.dist(line[k], line[k + STEP]):
        k += STEP
    return k


class _Crossings:
    """Junctions whose ink is one: pixels that touch, and ends of bridges shorter than the line is wide."""

    def __init__(self) -> None:
        self.parent: dict[Point, Point] = {}

    def of(self, p: Point) -> Point:
        while self.parent.setdefault(p, p) != p:
            p = self.parent[p]
        return p

    def join(self, a: Point, b: Point) -> None:
        self.parent[self.of(a)] = self.of(b)


def _smooth(line: np.ndarray, half: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Points one pixel apart, each the mean of its line over about the line's width; the ends stay."""
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    n = max(2, round(s[-1]))
    even = np.linspace(0, s[-1], n + 1)
    rows = np.column_stack([np.interp(even, s, k) for k in (*line.T, half)])
    sigma = min(max(2.0, 0.6 * float(np.median(half))), len(rows) / 6)
    if closed:
        rows = ndimage.gaussian_filter1d(rows[:-1], sigma, axis=0, mode="wrap")
        rows = np.vstack([rows, rows[:1]])
    else:  # mirrored in the ends' points, so that they stay
        pad = min(len(rows) - 1, int(4 * sigma) + 1)
        wide = np.vstack([2 * rows[0] - rows[pad:0:-1], rows, 2 * rows[-1] - rows[-2 : -pad - 2 : -1]])
        wide[:, 2] = np.concatenate([rows[pad:0:-1, 2], rows[:, 2], rows[-2 : -pad - 2 : -1, 2]])
        rows = ndimage.gaussian_filter1d(wide, sigma, axis=0)[pad : pad + len(rows)]
    return rows[:, :2], rows[:, 2]


def centre_lines(ink: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Strokes: rows x, y [pixels of ``ink``, from the corner of the first] and the line's width at each. A dot has one point."""
    ink = np.pad(ink, 2)
    half = ndimage.distance_transform_edt(ink)
    near = _neighbours(_skeleton(ink, half))
    crossings, branches = _Crossings(), []
    for line in _branches(near):
        a, b = line[0], line[-1]
        both = len(near[a]) > 2 and len(near[b]) > 2
        if both and a != b and _length(line) < 1.2 * max(half[a], half[b]):
            crossings.join(a, b)
        else:
            branches.append(line)
    # Each end of a branch at a crossing, with its direction away from there, beyond the ink that the lines share.
    at: dict[Point, list[tuple[int, int, np.ndarray]]] = defaultdict(list)
    lines = []
    for index, line in enumerate(branches):
        points = np.array(line, float)
        ends = [len(near[line[k]]) > 2 for k in (0, -1)]
        cut = [round(1.2 * half[way[0]]) if end else _beyond(way, half) for way, end in zip((line, line[::-1]), ends)]
        if sum(cut) > len(line) - 3:
            cut = [min(c, max(0, len(line) // 3 - 1)) for c in cut]
        kept = points[cut[0] : len(points) - cut[1]]
        lines.append(kept)
        for side, end in enumerate(ends):
            if not end:
                continue
            walk = kept if side == 0 else kept[::-1]
            away = walk[min(len(walk) - 1, 2 + round(2 * half[line[-side]]))] - walk[0]
            if not away.any():
                away = walk[0] - points[-side]
            at[crossings.of(line[-side])].append((index, side, away / max(np.linalg.norm(away), 1e-9)))
    follows: dict[tuple[int, int], tuple[int, int]] = {}
    stub: dict[tuple[int, int], np.ndarray] = {}
    tip = lambda end: lines[end[0]][0 if end[1] == 0 else -1]  # noqa: E731
    for ends in at.values():
        pairs = sorted(((float(p[2] @ q[2]), p, q) for k, p in enumerate(ends) for q in ends[k + 1 :]), key=lambda pair: pair[0])
        through = []
        for cosine, p, q in pairs:
            a, b = p[:2], q[:2]
            if (cosine < THROUGH or len(ends) == 2) and a not in follows and b not in follows:
                follows[a], follows[b] = b, a
                through.append((tip(a), tip(b)))
        middle = np.mean([tip(e[:2]) for e in ends], axis=0)
        for index, side, away in ends:
            if (index, side) in follows:
                continue
            start, goal, least = tip((index, side)), middle, math.inf
            for a, b in through:  # where the line, led on, meets the one that goes through
                share = np.clip(np.linspace(0, 1, 33), 0, 1)[:, None]
                along = a + share * (b - a)
                off = np.abs((along - start) @ [-away[1], away[0]]) + 0.01 * np.linalg.norm(along - start, axis=1)
                if off.min() < least:
                    least, goal = off.min(), along[off.argmin()]
            stub[index, side] = goal
    strokes, used = [], set()
    starts = [(i, 0) for i in range(len(lines)) if (i, 0) not in follows] + [(i, 1) for i in range(len(lines)) if (i, 1) not in follows]
    for start in starts + [(i, 0) for i in range(len(lines))]:
        if start[0] in used:
            continue
        pieces = [stub[start][None]] if start in stub else []
        end, ring = start, False
        while True:
            index, side = end
            used.add(index)
            pieces.append(lines[index] if side == 0 else lines[index][::-1])
            leave = (index, 1 - side)
            if leave not in follows:
                pieces += [stub[leave][None]] if leave in stub else []
                break
            end = follows[leave]
            if end[0] in used:
                ring = end == start
                break
        line = np.vstack(pieces)
        line = line[np.concatenate([[True], np.any(np.diff(line, axis=0) != 0, axis=1)])]
        ring = ring or (len(line) > 3 and len(lines[start[0]]) == len(line) and np.array_equal(line[0], line[-1]))
        if ring and not np.array_equal(line[0], line[-1]):
            line = np.vstack([line, line[:1]])
        i, j = np.clip(np.round(line).astype(int), 0, np.array(half.shape) - 1).T
        radius = half[i, j]
        if len(line) > 1:
            line, radius = _smooth(line, radius, ring)
        # A distance to the nearest pixel outside is half a pixel more than that to the edge.
        strokes.append((line[:, ::-1] - 1.5, np.maximum(2 * radius - 1, 1)))
    return strokes
