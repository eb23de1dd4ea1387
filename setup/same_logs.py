"""Compares the logs of this tree's program with those of a base, bit by bit: a change that should change nothing changes no log.

    .venv/bin/python setup/same_logs.py BASE [PATTERN ...] [--program PROGRAM] [--out FOLDER]

BASE: a program (build/release/src/app/impedraw of another tree, or a copy), or a commit, which is built in FOLDER. Draws the scenarios
whose file is named like a PATTERN (default: every one that is not SLOW) and VARIANTS of them, which use what no scenario does; two runs
at a time. Prints the datasets of run.h5 that differ, with the first row that does; a case without a log differs. Measured times may
differ, and nothing else. The base's logs are kept in FOLDER (default: build/same_logs): comparing again costs one set of runs. The exit
code is 1 if any log differs.
"""
import argparse
import fnmatch
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
SLOW = {"gallery-cylinder", "gallery-leaf", "gallery-wall", "moving-shape", "wall"}  # 10 to 25 s; the others take 1 to 8 s
MEASURED = {"controller/step_time", "every_step/step_time"}
# Name → scenario and settings, for what no scenario uses.
VARIANTS = {
    "scaled": ("bowl-m", ["control.inertia=scaled", "control.inertia_scale=2"]),
    "paper-surface-axis": ("reach-wave", ["control.projection=paper", "control.pen_axis=surface"]),
    "felt-integral": ("reach-terrain", ["control.felt_normal.share=0.5", "control.force_integral.enabled=true", "control.normal_error=10"]),
    "feedforward": ("bowl-m-natural", ["control.friction_feedforward=0.3", "control.tip_stiffness=0"]),
    "moving-natural": ("moving-heave", ["control.wrench=realistic", "control.inertia=natural", "control.felt_normal.share=0.3"]),
    "moving-paper": ("moving-turntable", ["control.projection=paper", "control.pen_axis=surface", "control.force_integral.enabled=true"]),
    "slow-joints": ("bowl-m", ["control.joint_speed_share=0.3", "control.turn_speed_limit=1.5", "control.torque_rate=1000"]),
    "yields": ("bowl-push-elbow", ["control.observer.yield_limit=[1,1,1,1,1,1,1]", "world.joint_friction=2"]),
    "singular-weak": ("safety-singular", ["control.torque_share=0.15"]),
}  # fmt: skip


def program_of(base, out):
    """The base's program: the file itself, or built from a commit in a tree of its own."""
    if os.access(base, os.X_OK) and pathlib.Path(base).is_file():
        return pathlib.Path(base).resolve()
    found = subprocess.run(["git", "rev-parse", "--verify", "--quiet", f"{base}^{{commit}}"], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if found.returncode != 0:
        sys.exit(f"same_logs: '{base}' is neither a program nor a commit")
    tree = out / found.stdout.strip()
    if not tree.exists():
        subprocess.run(["git", "worktree", "add", "--detach", tree, found.stdout.strip()], cwd=ROOT, check=True)
    subprocess.run([tree / "impedraw", "--version"], check=True)  # builds what is missing
    return tree / "build/release/src/app/impedraw"


def cases(patterns):
    every = {file.stem: (file.stem, []) for file in sorted((ROOT / "scenarios").glob("*.yaml"))} | VARIANTS
    if patterns:
        return {name: case for name, case in every.items() if any(fnmatch.fnmatch(name, p) for p in patterns)}
    return {name: case for name, case in every.items() if name not in SLOW}


def draw(program, scenario, settings, folder):
    """Draws into `folder`, unless its log is there. Returns what the program said if there is no log, else None."""
    if (folder / "run.h5").exists():
        return None
    fresh = folder.with_suffix(".part")
    shutil.rmtree(fresh, ignore_errors=True)
    command = [program, "draw", ROOT / f"scenarios/{scenario}.yaml", "--out", fresh, *(w for s in settings for w in ("--set", s))]
    ended = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if not (fresh / "run.h5").exists():
        return ended.stdout.strip().replace(str(fresh), folder.name)
    folder.mkdir(parents=True, exist_ok=True)
    (fresh / "run.h5").rename(folder / "run.h5")
    shutil.rmtree(fresh)
    return None


def datasets(file):
    found = {}
    file.visititems(lambda name, item: found.update({name: item}) if isinstance(item, h5py.Dataset) else None)
    return found


def rows_of(dataset):
    """The values, rows first, as bytes: so that NaN equals itself, and 0 does not equal −0."""
    values = np.atleast_1d(dataset[()])
    if values.dtype.hasobject:
        return values
    return np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1) if values.size else values


def differences(base, here):
    """One line for each dataset that differs."""
    with h5py.File(base) as a, h5py.File(here) as b:
        mine, yours = datasets(a), datasets(b)
        for name in sorted(mine.keys() | yours.keys()):
            if name in MEASURED:
                continue
            if name not in mine or name not in yours:
                yield f"{name}: only in {'the base' if name in mine else 'this tree'}"
                continue
            if mine[name].dtype != yours[name].dtype or mine[name].shape[1:] != yours[name].shape[1:]:
                yield f"{name}: {mine[name].dtype} {mine[name].shape} in the base, {yours[name].dtype} {yours[name].shape} here"
                continue
            x, y = rows_of(mine[name]), rows_of(yours[name])
            shared = min(len(x), len(y))
            differ = (x[:shared] != y[:shared]).reshape(shared, -1).any(axis=1) if shared and x.size else np.zeros(0, bool)
            if differ.any():
                yield f"{name}: {differ.sum()} of {shared} rows differ, the first is row {differ.argmax()}"
            if len(x) != len(y):
                yield f"{name}: {len(x)} rows in the base, {len(y)} here"


def compare(name, case, base, here):
    """The lines to print for one case; none if the logs are the same."""
    (base_program, base_folder), (program, folder) = base, here
    said = draw(base_program, *case, base_folder / name), draw(program, *case, folder / name)
    if any(said):
        return [f"no log of the base: {said[0] or 'it has one'}", f"nor here: {said[1] or 'there is one'}"]
    return list(differences(base_folder / name / "run.h5", folder / name / "run.h5"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", metavar="BASE")
    parser.add_argument("patterns", metavar="PATTERN", nargs="*")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/src/app/impedraw")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/same_logs")
    given = parser.parse_args()
    out = given.out.resolve()
    chosen = cases(given.patterns)
    programs = program_of(given.base, out), given.program.resolve()
    # Logs are kept for the same program and scenarios.
    drawn = b"".join(file.read_bytes() for file in sorted((ROOT / "scenarios").glob("*.yaml"))) + repr(VARIANTS).encode()
    folders = [out / hashlib.sha256(program.read_bytes() + drawn).hexdigest()[:16] for program in programs]
    sides = list(zip(programs, folders))
    wrong = 0
    with ThreadPoolExecutor(2) as pool:
        lines = {name: pool.submit(compare, name, case, *sides) for name, case in chosen.items()}
        for number, (name, future) in enumerate(lines.items(), 1):
            wrong += bool(future.result())
            print(f"{number:3} of {len(chosen)}  {name:<28} {'DIFFERS' if future.result() else 'same'}", flush=True)
            for line in future.result():
                print(f"      {line}", flush=True)
    print(f"{len(chosen) - wrong} of {len(chosen)} logs are the same" if chosen else "no scenario is named so")
    return 1 if wrong or not chosen else 0


if __name__ == "__main__":
    sys.exit(main())
