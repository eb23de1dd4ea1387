"""The data set keeps what it has, refuses what is not its own, and has one order."""

import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from impedraw.sweep import Case, SweepError
from impedraw.sweep.dataset import Dataset, read_dataset, without_wall_times
from impedraw.sweep.rows import run_cases
from impedraw.sweep.runners import Context, Noop

IDENTITY = {"spec": "s", "runner": "noop", "program": "-", "inputs": "i",
            "columns": {"seed": "int"}, "axes": []}
CONTEXT = Context("noop", ".", "-", ".", {"seed": "int"}, [])


def case(i):
    return Case(i, f"{i:032x}", f"c{i}", "g", {"scenario": "a"}, {"seed": i})


def rows(*indices):
    return run_cases(CONTEXT, Noop(CONTEXT), [case(i) for i in indices])


def test_rows_come_back_in_order_whatever_the_order_of_writing(tmp_path):
    a, b = Dataset(tmp_path / "a", IDENTITY), Dataset(tmp_path / "b", IDENTITY)
    for i in range(6):
        a.append([rows(i)])
    b.append([rows(5, 3)])
    b.append([rows(4), rows(0, 2)])
    b.compact()
    b.append([rows(1)])
    assert without_wall_times(a.table()).equals(without_wall_times(b.table()))
    a.compact(), b.compact()
    assert without_wall_times(a.table()).equals(without_wall_times(b.table()))
    assert a.table()["index"].to_pylist() == list(range(6))
    assert not list((tmp_path / "b/parts").iterdir())


def test_a_row_that_stands_in_part_and_whole_counts_once(tmp_path):
    data = Dataset(tmp_path / "d", IDENTITY)
    data.append([rows(0, 1, 2)])
    part = next((tmp_path / "d/parts").iterdir())
    left = part.read_bytes()
    data.compact()
    part.write_bytes(left)  # killed between the two steps of a compaction
    data.close()
    data = Dataset(tmp_path / "d", IDENTITY)
    assert len(data.done()[0]) == 3 and data.table().num_rows == 3
    assert data.compact() == 3


def test_a_reader_is_not_disturbed_by_a_compaction(tmp_path, monkeypatch):
    data = Dataset(tmp_path / "d", IDENTITY)
    for i in range(4):
        data.append([rows(i)])
    read = pq.read_table

    def read_while_parts_go(file, **options):
        table = read(file, **options)
        monkeypatch.setattr(pq, "read_table", read)
        data.compact()
        return table

    monkeypatch.setattr(pq, "read_table", read_while_parts_go)
    assert read_dataset(tmp_path / "d")[0].num_rows == 4


def test_a_half_written_file_is_not_seen(tmp_path):
    data = Dataset(tmp_path / "d", IDENTITY)
    data.append([rows(0)])
    (tmp_path / "d/parts/.00000002.parquet.new").write_bytes(b"PAR1half")
    data.close()
    data = Dataset(tmp_path / "d", IDENTITY)
    assert data.table().num_rows == 1
    assert not list((tmp_path / "d/parts").glob(".*"))


@pytest.mark.parametrize(("key", "told"), [
    ("spec", "another specification"), ("program", "another build"), ("inputs", "changed since"),
    ("runner", "another runner")])
def test_a_data_set_of_something_else_is_refused_and_stays_as_it_is(tmp_path, key, told):
    data = Dataset(tmp_path / "d", IDENTITY)
    data.append([rows(0)])
    data.close()
    before = {f: f.read_bytes() for f in (tmp_path / "d").rglob("*") if f.is_file()}
    with pytest.raises(SweepError, match=told):
        Dataset(tmp_path / "d", {**IDENTITY, key: "other"})
    assert before == {f: f.read_bytes() for f in (tmp_path / "d").rglob("*") if f.is_file()}
    Dataset(tmp_path / "d", {**IDENTITY, key: "other"}, again=True)
    assert read_dataset(tmp_path / "d")[0].num_rows == 0


def test_a_foreign_folder_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("mine", encoding="ascii")
    with pytest.raises(SweepError, match="neither empty nor"):
        Dataset(tmp_path, IDENTITY)
    with pytest.raises(SweepError, match="neither empty nor"):
        Dataset(tmp_path, IDENTITY, again=True)
    assert [f.name for f in tmp_path.iterdir()] == ["mine.txt"]


def test_two_sweeps_cannot_write_the_same_data_set(tmp_path):
    first = Dataset(tmp_path / "d", IDENTITY)
    with pytest.raises(SweepError, match="another sweep"):
        Dataset(tmp_path / "d", IDENTITY)
    with pytest.raises(SweepError, match="another sweep"):
        Dataset(tmp_path / "d", IDENTITY, again=True)
    first.close()
    Dataset(tmp_path / "d", IDENTITY)


def test_compaction_comes_with_many_parts(tmp_path):
    data = Dataset(tmp_path / "d", IDENTITY)
    for i in range(200):
        data.append([rows(i)])
    assert len(list((tmp_path / "d/parts").iterdir())) < 128
    assert data.table().num_rows == 200


def test_a_metric_that_came_late_is_null_before(tmp_path):
    data = Dataset(tmp_path / "d", IDENTITY)
    data.append([rows(0).drop_columns(["value"])])
    data.append([rows(1)])
    values = data.table()["value"].to_pylist()
    assert values[0] is None and values[1] is not None
    assert pa.types.is_float64(data.table().schema.field("value").type)


def test_the_file_is_plain_parquet(tmp_path):
    data = Dataset(tmp_path / "d", IDENTITY)
    data.append([rows(1, 0)])
    data.compact()
    table = pq.read_table(tmp_path / "d/runs.parquet")
    assert table["seed"].to_pylist() == [0, 1]
    assert json.loads(table["set"][1].as_py()) == {"seed": 1}
