"""Flattens a triangle mesh with as little stretch as possible. wrap.cc calls it with two files.

In:  int64 [vertices, triangles, pinned vertex], float64 vertices × 3 [m], int64 triangles × 3
Out: float64 vertices × 2 [m], the pinned vertex at the origin; how it is turned means nothing

libigl's least-squares conformal map (Lévy et al. 2002) unfolds the mesh; as-rigid-as-possible parametrisation (Liu et al. 2008) then
trades its angles for lengths: it minimises the sum over triangles of area · ((σ₁ − 1)² + (σ₂ − 1)²), σ the stretches.
"""

import sys
from pathlib import Path

import igl
import numpy as np

SETTLED = 1e-7  # [m]
BLOCK = 5       # iterations between checks for convergence
MOST = 400      # iterations


def areas(uv, triangles):
    a, b, c = (uv[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def farthest(points, from_vertex):
    return int(np.argmax(((points - points[from_vertex]) ** 2).sum(axis=1)))


def conformal(points, triangles):
    """Conformal map with two distant vertices fixed, scaled to the area of the mesh."""
    ends = np.array([farthest(points, 0), 0], dtype=np.int64)
    ends[1] = farthest(points, ends[0])
    distance = np.linalg.norm(points[ends[1]] - points[ends[0]])
    uv, _ = igl.lscm(points, triangles, ends, np.array([[0.0, 0.0], [distance, 0.0]]))
    area = 0.5 * np.linalg.norm(np.cross(points[triangles[:, 1]] - points[triangles[:, 0]],
                                         points[triangles[:, 2]] - points[triangles[:, 0]]), axis=1).sum()
    flat_area = areas(uv, triangles).sum()
    if not flat_area > 0:
        sys.exit("the conformal map of the surface collapsed")
    return uv * np.sqrt(area / flat_area)


def as_rigid_as_possible(points, triangles, uv, pinned):
    uv = uv - uv[pinned]
    data = igl.ARAPData()
    data.max_iter = BLOCK
    igl.arap_precomputation(points, triangles, 2, np.array([pinned], dtype=np.int32), data)
    for _ in range(MOST // BLOCK):
        last, uv = uv, igl.arap_solve(np.zeros((1, 2)), data, uv)
        if np.abs(uv - last).max() < SETTLED:
            break
    return uv


def main():
    raw = Path(sys.argv[1]).read_bytes()
    vertices, count, pinned = np.frombuffer(raw, dtype=np.int64, count=3)
    points = np.frombuffer(raw, dtype=np.float64, count=3 * vertices, offset=24).reshape(-1, 3)
    triangles = np.frombuffer(raw, dtype=np.int64, count=3 * count, offset=24 + 24 * int(vertices)).reshape(-1, 3)
    uv = as_rigid_as_possible(points, triangles, conformal(points, triangles), int(pinned))
    if not np.isfinite(uv).all():
        sys.exit("the surface could not be laid flat: some of its points have no finite place")
    Path(sys.argv[2]).write_bytes(np.ascontiguousarray(uv, dtype=np.float64).tobytes())


main()
