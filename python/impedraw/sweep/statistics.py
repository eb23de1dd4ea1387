"""Means and confidence intervals of groups of runs."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

# Student's t, two-sided 95 %, for 1 to 30 degrees of freedom (Abramowitz and Stegun, table 26.10).
_T95 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
        2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
        2.052, 2.048, 2.045, 2.042)


@dataclass
class Mean:
    """A mean over seeds, with the half width of its 95 % confidence interval."""

    mean: float | None  # None: no run has the metric
    half: float | None  # None: fewer than two seeds
    seeds: int
    runs: int  # with the metric
    failed: int
    all: int


def t95(freedom: int) -> float:
    """Student's t for a two-sided interval of 95 %; within 0.002 beyond 30 degrees."""
    if freedom <= len(_T95):
        return _T95[freedom - 1]
    return 1.95996 + 2.3723 / freedom + 2.82 / freedom**2


def mean_over_seeds(values: Iterable[tuple[Any, float | None, bool]]) -> Mean:
    """Of (seed, metric, failed) of each run. Runs of one seed are averaged first: whatever else
    varies among them is the same for every seed and no uncertainty."""
    by_seed: dict[Any, list[float]] = {}
    failed = count = 0
    for seed, value, bad in values:
        count += 1
        failed += bad
        if value is not None and math.isfinite(value):
            by_seed.setdefault(seed, []).append(value)
    means = [math.fsum(v) / len(v) for v in by_seed.values()]
    runs = sum(map(len, by_seed.values()))
    if not means:
        return Mean(None, None, 0, 0, failed, count)
    mean = math.fsum(means) / len(means)
    return Mean(mean, half_width(means), len(means), runs, failed, count)


def half_width(values: Sequence[float]) -> float | None:
    """Of the 95 % confidence interval of the mean; None of fewer than two values."""
    n = len(values)
    if n < 2:
        return None
    mean = math.fsum(values) / n
    variance = math.fsum((v - mean) ** 2 for v in values) / (n - 1)
    return t95(n - 1) * math.sqrt(variance / n)
