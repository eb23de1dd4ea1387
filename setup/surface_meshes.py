"""Writes the meshes that ./impedraw robustness --part surfaces draws on: things that other people scanned and modelled, as
pinned packages bring them, 0.3 m wide, z up, standing on z = 0.

    python setup/surface_meshes.py WHEEL FOLDER     WHEEL: that of setup/arm-meshes.txt
"""
import pathlib
import sys
import zipfile

import matplotlib.cbook
import numpy as np

WIDTH = 0.3  # [m]
Y_UP = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
# Of pybullet_data, with the rotation that turns them upright.
MODELS = {
    "duck": ("duck.obj", Y_UP),
    "bunny": ("bunny.obj", np.eye(3)),
    "torus": ("torus/torus_textured.obj", Y_UP),
    "football": ("soccerball.obj", np.eye(3)),
    "teddy": ("teddy2_VHACD_CHs.obj", np.eye(3)),
    "mug": ("objects/mug.obj", Y_UP),
    "chassis": ("laikago/chassis_zup.obj", np.eye(3)),
    "body": ("mini_cheetah/meshes/mini_body.obj", np.eye(3)),
    "block": ("random_urdfs/007/007.obj", np.eye(3)),
}


def read_obj(text):
    vertices, faces = [], []
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            faces.append([int(w.split("/")[0]) for w in words[1:]])
    return np.array(vertices), faces


def write_obj(file, vertices, faces):
    used = np.unique(np.concatenate([np.abs(f) for f in faces])) - 1
    low, high = vertices[used].min(axis=0), vertices[used].max(axis=0)
    scale = WIDTH / (high - low)[:2].max()
    origin = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    with open(file, "w") as out:
        for x, y, z in scale * (vertices - origin):
            out.write(f"v {x:.6f} {y:.6f} {z:.6f}\n")
        for f in faces:
            out.write("f " + " ".join(map(str, f)) + "\n")


def height_field(heights, metres):
    """Triangles over a grid of heights, `metres` between samples."""
    rows, columns = heights.shape
    x, y = np.meshgrid(metres * np.arange(columns), -metres * np.arange(rows))
    number = 1 + np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.concatenate([np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)])
    return np.stack([x, y, heights], -1).reshape(-1, 3), faces


def mountains():
    """Those of matplotlib's examples, every second sample, heights one and a half times as they are."""
    with matplotlib.cbook.get_sample_data("jacksboro_fault_dem.npz") as data:
        return height_field(1.5 * data["elevation"][::2, ::2].astype(float), 60.0)


def sea_bed():
    """The coast and sea bed of matplotlib's examples, every second sample, of low relief."""
    with matplotlib.cbook.get_sample_data("topobathy.npz") as data:
        return height_field(data["topo"][::2, ::2] * 3e-3, 2.0)


def main():
    wheel, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(wheel) as package:
        for name, (member, rotation) in MODELS.items():
            vertices, faces = read_obj(package.read("pybullet_data/" + member).decode())
            write_obj(folder / f"{name}.obj", vertices @ rotation.T, faces)
    write_obj(folder / "mountains.obj", *mountains())
    write_obj(folder / "sea_bed.obj", *sea_bed())


main()
