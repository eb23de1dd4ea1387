"""Sweeps: many runs of a scenario, on one machine or on a cluster, in one data set.

A specification (spec.py) names scenario and axes. Its cases are run by a runner (runners.py) in
batches on Ray (engine.py); each gives one row of a Parquet data set (dataset.py), from which a
page is made (report.py). `./impedraw sweep SPEC.yaml` is the command (__main__.py).

Importing this package imports neither Ray nor pyarrow, nor the compiled part of impedraw.
"""

import sys
import types
from typing import Any

from .errors import SweepError
from .spec import Case, Spec, load_spec

class _Callable(types.ModuleType):
    """`impedraw.sweep` is this package once it is imported, and a function before: both may be
    called."""

    def __call__(self, *arguments: Any, **more: Any) -> Any:
        from .._sweep import sweep

        return sweep(*arguments, **more)


sys.modules[__name__].__class__ = _Callable

__all__ = ["Case", "Spec", "SweepError", "load_spec"]
