"""Treats the surfaces of docs/cover.md and writes its table and its picture.

    python setup/cover_figures.py PROGRAM FOLDER [SURFACE ...]     FOLDER gets the meshes and the runs; SURFACE: only these

A run that FOLDER holds already is not repeated: after an interrupt it goes on, and an empty FOLDER measures all anew. Two run at a time.
"""
import concurrent.futures
import json
import pathlib
import shutil
import subprocess
import sys

import cover_meshes
from quotes import fill_part

ROOT = pathlib.Path(__file__).resolve().parents[1]


def scanned(name):
    """The arguments for an object of setup/surface_meshes.py."""
    mesh = ROOT / f"build/surface-meshes/{name}.obj"
    return ["--set", "canvas.kind=mesh", "--set", f"canvas.mesh.file={mesh}", "--set", "canvas.mesh.position=[0.6,0,0]"]


WINDOW = '<svg xmlns="http://www.w3.org/2000/svg" width="150mm" height="150mm"><rect width="150mm" height="150mm"/></svg>'
HILLS = "--set canvas.kind=terrain --set perception.noise.sigma_at_1m=0.0012 --region FOLDER/window.svg --set drawing.placement.scale=1 --set drawing.placement.centre=[0.605,0.005]"
SURFACES = {  # name: in the table, arguments beside the mesh of that name, whether there is one
    "dome": ("dome (`./impedraw cover`)", [], False),
    "saddle": ("saddle", ["--set", "canvas.kind=saddle"], False),
    "curve": ("a car door's curve", [], True),
    "terrain": ("150 × 150 mm of hills, 1.2 mm of depth noise at 1 m", HILLS.split(), False),
    "duck": ("duck", scanned("duck"), False),
    "door": ("car door with crease and recess", [], True),
    "hole": ("plane with a hole", [], True),
    "ell": ("an L", [], True),
    "step": ("step of 8 mm", [], True),
    "vase": ("lying vase", [], True),
    "torus": ("torus", [], True),
    "helmet": ("helmet with slits", ["--set", "name=helmet"], True),
    "strip": ("strip of 44 mm", [], True),
    "mug": ("mug", scanned("mug"), False),
    "bear": ("teddy bear", scanned("teddy"), False),
    "rabbit": ("rabbit", scanned("bunny"), False),
}
HEAD = (
    "surface", "treated", "promised", "force, its SD, and its RMS error from what is asked there [N]", "mean speed [mm/s]", "removal even to",
    "map of the arm off by", "untreated, unsaid",
)  # fmt: skip


def treat(program, folder, name):
    if not (folder / name / "metrics.json").exists():
        _, arguments, meshed = SURFACES[name]
        mesh = ["--set", "canvas.kind=mesh", "--set", f"canvas.mesh.file={folder / name}.obj"] if meshed else []
        arguments = [a.replace("FOLDER", str(folder)) for a in arguments]
        command = [program, "cover", *mesh, *arguments, "--out", folder / name, "--overwrite"]
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        if run.returncode:
            raise SystemExit(f"{name}: {run.stderr.strip()}")
    print(name, file=sys.stderr, flush=True)


def row(folder, name):
    m = json.loads((folder / name / "metrics.json").read_text())
    cells = [
        SURFACES[name][0], f"{m['treated_share']:.4f}", f"{m['promised_share']:.3f}", f"{m['force_mean']:.2f}, {m['force_sd']:.2f}, {m['force_rms_error']:.2f}",
        f"{m['speed_mean']:.0f}",
        f"{100 * m['removal_cv']:.1f} %", f"{100 * m['removal_map_error']:.1f} %", f"{m['unsaid_share']:.4f}",
    ]  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    names = sys.argv[3:] or list(SURFACES)
    if unknown := set(names) - set(SURFACES):
        sys.exit(f"{', '.join(sorted(unknown))}: no surface of this table; valid are {', '.join(SURFACES)}")
    folder.mkdir(parents=True, exist_ok=True)
    cover_meshes.write(folder)
    (folder / "window.svg").write_text(WINDOW)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda name: treat(program, folder, name), names))
    lines = ["| " + " | ".join(HEAD) + " |", "|---" * len(HEAD) + "|"]
    lines += [row(folder, name) for name in SURFACES if (folder / name / "metrics.json").exists()]
    fill_part(ROOT / "docs/cover.md", "treated", lines)
    if (picture := folder / "helmet/cover.png").exists():
        shutil.copy(picture, ROOT / "docs/cover-helmet.png")


if __name__ == "__main__":
    main()
