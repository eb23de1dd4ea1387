"""Objects that no test draws on, as three views of a foreign renderer (Embree, through trimesh) see them on a table, and what
`--place surface` makes of them.

    python -m venv V && V/bin/pip install numpy scipy trimesh embreex scikit-image
    V/bin/python setup/place_captures.py FOLDER [--program build/release/src/app/impedraw] [--only mug,chair] [--mesh FILE.obj ...]

Writes FOLDER/NAME/{object.obj, capture.json, depth_*.png} and FOLDER/NAME/run, and prints for each object the share of "Hello", 100 mm
wide, that is promised, its coverage, and the force's standard deviation. Depths are whole millimetres, the cameras stand as they say.
"""
import argparse
import json
import pathlib
import subprocess
import sys

import numpy as np
import trimesh
from skimage.measure import marching_cubes

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "foreign"))
import eyes  # noqa: E402

CELL = 0.003  # of the grid that the objects are made on [m]


def ball(p, c, r):
    return np.linalg.norm((p - c) / r, axis=-1) * np.min(r) - np.min(r)


def box(p, c, half, round_=0.005):
    q = np.abs(p - c) - (np.asarray(half) - round_)
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0) - round_


def rod(p, a, b, r):
    a, b = np.asarray(a, float), np.asarray(b, float)
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - r


def upright(p, c, r, low, high):
    return np.maximum(np.hypot(p[..., 0] - c[0], p[..., 1] - c[1]) - r, np.abs(p[..., 2] - (low + high) / 2) - (high - low) / 2)


def ring(p, c, axis, large, small):
    q = p - c
    along = q[..., axis]
    across = np.sqrt(np.maximum((q**2).sum(-1) - along**2, 0))
    return np.hypot(across - large, along) - small


def blend(a, b, k=0.02):
    h = np.clip(0.5 + 0.5 * (b - a) / k, 0, 1)
    return b + (a - b) * h - k * h * (1 - h)


def skull(p):
    d = blend(ball(p, (0, 0, 0.20), (0.12, 0.09, 0.11)), box(p, (0.07, 0, 0.09), (0.05, 0.05, 0.07), 0.03), 0.04)
    for y in (-0.036, 0.036):
        d = np.maximum(d, -ball(p, (0.11, y, 0.17), (0.03, 0.024, 0.024)))
    d = np.maximum(d, -ball(p, (0.13, 0, 0.12), (0.02, 0.012, 0.02)))
    return np.maximum(d, -box(p, (0.11, 0, 0.065), (0.03, 0.035, 0.006)))


def bust(p):
    d = blend(ball(p, (0, 0, 0.31), (0.075, 0.065, 0.09)), rod(p, (0, 0, 0.14), (0, 0, 0.26), 0.045), 0.03)
    d = blend(d, ball(p, (0, 0, 0.10), (0.08, 0.17, 0.10)), 0.05)
    return blend(d, ball(p, (0.075, 0, 0.30), (0.02, 0.012, 0.025)), 0.015)


def boot(p):
    d = blend(rod(p, (-0.07, 0, 0.05), (0.11, 0, 0.04), 0.045), upright(p, (-0.07, 0), 0.055, 0.02, 0.26), 0.03)
    d = np.maximum(d, -upright(p, (-0.07, 0), 0.048, 0.12, 0.5))
    return np.minimum(d, box(p, (0.015, 0, 0.01), (0.135, 0.05, 0.01)))


def guitar(p):
    body = blend(upright(p, (-0.10, 0), 0.115, 0, 0.07), upright(p, (0.06, 0), 0.09, 0, 0.07), 0.05)
    body = np.maximum(body, -upright(p, (0.03, 0), 0.035, 0.02, 0.2))
    d = np.minimum(body, box(p, (0.26, 0, 0.072), (0.14, 0.02, 0.012)))
    for k in range(6):
        d = np.minimum(d, rod(p, (-0.13, -0.0125 + 0.005 * k, 0.084), (0.38, -0.0125 + 0.005 * k, 0.088), 0.0018))
    return np.minimum(d, box(p, (-0.13, 0, 0.075), (0.012, 0.05, 0.008)))


def mug(p):
    d = np.maximum(upright(p, (0, 0), 0.09, 0, 0.20), -upright(p, (0, 0), 0.083, 0.01, 0.5))
    handle = np.maximum(ring(p, (0, 0.095, 0.10), 0, 0.05, 0.011), -upright(p, (0, 0), 0.086, -1, 1))
    return np.minimum(d, handle)


