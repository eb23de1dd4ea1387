#!/usr/bin/env python3
"""./impedraw bench --python: what a call from Python costs, as ratios to the same call from C++ in the same process, and of whole
commands to each other. Parts alternate; medians are compared. The exit code is 1 if a limit is exceeded. With --fill, the table goes
into docs/python.md.

python_bench.py PACKAGE_FOLDER PROGRAM [--fill]
"""

import datetime
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

PACKAGE, PROGRAM = sys.argv[1:3]
ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/python.md"
sys.path[:0] = [PACKAGE, str(ROOT / "setup")]

import numpy as np  # noqa: E402

import impedraw as idr  # noqa: E402
from quotes import fill_part  # noqa: E402

missed = []
rows = []


def tell(what, ratio, limit, detail):
    verdict = "ok" if ratio <= limit else "MISSED"
    if ratio > limit:
        missed.append(what)
    print(f"{what:<34} {ratio:6.3f}  limit {limit:5.2f}  {verdict:<6} {detail}")
    rows.append(f"| {what} | {ratio:.2f} | {limit:.2f} | {detail} |")


def cpu(call, n):
    start = time.process_time()
    for _ in range(n):
        call()
    return (time.process_time() - start) / n


def alternating(a, b, rounds):
    """Medians of a and b, taken in turn: each changes places with the other from round to round."""
    times = ([], [])
    for i in range(rounds):
        for k in ((0, 1) if i % 2 == 0 else (1, 0)):
            times[k].append((a, b)[k]())
    return statistics.median(times[0]), statistics.median(times[1])


def controller_step():
    arm = idr.ArmModel.standard()
    q = np.array([0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3])
    terms = arm.compute(q, np.zeros(7))
    controller = idr.ImpedanceController(idr.ImpedanceSettings(), 7)
    reference = idr.TipReference(p_WD=terms.X_WE.p, n_WD=-terms.X_WE.R[:, 2])
    surface, F_ext = idr.SurfaceEstimate(), np.zeros(6)
    step = controller.step
    python, native = alternating(
        lambda: cpu(lambda: step(terms, reference, surface, F_ext), 500),
        lambda: controller._time_steps(terms, reference, surface, 500),
        101,
    )
    tell("controller.step / C++", python / native, 1.4, f"{1e6 * python:.1f} µs, {1e6 * native:.1f} µs")


def world_step():
    arm = idr.ArmModel.standard()
    world = idr.World(arm.urdf, idr.Bowl().canvas())
    q = np.array([0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3])
    tau = arm.compute(q, np.zeros(7)).g.copy()

    def python():
        world.set_state(q)
        return cpu(lambda: world.step(tau), 300)

    def native():
        world.set_state(q)
        return world._time_steps(tau, 300)

    a, b = alternating(python, native, 101)
    tell("world.step / C++", a / b, 1.4, f"{1e6 * a:.1f} µs, {1e6 * b:.1f} µs")


def processor_seconds(command, environment):
    """Of a child process."""
    before = os.times()
    subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def draw():
    folder = tempfile.mkdtemp()
    environment = {**os.environ, "PYTHONPATH": PACKAGE, "PYTHONDONTWRITEBYTECODE": ""}
    code = f"import impedraw; impedraw.draw(out={folder + '/python'!r})"

    def python():
        shutil.rmtree(folder + "/python", ignore_errors=True)
        return processor_seconds([sys.executable, "-c", code], environment)

    def program():
        shutil.rmtree(folder + "/program", ignore_errors=True)
        return processor_seconds([PROGRAM, "draw", "--out", folder + "/program"], environment)

    python()
    a, b = alternating(python, program, 7)
    shutil.rmtree(folder)
    tell("impedraw.draw / ./impedraw draw", a / b, 1.05, f"{a:.2f} s, {b:.2f} s of processor time, start of Python included")


def importing():
    environment = {**os.environ, "PYTHONPATH": PACKAGE}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)

    def of(module):
        code = f"import time; a=time.process_time(); import {module}; print(time.process_time()-a)"
        return lambda: float(subprocess.run([sys.executable, "-c", code], check=True, env=environment, capture_output=True, text=True).stdout)

    of("impedraw")()
    a, b = alternating(of("numpy, impedraw"), of("numpy"), 21)
    tell("import impedraw beyond numpy [s]", a - b, 0.1, f"{a:.3f} s, {b:.3f} s of processor time")


for part in (importing, controller_step, world_step, draw):
    part()
if "--fill" in sys.argv:
    fill_part(PAGE, "bench", [
        f"On {os.cpu_count()} cores, Python {sys.version.split()[0]}, {datetime.date.today()}:", "",
        "| | measured | limit | medians |", "|---|---|---|---|", *rows])
sys.exit(1 if missed else 0)
