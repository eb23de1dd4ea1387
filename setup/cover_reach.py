"""What of a mesh a perfect planner treats with a pad: the share that ./impedraw cover promises is measured against it.

    python setup/cover_reach.py MESH X Y MARGIN [PICTURE]     MESH: .obj, moved by X and Y on the table; MARGIN: off edges; metres

Independent of the program: heights are rasterised from the triangles, a disc is put level on the surface under it at every place,
and MuJoCo's kinematics of models/iiwa14_pen.urdf answer whether the arm gets there, from many postures, its links off the surface.
"""
import pathlib
import re
import sys

import mujoco
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
CELL, RADIUS, THICKNESS, DEPTH = 1e-3, 0.015, 0.010, 5.0 / (2e6 * np.pi * 0.015**2)  # [m]
STEEPEST, TOUCHING = np.cos(np.radians(75.0)), 0.98
ARM_STEP, SEEDS = 4, 24  # cells between the places that the arm is asked for, postures tried at each


def read_obj(file):
    vertices, faces = [], []
    for line in file.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
            faces += [(corners[0], b, c) for b, c in zip(corners[1:], corners[2:])]
    return np.array(vertices), faces


class Surface:
    """Seen from above: points of a grid, and where there is surface that is not too steep."""

    def __init__(self, vertices, faces):
        self.low = vertices[:, :2].min(0) - 20 * CELL
        nx, ny = np.ceil((vertices[:, :2].max(0) - self.low) / CELL).astype(int) + 21
        z, cosine = np.full((nx, ny), -np.inf), np.zeros((nx, ny))
        for face in faces:
            a, b, c = vertices[list(face)]
            n = np.cross(b - a, c - a)
            if abs(n[2]) < 1e-14:
                continue
            corners = (np.array([a, b, c])[:, :2] - self.low) / CELL
            (i0, j0), (i1, j1) = np.floor(corners.min(0)).astype(int), np.ceil(corners.max(0)).astype(int) + 1
            i, j = np.meshgrid(np.arange(i0, i1), np.arange(j0, j1), indexing="ij")
            x, y = self.low[0] + i * CELL - a[0], self.low[1] + j * CELL - a[1]
            e, f = (b - a)[:2], (c - a)[:2]
            u, v = (x * f[1] - y * f[0]) / n[2], (e[0] * y - e[1] * x) / n[2]
            height = a[2] + u * (b - a)[2] + v * (c - a)[2]
            higher = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (height > z[i, j])
            z[i[higher], j[higher]] = height[higher]
            cosine[i[higher], j[higher]] = abs(n[2]) / np.linalg.norm(n)
        self.known = np.isfinite(z) & (cosine >= STEEPEST)
        self.area = np.where(self.known, CELL**2 / np.maximum(cosine, STEEPEST), 0.0)
        x, y = np.meshgrid(self.low[0] + CELL * np.arange(nx), self.low[1] + CELL * np.arange(ny), indexing="ij")
        self.points = np.stack([x, y, z], -1)

    def window(self, i, j, k):
        return np.s_[i - k : i + k + 1, j - k : j + k + 1]


def footprints(surface, margin):
    """Places where a disc may stand, and the disc's normals there."""
    k = int(np.ceil((RADIUS + margin) / CELL))
    normals = np.full(surface.points.shape, np.nan)
    for i, j in np.argwhere(surface.known):
        if not (k <= i < surface.known.shape[0] - k and k <= j < surface.known.shape[1] - k):
            continue
        s = surface.window(i, j, k)
        known = surface.known[s]
        d = np.where(known[..., None], surface.points[s] - surface.points[i, j], surface.points[s] * [1, 1, 0] - surface.points[i, j] * [1, 1, 0])
        under = d[known & ((d**2).sum(-1) <= RADIUS**2)]
        plane = np.linalg.lstsq(np.c_[np.ones(len(under)), under[:, :2]], under[:, 2], rcond=None)[0]
        flat = d[..., 0] ** 2 + d[..., 1] ** 2 + (d[..., :2] @ plane[1:]) ** 2
        if (~known & (flat <= (RADIUS + margin) ** 2)).any():
            continue
        up = np.array([-plane[1], -plane[2], 1.0]) / np.sqrt(1.0 + plane[1] ** 2 + plane[2] ** 2)
        depth = DEPTH + (under[:, 2] - plane[0] - under[:, :2] @ plane[1:]) * up[2]
        if ((depth > 0) & (depth < THICKNESS)).mean() >= TOUCHING:
            normals[i, j] = up
    return normals


