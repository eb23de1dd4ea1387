"""Structs as Python sees them: construction, repr, equality, copy, pickle, faults."""

import copy
import gc
import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import impedraw as idr

RECORDS = [
    getattr(idr, name)
    for name in idr.__all__
    if hasattr(getattr(idr, name), "__setstate__") and hasattr(getattr(idr, name), "__copy__")
]


def test_all_records_are_here() -> None:
    assert len(RECORDS) >= 35


@pytest.mark.parametrize("record", RECORDS, ids=lambda r: r.__name__)
def test_copies_are_equal_and_their_own(record: Any) -> None:
    a = record()
    assert a == record() and not a != record()
    for b in (copy.copy(a), copy.deepcopy(a), pickle.loads(pickle.dumps(a))):
        assert type(b) is record and b == a and b is not a
    assert repr(a).startswith(record.__name__ + "(") and "\n" not in repr(a)
    with pytest.raises(TypeError):
        hash(a)
    assert a != 1
    for name, value in a.__getstate__().items():
        if isinstance(value, bool):
            assert record(**{name: not value}) != a
        elif isinstance(value, float) and math.isfinite(value):
            changed = record(**{name: value + 1.0})
            assert changed != a and getattr(changed, name) == value + 1.0
            assert pickle.loads(pickle.dumps(changed)) == changed


@given(force=st.floats(0, 50), k=st.floats(0, 20000), q=st.lists(st.floats(-3, 3), min_size=7, max_size=7))
def test_values_come_back_exactly(force: Any, k: Any, q: Any) -> None:
    s = idr.ImpedanceSettings(
        normal_force=force,
        stiffness=idr.TipGain(linear=idr.AxialGain(tangent=k)),
        null_space=idr.NullSpaceSettings(q_0=q),
    )
    assert s.normal_force == force and s.stiffness.linear.tangent == k
    assert list(s.null_space.q_0) == q
    assert pickle.loads(pickle.dumps(s)) == s


def test_groups_are_references_and_outlive_their_owner() -> None:
    s = idr.ImpedanceSettings()
    contact = s.contact
    contact.touch_force = 0.7
    assert s.contact.touch_force == 0.7
    axis = s.surface.drawing_axis_W
    del s
    gc.collect()
    junk = [idr.ImpedanceSettings() for _ in range(200)]
    assert contact.touch_force == 0.7 and list(axis) == [0, 0, 1] and len(junk) == 200


def test_arrays_are_views_where_storage_is_fixed() -> None:
    r = idr.TipReference()
    r.p_WD[1] = 0.25
    assert list(r.p_WD) == [0, 0.25, 0]
    kept = idr.TipReference(p_WD=[1, 2, 3]).p_WD
    gc.collect()
    assert list(kept) == [1, 2, 3]


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: idr.ImpedanceSettings(normal_forc=3), "did you mean 'normal_force'?"),  # type: ignore[call-arg]
        (lambda: idr.ImpedanceSettings(normal_force="abc"), "normal_force is 'abc'; valid is a number"),  # type: ignore[arg-type]
        (lambda: idr.ImpedanceSettings(normal_force=None), "normal_force is None; valid is a number"),  # type: ignore[arg-type]
        (lambda: idr.ImpedanceSettings(inertia="heavy"), "valid is one of natural, scaled, shaped"),
        (lambda: idr.ImpedanceSettings(contact=3), "valid is a ContactSettings"),  # type: ignore[arg-type]
        (lambda: idr.ObserverSettings(enabled=1), "valid is True or False"),  # type: ignore[arg-type]
        (lambda: idr.NormalSettings(k=3.5), "k is 3.5; valid is a whole number"),  # type: ignore[arg-type]
        (lambda: idr.TipReference(p_WD=[1, 2]), "p_WD has the shape (2,); valid is (3,)"),
        (lambda: idr.TipReference(p_WD=["a", "b", "c"]), "valid is an array of real numbers"),
        (lambda: idr.TipReference(p_WD=[[1], [2, 3]]), "valid is an array of real numbers"),
        (lambda: idr.TipReference(p_WD=np.zeros(3, dtype=complex)), "valid is an array of real numbers"),
        (lambda: idr.Pose(R=np.zeros(9)), "R has the shape (9,); valid is (3, 3)"),
        (lambda: idr.ArmTerms(q=np.zeros(13)), "valid is at most 12 entries"),
        (lambda: idr.ImpedanceController(idr.ImpedanceSettings(normal_force=90), 7), "normal_force is 90 N, allowed is 0 to 50 N"),
        (lambda: idr.ImpedanceController(idr.ImpedanceSettings(normal_force=math.nan), 7), "normal_force is"),
        (lambda: idr.ImpedanceController(idr.ImpedanceSettings(), 13), "joints"),
        (lambda: idr.ArmModel.from_urdf("/nowhere.urdf"), "/nowhere.urdf"),
        (lambda: idr.WrenchEstimator(idr.WrenchEstimatorSettings(filter_bandwidth=1e9)), "filter_bandwidth"),
    ],
)
def test_faults_are_one_line_that_names_the_value(make: Any, message: Any) -> None:
    with pytest.raises(ValueError) as fault:
        make()
    assert message in str(fault.value) and "\n" not in str(fault.value)


@pytest.mark.parametrize("layout", ["fortran", "strided", "reversed", "float32", "int", "list", "readonly"])
def test_arrays_of_any_layout(layout: Any) -> None:
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    given = {
        "fortran": np.asfortranarray(R),
        "strided": np.kron(R, np.ones((2, 2)))[::2, ::2],
        "reversed": R[::-1, ::-1].copy()[::-1, ::-1],
        "float32": R.astype(np.float32),
        "int": R.astype(int),
        "list": R.tolist(),
        "readonly": R.copy(),
    }[layout]
    if layout == "readonly":
        given.setflags(write=False)
    assert np.array_equal(idr.Pose(R=given).R, R)
