"""Each control setting's ends, and random pairs of them: refused by name, or a finite torque."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from conftest import LONG, POSTURE

import impedraw as idr

VECTORS = ("stiffness", "torque", "torque_rate", "joint_speed", "yield_limit")  # of one entry per joint
HUGE = 1e30
ARM = idr.ArmModel.standard()


def base(kind: str) -> idr.ImpedanceSettings:
    measured = kind != "natural"
    return idr.ImpedanceSettings(
        inertia=kind,
        wrench="measured" if measured else "none",
        observer=idr.ObserverSettings(enabled=measured),
        limits=idr.LimitSettings(joint_speed=ARM.limits.speed),
    )


def leaves(record: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Paths to all numbers of a record and of those in it, and to its vectors of one entry per joint."""
    for name in dir(record):
        value = getattr(record, name)
        if name.startswith("_") or callable(value) or isinstance(value, bool):
            continue
        if type(value).__name__.endswith(("Settings", "Gain")):
            yield from leaves(value, (*path, name))
        elif isinstance(value, float) or name in VECTORS:
            yield (*path, name)


def put(settings: Any, path: tuple[str, ...], x: float) -> None:
    for name in path[:-1]:
        settings = getattr(settings, name)
    number = isinstance(getattr(settings, path[-1]), float)
    setattr(settings, path[-1], x if number else np.full(7, x))


def ends(path: tuple[str, ...]) -> tuple[float, float]:
    """As a refusal of what is far outside tells them; open where it tells none."""
    low, high = 1e-6, 1e6
    for x in (-HUGE, HUGE):
        settings = base("shaped")
        put(settings, path, x)
        try:
            settings.validate(7)
        except ValueError as refused:
            text = str(refused)
            if span := re.search(r"allowed is (\S+) to (\S+)", text):
                low, high = float(span[1]), float(span[2])
            if least := re.search(r"(?:more than|at least) (\S+)", text):
                low = float(least[1]) + (1e-6 if "more than" in text else 0.0)
            if most := re.search(r"(?:less than|at most) (\S+)", text):
                high = float(most[1]) - (1e-6 if "less than" in text else 0.0)
    # Set-up follows the contact through the delay in steps of dt, and takes minutes beyond these.
    return max(low, 5e-4 if path[-1] == "dt" else low), min(high, 0.03 if path[-1] == "wrench_delay" else high)


def step(settings: idr.ImpedanceSettings) -> bool:
    """False if refused, in one line."""
    try:
        controller = idr.ImpedanceController(settings, 7)
    except ValueError as refused:
        assert str(refused) and "\n" not in str(refused)
        return False
    terms = ARM.compute(POSTURE, np.zeros(7))
    n = -terms.X_WE.R[:, 2]
    far = terms.X_WE.p + [0.3, -0.2, 0.1]
    surface = idr.SurfaceEstimate(status="ok", n_W=n, distance=2e-3)
    for i in range(20):
        reference = idr.TipReference(p_WD=far, v_WD=[0.1, 0.2, 0.3], n_WD=n, pen_down=i >= 5)
        out = controller.step(terms, reference, surface, np.concatenate([4.0 * (i >= 8) * n, np.zeros(3)]))
        assert np.isfinite(out.tau).all() and not out.status.bad_input
    return True


KINDS = ("shaped", "scaled", "natural")
PATHS = list(leaves(idr.ImpedanceSettings()))


def test_all_settings_are_found() -> None:
    names = {".".join(path) for path in PATHS}
    assert len(names) > 50
    assert {"stiffness.linear.normal", "damping_ratio", "null_space.stiffness", "limits.torque_rate"} <= names
    assert ends(("damping_ratio",)) == (0.05, 3.0) and ends(("timing", "dt")) == (5e-4, 0.1)


@pytest.mark.parametrize("kind", KINDS)
def test_each_end_is_refused_or_finite(kind: str) -> None:
    accepted = 0
    for path in PATHS:
        for x in ends(path):
            settings = base(kind)
            put(settings, path, x)
            try:
                accepted += step(settings)
            except AssertionError as failed:
                raise AssertionError(f"{kind}: {'.'.join(path)} = {x}") from failed
    assert accepted > len(PATHS) // 2


def test_random_pairs_are_refused_or_finite() -> None:
    seed = 36
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    accepted, count = 0, 20000 if LONG else 500
    for i in range(count):
        kind, chosen = KINDS[i % 3], rng.choice(len(PATHS), 2, replace=False)
        settings, told = base(kind), f"seed {seed}, pair {i}, {kind}"
        for path in (PATHS[k] for k in chosen):
            low, high = ends(path)
            share = rng.choice([0.0, 1.0, rng.random()], p=[0.3, 0.3, 0.4])
            put(settings, path, low + share * (high - low))
            told += f", {'.'.join(path)} = {low + share * (high - low)}"
        try:
            accepted += step(settings)
        except AssertionError as failed:
            raise AssertionError(told) from failed
    assert accepted > count // 4