def chair(p):
    d = box(p, (0, 0, 0.22), (0.15, 0.15, 0.012))
    d = np.minimum(d, box(p, (-0.14, 0, 0.36), (0.010, 0.15, 0.14)))
    for x in (-0.135, 0.135):
        for y in (-0.135, 0.135):
            d = np.minimum(d, box(p, (x, y, 0.11), (0.012, 0.012, 0.11)))
    return d


def tall_chair(p):
    d = box(p, (0, 0, 0.24), (0.17, 0.17, 0.012))
    d = np.minimum(d, box(p, (-0.16, 0, 0.40), (0.010, 0.17, 0.17)))
    for x in (-0.15, 0.15):
        for y in (-0.15, 0.15):
            d = np.minimum(d, box(p, (x, y, 0.12), (0.012, 0.012, 0.12)))
    return d


def helmet(p):
    d = np.maximum(np.abs(ball(p, (0, 0, 0.06), (0.15, 0.12, 0.14)) + 0.004) - 0.004, 0.02 - p[..., 2])
    brim = np.maximum(np.abs(p[..., 2] - 0.05 + 0.15 * np.maximum(p[..., 0] - 0.1, 0)) - 0.004, ball(p, (0.11, 0, 0.05), (0.10, 0.10, 0.10)))
    d = np.minimum(d, np.maximum(brim, -ball(p, (0, 0, 0.06), (0.146, 0.116, 0.136))))
    return blend(d, rod(p, (-0.10, 0, 0.175), (0.10, 0, 0.175), 0.008), 0.02)


def lamp(p):
    d = np.minimum(upright(p, (0, 0), 0.10, 0, 0.02), upright(p, (0, 0), 0.012, 0, 0.30))
    r = np.hypot(p[..., 0], p[..., 1])
    shade = np.abs(r - (0.14 - 0.55 * (p[..., 2] - 0.22))) / 1.14 - 0.004
    return np.minimum(d, np.maximum(shade, np.abs(p[..., 2] - 0.30) - 0.08))


def car(p):
    d = blend(box(p, (0, 0, 0.07), (0.19, 0.08, 0.035), 0.025), box(p, (-0.02, 0, 0.12), (0.09, 0.068, 0.035), 0.03), 0.03)
    for x in (-0.12, 0.12):
        for y in (-0.08, 0.08):
            wheel = np.maximum(np.hypot(p[..., 0] - x, p[..., 2] - 0.04) - 0.04, np.abs(p[..., 1] - y) - 0.015)
            d = np.minimum(d, wheel)
    return d


def trunk(p):
    a = np.arctan2(p[..., 1], p[..., 0])
    bark = 0.004 * np.sin(17 * a + 20 * p[..., 2]) + 0.002 * np.sin(31 * a - 45 * p[..., 2]) + 0.012 * np.cos(3 * a)
    flare = 0.05 * np.exp(-p[..., 2] / 0.05) * (1 + 0.5 * np.cos(5 * a))
    d = np.maximum((np.hypot(p[..., 0], p[..., 1]) - 0.11 - bark - flare) * 0.7, np.abs(p[..., 2] - 0.14) - 0.14)
    return blend(d, rod(p, (0.05, 0.05, 0.18), (0.16, 0.14, 0.26), 0.025), 0.02)


def bumps(p, size, seed):
    """Smooth noise, about ± 1, with features of this size [m]."""
    random = np.random.default_rng(seed)
    total = np.zeros(p.shape[:-1])
    for _ in range(12):
        k = random.normal(size=3)
        total += np.sin(p @ (k / np.linalg.norm(k) * 2 * np.pi / size * random.uniform(0.7, 1.4)) + random.uniform(0, 6.3))
    return total / 3.5


def rock(p):
    return (ball(p, (0, 0, 0.08), (0.15, 0.12, 0.10)) - 0.012 * bumps(p, 0.11, 1) - 0.002 * bumps(p, 0.03, 2)) * 0.8


def scanned_ball(p):
    return ball(p, (0, 0, 0.10), (0.11, 0.11, 0.11)) - 0.0006 * bumps(p, 0.014, 3)


