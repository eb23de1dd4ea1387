"""Who keeps whom alive, and references that are lost or given twice. ./check --asan runs these with the bindings under the address
sanitizer, where a view that outlives its memory ends the process."""

import copy
import gc
import pickle
import sys
import threading
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import POSTURE
from test_records import RECORDS

import impedraw as idr
from impedraw import _runner

Q = POSTURE


def controlled() -> tuple[idr.ImpedanceController, Any, Any, Any]:
    arm = idr.ArmModel.standard()
    t = arm.compute(Q, np.zeros(7))
    reference = idr.TipReference(p_WD=t.X_WE.p, n_WD=-t.X_WE.R[:, 2])
    return idr.ImpedanceController(idr.ImpedanceSettings(), arm), t, reference, idr.SurfaceEstimate()


def filled(record: Any) -> Any:
    """One with arrays that have entries, where the type has some."""
    if record is idr.ArmTerms:
        return idr.ArmModel.standard().compute(Q, Q)
    if record is idr.ImpedanceTorque:
        c, t, reference, surface = controlled()
        return c.step(t, reference, surface)
    if record is idr.ArmLimits:
        return idr.ArmModel.standard().limits
    return record()


def plain(value: Any) -> Any:
    """Python's own data of the same content."""
    return value.tolist() if isinstance(value, np.ndarray) else repr(value)


def churn(record: Any) -> None:
    """Frees what is free to go and takes its memory for something else."""
    gc.collect()
    for other in [record() for _ in range(50)]:
        for name, value in other.__getstate__().items():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                value.fill(-7.0)


@pytest.mark.parametrize("record", RECORDS, ids=lambda r: r.__name__)
def test_parts_outlive_their_owner(record: Any) -> None:
    owner = filled(record)
    expected = {name: plain(value) for name, value in owner.__getstate__().items()}
    parts = {name: getattr(owner, name) for name in expected}
    del owner
    churn(record)
    for name, part in parts.items():
        assert plain(part) == expected[name], name
        # Read by the bindings, too: their reads are the ones that the sanitizer sees.
        assert plain(getattr(record(**{name: part}), name)) == expected[name], name


@pytest.mark.parametrize("record", RECORDS, ids=lambda r: r.__name__)
def test_a_part_holds_one_reference_and_gives_it_back(record: Any) -> None:
    owner = filled(record)
    before = sys.getrefcount(owner)
    for name in list(owner.__getstate__()):
        parts = [getattr(owner, name) for _ in range(3)]
        held = sys.getrefcount(owner) - before
        assert 0 <= held <= 3, name
        if isinstance(parts[0], np.ndarray) and np.shares_memory(parts[0], getattr(owner, name)):
            assert held == 3, name
        del parts
        gc.collect()
        assert sys.getrefcount(owner) == before, name


@pytest.mark.parametrize("record", RECORDS, ids=lambda r: r.__name__)
def test_copies_share_nothing(record: Any) -> None:
    owner = filled(record)
    expected = plain(owner)
    for made in (copy.copy(owner), copy.deepcopy(owner), pickle.loads(pickle.dumps(owner))):
        for name, value in made.__getstate__().items():
            if isinstance(value, np.ndarray) and value.flags.writeable and value.size:
                value.fill(-7.0)
        assert plain(owner) == expected
        del made
    gc.collect()
    assert plain(owner) == expected


def test_parts_of_parts_keep_the_whole() -> None:
    pose = idr.ArmModel.standard().compute(Q, Q).X_WE
    R, expected = pose.R, pose.R.tolist()
    del pose
    churn(idr.ArmTerms)
    assert R.tolist() == expected == idr.Pose(R=R).R.tolist()


def test_results_are_not_the_next_ones() -> None:
    c, t, reference, surface = controlled()
    rng = np.random.default_rng(1)
    taus, expected = [], []
    for _ in range(100):
        out = c.step(t, reference, surface, rng.normal(0, 1, 6))
        reference.p_WD = t.X_WE.p + rng.normal(0, 1e-3, 3)
        taus.append((out.tau, out.terms, out.status))
        expected.append((out.tau.tolist(), out.terms.tolist(), repr(out.status)))
    del c, out, t
    gc.collect()
    assert [(a.tolist(), b.tolist(), repr(s)) for a, b, s in taus] == expected


def test_the_cloud_lives_as_long_as_a_view_of_it() -> None:
    cloud = np.random.default_rng(0).uniform(0, 0.1, (500, 3))
    e = idr.SurfaceEstimator(cloud, [0, 0, 1])
    before = sys.getrefcount(e)
    views = [e.points, e.normals]
    assert sys.getrefcount(e) == before + 2
    expected = [v.tolist() for v in views]
    del e
    gc.collect()
    assert [idr.SurfaceEstimator(cloud, [0, 0, 1]).points.shape for _ in range(5)] == [(500, 3)] * 5
    assert str([v.tolist() for v in views]) == str(expected)
    # The caller's array is copied.
    e = idr.SurfaceEstimator(cloud, [0, 0, 1])
    n = e.estimate([0.05, 0.05, 0.05])
    cloud.fill(np.nan)
    assert e.estimate([0.05, 0.05, 0.05]) == n


