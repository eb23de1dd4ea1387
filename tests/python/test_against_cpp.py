"""The bindings against the library called from C++ (oracle.cc), to the last bit, with inputs that Hypothesis draws."""

import ctypes
import os
from typing import Any

import numpy as np
import pytest
from conftest import POSTURE
from hypothesis import given
from hypothesis import strategies as st

import impedraw as idr

ORACLE = os.environ.get("IMPEDRAW_ORACLE")
pytestmark = pytest.mark.skipif(not ORACLE, reason="the oracle is made in a source tree")
library = ctypes.CDLL(ORACLE) if ORACLE else None
SEEDS = st.integers(0, 2**32 - 1)


def ask(name: str, count: int, *given: Any) -> Any:
    """The numbers that a function of oracle.cc writes."""
    out = np.full(count, np.nan)
    kept: list[Any] = []
    words: list[Any] = []
    for x in given:
        if isinstance(x, float):
            words.append(ctypes.c_double(x))
        elif isinstance(x, (int, bytes)):
            words.append(x)
        else:
            kept.append(np.ascontiguousarray(x, dtype=float))
            words.append(kept[-1].ctypes.data_as(ctypes.c_void_p))
    getattr(library, name)(*words, out.ctypes.data_as(ctypes.c_void_p))
    return out


def urdf() -> bytes:
    return os.fsencode(idr.ArmModel.standard().urdf)


def flat(*parts: Any) -> Any:
    return np.concatenate([np.ravel(np.asarray(p, dtype=float)) for p in parts])


@given(seed=SEEDS)
def test_arm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, v = POSTURE + rng.normal(0, 0.5, 7), rng.normal(0, 1, 7)
    t = idr.ArmModel.standard().compute(q, v)
    np.testing.assert_array_equal(
        flat(t.M, t.Cv, t.g, t.J, t.Jdot_v, t.X_WE.p, t.X_WE.R, t.V_WE), ask("oracle_arm", 129, urdf(), q, v)
    )


@given(
    seed=SEEDS,
    force=st.floats(0.5, 40),
    stiffness=st.floats(100, 4000),
    touch=st.floats(0.1, 2),
    mass=st.floats(1, 10),
    inertia=st.sampled_from(sorted(idr.InertiaShaping.__members__)),
)
def test_controller(seed: int, force: float, stiffness: float, touch: float, mass: float, inertia: str) -> None:
    rng = np.random.default_rng(seed)
    arm = idr.ArmModel.standard()
    s = idr.ImpedanceSettings(normal_force=force, inertia=inertia)
    s.stiffness.linear.tangent = stiffness
    s.contact.touch_force = touch
    s.shaped_inertia.linear.normal = mass
    controller = idr.ImpedanceController(s, arm)
    given, seen = [], []
    for k in range(40):
        q, v = POSTURE + rng.normal(0, 0.002, 7), rng.normal(0, 0.02, 7)
        t = arm.compute(q, v)
        n = -t.X_WE.R[:, 2] / np.linalg.norm(t.X_WE.R[:, 2])
        p, down, distance = t.X_WE.p + rng.normal(0, 1e-3, 3), k > 5, 1e-4 * rng.normal()
        F = rng.normal(0, 1, 6)
        given.append(flat(q, v, p, n, down, n, distance, F))
        out = controller.step(
            t,
            idr.TipReference(p_WD=p, n_WD=n, pen_down=down),
            idr.SurfaceEstimate(status="ok", n_W=n, distance=distance),
            F,
        )
        seen.append(flat(out.tau, out.terms, out.mode.value, out.push))
    number = idr.InertiaShaping.__members__[inertia].value
    told = ask("oracle_control", 65 * 40, urdf(), np.array([force, stiffness, touch, mass, number]), 40, np.array(given))
    np.testing.assert_array_equal(np.concatenate(seen), told)
    assert np.abs(told.reshape(40, 65)[:, :7]).max() > 1  # it did something


@given(seed=SEEDS, k=st.integers(8, 40), count=st.integers(100, 400))
def test_surface_estimator(seed: int, k: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    points = np.c_[rng.uniform(-0.05, 0.05, (count, 2)), rng.normal(0, 1e-3, count)]
    queries = rng.uniform(-0.06, 0.06, (20, 3)) * [1, 1, 0.1]
    eye = np.array([0.1, 0, 1.0])
    e = idr.SurfaceEstimator(points, eye, idr.NormalSettings(k=k))
    told = ask("oracle_surface", 100, points, count, eye, k, 20, queries).reshape(20, 5)
    normals, distances, status = e.estimate_all(queries)
    for i, x in enumerate(map(e.estimate, queries)):
        np.testing.assert_array_equal(flat(x.n_W, x.distance, x.status.value), told[i])
        np.testing.assert_array_equal(flat(normals[i], distances[i], status[i]), told[i])


@given(seed=SEEDS, z=st.floats(-0.2, 0.2), speed=st.floats(0.01, 0.1), count=st.integers(1, 12))
def test_tip_path(seed: int, z: float, speed: float, count: int) -> None:
    rng = np.random.default_rng(seed)
    stroke = np.array([0.6, 0.0]) + np.cumsum(rng.normal(0, 0.02, (count, 2)), axis=0)
    path = idr.plan_tip_path([stroke], z, idr.PathSettings(draw_speed=speed))
    times = np.linspace(-1, path.duration + 1, 50)
    told = ask("oracle_path", 1 + 14 * 50, stroke, count, z, speed, 50, times)
    seen = [
        flat(x.reference.p_WD, x.reference.v_WD, x.reference.a_WD, x.reference.n_WD, x.stroke, x.along)
        for x in map(path.at, times)
    ]
    np.testing.assert_array_equal(flat(path.duration, *seen), told)


@given(seed=SEEDS, bandwidth=st.floats(0, 500), tare=st.floats(0.01, 0.03))
def test_wrench_estimator(seed: int, bandwidth: float, tare: float) -> None:
    readings = np.random.default_rng(seed).normal(0, 5, (60, 6))
    e = idr.WrenchEstimator(idr.WrenchEstimatorSettings(filter_bandwidth=bandwidth, tare_time=tare))
    seen = [e.update(r, idr.Pose(), np.zeros(6)) for r in readings]
    assert e.tared
    np.testing.assert_array_equal(flat(*seen), ask("oracle_wrench", 360, bandwidth, tare, 60, readings))


@given(seed=SEEDS, friction=st.floats(0, 2))
def test_world(seed: int, friction: float) -> None:
    rng = np.random.default_rng(seed)
    steps = rng.normal(0, 5, (30, 10))
    w = idr.World(idr.ArmModel.standard().urdf, None, idr.WorldSettings(joint_friction=friction))
    w.set_state(POSTURE)
    seen = []
    for x in steps:
        contact = w.step(x[:7], x[7:])
        seen.append(flat(w.state.q, w.state.v, contact.f_W))
    np.testing.assert_array_equal(flat(*seen), ask("oracle_world", 17 * 30, urdf(), POSTURE, friction, 30, steps))
