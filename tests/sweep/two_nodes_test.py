"""A cluster of two nodes on this machine loses one in the middle: the sweep is complete."""

import subprocess
import time
from pathlib import Path

import pytest

from conftest import command
from engine_test import SPEC
from impedraw.sweep.dataset import read_dataset


@pytest.fixture
def cluster(monkeypatch):
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")  # its ports are this test's alone
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={
        "num_cpus": 1, "include_dashboard": False, "object_store_memory": 80 * 2**20})
    yield made
    made.shutdown()


def test_a_node_is_removed_in_the_middle(cluster, tmp_path):
    second = cluster.add_node(num_cpus=1, object_store_memory=80 * 2**20)
    cluster.wait_for_nodes()
    file, out = tmp_path / "engine.yaml", tmp_path / "d"
    file.write_text(SPEC.format(first=20, second=20), encoding="utf-8")
    driver = subprocess.Popen(command(file, out, "--address", cluster.address,
                                      options={"sleep": 0.06}), stderr=subprocess.PIPE, text=True)
    while len(list(out.glob("parts/*.parquet"))) < 2:
        time.sleep(0.1)
        assert driver.poll() is None, driver.stderr.read()
    cluster.remove_node(second, allow_graceful=False)
    assert driver.poll() is None, "the sweep was over before the node was removed"
    told = driver.communicate(timeout=180)[1]
    assert driver.returncode == 0, told
    rows = read_dataset(Path(out))[0]
    assert rows.num_rows == 400 == len(set(rows["key"].to_pylist()))
    assert not any(rows["failed"].to_pylist())
