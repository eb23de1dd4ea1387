"""Means and intervals against answers known by hand and against NumPy."""

import random

import numpy as np
import pytest

from impedraw.sweep.statistics import half_width, mean_over_seeds, t95


def test_student_against_published_values():
    # NIST/SEMATECH e-Handbook, 1.3.6.7.2, column 0.975.
    published = {1: 12.706, 5: 2.571, 30: 2.042, 40: 2.021, 60: 2.000, 100: 1.984}
    for freedom, value in published.items():
        assert t95(freedom) == pytest.approx(value, abs=2e-3)


def test_the_interval_holds_the_mean_in_95_of_100_cases():
    generator = random.Random(1)
    inside = 0
    for _ in range(4000):
        values = [generator.gauss(3, 2) for _ in range(5)]
        inside += abs(np.mean(values) - 3) <= half_width(values)
    assert 0.94 < inside / 4000 < 0.96


def test_what_varies_beside_the_seed_is_no_uncertainty():
    runs = [(seed, 10.0 * other + seed, False) for seed in (1, 2, 3) for other in (0, 1)]
    mean = mean_over_seeds(runs)
    assert mean.mean == pytest.approx(7.0) and mean.seeds == 3 and mean.runs == 6
    assert mean.half == pytest.approx(4.303 / 3**0.5)  # the seeds' means are 6, 7, 8


def test_nothing_is_null_and_one_seed_has_no_interval():
    assert mean_over_seeds([(1, None, True)]).mean is None
    one = mean_over_seeds([(1, 2.0, False), (1, None, True)])
    assert one.mean == 2.0 and one.half is None and one.failed == 1 and one.all == 2
