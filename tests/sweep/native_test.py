"""The runner in the worker's process gives the figures of the child process.

Needs the compiled package.
"""

import pytest

from conftest import needs_program, sweep
from impedraw.sweep.dataset import read_dataset
from process_test import SHORT, write

pytest.importorskip("impedraw._runner", reason="the compiled package is not installed")


@needs_program
def test_native_runs_are_those_of_the_program(tmp_path):
    file = write(tmp_path, SHORT + "accept: {light: force_mean < 4}\ncase: '{how}'\naxes:\n  how:\n"
                 "    levels:\n      good: {control.normal_force: 3}\n"
                 "      other: {control.normal_force: 5, seed: 2}\n"
                 "      refused: {canvas.kind: mesh}\n")
    rows = {}
    for runner in ("process", "native"):
        done = sweep(file, tmp_path / runner, "--serial", runner=runner)
        assert done.returncode == 0, done.stderr
        rows[runner] = {r["case"]: r for r in read_dataset(tmp_path / runner)[0].to_pylist()}
    assert rows["native"].keys() == rows["process"].keys() == {"good", "other", "refused"}
    compared = 0
    for name, process in rows["process"].items():
        native = rows["native"][name]
        assert (native["state"], native["failed"]) == (process["state"], process["failed"])
        metrics = set(list(process)[list(process).index("null_metrics") :])
        for column in metrics & {"coverage", "ink_error_rms", "force_mean", "force_sd", "ink_up",
                                 "tilt_max", "speed_mean", "draw_time", "joint_margin_min"}:
            assert native[column] == process[column], column
            compared += process[column] is not None
        for column in ("path.draw_speed", "canvas.kind", "control.normal_force", "seed"):
            if process[column] is not None:
                assert native[column] == process[column], column
    assert compared >= 16


def test_every_way_to_end_a_run_is_a_row(tmp_path):
    """Signals, a hang, no memory left: the next run of the same worker goes on."""
    file = write(tmp_path, "name: fault\nscenario: scenarios/robustness-nominal.yaml\n"
                 "svg: tests/sweep/line.csv\nset: {drawing.redraw: false}\n"
                 "limits: {time: 20, memory: 2.5}\ncase: 'n{seed}'\nseeds: 6\n")
    fault = {"n2": "SIGSEGV", "n3": "hang", "n4": "memory", "n5": "SIGKILL"}
    done = sweep(file, tmp_path / "d", "--serial", runner="native", options={"fault": fault})
    assert done.returncode == 0, done.stderr
    rows = read_dataset(tmp_path / "d")[0].to_pylist()
    assert [(r["case"], r["state"], (r["cause"] or "")[:32]) for r in rows] == [
        ("n1", "ok", ""), ("n2", "crashed", "crashed: signal 11 (SIGSEGV)"),
        ("n3", "timeout", "timeout: took longer than 20 s"),
        ("n4", "crashed", "crashed: out of memory: the limit"[:32]),
        ("n5", "crashed", "crashed: signal 9 (SIGKILL)"), ("n6", "ok", "")]
    assert rows[0]["coverage"] == rows[5]["coverage"] > 0.99


def test_sweep_from_python(tmp_path, monkeypatch):
    import impedraw

    monkeypatch.chdir(tmp_path)
    spec = {"name": "forces", "scenario": "scenarios/robustness-nominal.yaml",
            "svg": "tests/sweep/line.csv", "set": {"drawing.redraw": False},
            "axes": {"control.normal_force": [3, 5]}, "case": "{control.normal_force}N"}
    done = impedraw.sweep(spec, serial=True)
    assert [r["case"] for r in done.rows] == ["3N", "5N"] and len(done) == 2
    assert [round(r["force_mean"]) for r in done.rows] == [3, 5]
    assert done.folder.samefile(tmp_path / "runs/forces") and "2 runs, 0 failed" in repr(done)
    again = impedraw.sweep(spec, workers=2)  # on Ray: there is nothing left to do
    assert again.table.equals(done.table)
    assert impedraw.Sweep.open("runs/forces").table.equals(done.table)
    with pytest.raises(ValueError, match="control.normal_fors: .*control.normal_force"):
        impedraw.sweep({**spec, "axes": {"control.normal_fors": [1]}}, out="other")
    assert not (tmp_path / "other").exists()


def test_sweep_leaves_a_ray_that_is_the_callers(tmp_path, monkeypatch):
    import ray

    import impedraw

    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    ray.init(num_cpus=1, include_dashboard=False, log_to_driver=False, object_store_memory=80 * 2**20)
    try:
        done = impedraw.sweep({"name": "one", "scenario": "scenarios/robustness-nominal.yaml",
                               "svg": "tests/sweep/line.csv"}, out=tmp_path / "d")
        assert len(done) == 1 and done.rows[0]["state"] == "ok" and ray.is_initialized()
    finally:
        ray.shutdown()
