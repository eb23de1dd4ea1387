"""What the engine costs: two workers against two serial loops that know nothing of it.

    PYTHONPATH=build/release/python build/sweep-venv/bin/python tests/sweep/efficiency.py [RUNS]

Draws the same 20 mm lines (RUNS in all, default 600) by two plain loops over impedraw's runner, each
in a process of its own, and by a sweep on two workers. Start-up is left out of both: the loops
count from their second run on, the sweep from its second written part to its last. Prints the
ratio of the two rates, and how much longer a run takes in a worker than by itself, of a serial
sweep. Measures wall time: run it on a machine that does nothing else.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pyarrow.parquet as pq

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


def sweep(count: int, out: Path, *more: str) -> tuple[float, float]:
    """Seconds a run (of all workers together, without start-up), and the mean of a run alone."""
    file = out.with_suffix(".yaml")
    file.write_text(SPEC.format(count=count, last=3 + 0.001 * count), encoding="utf-8")
    driver = subprocess.Popen(
        [sys.executable, "-P", "-m", "impedraw.sweep", "--root", str(ROOT), str(file), "--out",
         str(out), "--runner", "native", *more], stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL)
    seen: list[tuple[float, int]] = []  # when, rows
    while driver.poll() is None:
        rows = 0
        for part in [out / "runs.parquet", *out.glob("parts/*.parquet")]:
            try:
                rows += pq.read_metadata(part).num_rows
            except (OSError, ValueError):
                rows = -1
                break
        if rows >= 0 and (not seen or rows > seen[-1][1]):
            seen.append((time.perf_counter(), rows))
        time.sleep(0.05)
    inner = [s for s in seen if s[1] > 8]  # both workers have their scene
    (start, first), (end, last) = inner[0], inner[-1]
    walls = sorted(pq.read_table(out / "runs.parquet")["wall_time"].to_pylist())
    return (end - start) / (last - first), walls[len(walls) // 2]


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 600
    with tempfile.TemporaryDirectory() as folder:
        alone = loops(count // 2, 2)
        together, _ = sweep(count, Path(folder) / "two", "--workers", "2")
        again = loops(count // 2, 2)
        alone = (alone + again) / 2
        one = loops(count // 4, 1)
        serial, inside = sweep(count // 4, Path(folder) / "one", "--serial")
    print(f"two loops: {1e3 * alone / 2:.1f} ms a run; sweep on two workers: "
          f"{1e3 * together:.1f} ms; efficiency {alone / 2 / together:.3f}")
    print(f"one loop: {1e3 * one:.1f} ms a run; serial sweep: {1e3 * inside:.1f} ms within the "
          f"runner (median), {1e3 * serial:.1f} ms in all; overhead {1e3 * (serial - one):.1f} ms")


if __name__ == "__main__":
    main()
