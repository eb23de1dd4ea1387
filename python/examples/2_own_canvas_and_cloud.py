"""2. A canvas of your own as a mesh, and the surface as a cloud of your own tells it.

Run: python 2_own_canvas_and_cloud.py
"""

import numpy as np

import impedraw as idr

# A hill of 3 cm on a square of 30 cm, as triangles. Any mesh of NumPy arrays will do.
x, y = np.meshgrid(np.linspace(0.45, 0.75, 61), np.linspace(-0.15, 0.15, 61), indexing="ij")
z = 0.05 + 0.03 * np.exp(-((x - 0.6) ** 2 + y**2) / 0.01)
vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
i = np.arange(61 * 61).reshape(61, 61)
a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel()
canvas = idr.Canvas.from_mesh(vertices, np.r_[np.c_[a, b, d], np.c_[a, d, c]])

# What a depth camera would see of it: points with half a millimetre of noise.
rng = np.random.default_rng(1)
cloud = vertices + rng.normal(0, 5e-4, vertices.shape)
estimator = idr.SurfaceEstimator(cloud, viewpoint=[0.6, 0, 1.5], settings=idr.NormalSettings(k=60))

# Errors of the estimated normals and distances at places on the true surface.
places = np.array([canvas.closest([px, py, 0.1]).p_W for px, py in rng.uniform([0.5, -0.1], [0.7, 0.1], (200, 2))])
normals, distances, status = estimator.estimate_all(places)
true = np.array([canvas.closest(p).n_W for p in places])
angle = np.degrees(np.arccos(np.clip((normals * true).sum(axis=1), -1, 1)))
print(f"normals: {angle.mean():.2f}° mean, {angle.max():.2f}° at worst; distance {1e3 * np.abs(distances).mean():.3f} mm")
assert (status == 0).all() and angle.mean() < 4

# A path over the seen surface, from strokes in metres.
stroke = np.c_[0.6 + 0.05 * np.cos(np.linspace(0, 6, 100)), 0.05 * np.sin(np.linspace(0, 6, 100))]
path = idr.plan_tip_path([stroke], estimator)
off = max(abs(canvas.closest(s.reference.p_WD).distance) for s in map(path.at, np.arange(0, path.duration, 0.01)) if s.stroke == 0)
print(f"path: {path.duration:.1f} s, {path.pen_down_length:.3f} m, within {1e3 * off:.2f} mm of the true surface")
assert off < 1e-3
