"""draw(): the same scenario, defaults and functions as ``./impedraw draw``."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from typing import Any

from . import _impedraw, _runner
from ._run import Run
from .canvases import CanvasShape


def _notebook_progress() -> Callable[[str, float], object] | None:
    """A bar within a notebook. On a terminal the library draws its own line."""
    if "IPython" not in sys.modules:
        return None
    from IPython import get_ipython  # type: ignore[import-not-found,unused-ignore]
    from IPython.display import HTML, display  # type: ignore[import-not-found,unused-ignore]

    if get_ipython() is None or "IPKernelApp" not in getattr(get_ipython(), "config", {}):
        return None
    handle = display(HTML(""), display_id=True)

    def show(what: str, share: float) -> None:
        handle.update(HTML(f'<progress value="{share:.3f}"></progress> {what} {100 * share:.0f} %'))

    return show


class _NotGiven:
    """Told apart from None, which may be the result of a search for a file that failed."""

    def __repr__(self) -> str:
        return "…"


_NOT_GIVEN = _NotGiven()


def _artwork(svg: str | os.PathLike[str] | _NotGiven) -> str | os.PathLike[str] | None:
    if svg is None:
        raise TypeError("svg is None; valid is a path, or leave it out")
    return None if isinstance(svg, _NotGiven) else svg


def _given(canvas: CanvasShape | None, settings: Mapping[str, Any] | None) -> dict[str, Any]:
    if canvas is not None and not isinstance(canvas, CanvasShape):
        raise TypeError(
            f"canvas is of type {type(canvas).__name__}; valid is a shape of impedraw.canvases, "
            "such as impedraw.Bowl()"
        )
    if settings is not None and not isinstance(settings, Mapping):
        raise TypeError(f"settings is of type {type(settings).__name__}; valid is a mapping")
    return {**(canvas.settings() if canvas is not None else {}), **(settings or {})}


def draw(
    svg: str | os.PathLike[str] | _NotGiven = _NOT_GIVEN,
    *,
    text: str | None = None,
    shape: str | None = None,
    canvas: CanvasShape | None = None,
    scenario: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    no_perception: bool = False,
    keep_order: bool = False,
    skip_unreachable: bool = False,
    progress: Callable[[str, float], object] | None = None,
) -> Run:
    """Draws artwork on a canvas and returns the run.

    svg: an .svg file, or strokes as .txt, .strokes or .csv. text: written in single strokes. shape:
    built in: sine, M, sine10, circle. Without any: the scenario's.
    canvas: of impedraw.canvases, as in ``canvas=impedraw.Bowl()``; default: the scenario's.
    scenario: a YAML file; default: the standard bowl.
    settings: as ``--set`` takes them: ``{"control.normal_force": 3}``, or nested.
    out: the run's folder; default: runs/NAME. overwrite: replaces the results of a run in ``out``.
    progress: called about 20 times a second with what is being done and the share of it.

    Raises TypeError, one line, for an argument of another type (None is no svg: leave it out), and
    ValueError, one line, for what ``./impedraw draw`` refuses: nothing is written then.
    KeyboardInterrupt on Ctrl-C: the pen is lifted first, and the log is kept.
    """
    file = _artwork(svg)
    if sum(given is not None for given in (file, text, shape)) > 1:
        raise ValueError("draw: svg, text and shape exclude each other; give one of them")
    result = _runner.run(
        _given(canvas, settings),
        scenario,
        svg=file,
        text=text,
        shape=shape,
        no_perception=no_perception,
        keep_order=keep_order,
        skip_unreachable=skip_unreachable,
        out=out,
        overwrite=overwrite,
        default_out=True,
        progress=progress or _notebook_progress(),
    )
    if result["end"] == "interrupted":
        raise KeyboardInterrupt(result["cause"])
    return Run(result["folder"], result)


def plan(
    svg: str | os.PathLike[str] | _NotGiven = _NOT_GIVEN,
    *,
    text: str | None = None,
    shape: str | None = None,
    canvas: CanvasShape | None = None,
    scenario: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The pre-flight: which strokes can be drawn, where the others fail and why, and how long it
    takes. What ``./impedraw plan --json`` prints, as a dict. Arguments as of draw()."""
    options = _runner.options(
        _given(canvas, settings), scenario, svg=_artwork(svg), text=text, shape=shape
    )
    return _impedraw.plan(options)