def test_a_path_and_a_world_need_nothing_of_what_made_them() -> None:
    canvas = idr.Plane().canvas()
    path = idr.plan_tip_path([np.array([[0.6, 0.0], [0.62, 0.0]])], canvas)
    middle = path.at(path.duration / 2)
    w = idr.World(idr.ArmModel.standard().urdf, canvas)
    w.set_state(Q)
    gone = sys.getrefcount(canvas)
    del canvas
    gc.collect()
    assert gone >= 2 and path.at(path.duration / 2) == middle
    states = []
    for _ in range(20):
        contact = w.step(np.zeros(7))
        states.append((w.state.q, w.state.X_WE.R, contact.f_W))
    expected = [[x.tolist() for x in s] for s in states]
    del w, contact
    gc.collect()
    assert [[x.tolist() for x in s] for s in states] == expected


def test_arguments_are_given_back() -> None:
    """After calls that work and calls that are refused."""
    c, t, reference, surface = controlled()
    arm, w = idr.ArmModel.standard(), idr.World(idr.ArmModel.standard().urdf)
    w.set_state(Q)
    six, seven, wrong, ragged = np.zeros(6), np.zeros(7), np.zeros(5), [[1], [2, 3]]
    cloud, strided = np.random.default_rng(0).uniform(0, 0.1, (200, 3)), np.zeros((7, 2))[:, 0]
    estimator = idr.SurfaceEstimator(cloud, [0, 0, 1])
    wrench = idr.WrenchEstimator(idr.WrenchEstimatorSettings())
    pose, stroke, triangle = idr.Pose(), np.array([[0.6, 0.0], [0.62, 0.0]]), np.array([[0, 1, 2]])
    corners = np.eye(3)
    things: list[Any] = [t, reference, surface, six, seven, wrong, ragged, cloud, strided, pose, stroke, triangle, corners]
    calls: list[Callable[[], Any]] = [
        lambda: c.step(t, reference, surface, six),
        lambda: c.step(t, reference, surface, wrong),
        lambda: c.step(t, reference, surface, ragged),
        lambda: arm.compute(seven, strided),
        lambda: arm.compute(wrong, seven),
        lambda: w.step(strided),
        lambda: w.step(wrong),
        lambda: w.step(seven, wrong),
        lambda: estimator.estimate_all(cloud),
        lambda: estimator.estimate_all(wrong),
        lambda: idr.SurfaceEstimator(cloud, wrong),
        lambda: idr.SurfaceEstimator(cloud, [0, 0, 1], weight=wrong),
        lambda: wrench.update(six, pose, six),
        lambda: wrench.update(wrong, pose, six),
        lambda: idr.plan_tip_path([stroke], 0.0),
        lambda: idr.plan_tip_path([stroke, wrong], 0.0),
        lambda: idr.Canvas.from_mesh(corners, triangle),
        lambda: idr.Canvas.from_mesh(corners, triangle + 1),
        lambda: idr.identify_tool([corners] * 3, wrong),
        lambda: idr.TipReference(p_WD=wrong),
        lambda: idr.ArmTerms(q=seven, X_WE=pose),
        lambda: idr.ImpedanceTorque(status=wrong),  # type: ignore[arg-type]
        lambda: idr.ImpedanceSettings(unknown=pose),  # type: ignore[call-arg]
    ]
    refused = 0
    before = [sys.getrefcount(x) for x in things]
    for call in calls:
        for _ in range(20):
            try:
                call()
            except ValueError as fault:
                refused += 1
                assert "\n" not in str(fault)
    gc.collect()
    assert refused == 15 * 20
    assert [sys.getrefcount(x) for x in things] == before


def test_a_callback_is_given_back() -> None:
    told: list[float] = []

    def seen(what: str, share: float) -> None:
        told.append(share)

    def fail(what: str, share: float) -> None:
        raise RuntimeError("mine")

    settings = {"canvas.kind": "plane", "drawing.placement.scale": 0.05}
    for callback in (seen, fail):
        before = sys.getrefcount(callback)
        try:
            _runner.run(settings, progress=callback)
        except RuntimeError as fault:
            assert str(fault) == "mine"
            del fault
        gc.collect()
        assert sys.getrefcount(callback) == before
    gone = weakref.ref(seen)
    del seen, callback
    gc.collect()
    assert told and gone() is None


def test_threads_share_what_may_be_shared() -> None:
    cloud = np.random.default_rng(0).uniform(0, 0.1, (2000, 3))
    estimator, canvas = idr.SurfaceEstimator(cloud, [0, 0, 1]), idr.Plane().canvas()
    expected = [x.tolist() for x in estimator.estimate_all(cloud[:200])]
    said: list[Any] = []

    def work(e: idr.SurfaceEstimator, s: idr.Canvas) -> None:
        for _ in range(10):
            said.append([x.tolist() for x in e.estimate_all(cloud[:200])])
            assert s.closest([0.6, 0, 0.3]).distance > 0
            pickle.dumps(e.estimate(cloud[0]))

    threads = [threading.Thread(target=work, args=(estimator, canvas)) for _ in range(4)]
    for t in threads:
        t.start()
    del estimator, canvas  # the threads' own references are the last ones
    for t in threads:
        t.join()
    assert len(said) == 40 and all(str(s) == str(expected) for s in said)
