"""Runs of the program: figures as `impedraw draw` gives them, and every way to fail is a row."""

import json
import os
import shlex
import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, command, needs_program, sweep
from impedraw.sweep.dataset import read_dataset, without_wall_times
from impedraw.sweep.rows import WALL_COLUMNS

SHORT = """name: short
scenario: scenarios/robustness-nominal.yaml
set: {drawing.redraw: false, drawing.placement.scale: 0.15, path.draw_speed: 0.1}
"""

pytestmark = needs_program


def write(tmp_path, text):
    file = tmp_path / "s.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def rows_of(folder):
    return {row["case"]: row for row in read_dataset(Path(folder))[0].to_pylist()}


def test_figures_are_those_of_draw_and_of_a_serial_sweep(tmp_path):
    file = write(tmp_path, SHORT + "axes: {control.normal_force: [3, 5], seed: [1, 2]}\n"
                 "case: '{control.normal_force}N-{seed}'\n")
    done = sweep(file, tmp_path / "d", runner="process")
    assert done.returncode == 0, done.stderr
    again = sweep(file, tmp_path / "serial", "--serial", runner="process")
    assert again.returncode == 0, again.stderr
    mine, serial = (without_wall_times(read_dataset(tmp_path / f)[0]) for f in ("d", "serial"))
    assert mine.num_rows == 4 and mine.equals(serial)
    listed = sweep(file, tmp_path / "d", "--list").stdout.splitlines()
    draw = shlex.split(listed[listed.index("5N-2") + 1])[1:]
    subprocess.run([os.environ["IMPEDRAW"], *draw, "--out", str(tmp_path / "run")], cwd=ROOT,
                   check=True, capture_output=True)
    metrics = json.loads((tmp_path / "run/metrics.json").read_text(encoding="utf-8"))
    row = rows_of(tmp_path / "d")["5N-2"]
    compared = 0
    for name, value in metrics.items():
        if isinstance(value, (int, float)) and name not in WALL_COLUMNS:
            assert row[name] == value, name
            compared += 1
    assert compared > 20
    # Every setting, also those that the specification leaves alone.
    assert row["control.normal_force"] == 5 and row["seed"] == 2
    assert row["canvas.kind"] == "plane" and row["path.draw_acceleration"] == 2
    assert row["perception.fiducials.noise"] == 3e-4  # written as 3e-04, no number in YAML 1.1
    assert row["canvas.plane.normal"] == [0, 0, 1]


def test_a_block_keeps_what_it_asks_for(tmp_path):
    file = write(tmp_path, SHORT + """keep: {log: failed}
blocks:
  - {case: plain, set: {control.normal_force: 3}}
  - {case: log, keep: {log: always}}
  - {case: pictures, keep: {pictures: always}, set: {control.normal_force: 4}}
""")
    done = sweep(file, tmp_path / "d", "--serial", runner="process")
    assert done.returncode == 0, done.stderr
    kept = {name: tmp_path / "d/kept" / row["key"] for name, row in rows_of(tmp_path / "d").items()}
    assert not kept["plain"].exists()
    assert (kept["log"] / "run.h5").exists() and not (kept["log"] / "ink_top.png").exists()
    assert (kept["pictures"] / "ink_top.png").exists()
    assert not (kept["pictures"] / "run.h5").exists()


def test_failures_are_rows_with_their_reason_and_keep_what_was_asked(tmp_path):
    file = write(tmp_path, SHORT + """keep: {log: failed}
case: '{how}'
accept: {light: force_mean <= 4 or control.normal_force > 10}
axes:
  how:
    levels:
      good: {control.normal_force: 3}
      missed: {control.normal_force: 5}
      refused: {canvas.kind: mesh}
      stopped:
        scenario: scenarios/bowl-sine.yaml
        world.errors.rotor_inertia: 0.3
        control.check_rotors: false
        preflight.arm: false
        drawing.placement.scale: 1
""")
    done = sweep(file, tmp_path / "d", "--workers", "2", runner="process")
    assert done.returncode == 0, done.stderr
    assert "4 runs, 3 failed" in done.stdout
    rows = rows_of(tmp_path / "d")
    for name, row in rows.items():
        assert row["state"] == {"good": "ok"}.get(name, name), row["cause"]
    assert rows["missed"]["cause"].startswith("light: force_mean <= 4 or control.normal_force > 10,"
                                              " but force_mean is ")
    assert "canvas.mesh.file" in rows["refused"]["cause"]
    assert "above its speed limit" in rows["stopped"]["cause"]
    assert "ink_error_rms" in json.loads(rows["stopped"]["null_metrics"])
    kept = {k.name for k in (tmp_path / "d/kept").iterdir()}
    assert kept == {rows["missed"]["key"], rows["stopped"]["key"]}  # the refused one has no run
    assert (tmp_path / "d/kept" / rows["missed"]["key"] / "run.h5").exists()
    assert not (tmp_path / "d/scratch").exists()
    page = (tmp_path / "d/report.html").read_text(encoding="utf-8")
    assert "Failed runs: 3" in page and "http" not in page.replace("http-equiv", "")
    assert shlex.join(["./impedraw", "draw"]) in page


@pytest.mark.parametrize(("script", "limits", "state", "cause"), [
    ("kill -SEGV $$", "", "crashed", "crashed: signal 11 (SIGSEGV)"),
    ("sleep 60", "limits: {time: 0.5}", "timeout", "timeout: took longer than 0.5 s"),
    ("exit 0", "", "error", "cannot be read"),
    ("echo 'impedraw: no such arm' >&2; exit 2", "", "refused", "refused: no such arm"),
    ("exec python3 -c 'x = bytearray(3 * 10**8)'", "limits: {memory: 0.2}", "crashed", "exit code"),
])
def test_a_program_that_fails_is_a_row(tmp_path, script, limits, state, cause):
    program = tmp_path / "program"
    program.write_text(f"#!/bin/bash\n{script}\n", encoding="utf-8")
    program.chmod(0o755)
    words = command(write(tmp_path, SHORT + limits), tmp_path / "d", "--serial", runner="process")
    words[words.index("--program") + 1] = str(program)
    done = subprocess.run(words, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    (row,) = rows_of(tmp_path / "d").values()
    assert row["state"] == state and cause in row["cause"]


def test_a_changed_program_is_another_data_set(tmp_path):
    file = write(tmp_path, SHORT)
    program = tmp_path / "program"
    for n, code in ((1, 0), (2, 2)):
        program.write_text(f"#!/bin/bash\nexit {n}\n", encoding="utf-8")
        program.chmod(0o755)
        words = command(file, tmp_path / "d", "--serial", runner="process")
        words[words.index("--program") + 1] = str(program)
        done = subprocess.run(words, capture_output=True, text=True, timeout=240)
        assert done.returncode == code, done.stderr
    assert "another build" in done.stderr and done.stderr.count("\n") == 1
