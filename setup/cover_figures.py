"""Treats the surfaces of docs/cover.md and writes its table.

    python setup/cover_figures.py PROGRAM FOLDER     FOLDER gets the meshes and the runs
"""
import json
import pathlib
import subprocess
import sys

import cover_meshes
from quotes import fill_part

ROOT = pathlib.Path(__file__).resolve().parents[1]
SURFACES = {
    "dome": "dome (`./impedraw cover`)", "saddle": "saddle", "door": "car door with crease and recess",
    "hole": "plane with a hole", "ell": "an L", "step": "step of 8 mm", "vase": "lying vase", "torus": "torus",
    "helmet": "helmet with slits", "strip": "strip of 44 mm", "duck": "duck",
}  # fmt: skip
BUILT_IN = {"dome": [], "saddle": ["--set", "canvas.kind=saddle"]}


def row(program, folder, name):
    file = ROOT / "build/surface-meshes/duck.obj" if name == "duck" else folder / f"{name}.obj"  # setup/surface_meshes.py makes the duck
    mesh = ["--set", "canvas.kind=mesh", "--set", f"canvas.mesh.file={file}"]
    run = subprocess.run(
        [program, "cover", *BUILT_IN.get(name, mesh), "--out", folder / name, "--overwrite"], cwd=ROOT, capture_output=True, text=True
    )
    if run.returncode:
        sys.exit(f"{name}: {run.stderr.strip()}")
    m = json.loads((folder / name / "metrics.json").read_text())
    cells = [
        SURFACES[name], f"{m['treated_share']:.4f}", f"{m['promised_share']:.3f}", f"{m['force_mean']:.2f}, {m['force_rms_error']:.2f}",
        f"{100 * m['removal_cv']:.1f} %", f"{100 * m['removal_map_error']:.1f} %", f"{m['unsaid_share']:.4f}",
    ]  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    cover_meshes.write(folder)
    lines = [
        "| surface | treated | promised | force, and its RMS error from what is asked there [N] | removal even to | map of the arm off by | untreated, unsaid |",
        "|---" * 7 + "|",
    ]
    for name in SURFACES:
        print(name, file=sys.stderr)
        lines.append(row(program, folder, name))
    fill_part(ROOT / "docs/cover.md", "treated", lines)


if __name__ == "__main__":
    main()
