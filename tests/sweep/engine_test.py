"""The engine on Ray: complete and the same whatever is killed. Cases that do nothing."""

import os
import random
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from conftest import command, sweep
from impedraw.sweep.dataset import read_dataset, without_wall_times
from kill_driver import run_and_kill

SEED = int(os.environ.get("IMPEDRAW_SEED", "1"))

SPEC = """name: engine
scenario: scenarios/robustness-nominal.yaml
axes:
  path.draw_speed: {{from: 0.01, to: 0.2, count: {first}}}
  control.normal_force: {{uniform: [1, 20], count: {second}, seed: 2}}
"""


@pytest.fixture
def spec(tmp_path):
    def write(first, second, more=""):
        file = tmp_path / "engine.yaml"
        file.write_text(SPEC.format(first=first, second=second) + more, encoding="utf-8")
        return file

    return write


def result(folder):
    return without_wall_times(read_dataset(Path(folder))[0])


def workers_of(driver):
    """Ray's worker processes that belong to the driver."""
    parents, names = {}, {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text(encoding="utf-8", errors="replace")
                names[int(entry.name)] = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            parents[int(entry.name)] = int(stat.rsplit(")", 1)[1].split()[1])

    def is_mine(process):
        while process in parents:
            if process == driver:
                return True
            process = parents[process]
        return False

    return [p for p, name in names.items() if name.startswith(b"ray::_run_batch") and is_mine(p)]


def test_driver_and_worker_killed_and_the_result_is_that_of_a_serial_run(spec, tmp_path):
    file = spec(25, 20)  # 500 cases of 30 ms
    options = {"sleep": 0.03}
    print(f"seed {SEED}")
    killed = run_and_kill(command(file, tmp_path / "a", options=options), SEED, 2, 14)
    assert killed["code"] == 0 and killed["peak_mb"] < 1000, killed
    # And a worker, in another folder.
    driver = subprocess.Popen(command(file, tmp_path / "b", options=options),
                              stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    found = []
    while driver.poll() is None and not found:
        time.sleep(0.1)
        found = workers_of(driver.pid)
    assert found, "no worker was seen"
    os.kill(random.Random(SEED).choice(found), signal.SIGKILL)
    assert driver.wait(timeout=120) == 0
    # Sleeping is no part of a run's result.
    assert sweep(file, tmp_path / "serial", "--serial").returncode == 0
    serial = result(tmp_path / "serial")
    assert serial.num_rows == 500 == len(set(serial["key"].to_pylist()))
    assert result(tmp_path / "a").equals(serial)
    assert result(tmp_path / "b").equals(serial)


@pytest.mark.skipif(os.environ.get("IMPEDRAW_LONG") != "1", reason="long: ./check --all")
def test_a_hundred_thousand_cases_and_three_kills(spec, tmp_path):
    file = spec(250, 400)
    print(f"seed {SEED}")
    killed = run_and_kill(command(file, tmp_path / "a"), SEED, 3, 40)
    assert killed["code"] == 0 and killed["peak_mb"] < 1000, killed
    rows = result(tmp_path / "a")
    assert rows.num_rows == 100_000 == len(set(rows["key"].to_pylist()))
    few = sweep(file, tmp_path / "serial", "--serial", "--only", "-00")
    assert few.returncode == 0, few.stderr
    subset = result(tmp_path / "serial")
    keys = set(subset["key"].to_pylist())
    mine = rows.filter([k in keys for k in rows["key"].to_pylist()])
    assert subset.num_rows > 200 and mine.equals(subset)


def test_a_run_that_kills_its_worker_is_a_row(spec, tmp_path):
    done = sweep(spec(4, 10), tmp_path / "d", options={"crash": "0", "fail": "1"})
    assert done.returncode == 0, done.stderr
    rows = result(tmp_path / "d").to_pylist()
    assert len(rows) == 40
    for row in rows:
        expected = {"0": "crashed", "1": "stopped"}.get(row["key"][0], "ok")
        assert row["state"] == expected and row["failed"] == (expected != "ok")
        assert bool(row["cause"]) == row["failed"]
    assert {"crashed", "stopped", "ok"} == {row["state"] for row in rows}


def test_ctrl_c_keeps_what_is_there_and_a_local_ray_listens_on_the_loopback_alone(spec, tmp_path):
    file, options = spec(25, 20), {"sleep": 0.06}
    before = listening()
    driver = subprocess.Popen(command(file, tmp_path / "d", options=options),
                              stderr=subprocess.PIPE, text=True)
    while not list((tmp_path / "d").glob("parts/*.parquet")):
        time.sleep(0.1)
        assert driver.poll() is None
    listens = addresses_of({driver.pid, *descendants(driver.pid)}, before)
    driver.send_signal(signal.SIGINT)
    told = driver.communicate(timeout=240)[1]
    assert driver.returncode == 130
    kept = int(re.search(r"interrupted; (\d+) runs are kept", told)[1])
    assert 0 < kept < 500 and result(tmp_path / "d").num_rows == kept
    assert listens, "nothing listens: the test sees too little"
    assert all(address.startswith(LOOPBACK) for address in listens), listens
    again = sweep(file, tmp_path / "d", "--serial")
    assert again.returncode == 0 and f"{kept} runs are kept" in again.stderr
    assert result(tmp_path / "d").num_rows == 500


LOOPBACK = ("0100007F:", "0000000000000000FFFF00000100007F:", "00000000000000000000000001000000:")


def listening():
    """Addresses and ports that this machine listens on."""
    found = set()
    for name in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{name}").read_text(encoding="ascii").splitlines()[1:]:
            words = line.split()
            if words[3] == "0A":
                found.add((words[1], words[9]))
    return found


def addresses_of(processes, before):
    """Those of `listening` that belong to the processes."""
    inodes = set()
    for process in processes:
        for handle in Path(f"/proc/{process}/fd").glob("*"):
            try:
                target = os.readlink(handle)
            except OSError:
                continue
            if target.startswith("socket:["):
                inodes.add(target[8:-1])
    return {address for address, inode in listening() - before if inode in inodes}


def descendants(process):
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue
            if int(stat.rsplit(")", 1)[1].split()[1]) == process:
                found += [int(entry.name), *descendants(int(entry.name))]
    return found


def test_an_expression_that_matches_no_case(spec, tmp_path):
    done = sweep(spec(2, 2), tmp_path / "d", "--serial", "--only", "nothing-like-this")
    assert done.returncode == 2 and "--list shows them" in done.stderr
    assert not (tmp_path / "d").exists()


@pytest.mark.parametrize(("address", "told"), [
    ("127.0.0.1:1", "no cluster is there"), ("ray://x:1", "HOST:PORT"), ("x", "HOST:PORT"),
    ("127.0.0.1:99999", "HOST:PORT")])
def test_an_address_where_no_cluster_is(spec, tmp_path, address, told):
    done = sweep(spec(2, 2), tmp_path / "d", "--address", address)
    assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1
    assert not (tmp_path / "d").exists()
