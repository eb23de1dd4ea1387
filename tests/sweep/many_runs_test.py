"""Drawings of a 20 mm line on a plane, in the worker: complete, each once and as in a serial run,
though the driver is killed three times and a worker once. 500 runs; 10,000 with ./check --all.

IMPEDRAW_SEED chooses the moments. The figures of the long form stand in docs/sweeps.md.
"""

import os
import random
import signal
import subprocess
import time

import pyarrow.parquet as pq
import pytest

from conftest import command, sweep
from engine_test import result, workers_of
from kill_driver import resident

pytest.importorskip("impedraw._impedraw", reason="the compiled package is not installed")

SEED = int(os.environ.get("IMPEDRAW_SEED", "1"))
LONG = os.environ.get("IMPEDRAW_LONG") == "1"
SPEEDS, FORCES, SUBSET = (100, 100, "-0[0-9a-d]") if LONG else (25, 20, "-[0-3]")
SPEC = f"""name: line
scenario: scenarios/robustness-nominal.yaml
svg: tests/sweep/line.csv
set: {{drawing.redraw: false}}
axes:
  path.draw_speed: {{from: 0.05, to: 0.12, count: {SPEEDS}}}
  control.normal_force: {{uniform: [2, 10], count: {FORCES}, seed: 2}}
"""


def rows_in(folder):
    """Rows that are on the disk."""
    count = 0
    for file in [folder / "runs.parquet", *folder.glob("parts/*.parquet")]:
        try:
            count += pq.read_metadata(file).num_rows
        except OSError:  # gathered in runs.parquet meanwhile
            continue
    return count


def run_until(words, out, rows):
    """Starts the driver, and returns it when so many rows are there. None: it ended before."""
    driver = subprocess.Popen(words, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    peak = 0
    while driver.poll() is None:
        peak = max(peak, resident(driver.pid))
        if rows_in(out) >= rows:
            return driver, peak
        time.sleep(0.1)
    return None, peak


def test_many_runs_three_killed_drivers_and_a_killed_worker(tmp_path):
    chance = random.Random(SEED)
    file, out = tmp_path / "line.yaml", tmp_path / "d"
    file.write_text(SPEC, encoding="utf-8")
    total = SPEEDS * FORCES
    words = command(file, out, runner="native")
    moments = sorted(chance.uniform(0.02, 0.7) * total for _ in range(3))
    start, peak = time.monotonic(), 0
    for i, rows in enumerate(moments):
        driver, resident_now = run_until(words, out, rows)
        peak = max(peak, resident_now)
        assert driver is not None, "the sweep ended before it was killed"
        if i == 1:
            workers = workers_of(driver.pid)
            assert workers
            os.kill(chance.choice(workers), signal.SIGKILL)
            time.sleep(chance.uniform(0.0, 3.0))
            assert driver.poll() is None
        driver.send_signal(signal.SIGKILL)
        driver.wait()
    # Rows count twice while parts are gathered, so the end of the driver is what is waited for.
    driver, resident_now = run_until(words, out, 10 * total)
    assert driver is None
    peak = max(peak, resident_now)
    wall = time.monotonic() - start
    rows = result(out)
    assert rows.num_rows == total == len(set(rows["key"].to_pylist()))
    assert not any(rows["failed"].to_pylist())
    serial = sweep(file, tmp_path / "serial", "--serial", f"--only={SUBSET}", runner="native")
    assert serial.returncode == 0, serial.stderr
    subset = result(tmp_path / "serial")
    assert subset.num_rows > (500 if LONG else 100)
    keys = set(subset["key"].to_pylist())
    assert rows.filter([k in keys for k in rows["key"].to_pylist()]).equals(subset)
    assert peak < 1e9
    print(f"seed {SEED}: {total} runs in {wall:.0f} s with all starts, {subset.num_rows} compared, "
          f"driver's memory {peak / 1e6:.0f} MB")