def cushion(p):
    thick = 0.055 * np.sqrt(np.clip((1 - (p[..., 0] / 0.19) ** 2) * (1 - (p[..., 1] / 0.17) ** 2), 0, 1)) ** 0.8
    d = np.maximum(np.abs(p[..., 2] - 0.06) - thick, np.maximum(np.abs(p[..., 0]) - 0.19, np.abs(p[..., 1]) - 0.17))
    return (d + 0.012 * np.exp(-(p[..., 0] ** 2 + p[..., 1] ** 2) / 0.02**2)) * 0.7


def vase(p):
    z = p[..., 2]
    r = 0.075 + 0.035 * np.sin(2 * np.pi * (z - 0.02) / 0.30)
    wall = np.abs(np.hypot(p[..., 0], p[..., 1]) - r) * 0.8 - 0.004
    return np.minimum(np.maximum(wall, np.abs(z - 0.14) - 0.14), upright(p, (0, 0), 0.075, 0, 0.01))


def pumpkin(p):
    a = np.arctan2(p[..., 1], p[..., 0])
    r = np.hypot(p[..., 0], p[..., 1])
    d = np.hypot(r - 0.065 - 0.010 * np.abs(np.cos(5 * a)) * np.clip(r / 0.08, 0, 1), (p[..., 2] - 0.085) * 0.95) - 0.078
    d = np.minimum(d, upright(p, (0, 0), 0.05, 0.03, 0.13))
    return blend(d * 0.8, rod(p, (0, 0, 0.12), (0.02, 0, 0.19), 0.012), 0.015)


def shoe(p):
    d = blend(rod(p, (-0.09, 0, 0.055), (0.10, 0.01, 0.035), 0.042), ball(p, (-0.08, 0, 0.10), (0.055, 0.042, 0.06)), 0.04)
    d = np.maximum(d, -ball(p, (-0.09, 0, 0.15), (0.042, 0.03, 0.07)))
    for k in range(4):
        x = -0.02 + 0.02 * k
        d = np.minimum(d, rod(p, (x, -0.025, 0.085 - 0.3 * (x + 0.02)), (x, 0.025, 0.085 - 0.3 * (x + 0.02)), 0.003))
    return np.minimum(d, box(p, (0.005, 0, 0.01), (0.145, 0.046, 0.010), 0.008))


def small_mug(p):
    d = np.maximum(upright(p, (0, 0), 0.06, 0, 0.15), -upright(p, (0, 0), 0.054, 0.01, 0.5))
    return np.minimum(d, np.maximum(ring(p, (0, 0.065, 0.075), 0, 0.035, 0.008), -upright(p, (0, 0), 0.057, -1, 1)))


def hull(p):
    keel = 0.10 * np.sqrt(np.clip(1 - (p[..., 0] / 0.21) ** 2, 0, 1))
    d = np.hypot(p[..., 1] / 0.9, np.maximum(p[..., 2], 0)) - keel
    return blend(d * 0.7, box(p, (-0.02, 0, 0.095), (0.12, 0.006, 0.02)), 0.015)


def saddle_shell(p):
    z = 0.10 + 2.2 * (p[..., 0] ** 2 - p[..., 1] ** 2)
    shell = np.abs(p[..., 2] - z) * 0.7 - 0.004
    return np.minimum(np.maximum(shell, np.hypot(p[..., 0], p[..., 1]) - 0.15), upright(p, (0, 0), 0.02, 0, 0.10))


def bicycle_helmet(p):
    d = np.maximum(ball(p, (0, 0, 0.03), (0.15, 0.105, 0.125)), 0.01 - p[..., 2])
    for y in (-0.055, 0.0, 0.055):
        for x in (-0.09, 0.0, 0.08):
            d = np.maximum(d, -ball(p, (x, y, 0.14 - 1.6 * y * y), (0.030, 0.009, 0.03)))
    return np.maximum(d, -ball(p, (0, 0, 0.0), (0.125, 0.082, 0.105)))


FIRST = (skull, bust, boot, guitar, mug, chair, tall_chair, helmet, lamp, car, trunk)
SECOND = (rock, scanned_ball, cushion, vase, pumpkin, shoe, small_mug, hull, saddle_shell, bicycle_helmet)
OBJECTS = {f.__name__: f for f in FIRST + SECOND}


def mesh_of(distance):
    low, high = np.array([-0.26, -0.26, -0.02]), np.array([0.42, 0.26, 0.60])
    axes = [np.arange(a, b, CELL) for a, b in zip(low, high)]
    p = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    d = np.maximum(distance(p), 0.001 - p[..., 2])
    vertices, faces, _, _ = marching_cubes(d, 0.0, spacing=(CELL,) * 3)
    return trimesh.Trimesh(vertices + low, faces)


