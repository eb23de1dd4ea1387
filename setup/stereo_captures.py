"""Sine and M on the bowl, text on the wave, by three views with a stereo camera's faults (tests/foreign/eyes.py), that Embree renders.

    V/bin/pip install numpy trimesh embreex pyyaml      (V: a venv, as for setup/place_captures.py)
    V/bin/python setup/stereo_captures.py FOLDER [--program build/release/src/app/impedraw] [--seeds 3]

Writes FOLDER/NAME_SEED/{capture.json, depth_*.png} and its run, and prints a line of figures for each. The arm is impedraw's own.
"""
import argparse
import json
import pathlib
import subprocess
import sys

import numpy as np
import trimesh

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests/foreign"), str(ROOT / "tests/foreign/drake")]
import eyes  # noqa: E402
import scene  # noqa: E402

DRAWINGS = {
    "sine": ("bowl", ["scenarios/bowl-sine.yaml"]),
    "m": ("bowl", ["scenarios/bowl-m.yaml"]),
    "text": ("wave", ["scenarios/artwork.yaml", "--text", "Hello", "--set", "canvas.kind=wave"]),
}
FIGURES = ("contact_fraction", "coverage", "ink_error_rms", "ink_error_max", "force_sd", "touchdown_peak", "tilt_mean")


def depths(rays, R, p):
    i, j = np.meshgrid(np.arange(eyes.WIDTH), np.arange(eyes.HEIGHT))
    unit = np.stack([(i - eyes.CX) / eyes.FX, (j - eyes.CY) / eyes.FY, np.ones_like(i, float)], -1).reshape(-1, 3) @ R.T
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    point, ray, _ = rays.intersects_location(np.broadcast_to(p, unit.shape), unit, multiple_hits=False)
    depth = np.zeros(len(unit))
    depth[ray] = (point - p) @ R[:, 2]
    return depth.reshape(eyes.HEIGHT, eyes.WIDTH)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default=ROOT / "build/release/src/app/impedraw")
    parser.add_argument("--seeds", type=int, default=3)
    a = parser.parse_args()
    a.folder.mkdir(parents=True, exist_ok=True)
    table = trimesh.creation.box((0.8, 1.2, 0.02), trimesh.transformations.translation_matrix((0.7, 0, -0.01)))
    for name, (canvas, arguments) in DRAWINGS.items():
        mesh = trimesh.load(scene.CANVASES[canvas](str(a.folder / f"{canvas}.obj")), force="mesh")
        rays = trimesh.ray.ray_pyembree.RayMeshIntersector(trimesh.util.concatenate([mesh, table]))
        poses = list(eyes.cameras((0.60, 0.0, 0.12)))
        images = [depths(rays, R, p) for R, p in poses]
        for seed in range(1, a.seeds + 1):
            folder = (a.folder / f"{name}_{seed}").resolve()
            eyes.write_capture(folder, images, poses, [0.0] * 7, seed)
            capture = json.loads((folder / "capture.json").read_text())
            for view in capture["views"]:
                del view["joints"]  # the arm is not in the picture
            (folder / "capture.json").write_text(json.dumps(capture))
            done = subprocess.run(
                [a.program, "draw", *arguments, "--out", folder / "run", "--overwrite", "--set", "perception.source=capture",
                 "--set", f"perception.capture={folder}"], cwd=ROOT, capture_output=True, text=True)  # fmt: skip
            m = json.loads((folder / "run/metrics.json").read_text()) if done.returncode == 0 else {}
            print(name, seed, *(f"{f} {m[f]:.4g}" for f in FIGURES if f in m), f"exit {done.returncode}", flush=True)


main()
