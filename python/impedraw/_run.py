"""A finished run: its metrics, its log, its page."""

from __future__ import annotations

import html
import os
import pathlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ._metrics import Metrics

if TYPE_CHECKING:
    import numpy
    import numpy.typing
    import pandas  # type: ignore[import-untyped,import-not-found,unused-ignore]


class Log(Mapping[str, "numpy.typing.NDArray[Any]"]):
    """The datasets of run.h5 by name, as in ``log["contact/force"]``. SI, world frame; a row a control
    step. ``unit(name)`` and ``description(name)`` tell what each is."""

    def __init__(self, file: str | os.PathLike[str]) -> None:
        self.file = pathlib.Path(file)

    def _open(self) -> Any:
        try:
            import h5py  # type: ignore[import-untyped,import-not-found,unused-ignore]
        except ImportError as error:
            raise ImportError("reading run.h5 needs h5py: pip install h5py") from error
        return h5py.File(self.file, "r")

    def __getitem__(self, name: str) -> numpy.typing.NDArray[Any]:
        with self._open() as file:
            if name not in file or not hasattr(file[name], "shape"):
                raise KeyError(f"{self.file} has no dataset {name!r}; list(log) names all")
            data: numpy.typing.NDArray[Any] = file[name][()]
            return data

    def __iter__(self) -> Iterator[str]:
        names: list[str] = []
        with self._open() as file:
            file.visititems(lambda name, item: names.append(name) if hasattr(item, "shape") else None)
        return iter(names)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def unit(self, name: str) -> str:
        """Of a dataset: "N"."""
        with self._open() as file:
            return str(file[name].attrs["unit"])

    def description(self, name: str) -> str:
        with self._open() as file:
            return str(file[name].attrs["description"])

    def __repr__(self) -> str:
        return f"Log({str(self.file)!r})"


class Run:
    """What came of a drawing, and the folder with its log, pictures and report.

    end: "finished", "stopped" (halted by a fault), "interrupted" (by a person), "nothing_drawn",
    "far_off" or "unknown" (killed, or an older log); cause: why, in a sentence. incident: the page
    with the last seconds of a run that was halted, or None. not_drawn_mm: length without ink by
    reason; ``metrics.drawn`` is the share that has ink. met: seconds of each controller status;
    notes: repairs to the input, and what was not drawn; both of draw() alone.
    """

    def __init__(self, folder: str | os.PathLike[str], result: Mapping[str, Any]) -> None:
        self.folder = pathlib.Path(folder)
        self.name: str = result.get("name", self.folder.name)
        self.end: str = result.get("end", "")
        self.cause: str = result.get("cause", "")
        self.not_drawn_mm: dict[str, float] = dict(result.get("not_drawn_mm", {}))
        self.met: dict[str, float] = dict(result.get("met", {}))
        self.notes: list[str] = list(result.get("notes", []))
        self.metrics = Metrics(result["metrics"], result.get("reasons", {}))
        self.log = Log(self.folder / "run.h5")

    @staticmethod
    def open(folder: str | os.PathLike[str]) -> Run:
        """A run that is there, by its folder. Raises ValueError if it has no log."""
        from . import _impedraw

        file = pathlib.Path(folder) / "run.h5"
        if not file.is_file():
            raise ValueError(f"{folder}: contains no run.h5; name the folder of a run")
        metrics, reasons, ending = _impedraw.metrics_of(os.fspath(file))
        return Run(folder, {"metrics": metrics, "reasons": reasons, **ending})

    def to_dataframe(self) -> pandas.DataFrame:
        """The log's rows as a table: a column for each component ("contact/force.x"), ``time`` as
        its index. Needs pandas."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_dataframe() needs pandas: pip install pandas") from error
        axes = {2: "xy", 3: "xyz"}
        columns: dict[str, Any] = {}
        time = self.log["time"]
        for name in self.log:
            if name == "time" or name.split("/")[0] in ("canvas", "cloud", "target", "every_step"):
                continue
            data = self.log[name]
            if data.shape[0] != len(time):
                continue
            if data.ndim == 1:
                columns[name] = data
            else:
                for i in range(data.shape[1]):
                    part = axes[data.shape[1]][i] if data.shape[1] in axes else str(i)
                    columns[f"{name}.{part}"] = data[:, i]
        table: pandas.DataFrame = pandas.DataFrame(columns, index=pandas.Index(time, name="time"))
        return table

    @property
    def incident(self) -> pathlib.Path | None:
        """incident.html, where the run was halted."""
        file = self.folder / "incident.html"
        return file if file.is_file() else None

    @property
    def page(self) -> pathlib.Path:
        """report.html: the replay and the numbers."""
        return self.folder / "report.html"

    def show(self) -> None:
        """The replay: within a notebook, else in a browser."""
        try:
            from IPython import get_ipython  # type: ignore[import-not-found,unused-ignore]
            from IPython.display import display  # type: ignore[import-not-found,unused-ignore]
        except ImportError:
            get_ipython = None
        if get_ipython is not None and get_ipython() is not None:
            display(self)
            return
        import webbrowser

        webbrowser.open(self.page.resolve().as_uri())

    def _repr_html_(self) -> str:
        content = html.escape(self.page.read_text(encoding="utf-8"), quote=True)
        return (
            f'<iframe srcdoc="{content}" sandbox="allow-scripts" width="100%" height="640" '
            'style="border:0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r}, end={self.end!r})"
