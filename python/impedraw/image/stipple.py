"""Stipples by weighted Voronoi cells, and one line through them.

A line through points of density ρ has 0.7124 √ρ of length per area (Beardwood, Halton, Hammersley), so that tone asks for ρ ∝ tone²."""

from __future__ import annotations

from typing import Callable

import numpy as np
from scipy.ndimage import zoom
from scipy.spatial import cKDTree

ROUNDS = ((0.25, 12), (0.5, 12), (1.0, 5))  # how much of the picture's resolution, and how often the cells' centres are taken


def stipples(density: np.ndarray, count: int, rng: np.random.Generator, progress: Callable[[float], None]) -> np.ndarray:
    """count × 2 points x, y [pixels], each in the weighted centre of its Voronoi cell (Lloyd's iteration, Secord 2002)."""
    flat = density.ravel() / density.sum()
    at = rng.choice(flat.size, count, p=flat)
    points = np.column_stack([at % density.shape[1], at // density.shape[1]]) + rng.random((count, 2))
    for share, times in ROUNDS:
        if share < 1 and share**2 * density.size < 12 * count:
            continue  # too few pixels a cell
        weights = density if share == 1 else np.maximum(zoom(density, share, order=1, grid_mode=True, mode="nearest"), 0)
        used = np.flatnonzero(weights.ravel() > 1e-4 * weights.max())
        w = weights.ravel()[used]
        rows, columns = np.divmod(used, weights.shape[1])
        # Pixels' centres in pixels of the whole picture.
        pixels = (np.column_stack([columns, rows]) + 0.5) * [density.shape[1] / weights.shape[1], density.shape[0] / weights.shape[0]]
        for i in range(times):
            cell = cKDTree(points).query(pixels, workers=-1)[1]
            mass = np.bincount(cell, w, count)
            own = mass > 0
            centres = np.column_stack([np.bincount(cell, w * pixels[:, k], count) for k in (0, 1)])[own] / mass[own, None]
            points[own] += (1.4 if i < times - 2 else 1.0) * (centres - points[own])
            progress(share * (i + 1) / times)
        np.clip(points, 0, [density.shape[1], density.shape[0]], out=points)
    return points


def _along_hilbert(points: np.ndarray) -> list[int]:
    """Order along Hilbert's curve."""
    span = np.ptp(points, axis=0).max() or 1.0
    x, y = ((points - points.min(0)) / span * 65535).astype(np.int64).T
    key, side = np.zeros(len(points), np.int64), 32768
    while side:
        right, down = (x & side) > 0, (y & side) > 0
        key += side * side * ((3 * right) ^ down)
        flip = ~down & right
        x, y = np.where(flip, 65535 - x, x), np.where(flip, 65535 - y, y)
        x, y = np.where(~down, y, x), np.where(~down, x, y)
        side //= 2
    return np.argsort(key, kind="stable").tolist()


def tour(points: np.ndarray, progress: Callable[[float], None] = lambda share: None) -> np.ndarray:
    """The points in an order that makes a short open line: 2-opt and or-opt among eight neighbours, from Hilbert's curve."""
    n = len(points)
    if n < 5:
        return points[np.argsort(points[:, 0], kind="stable")]
    order = _along_hilbert(points)
    place = [0] * n
    for i, city in enumerate(order):
        place[city] = i
    px, py = points.T.tolist()
    distances, near = cKDTree(points).query(points, min(9, n))
    near, distances = near[:, 1:].tolist(), distances[:, 1:].tolist()

    def d(a: int, b: int) -> float:
        return ((px[a] - px[b]) ** 2 + (py[a] - py[b]) ** 2) ** 0.5

    def reverse(i: int, j: int) -> None:
        """Places i … j, around the end where j < i; the shorter part of the circle is turned."""
        if (j - i) % n + 1 > n // 2:
            i, j = (j + 1) % n, (i - 1) % n
        if i <= j:
            part = order[i : j + 1][::-1]
            order[i : j + 1] = part
            for k, city in enumerate(part, i):
                place[city] = k
            return
        places = [k % n for k in range(i, j + n + 1)]
        for k, city in zip(places, [order[k] for k in places][::-1]):
            order[k] = city
            place[city] = k

    def exchange(a: int, b: int, c: int, e: int) -> None:
        """The edges a-b and c-e become a-c and b-e."""
        if order[(place[a] + 1) % n] == b:
            reverse(place[b], place[c])
        else:
            reverse(place[a], place[e])

    def improved(a: int) -> tuple[int, ...]:
        """Makes a move at city a that shortens the circle, and returns its cities; empty: there is none."""
        for step in (1, -1):
            b = order[(place[a] + step) % n]
            ab = d(a, b)
            for c, ac in zip(near[a], distances[a]):
                if ac >= ab:
                    break
                e = order[(place[c] + step) % n]
                if ac + d(b, e) < ab + d(c, e) - 1e-9:
                    exchange(a, b, c, e)
                    return a, b, c, e
        # A piece of up to three cities, a … end, put beside a neighbour c of a.
        for step in (1, -1):
            before, end = order[(place[a] - step) % n], a
            for length in range(1, 4):
                after = order[(place[end] + step) % n]
                if after == before:
                    break
                gain = d(before, a) + d(end, after) - d(before, after)
                for c, ac in zip(near[a], distances[a]):
                    if ac >= gain:
                        break
                    for side in (step, -step):
                        e = order[(place[c] + side) % n]
                        if (place[c] - place[a]) * step % n < length or (place[e] - place[a]) * step % n < length:
                            continue  # in the piece
                        if ac + d(end, e) - d(c, e) < gain - 1e-9:
                            first, last = (c, e) if side == step else (e, c)
                            exchange(before, a, first, last)
                            exchange(before, first, after, end)
                            if side == step:
                                exchange(first, end, a, last)
                            return before, after, a, end, c, e
                end = after
        return ()

    queue, waiting = list(range(n)), [True] * n
    done = 0
    while queue:
        batch, queue = queue, []
        for a in batch:
            waiting[a] = False
            while moved := improved(a):
                for city in moved:
                    if not waiting[city]:
                        waiting[city] = True
                        queue.append(city)
            done += 1
        progress(min(1.0, done / (4 * n)))
    circle = points[order]
    longest = int(np.argmax(np.linalg.norm(np.roll(circle, -1, 0) - circle, axis=1)))
    return np.roll(circle, -longest - 1, 0)
