"""How evenly a round pad can remove that stays inside an area: the limits that docs/cover.md quotes.

    python setup/cover_floor.py              beside a straight border, and on a disc
    python setup/cover_floor.py RUN [...]    on the area that the run of each folder promised

The dose of a place is the way of the pad's centres, times force, within one radius of it. Any density of way that is not negative is
allowed, and any line of it along the border; non-negative least squares finds the most even one. It knows neither the arm nor lines that
end. Without a run, lengths are in radii of the pad.
"""
import pathlib
import sys

import h5py
import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.optimize import minimize, nnls
from scipy.sparse import csr_matrix, diags
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from cover_reach import DEPTH, RADIUS, Surface

STEP = 0.02
# What a promise keeps off the pad's rim; what the program's distances are short of [m].
ASTRAY, HALF_STEP = 0.25e-3, 0.75e-3


def cv(dose, weight):
    mean = (weight * dose).sum() / weight.sum()
    return np.sqrt((weight * (dose - mean) ** 2).sum() / weight.sum()) / mean


def border(free, judged=3.0):
    """Beside a straight border, rows as dense everywhere beyond `free`: RMS over a strip as wide as `judged`."""
    x = np.arange(STEP / 2, free + 1, STEP)
    y = np.r_[0.0, np.arange(STEP / 2, free, STEP)]
    chord = 2 * np.sqrt(np.maximum(0.0, 1 - (x[:, None] - y) ** 2))
    u = np.clip(x - free, -1, 1)
    rest = 1 - (u * np.sqrt(1 - u * u) + np.arcsin(u) + np.pi / 2) / np.pi
    density, _ = nnls(chord, rest, maxiter=100000)
    return np.sqrt(((chord @ density - rest) ** 2).sum() * STEP / judged)


def disc(radius):
    """On a disc of centres, any rings."""
    place = np.arange(STEP / 2, radius, STEP)
    ring = np.r_[np.arange(STEP / 2, radius, STEP), radius]
    cosine = (place[:, None] ** 2 + ring**2 - 1) / (2 * place[:, None] * ring)
    arc = 2 * ring * np.arccos(np.clip(cosine, -1, 1))
    weight = np.sqrt(place)
    density, _ = nnls(arc * weight[:, None], weight, maxiter=100000)
    return cv(arc @ density, place)


def depth_of(surface, inside):
    """Way along the surface to the nearest place that is not inside; what is unknown continues as its nearest place [m]."""
    near = distance_transform_edt(~surface.known, return_distances=False, return_indices=True)
    p = surface.points.copy()
    p[..., 2] = surface.points[..., 2][tuple(near)]
    number = np.arange(inside.size).reshape(inside.shape)
    i, j, ways = [], [], []
    for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2)):
        a = np.s_[: inside.shape[0] - di, max(0, -dj) : inside.shape[1] - max(0, dj)]
        b = np.s_[di:, max(0, dj) : inside.shape[1] - max(0, -dj)]
        i.append(number[a].ravel())
        j.append(number[b].ravel())
        ways.append(np.linalg.norm(p[a] - p[b], axis=-1).ravel())
    graph = csr_matrix((np.concatenate(ways), (np.concatenate(i), np.concatenate(j))), (inside.size,) * 2)
    return dijkstra(graph, directed=False, indices=number[~inside], min_only=True, limit=0.1).reshape(inside.shape)


def pressed(points, centres, places):
    """The pressure at each place under a pad at each centre, over its mean: a foam of even stiffness, a disc that lies level."""
    column = np.full(len(points), -1)
    column[places] = np.arange(len(places))
    rows, columns, values = [], [], []
    for c, under in enumerate(cKDTree(points).query_ball_point(centres, RADIUS)):
        d = points[under] - centres[c]
        plane = np.linalg.lstsq(np.c_[np.ones(len(d)), d[:, :2]], d[:, 2], rcond=None)[0]
        height = (d[:, 2] - plane[0] - d[:, :2] @ plane[1:]) / np.sqrt(1.0 + plane[1:] @ plane[1:])
        pressure = np.maximum(0.0, DEPTH + height)
        judged = column[under] >= 0
        rows.append(column[under][judged])
        columns.append(np.full(judged.sum(), c))
        values.append((pressure / pressure.mean())[judged])
    return csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (len(places), len(centres)))


def promised(folder):
    """The coefficient of variation that is left on the promised area of a run, at places a radius inside of it."""
    with h5py.File(pathlib.Path(folder) / "run.h5") as run:
        surface = Surface(run["canvas/vertices"][:], run["canvas/triangles"][:])
        lines = run["target/points"][:]  # of the promised strokes, on the true surface
    treated = np.zeros_like(surface.known)
    treated[surface.known] = cKDTree(lines).query(surface.points[surface.known])[0] <= RADIUS - ASTRAY
    of_every = lambda n: (np.indices(surface.known.shape) % n == 0).all(0)[surface.known]  # noqa: E731
    depth = (depth_of(surface, treated) - HALF_STEP)[surface.known]
    points, area = surface.points[surface.known], surface.area[surface.known]
    inner, allowed = of_every(2) & (depth >= RADIUS), of_every(3) & (depth >= RADIUS - 2 * ASTRAY)
    centres = np.r_[points[allowed], lines[::3]]
    held = pressed(points, centres, np.flatnonzero(inner))
    weight = np.sqrt(area[inner] / area[inner].mean())
    weighted = diags(weight) @ held

    def off(density):
        rest = weighted @ density - weight
        return 0.5 * rest @ rest, weighted.T @ rest

    start = np.full(held.shape[1], 1.0 / held.sum(1).mean())
    found = minimize(off, start, jac=True, method="L-BFGS-B", bounds=[(0, None)] * len(start), options={"maxiter": 3000, "maxfun": 6000, "ftol": 1e-13, "gtol": 1e-7})
    return cv(held @ found.x, area[inner])


def main():
    for folder in sys.argv[1:]:
        print(f"{folder}: {100 * promised(folder):.1f} %", flush=True)
    if len(sys.argv) > 1:
        return
    for free in (1, 2, 3, 5, 8):
        print(f"straight border, free within {free} radii: {100 * border(free):.1f} % in a strip of 3 radii")
    for radius in (4.0, 5.0, 6.1, 7.0):
        print(f"disc of {radius} radii: {100 * disc(radius):.1f} %")


if __name__ == "__main__":
    main()
