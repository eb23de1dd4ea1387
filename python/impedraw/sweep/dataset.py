"""The data set of a sweep: a folder that survives being killed at any moment.

    OUT/sweep.json          what the data set is of: specification, inputs, program
    OUT/parts/*.parquet     rows as they came
    OUT/runs.parquet        all rows in the specification's order (after a compaction)
    OUT/kept/KEY/           logs and pictures that the specification keeps
    OUT/report.html

Every file is written under another name, flushed to the disk and then renamed, so a file that has
its name is whole. A compaction writes runs.parquet before it removes the parts; where it is killed
in between, a row stands in both and is read once.
"""

import contextlib
import fcntl
import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from .errors import SweepError
from .rows import WALL_COLUMNS, in_column_order

FORMAT = 1
_PARTS_BEFORE_COMPACTION = 64


class Dataset:
    """A folder of results, open for one process at a time."""

    def __init__(self, folder: Path, identity: dict[str, Any], again: bool = False) -> None:
        """Opens or creates. Raises SweepError, with nothing written, where the folder holds
        something else, another process has it open, or its identity differs."""
        self.folder, self.identity = folder, {"format": FORMAT, **identity}
        self.parts = folder / "parts"
        head = folder / "sweep.json"
        if head.exists():
            if not again:
                self._require_same(head)
        elif folder.is_dir() and any(folder.iterdir()):
            raise SweepError(f"--out {folder}: is neither empty nor a sweep's data set")
        elif folder.exists() and not folder.is_dir():
            raise SweepError(f"--out {folder}: is no folder")
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = open(folder / ".lock", "w", encoding="ascii")
        except OSError as error:
            raise SweepError(f"--out {folder}: cannot be written: {error.strerror}") from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise SweepError(f"--out {folder}: another sweep is writing it") from None
        if again:
            for name in ("parts", "kept"):
                shutil.rmtree(folder / name, ignore_errors=True)
            for name in ("runs.parquet", "report.html", "sweep.json"):
                (folder / name).unlink(missing_ok=True)
        shutil.rmtree(folder / "scratch", ignore_errors=True)
        for left in [*folder.glob(".*.new"), *self.parts.glob(".*.new"),
                     *(folder / "kept").glob(".*")]:
            shutil.rmtree(left) if left.is_dir() else left.unlink()
        self.parts.mkdir(exist_ok=True)
        if not head.exists():
            write_whole(head, json.dumps(self.identity, indent=1).encode() + b"\n")
        numbers = [int(p.stem) for p in self.parts.glob("*.parquet") if p.stem.isdigit()]
        self._next = max(numbers, default=0) + 1
        self._count = len(numbers)
        self._part_rows = 0

    def _require_same(self, head: Path) -> None:
        try:
            found = json.loads(head.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            raise SweepError(f"{head}: is damaged; --again discards the data set") from None
        words = {"format": "another format", "spec": "another specification",
                 "runner": "another runner", "program": "another build of the program",
                 "inputs": "input files that were changed since"}
        if not isinstance(found, dict):
            raise SweepError(f"{head}: is damaged; --again discards the data set")
        for key, word in words.items():
            if found.get(key) != self.identity.get(key):
                raise SweepError(f"--out {self.folder}: is the data set of {word}; name another "
                                 "folder, or --again discards it")

    def done(self) -> tuple[set[bytes], int]:
        """The keys of the rows that are there, and how many of them failed."""
        keys: set[bytes] = set()
        failed = 0
        for file in self._files():
            with _readable(file):
                table = pq.read_table(file, columns=["key", "failed"])
                for key, bad in zip(table["key"].to_pylist(), table["failed"].to_pylist()):
                    if (digest := bytes.fromhex(key)) not in keys:
                        keys.add(digest)
                        failed += bad
        return keys, failed

    def append(self, tables: list[pa.Table]) -> None:
        """Writes the rows as one part. When this returns they are on the disk."""
        if not tables:
            return
        table = pa.concat_tables(tables, promote_options="default")
        _write_table(self.parts / f"{self._next:08}.parquet", table, compact=False)
        self._next += 1
        self._count += 1
        self._part_rows += table.num_rows
        if self._count >= _PARTS_BEFORE_COMPACTION and self._part_rows >= self._compacted_rows():
            self.compact()

    def compact(self) -> int:
        """Writes runs.parquet, all rows in order, and removes the parts. Returns their number."""
        table = self.table()
        parts = sorted(self.parts.glob("*.parquet"))
        if parts or not (self.folder / "runs.parquet").exists():
            _write_table(self.folder / "runs.parquet", table)
            for part in parts:
                part.unlink()
        self._count = self._part_rows = 0
        return table.num_rows

    def table(self) -> pa.Table:
        """All rows in the specification's order, each once."""
        return _rows(self.folder, self.identity)

    def close(self) -> None:
        shutil.rmtree(self.folder / "scratch", ignore_errors=True)
        self._lock.close()

    def _files(self) -> list[Path]:
        return _files(self.folder)

    def _compacted_rows(self) -> int:
        file = self.folder / "runs.parquet"
        with _readable(file):
            return pq.read_metadata(file).num_rows // 2 if file.exists() else 0


def read_dataset(folder: Path) -> tuple[pa.Table, dict[str, Any]]:
    """All rows of a data set, also of one that is being written, and its identity."""
    try:
        identity = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise SweepError(f"{folder}: is no sweep's data set") from None
    return _rows(folder, identity), identity


def without_wall_times(table: pa.Table) -> pa.Table:
    """What is the same whenever the same sweep is run."""
    return table.drop_columns([c for c in WALL_COLUMNS if c in table.column_names])


def write_whole(file: Path, content: bytes) -> None:
    """Writes under another name, flushes to the disk, renames."""
    new = file.with_name(f".{file.name}.new")
    with open(new, "wb") as out:
        out.write(content)
        out.flush()
        os.fsync(out.fileno())
    os.replace(new, file)
    _flush_folder(file.parent)


def _files(folder: Path) -> list[Path]:
    whole = folder / "runs.parquet"
    return ([whole] if whole.exists() else []) + sorted((folder / "parts").glob("*.parquet"))


@contextlib.contextmanager
def _readable(what: Path) -> Iterator[None]:
    """What a damaged file or head brings up is one line."""
    try:
        yield
    except SweepError:
        raise
    except (pa.ArrowException, OSError, LookupError, TypeError, ValueError) as error:
        raise SweepError(f"{what}: is damaged ({error}); restore it, remove it (its runs are made "
                         "again), or discard the data set with --again") from None


def _rows(folder: Path, identity: dict[str, Any]) -> pa.Table:
    with _readable(folder):
        return _ordered(_tables(folder), identity)


def _tables(folder: Path) -> list[pa.Table]:
    """The tables of all files. Where a compaction removes a part meanwhile, they are listed anew:
    its rows stand in runs.parquet by then."""
    while True:
        files, tables = _files(folder), []
        for file in files:
            with _readable(file):
                try:
                    tables.append(pq.read_table(file))
                except FileNotFoundError:
                    if os.path.lexists(file):
                        raise
                    break
        if len(tables) == len(files):
            return tables


def _ordered(tables: list[pa.Table], identity: dict[str, Any]) -> pa.Table:
    if not tables:
        return pa.table({})
    table = pa.concat_tables(tables, promote_options="default")
    order = in_column_order(table.column_names, identity["columns"], identity["axes"])
    table = table.select([name for name in order if name in table.column_names])
    table = table.sort_by("index")
    index = table["index"].to_numpy()
    if len(index) > 1 and (index[1:] == index[:-1]).any():
        first = [True, *(index[1:] != index[:-1]).tolist()]
        table = table.filter(pa.array(first))
    return table.combine_chunks()


def _write_table(file: Path, table: pa.Table, compact: bool = True) -> None:
    """`compact`: small rather than fast. Of a few rows, a column costs a fifth without it."""
    new = file.with_name(f".{file.name}.new")
    with open(new, "wb") as out:
        pq.write_table(table.replace_schema_metadata(None), out,
                       compression="zstd" if compact else "none", use_dictionary=compact,
                       write_statistics=compact, row_group_size=65536)
        out.flush()
        os.fsync(out.fileno())
    os.replace(new, file)
    _flush_folder(file.parent)


def _flush_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
