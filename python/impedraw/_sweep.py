"""sweep(): many runs, on one machine or on a cluster, as ``./impedraw sweep`` does them."""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

_HERE = Path(__file__).resolve().parent


def _part(name: str) -> Any:
    """Of impedraw.sweep, whose own needs are not those of the package."""
    try:
        importlib.import_module("pyarrow")
        return importlib.import_module(f".sweep.{name}", __package__)
    except ModuleNotFoundError as error:
        raise ImportError(f"{error}; pip install 'impedraw[sweep]'") from None


class Sweep:
    """What came of a sweep: a row for each run, with every setting and metric."""

    def __init__(self, folder: Path, identity: Mapping[str, Any], table: Any) -> None:
        self.folder = folder
        """The data set: ``runs.parquet``, ``report.html``, ``kept/``."""
        self.name = str(identity.get("name", ""))
        self.table = table
        """A ``pyarrow.Table`` in the specification's order."""

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Sweep:
        """Reads a data set, also one that is being written. Raises ValueError where there is none."""
        table, identity = _part("dataset").read_dataset(Path(folder))
        return cls(Path(folder), identity, table)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The runs as dicts: ``case``, ``state``, ``cause``, ``failed``, settings and metrics."""
        rows: list[dict[str, Any]] = self.table.to_pylist()
        return rows

    def to_dataframe(self) -> Any:
        """A ``pandas.DataFrame``; needs pandas."""
        return self.table.to_pandas()

    def __len__(self) -> int:
        return int(self.table.num_rows)

    def __repr__(self) -> str:
        failed = sum(self.table["failed"].to_pylist()) if len(self) else 0
        return f"<Sweep {self.name}: {len(self)} runs, {failed} failed, in {self.folder}>"


def sweep(
    spec: str | os.PathLike[str] | Mapping[str, Any],
    *,
    out: str | os.PathLike[str] | None = None,
    only: str = "",
    workers: int | None = None,
    address: str | None = None,
    serial: bool = False,
    again: bool = False,
) -> Sweep:
    """Runs every case of a specification that its data set lacks, and returns all of them.

    spec: a YAML file, or the same as a mapping: ``{"scenario": "scenarios/bowl-sine.yaml", "axes":
    {"control.normal_force": [2, 5]}, "seeds": 3}``. Files are looked for in the package's data (or
    the source tree), then beside the specification.
    out: folder of the data set; default: runs/NAME. The same call goes on after a kill.
    only: cases whose name matches this regular expression.
    workers: runs at a time; default: one a core. address: of a Ray cluster, HOST:PORT.
    serial: in one child process, without Ray. again: discards the data set that is there.

    A run that is refused, crashes, hangs or uses too much memory is a row. Needs
    ``impedraw[sweep]``. Raises ValueError, one line, before anything is written;
    KeyboardInterrupt on Ctrl-C, with what is done kept.
    """
    import argparse

    command, specs = _part("__main__"), _part("spec")
    data = _HERE / "data"
    root = data if data.is_dir() else _HERE.parents[1]
    settings = _part("settings").Settings.read(root / "docs/scenario.schema.json")
    if isinstance(spec, Mapping):
        loaded, file = specs.spec_of(spec, root, settings), None
    else:
        file = os.fspath(spec)
        loaded = specs.load_spec(file, root, settings)
    folder = Path(out) if out is not None else Path("runs") / loaded.name
    options = argparse.Namespace(
        spec=file, out=os.fspath(out) if out is not None else None, only=only, workers=workers,
        address=address, serial=serial, again=again, runner="native", report=False, program="",
        noop_options="", quiet=True,
        command="impedraw.sweep()" if file is None else f"{_part('errors').COMMAND} sweep {file}")
    code = command.run_loaded(loaded, options, root, settings, folder)
    if code != command.FINISHED:
        raise KeyboardInterrupt(f"interrupted; the runs that were done are kept in {folder}")
    return Sweep.open(folder)
