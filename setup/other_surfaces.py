"""Writes the meshes of studies/other-surfaces.yaml, which no limit was found with: those of studies/surfaces.yaml at other
sizes, tilted, on their sides, and with noise between neighbouring vertices, as a scan has.

    python setup/other_surfaces.py [FOLDER]     FOLDER: build/surface-meshes, which gets them, too
"""
import math
import pathlib
import sys

import numpy as np

WIDTH = 0.3  # longest side of the box [m]
NAMES = ("duck", "bunny", "teddy", "body", "chassis", "football", "mug", "block", "mountains", "sea_bed")
TERRAIN = ("mountains", "sea_bed")
SCANS = ("duck", "bunny")
NOISE = 2e-4  # of each coordinate, RMS [m]
TILT = math.radians(35.0)
ABOUT_X = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
ABOUT_Y = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
TILTED = np.array([[math.cos(TILT), 0, math.sin(TILT)], [0, 1, 0], [-math.sin(TILT), 0, math.cos(TILT)]])


def read(file):
    vertices, faces = [], []
    for line in file.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) for w in words[1:]]
            faces += [(corners[0], b, c) for b, c in zip(corners[1:], corners[2:])]
    vertices = np.array(vertices)
    return vertices / (vertices.max(axis=0) - vertices.min(axis=0)).max(), faces


def write(file, vertices, faces):
    with open(file, "w") as out:
        out.writelines("v {:.6f} {:.6f} {:.6f}\n".format(*v) for v in vertices)
        out.writelines("f {} {} {}\n".format(*f) for f in faces)


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[1] / "build/surface-meshes")
    random = np.random.default_rng(7)
    for name in NAMES:
        vertices, faces = read(folder / f"{name}.obj")
        write(folder / f"{name}-large.obj", 0.4 * vertices, faces)
        write(folder / f"{name}-tilted.obj", WIDTH * vertices @ TILTED.T, faces)
        if name in TERRAIN:
            write(folder / f"{name}-small.obj", 0.2 * vertices, faces)
        else:
            write(folder / f"{name}-about_x.obj", WIDTH * vertices @ ABOUT_X.T, faces)
            write(folder / f"{name}-about_y.obj", WIDTH * vertices @ ABOUT_Y.T, faces)
        if name in SCANS:
            write(folder / f"{name}-noisy.obj", WIDTH * vertices + random.normal(0.0, NOISE, vertices.shape), faces)


main()
