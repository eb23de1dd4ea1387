"""Runs one drawing after another in this process, for sweeps and learners.

The scene (canvas, arm, world, snapshot of the cameras) of a run is kept. A later run whose settings
make the same scene takes it as it is, and gives bit for bit the same numbers as one without.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from typing import Any

from . import _impedraw
from ._settings import assignments

_local = threading.local()


def _runner() -> _impedraw.Runner:
    """This thread's runner."""
    if not hasattr(_local, "runner"):
        _local.runner = _impedraw.Runner()
    runner: _impedraw.Runner = _local.runner
    return runner


def _text_or_path(name: str, value: object, path: bool) -> None:
    """Raises TypeError or ValueError, one line, unless the value is a text that holds something,
    or a path where that is valid."""
    if not isinstance(value, (str, os.PathLike) if path else str):
        valid = "a path as str or os.PathLike" if path else "a str"
        raise TypeError(f"{name} is of type {type(value).__name__}; valid is {valid}")
    if not os.fspath(value):
        raise ValueError(f"{name} is empty")
    if not isinstance(os.fspath(value), str):
        raise TypeError(f"{name} is a path of bytes; valid is a path as str")


def options(
    settings: Mapping[str, Any],
    scenario: str | os.PathLike[str] | None = None,
    *,
    svg: str | os.PathLike[str] | None = None,
    text: str | None = None,
    shape: str | None = None,
    no_perception: bool = False,
    keep_order: bool = False,
    skip_unreachable: bool = False,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
) -> _impedraw.DrawOptions:
    """What the command line would take. Raises TypeError, one line, for a value of another type."""
    if not isinstance(settings, Mapping):
        raise TypeError(f"settings is of type {type(settings).__name__}; valid is a mapping")
    for name, value, path in (
        ("scenario", scenario, True), ("svg", svg, True), ("text", text, False),
        ("shape", shape, False), ("out", out, True),
    ):  # fmt: skip
        if value is not None:
            _text_or_path(name, value, path)
    for name, flag in (
        ("no_perception", no_perception), ("keep_order", keep_order),
        ("skip_unreachable", skip_unreachable), ("overwrite", overwrite),
    ):  # fmt: skip
        if not isinstance(flag, bool):
            raise TypeError(f"{name} is of type {type(flag).__name__}; valid are True and False")
    made = _impedraw.DrawOptions()
    made.assignments = assignments(settings)
    if scenario is not None:
        made.scenario = os.fspath(scenario)
    if svg is not None:
        made.svg = os.fspath(svg)
    if text is not None:
        made.text = text
    if shape is not None:
        made.shape = shape
    made.no_perception = no_perception
    made.keep_order = keep_order
    made.skip_unreachable = skip_unreachable
    if out is not None:
        made.out = os.fspath(out)
    made.overwrite = overwrite
    return made


def run(
    settings: Mapping[str, Any],
    scenario: str | os.PathLike[str] | None = None,
    *,
    svg: str | os.PathLike[str] | None = None,
    text: str | None = None,
    shape: str | None = None,
    no_perception: bool = False,
    keep_order: bool = False,
    skip_unreachable: bool = False,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    default_out: bool = False,
    progress: Callable[[str, float], object] | None = None,
) -> dict[str, Any]:
    """Draws, and returns what came of it.

    settings: as ``--set`` takes them, by full names or nested: ``{"path.draw_speed": 0.1}``.
    scenario: a YAML file; None: as ``./impedraw draw`` chooses.
    out: folder of the run, with log, pictures and report, as ``./impedraw draw --out`` makes it;
    None: nothing is written, unless ``default_out``: then runs/NAME.
    overwrite: replaces the results of a run that stands in ``out``.

    Returns a dict of plain values: ``end`` and ``cause`` (as of Run), ``not_drawn_mm``, ``metrics`` (name to float, None where there is no number), ``reasons`` (why not), ``not_drawn``
    (findings of the pre-flight by problem), ``met`` (seconds of each controller status), ``simulated`` [s], ``wall`` [s], ``drawn_again``,
    ``lacking``, ``notes``, ``name``, ``folder``.

    Raises ValueError, one line, for settings that ``./impedraw draw`` refuses with exit code 2.
    """
    given = options(
        settings,
        scenario,
        svg=svg,
        text=text,
        shape=shape,
        no_perception=no_perception,
        keep_order=keep_order,
        skip_unreachable=skip_unreachable,
        out=out,
        overwrite=overwrite,
    )
    if progress is not None and not callable(progress):
        raise TypeError(f"progress is of type {type(progress).__name__}; valid is a function")
    result: dict[str, Any] = _runner().run(given, out is not None or default_out, progress)
    return result
