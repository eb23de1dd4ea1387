"""Tuning proposes the same whatever is killed, and says how good the shipped settings are."""

import re
import subprocess
import time

import pytest

from conftest import command, sweep
from impedraw.sweep import SweepError, load_spec
from impedraw.sweep.dataset import read_dataset, without_wall_times

SPEC = """name: tune
scenario: scenarios/robustness-nominal.yaml
seeds: 2
tune:
  settings:
    control.damping_ratio: {uniform: [0.5, 1.2]}
    control.stiffness_tangent: {loguniform: [500, 10000]}
    control.inertia: {choice: [shaped, natural]}
  objective: value + 0.001 * control.damping_ratio
  constraints: {some: sparse == null or sparse < 0.9}
  trials: 30
  startup: 10
"""


def write(tmp_path, text=SPEC):
    file = tmp_path / "tune.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_killed_tuning_goes_on_to_the_same_end(tmp_path):
    file = write(tmp_path)
    whole = sweep(file, tmp_path / "a", "--serial")
    assert whole.returncode == 0, whole.stderr
    words = command(file, tmp_path / "b", "--serial", options={"sleep": 0.05})
    driver = subprocess.Popen(words, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    while not list((tmp_path / "b").glob("parts/*.parquet")):
        time.sleep(0.05)
        assert driver.poll() is None
    driver.kill()
    driver.wait()
    rest = sweep(file, tmp_path / "b", "--serial")
    a, b = (without_wall_times(read_dataset(tmp_path / f)[0]) for f in "ab")
    assert a.num_rows == 60 and a.equals(b)
    assert rest.stdout.splitlines()[0] == whole.stdout.splitlines()[0]
    # The first trial is what the scenario and the defaults have.
    row = a.to_pylist()[0]
    assert row["axis:trial"] == "0" and row["control.damping_ratio"] == 0.8
    assert row["control.stiffness_tangent"] == 5000 and row["control.inertia"] == "shaped"


def test_the_best_is_the_best_of_the_feasible(tmp_path):
    done = sweep(write(tmp_path), tmp_path / "d", "--serial")
    rows = read_dataset(tmp_path / "d")[0].to_pylist()
    values = {}
    for row in rows:
        values.setdefault(row["axis:trial"], []).append(row)
    feasible = {t: sum(r["value"] + 0.001 * r["control.damping_ratio"] for r in of) / 2
                for t, of in values.items()
                if all(r["sparse"] is None or r["sparse"] < 0.9 for r in of)}
    best = min(feasible, key=feasible.get)
    told = re.search(r"30 trials, (\d+) feasible;.* of the best (\S+) \(trial (\d+)\)",
                     done.stdout)
    assert told, done.stdout
    assert int(told[1]) == len(feasible) and told[3] == best
    assert float(told[2]) == pytest.approx(feasible[best], rel=1e-5)


@pytest.mark.parametrize(("change", "told"), [
    (("uniform: [0.5, 1.2]", "uniform: [0.9, 1.2]"), "0.8, which the scenarios have"),
    (("trials: 30", "trials: 0"), "above 0"),
    (("seeds: 2", "axes: {control.damping_ratio: [1]}"), "also set by the cases"),
])
def test_what_cannot_be_tuned_is_refused(tmp_path, change, told):
    done = sweep(write(tmp_path, SPEC.replace(*change)), tmp_path / "d", "--serial")
    assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1
    assert not (tmp_path / "d").exists()


def test_an_unknown_setting_is_refused(tmp_path, settings):
    from conftest import ROOT

    with pytest.raises(SweepError, match="control.damping_ratoi: no setting; did you mean"):
        load_spec(write(tmp_path, SPEC.replace("damping_ratio: {", "damping_ratoi: {")), ROOT,
                  settings)
