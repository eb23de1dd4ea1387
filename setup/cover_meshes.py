"""Writes the surfaces that ./impedraw cover is measured on (docs/cover.md), beside the built-in ones and the duck.

    python setup/cover_meshes.py [FOLDER]     FOLDER: build/cover-meshes, which gets curve.obj, door.obj, vase.obj, torus.obj, helmet.obj,
                                              hole.obj, step.obj, ell.obj and strip.obj; metres, on the table before the arm
"""
import math
import pathlib
import sys

STEP = 2e-3  # of the grids [m]
CENTRE = (0.60, 0.0, 0.15)


def curve(x, y):
    """A car door's: doubly curved, 0.9 m along and 0.5 m across."""
    return -x * x / 0.5 / 2 - y * y / 0.9 / 2


def door(x, y):
    """The same with a crease of 12° along a line and a handle's recess of 6 mm, 90 × 50 mm."""
    z = curve(x, y)
    s = x + 0.055 + 0.04 * y
    z -= 0.5 * math.tan(math.radians(12)) * (math.hypot(s, 4e-3) - s)
    d = math.hypot((x - 0.05) / 0.025, (y - 0.03) / 0.045)
    return z - 6e-3 * 0.5 * (1 - math.tanh((d - 1.0) / 0.25))


def vase(x, y):
    """A vase that lies: a wall of revolution about y, 60 to 90 mm thick, seen from above."""
    r = 0.075 + 0.015 * math.cos(2 * math.pi * y / 0.16)
    return math.sqrt(r * r - x * x) - 0.09 if abs(x) < 0.8 * r else None


def torus(x, y):
    """The upper part of a torus of 80 and 40 mm."""
    d = math.hypot(x, y) - 0.08
    return math.sqrt(0.04**2 - d * d) if abs(d) < 0.034 else None


def helmet(x, y):
    """An ellipsoid with a keel, and air slits and a round hole that go through."""
    q = 1 - (x / 0.13) ** 2 - (y / 0.105) ** 2
    if q < 0.25 or math.hypot(x - 0.02, y) < 0.012:
        return None
    if any(abs(x + 0.035) < 0.03 and abs(y - c) < 0.005 for c in (-0.04, 0.04)):
        return None
    return 0.14 * math.sqrt(q) + 4e-3 * math.exp(-((y / 0.02) ** 2))


def hole(x, y):
    return None if math.hypot(x - 0.01, y + 0.015) < 0.02 else 0.0


def step(x, y):
    """A step of 8 mm, as steep as a mesh of this step has it."""
    return 8e-3 if x > 0.013 else 0.0


def ell(x, y):
    return None if x > 0.0 and y > -0.02 else 0.05 * x


def strip(x, y):
    """44 mm wide, curved."""
    return 0.02 * math.cos(30 * y) if abs(x - 0.03 * math.sin(15 * y)) < 0.022 else None


SHAPES = {  # half a width along x and y [m]
    curve: (0.11, 0.14), door: (0.11, 0.14), vase: (0.08, 0.13), torus: (0.12, 0.12), helmet: (0.13, 0.11), hole: (0.09, 0.09), step: (0.09, 0.09),
    ell: (0.09, 0.09), strip: (0.09, 0.13)}


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for height, (a, b) in SHAPES.items():
        nx, ny = round(2 * a / STEP) + 1, round(2 * b / STEP) + 1
        numbers, lines = {}, []
        for i in range(nx):
            for j in range(ny):
                x, y = -a + i * STEP, -b + j * STEP
                z = height(x, y)
                if z is not None:
                    numbers[i, j] = len(numbers) + 1
                    lines.append(f"v {CENTRE[0] + x:.6f} {CENTRE[1] + y:.6f} {CENTRE[2] + z:.6f}\n")
        for i, j in list(numbers):
            for corners in ([(i, j), (i + 1, j), (i + 1, j + 1)], [(i, j), (i + 1, j + 1), (i, j + 1)]):
                if all(c in numbers for c in corners):
                    lines.append("f {} {} {}\n".format(*(numbers[c] for c in corners)))
        (folder / f"{height.__name__}.obj").write_text("".join(lines))


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[1] / "build/cover-meshes"))