def stood(mesh, width=None, up="z"):
    """Before the arm, on the table."""
    if up != "z":
        mesh.vertices = mesh.vertices[:, [1, 2, 0]] if up == "x" else mesh.vertices[:, [0, 2, 1]] * (1, -1, 1)
    low, high = mesh.bounds
    if width:
        mesh.apply_scale(width / (high - low)[:2].max())
        low, high = mesh.bounds
    mesh.apply_translation([0.60 - (low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]])
    return mesh


def capture(mesh, folder, width=640, height=480, f=554.3):
    table = trimesh.creation.box((0.9, 1.2, 0.02), trimesh.transformations.translation_matrix((0.7, 0, -0.01)))
    scene = trimesh.util.concatenate([mesh, table])
    rays = trimesh.ray.ray_pyembree.RayMeshIntersector(scene)
    about = np.array([0.6, 0.0, mesh.bounds[1][2] / 2])
    images, poses = [], list(eyes.cameras(about, distance=0.85, height=0.60))
    i, j = np.meshgrid(np.arange(width), np.arange(height))
    d_C = np.stack([(i - (width - 1) / 2) / f, (j - (height - 1) / 2) / f, np.ones_like(i, float)], -1).reshape(-1, 3)
    for R, p in poses:
        direction = d_C @ R.T
        unit = direction / np.linalg.norm(direction, axis=1)[:, None]
        point, ray, _ = rays.intersects_location(np.broadcast_to(p, unit.shape), unit, multiple_hits=False)
        depth = np.zeros(len(unit))
        depth[ray] = (point - p) @ R[:, 2]
        images.append(np.round(1e3 * depth).reshape(height, width).astype(np.uint16))
    eyes.WIDTH, eyes.HEIGHT = width, height
    eyes.write_capture(folder, images, poses, [0.0] * 7, lens=(f, f, (width - 1) / 2, (height - 1) / 2))
    views = json.loads((folder / "capture.json").read_text())
    for view in views["views"]:
        del view["joints"]  # the arm is not in the picture
    (folder / "capture.json").write_text(json.dumps(views))


def draw(program, folder, more):
    command = [
        program, "draw", "--text", "Hello", "--place", "surface", "--skip-unreachable", "--out", str(folder / "run"),
        "--set", "drawing.placement.width=100", "--set", "perception.source=capture", "--set", f"perception.capture={folder}",
        "--set", "canvas.kind=mesh", "--set", f"canvas.mesh.file={folder}/object.obj", *more]
    done = subprocess.run(command, capture_output=True, text=True)
    (folder / "said.txt").write_text(" ".join(command) + "\n" + done.stdout + done.stderr)
    try:
        m = json.loads((folder / "run" / "metrics.json").read_text())
    except OSError:
        return f"exit {done.returncode}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ''}"
    share = m["length_promised"] / m["length_asked"] if m.get("length_asked") else float("nan")
    good = share >= 0.98 and m["coverage"] >= 0.98 and m["force_sd"] <= 0.6
    return f"{'ok ' if good else 'MISS'} share {share:.3f} coverage {m['coverage']:.3f} SD {m['force_sd']:.2f} N exit {done.returncode}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default="build/release/src/app/impedraw")
    parser.add_argument("--only", default=",".join(OBJECTS))
    parser.add_argument("--mesh", nargs="*", default=[], help="of others, instead")
    parser.add_argument("--up", choices="xyz", default="z", help="axis of those")
    parser.add_argument("--width", type=float, default=0.3, help="of those [m]")
    parser.add_argument("--captures", action="store_true", help="draws nothing")
    parser.add_argument("--set", action="append", default=[])
    a = parser.parse_args()
    more = [x for s in a.set for x in ("--set", s)]
    made = {pathlib.Path(m).stem: lambda m=m: stood(trimesh.load(m, force="mesh"), a.width, a.up) for m in a.mesh}
    if not made:
        made = {name: lambda f=OBJECTS[name]: stood(mesh_of(f)) for name in a.only.split(",")}
    for name, make in made.items():
        folder = a.folder / name
        if not (folder / "capture.json").exists():
            folder.mkdir(parents=True, exist_ok=True)
            mesh = make()
            mesh.export(folder / "object.obj")
            capture(mesh, folder)
        if not a.captures:
            print(f"{name:10} {draw(a.program, folder, more)}", flush=True)


main()
