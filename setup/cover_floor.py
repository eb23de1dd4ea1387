"""How evenly a round pad can remove that stays inside an area: the limits that docs/cover.md quotes.

    python setup/cover_floor.py

The dose of a place is the way of the pad's centres, times force, within one radius of it. Any density of way that is not negative is
allowed, and any line of it along the border; non-negative least squares finds the most even one. Lengths in radii of the pad.
"""
import numpy as np
from scipy.optimize import nnls

STEP = 0.02


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


for free in (1, 2, 3, 5, 8):
    print(f"straight border, free within {free} radii: {100 * border(free):.1f} % in a strip of 3 radii")
for radius in (4.0, 5.0, 6.1, 7.0):
    print(f"disc of {radius} radii: {100 * disc(radius):.1f} %")
