"""Draws on the study's meshes at random sizes and says which drawings miss a limit, for defects that fixed cases hide.

    .venv/bin/python setup/random_drawings.py SEED NUMBER [PROGRAM]

Each is a mesh of build/surface-meshes (`./impedraw robustness --part surfaces` and setup/other_surfaces.py write them) with
lettering, a spiral or a filled area, 70 to 160 mm wide. The limits are those of studies/other-surfaces.yaml.
Prints how to repeat each that misses one.
"""
import concurrent.futures
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
ARTWORK = ["--set drawing.text.text=Hello", "--svg artwork/spiral.svg", "--svg artwork/hatch.svg"]
ACCEPT = ROOT / "studies/other-surfaces.yaml"
LIMITS = [(name, sense, float(limit)) for name, sense, limit in
          re.findall(r"^  \w+: (\w+) (<=|>=) ([\d.]+)$", ACCEPT.read_text(), re.MULTILINE)]


def cases(seed, number):
    chance = random.Random(seed)
    meshes = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "build/surface-meshes").glob("*.obj"))
    if not meshes:
        sys.exit("build/surface-meshes has no mesh; ./impedraw robustness --part surfaces writes some")
    for _ in range(number):
        mesh, artwork, width = chance.choice(meshes), chance.choice(ARTWORK), chance.randint(70, 160)
        yield (f"scenarios/surfaces.yaml {artwork} --set canvas.kind=mesh --set canvas.mesh.file={mesh} "
               f"--set drawing.placement.width={width}")


def draw(program, arguments):
    """What it misses; None: there is nothing to draw on."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, "draw", *arguments.split(), "--out", folder], cwd=ROOT, capture_output=True, text=True)
        metrics, strokes = pathlib.Path(folder, "metrics.json"), pathlib.Path(folder, "strokes.json")
        if not metrics.exists():
            return None if "nothing can be drawn" in done.stderr else [done.stderr.strip().splitlines()[-1]]
        values = json.loads(metrics.read_text())
        missed = json.loads(strokes.read_text()).get("damped", [])
    if done.returncode:
        missed.append(done.stderr.strip().splitlines()[-1])
    for name, sense, limit in LIMITS:
        value = values[name]
        if value is None or (value < limit if sense == ">=" else value > limit):
            missed.append(f"{name} {value:.3g}, not {sense} {limit:g}" if value is not None else f"{name} is not known")
    return missed


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    program = str(pathlib.Path(sys.argv[3]).resolve() if len(sys.argv) == 4 else ROOT / "impedraw")
    all_cases = list(cases(int(sys.argv[1]), int(sys.argv[2])))
    drawn = bad = 0
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for arguments, missed in zip(all_cases, pool.map(lambda a: draw(program, a), all_cases)):
            if missed is None:
                continue
            drawn += 1
            if missed:
                bad += 1
                print(f"./impedraw draw {arguments}\n    {'; '.join(missed)}", flush=True)
    print(f"seed {sys.argv[1]}: {drawn} drawn, {bad} missed a limit")


if __name__ == "__main__":
    main()