class Arm:
    def __init__(self, surface):
        text = (ROOT / "models/iiwa14_pen.urdf").read_text()
        text = re.sub(r"<visual>.*?</visual>", "", text, flags=re.S)
        text = re.sub(r"(<robot[^>]*>)", r'\1<mujoco><compiler fusestatic="false" balanceinertia="true"/></mujoco>', text)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.tip = self.model.body("tip").id
        self.surface = surface
        self.random = np.random.default_rng(1)
        self.skins = []  # points on the links' cylinders and spheres, in their geometries' frames
        angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        pen = {self.tip, self.model.body("pen").id}
        for g in range(self.model.ngeom):
            if self.model.geom_bodyid[g] in pen:
                continue
            r, half = self.model.geom_size[g][:2]
            if self.model.geom_type[g] == mujoco.mjtGeom.mjGEOM_SPHERE:
                rings = [(r * np.sin(t), r * np.cos(t)) for t in np.linspace(0.1, 3.0, 10)]
            else:
                rings = [(r, z) for z in np.linspace(-half, half, 12)] + [(0.5 * r, -half), (0.5 * r, half)]
            self.skins.append((g, np.array([(a * np.cos(t), a * np.sin(t), z) for a, z in rings for t in angle])))

    def free(self):
        for g, skin in self.skins:
            p = self.data.geom_xpos[g] + skin @ self.data.geom_xmat[g].reshape(3, 3).T
            ij = np.round((p[:, :2] - self.surface.low) / CELL).astype(int)
            on = ((ij >= 0) & (ij < self.surface.known.shape)).all(1)
            if (p[on, 2] < self.surface.points[ij[on, 0], ij[on, 1], 2]).any():
                return False
        return True

    def posture(self, p, up, start):
        """Joint angles with the tip at p and its axis against `up`; None where the search ends elsewhere."""
        q = start.copy()
        low, high = self.model.jnt_range.T
        jp, jr = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        for _ in range(60):
            self.data.qpos[:] = q
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            z = self.data.xmat[self.tip].reshape(3, 3)[:, 2]
            e = np.r_[p - self.data.xpos[self.tip], np.cross(z, -up) if z @ up < 0 else 2 * np.cross(z, -up) + 1e-3]
            if np.abs(e).max() < 2e-4:
                return q
            mujoco.mj_jacBody(self.model, self.data, jp, jr, self.tip)
            turn = jr - np.outer(z, z @ jr)
            J = np.r_[jp, turn]
            q = np.clip(q + J.T @ np.linalg.solve(J @ J.T + 1e-5 * np.eye(6), e), low, high)
        return None

    def reaches(self, p, up, warm):
        low, high = self.model.jnt_range.T
        for k in range(SEEDS):
            start = warm[k] if k < len(warm) else self.random.uniform(low, high)
            q = self.posture(p, up, start)
            if q is not None and self.free():
                return q
        return None


def swept(surface, centres):
    k = int(np.ceil(RADIUS / CELL))
    places = np.zeros(surface.known.shape, bool)
    for i, j in np.argwhere(centres):
        s = surface.window(i, j, k)
        places[s] |= surface.known[s] & (((surface.points[s] - surface.points[i, j]) ** 2).sum(-1) <= RADIUS**2)
    return places


def main():
    vertices, faces = read_obj(pathlib.Path(sys.argv[1]))
    surface = Surface(vertices + [float(sys.argv[2]), float(sys.argv[3]), 0.0], faces)
    normals = footprints(surface, float(sys.argv[4]))
    stands = np.isfinite(normals[..., 0])
    cm2 = lambda places: 1e4 * surface.area[places].sum()  # noqa: E731
    print(f"surface {cm2(surface.known):.0f} cm², treated by a disc {cm2(swept(surface, stands)):.0f} cm²", flush=True)
    arm, reached, last = Arm(surface), np.zeros_like(stands), {}
    for i, j in np.argwhere(stands[::ARM_STEP, ::ARM_STEP]) * ARM_STEP:
        warm = [last[n] for n in ((i, j - ARM_STEP), (i - ARM_STEP, j)) if n in last] + [np.array([0, 0.5, 0, -1.3, 0, 1.3, 0])]
        q = arm.reaches(surface.points[i, j], normals[i, j], warm)
        if q is not None:
            last[i, j] = q
            reached[i - ARM_STEP // 2 : i + ARM_STEP // 2, j - ARM_STEP // 2 : j + ARM_STEP // 2] = True
    print(f"by the arm {cm2(swept(surface, reached & stands)):.0f} cm²")
    if len(sys.argv) > 5:
        import matplotlib.pyplot as plt

        plt.imsave(sys.argv[5], (surface.known + 1.0 * swept(surface, stands) + swept(surface, reached & stands))[::-1])


if __name__ == "__main__":
    main()
