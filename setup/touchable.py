"""The share of a drawing's target that the ball of the tip can touch: what its coverage could be.

    .venv/bin/python setup/touchable.py RUN_FOLDER ...

A place counts if a ball of 1 mm that touches the true canvas within 0.5 mm of it fits there: hard, nowhere deeper in
the canvas than 20 µm; soft, than 0.25 mm, the give of the standard tip at 5 N. The canvas is sampled every 0.1 mm.
"""
import sys
from pathlib import Path

import h5py
import numpy as np
from scipy.spatial import cKDTree

RADIUS, REACH, SPACING = 1e-3, 0.5e-3, 0.1e-3
DEEPEST = {"hard": 20e-6, "soft": 0.25e-3}


def samples(vertices, triangles):
    """Points of the triangles, and their normals."""
    rng = np.random.default_rng(0)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1) / 2
    normal /= 2 * area[:, None] + 1e-30
    which = np.repeat(np.arange(len(triangles)), np.maximum(3, np.ceil(area / SPACING**2)).astype(int))
    u = rng.random((len(which), 2))
    outside = u.sum(1) > 1
    u[outside] = 1 - u[outside]
    return a[which] + u[:, :1] * (b - a)[which] + u[:, 1:] * (c - a)[which], normal[which]


def covered_share(target, stroke, distance):
    """Of the target's length; half of a piece belongs to each of its ends."""
    length = covered = 0.0
    for s in np.unique(stroke):
        at = stroke == s
        piece = np.linalg.norm(np.diff(target[at], axis=0), axis=1) / 2
        weight = np.r_[piece, 0] + np.r_[0, piece]
        length += weight.sum()
        covered += weight[distance[at] <= REACH].sum()
    return covered / length


def main(folder):
    with h5py.File(folder / "run.h5") as run:
        vertices, triangles = run["canvas/vertices"][:], run["canvas/triangles"][:]
        target, of_target = run["target/points"][:], run["target/stroke"][:]
        stroke, force = run["stroke"][:], run["contact/force"][:]
        normal, point = run["contact/normal"][:], run["contact/point"][:]
    ink = (stroke >= 0) & ((force * normal).sum(1) > 0.1)
    near_target = cKDTree(target)
    centre = vertices[triangles].mean(1)
    size = np.linalg.norm(vertices[triangles] - centre[:, None], axis=2).max(1)
    triangles = triangles[near_target.query(centre)[0] < 4 * RADIUS + size]
    surface, outward = samples(vertices, triangles)
    tree = cKDTree(surface)
    outward *= np.sign(np.median((outward[tree.query(point[ink])[1]] * normal[ink]).sum(1)))
    candidates = near_target.query(surface)[0] < REACH
    ball = surface[candidates] + RADIUS * outward[candidates]
    gap = tree.query(ball)[0] - RADIUS
    drawn = np.full(len(target), np.inf)
    for s in np.unique(of_target):
        own = ink & (stroke == s)
        if own.any():
            drawn[of_target == s] = cKDTree(point[own]).query(target[of_target == s])[0]
    shares = []
    for name, deepest in DEEPEST.items():
        touchable = cKDTree(surface[candidates][gap > -deepest]).query(target)[0]
        shares.append(f"{name} {covered_share(target, of_target, np.minimum(touchable, drawn)):.3f}")
    print(f"{folder}: touchable {', '.join(shares)}; drawn {covered_share(target, of_target, drawn):.3f}")


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    for name in sys.argv[1:]:
        main(Path(name))
