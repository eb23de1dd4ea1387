"""What the engine costs: two workers against two serial loops that know nothing of it.

    PYTHONPATH=build/release/python build/sweep-venv/bin/python tests/sweep/efficiency.py [RUNS]

Draws the same 20 mm lines (RUNS in all, default 600) by two plain loops over impedraw's runner, each
in a process of its own, and by a sweep on two workers. Start-up is left out of both: the loops
count from their second run on, of sweeps the difference of a long and a short one is taken. Prints
the ratio of the two rates, and by how much a run of a serial sweep takes longer than one of a loop.
Measures wall time: run it on a machine that does nothing else.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LOOP = """
import sys, time
from impedraw import _runner
count, first = int(sys.argv[1]), int(sys.argv[2])
start = None
for i in range(count + 1):
    _runner.run({"drawing.redraw": False, "path.draw_speed": 0.1,
                 "control.normal_force": 3 + 0.001 * (first + i)},
                "scenarios/robustness-nominal.yaml", svg="tests/sweep/line.csv")
    if start is None:
        start = time.perf_counter()
print((time.perf_counter() - start) / count)
"""
SPEC = """name: efficiency
scenario: scenarios/robustness-nominal.yaml
svg: tests/sweep/line.csv
set: {{drawing.redraw: false, path.draw_speed: 0.1}}
axes: {{control.normal_force: {{from: 3, to: {last}, count: {count}}}}}
"""


def loops(count: int, many: int) -> float:
    """Seconds a run, of each of the loops, mean."""
    children = [subprocess.Popen([sys.executable, "-c", LOOP, str(count), str(i * count)],
                                 cwd=ROOT, stdout=subprocess.PIPE, text=True) for i in range(many)]
    return sum(float(c.communicate()[0]) for c in children) / many


def sweep(count: int, folder: Path, *more: str) -> float:
    """Seconds of the whole command."""
    out = folder / f"{count}{''.join(more)}"
    file = out.with_suffix(".yaml")
    file.write_text(SPEC.format(count=count, last=3 + 0.001 * count), encoding="utf-8")
    start = time.perf_counter()
    subprocess.run([sys.executable, "-P", "-m", "impedraw.sweep", "--root", str(ROOT), str(file),
                    "--out", str(out), "--runner", "native", *more], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def rate(count: int, folder: Path, *more: str) -> float:
    """Seconds a run, by the difference of a long and a short sweep: start-up drops out."""
    few = count // 5
    return (sweep(count, folder, *more) - sweep(few, folder, *more)) / (count - few)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 600
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        before = loops(count // 2, 2)
        together = rate(count, folder, "--workers", "2")
        alone = (before + loops(count // 2, 2)) / 2
        one = loops(count // 4, 1)
        serial = rate(count // 2, folder, "--serial")
        one = (one + loops(count // 4, 1)) / 2
    print(f"two loops: {1e3 * alone / 2:.1f} ms a run; sweep on two workers: "
          f"{1e3 * together:.1f} ms; efficiency {alone / 2 / together:.3f}")
    print(f"one loop: {1e3 * one:.1f} ms a run; serial sweep: {1e3 * serial:.1f} ms; "
          f"overhead {1e3 * (serial - one):.1f} ms")


if __name__ == "__main__":
    main()
