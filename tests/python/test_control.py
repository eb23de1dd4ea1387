"""The control side against closed forms and against itself called another way."""

from typing import Any

import numpy as np
import pytest
from conftest import POSTURE
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import impedraw as idr

postures = st.lists(st.floats(-0.4, 0.4), min_size=7, max_size=7).map(lambda d: POSTURE + np.array(d))
speeds = st.lists(st.floats(-0.5, 0.5), min_size=7, max_size=7).map(np.array)


@given(q=postures, v=speeds)
def test_arm_terms_keep_the_laws_of_mechanics(q: Any, v: Any) -> None:
    arm = idr.ArmModel.standard()
    t = arm.compute(q, v)
    assert np.array_equal(t.M, t.M.T) and np.linalg.eigvalsh(t.M).min() > 0
    np.testing.assert_allclose(t.V_WE, t.J @ v, atol=1e-12)
    np.testing.assert_allclose(t.X_WE.R @ t.X_WE.R.T, np.eye(3), atol=1e-12)
    np.testing.assert_array_equal(arm.tip_pose(q).p, t.X_WE.p)
    # J against central differences of the pose, C v against those of the kinetic energy.
    h = 1e-6
    for j in range(7):
        step = h * np.eye(7)[j]
        dp = (arm.tip_pose(q + step).p - arm.tip_pose(q - step).p) / (2 * h)
        np.testing.assert_allclose(t.J[:3, j], dp, atol=1e-8)
    ahead, behind = (arm.compute(q + s * h * v, v).M for s in (1, -1))
    rate = v @ ((ahead - behind) / (2 * h)) @ v
    np.testing.assert_allclose(v @ t.Cv, rate / 2, atol=1e-6)  # v·(Ṁ − 2C)v = 0


@given(q=postures, v=speeds, offset=st.lists(st.floats(-0.01, 0.01), min_size=3, max_size=3))
def test_free_motion_follows_the_closed_loop(q: Any, v: Any, offset: Any) -> None:
    """M_d (V̇ − V̇_d) = B (V_d − V) + K e along the tangents, from the torque alone (1)."""
    arm = idr.ArmModel.standard()
    s = idr.ImpedanceSettings(
        observer=idr.ObserverSettings(enabled=False),
        limits=idr.LimitSettings(torque=np.full(7, 1000.0), tip_speed=5, turn_speed=50),
    )
    controller = idr.ImpedanceController(s, 7)
    t = arm.compute(q, np.zeros(7))
    n = -t.X_WE.R[:, 2]
    reference = idr.TipReference(p_WD=t.X_WE.p + offset, n_WD=n)
    out = controller.step(t, reference, idr.SurfaceEstimate(), np.zeros(6))
    assert out.mode == idr.ContactMode.free
    np.testing.assert_allclose(out.terms.sum(axis=1), out.tau, atol=1e-9)
    assert not out.status.bad_input
    if out.status.near_singular or out.status.joint_limit:
        return
    acceleration = t.J @ np.linalg.solve(t.M, out.tau - t.g) + t.Jdot_v
    P = np.outer(n, n)
    K = s.stiffness.linear.tangent * (np.eye(3) - P) + s.stiffness.linear.normal * P
    M = s.shaped_inertia.linear.tangent * (np.eye(3) - P) + s.shaped_inertia.linear.normal * P
    np.testing.assert_allclose(acceleration[:3], np.linalg.solve(M, K @ offset), atol=1e-7)


def test_a_step_is_what_the_same_step_was(arm: idr.ArmModel, posture: NDArray[np.float64]) -> None:
    """Two controllers with the same inputs give the same bits; a result is not changed by the next."""
    a, b = (idr.ImpedanceController(idr.ImpedanceSettings(), arm.joints) for _ in range(2))
    rng = np.random.default_rng(1)
    first = None
    for _ in range(50):
        t = arm.compute(posture + rng.normal(0, 0.01, 7), rng.normal(0, 0.1, 7))
        reference = idr.TipReference(p_WD=t.X_WE.p, n_WD=-t.X_WE.R[:, 2], pen_down=True)
        surface = idr.SurfaceEstimate(status="ok", n_W=-t.X_WE.R[:, 2], distance=1e-4)
        F = rng.normal(0, 1, 6)
        x, y = a.step(t, reference, surface, F), b.step(t, reference, surface, list(F))
        assert x == y
        if first is None:
            first, kept = x, x.tau.copy()
    assert first is not None and np.array_equal(first.tau, kept)


def test_faults_of_the_loop_are_told_in_the_status(arm: idr.ArmModel, posture: NDArray[np.float64]) -> None:
    c = idr.ImpedanceController(idr.ImpedanceSettings(), 7)
    t = arm.compute(posture, np.zeros(7))
    ref = idr.TipReference(p_WD=t.X_WE.p, n_WD=-t.X_WE.R[:, 2])
    none = idr.SurfaceEstimate()
    g = c.step(t, ref, none, np.zeros(6)).terms[:, list(idr.TORQUE_TERMS).index("gravity")]
    np.testing.assert_allclose(g, t.g)
    for wrong in ([np.nan] * 6, [np.inf] * 6):
        out = c.step(t, ref, none, wrong)
        assert out.status.bad_input and not out.status.ok
    assert c.step(t, ref, none, np.zeros(6), state_age=0.1).status.stale_state
    assert c.step(t, ref, none, np.zeros(6), wrench_age=0.1).status.stale_wrench
    with pytest.raises(ValueError, match=r"F_ext has the shape \(5,\); valid is \(6,\)"):
        c.step(t, ref, none, np.zeros(5))
    with pytest.raises(ValueError, match="terms are of an arm of 6 joints"):
        c.step(idr.ArmTerms(q=np.zeros(6)), ref, none)
    with pytest.raises(ValueError, match="q is .*; valid is 7 entries"):
        arm.compute(posture[:6], posture)


@given(
    mass=st.floats(0.1, 5),
    centre=st.lists(st.floats(-0.1, 0.1), min_size=3, max_size=3),
    bias=st.lists(st.floats(-5, 5), min_size=6, max_size=6),
)
def test_tool_is_identified(mass: Any, centre: Any, bias: Any) -> None:
    g = np.array([0, 0, -9.81])
    turns = [np.eye(3)]
    for a in range(3):
        for angle in (np.pi / 2, -np.pi / 2, np.pi):
            u, w = np.eye(3)[(a + 1) % 3], np.eye(3)[(a + 2) % 3]
            R = np.outer(np.eye(3)[a], np.eye(3)[a]) + np.cos(angle) * (np.outer(u, u) + np.outer(w, w))
            turns.append(R + np.sin(angle) * (np.outer(w, u) - np.outer(u, w)))
    readings = [np.r_[mass * R.T @ g, np.cross(centre, mass * R.T @ g)] + bias for R in turns]
    found = idr.identify_tool(turns, readings)
    assert found.mass == pytest.approx(mass, rel=1e-9)
    np.testing.assert_allclose(found.p_SC, centre, atol=1e-9)
    np.testing.assert_allclose(found.bias_S, bias, atol=1e-8)


def test_tool_needs_poses() -> None:
    with pytest.raises(ValueError, match="3"):
        idr.identify_tool([np.eye(3)] * 2, np.zeros((2, 6)))
    with pytest.raises(ValueError, match=r"readings_S has the shape \(3, 5\)"):
        idr.identify_tool([np.eye(3)] * 3, np.zeros((3, 5)))


def test_wrench_estimator_tares_and_moves_the_wrench_to_the_tip() -> None:
    X_ES = idr.Pose(p=[0, 0, -0.1])
    e = idr.WrenchEstimator(idr.WrenchEstimatorSettings(X_ES=X_ES, tare_time=0.05))
    rest = idr.Pose()
    for _ in range(60):
        e.update([1, 2, 3, 0.1, 0.2, 0.3], rest, np.zeros(6))
    assert e.tared and not e.fault
    np.testing.assert_allclose(e.bias, [1, 2, 3, 0.1, 0.2, 0.3], atol=1e-12)
    F = e.update([2, 2, 3, 0.1, 0.2, 0.3], rest, np.zeros(6))
    np.testing.assert_allclose(F, np.r_[1, 0, 0, -np.cross([0, 0, 0.1], [1, 0, 0])], atol=1e-12)
    e.update([np.nan] * 6, rest, np.zeros(6))
    assert e.fault


def test_joint_state_estimator_follows_a_steady_motion(arm: idr.ArmModel) -> None:
    s = idr.JointStateEstimatorSettings()
    e = idr.JointStateEstimator(s, 7)
    q, v = POSTURE.copy(), np.full(7, 0.1)
    for _ in range(400):
        e.update(q)
        t = arm.compute(e.q, e.v)
        e.commanded(t, np.zeros(6), t.Cv + t.g)  # the model explains rest of acceleration
        q = q + s.dt * v
    np.testing.assert_allclose(e.v, v, atol=1e-3)


@given(tilt=st.floats(-0.4, 0.4), height=st.floats(-0.2, 0.2))
def test_surface_estimator_of_a_plane(tilt: Any, height: Any) -> None:
    rng = np.random.default_rng(3)
    xy = rng.uniform(-0.1, 0.1, (4000, 2))
    points = np.c_[xy, tilt * xy[:, 0] + height]
    e = idr.SurfaceEstimator(points, [0, 0, 5])
    n = np.array([-tilt, 0, 1]) / np.hypot(tilt, 1)
    p = np.array([0.01, 0.02, 0.01 * tilt + height]) + 0.002 * n
    there = e.estimate(p)
    assert there.status == idr.SurfaceStatus.ok
    np.testing.assert_allclose(there.n_W, n, atol=1e-9)
    assert there.distance == pytest.approx(0.002, abs=1e-9)
    normals, distances, status = e.estimate_all([p, [5, 5, 5]])
    assert np.array_equal(normals[0], there.n_W) and distances[0] == there.distance
    assert list(status) == [0, idr.SurfaceStatus.too_few.value]
    assert e.points.shape == (4000, 3) and not e.points.flags.writeable
    assert sorted(map(tuple, e.points)) == sorted(map(tuple, points))


@pytest.mark.parametrize(
    "points, message",
    [
        (np.zeros((0, 3)), "cloud"),
        (np.zeros((100, 2)), r"points has the shape \(100, 2\); valid is \(N, 3\)"),
        (np.full((100, 3), np.nan), "finite"),
    ],
)
def test_surface_estimator_refuses(points: Any, message: Any) -> None:
    with pytest.raises(ValueError, match=message):
        idr.SurfaceEstimator(points, [0, 0, 1])


def test_a_view_of_the_cloud_keeps_it_alive() -> None:
    import gc

    points = idr.SurfaceEstimator(np.random.default_rng(0).uniform(0, 0.1, (500, 3)), [0, 0, 1]).points
    gc.collect()
    assert points.sum() > 0 and points.shape == (500, 3)


@given(length=st.floats(0.02, 0.2), z=st.floats(-0.1, 0.1))
def test_tip_path_of_a_line(length: Any, z: Any) -> None:
    s = idr.PathSettings()
    path = idr.plan_tip_path([[[0.5, 0.0], [0.5 + length, 0.0]]], z, s)
    assert path.pen_down_length == pytest.approx(length, rel=1e-9)
    times = np.arange(0, path.duration, 0.01)
    samples = [path.at(t) for t in times]
    drawn = [x for x in samples if x.stroke == 0]
    assert drawn and all(abs(x.reference.p_WD[2] - z) < 1e-9 for x in drawn)
    assert max(np.linalg.norm(x.reference.v_WD) for x in drawn) <= s.draw_speed * (1 + 1e-9)
    h = 1e-5
    x = path.at(path.duration / 2)
    v = (path.at(path.duration / 2 + h).reference.p_WD - path.at(path.duration / 2 - h).reference.p_WD) / (2 * h)
    np.testing.assert_allclose(x.reference.v_WD, v, atol=1e-4)


def test_tip_path_refuses() -> None:
    with pytest.raises(ValueError, match=r"strokes\[0\] has the shape \(2, 3\)"):
        idr.plan_tip_path([np.zeros((2, 3))], 0.0)
    with pytest.raises(ValueError, match="draw_speed"):
        idr.plan_tip_path([[[0, 0], [1, 0]]], 0.0, idr.PathSettings(draw_speed=-1))
    with pytest.raises(ValueError, match="no strokes|stroke"):
        idr.plan_tip_path([], 0.0)


def test_preflight_tells_what_the_arm_cannot_draw() -> None:
    arm = idr.ArmModel.standard()
    q = [0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0]
    line = np.column_stack([np.linspace(0.55, 1.4, 400), np.zeros(400)])
    checked = idr.check_strokes([line], 0.2, arm, q)
    assert checked.drawable and checked.findings
    # Parts and findings cover the stroke once.
    parts = sorted([(p.start, p.end) for p in checked.drawable] + [(f.part.start, f.part.end) for f in checked.findings])
    assert parts[0][0] == 0.0 and abs(parts[-1][1] - 0.85) < 1e-9
    assert all(abs(a[1] - b[0]) < 1e-9 for a, b in zip(parts, parts[1:]))
    assert checked.findings[-1].problem in (idr.Problem.out_of_reach, idr.Problem.near_singular, idr.Problem.joint_limit, idr.Problem.torque)
    # The far end, 1.4 m away, is beyond the arm: the model itself says how far the flange gets.
    assert checked.drawable[-1].end < 0.85
    only_surface = idr.check_strokes([line], 0.2, arm, q, idr.PreflightSettings(arm=False))
    assert not only_surface.findings
    with pytest.raises(ValueError, match="step"):
        idr.check_strokes([line], 0.2, arm, q, idr.PreflightSettings(step=9.0))
    with pytest.raises(ValueError, match="start_q"):
        idr.check_strokes([line], 0.2, arm, [0.0, 1.0])
    near = line[:40]
    path = idr.plan_tip_path([near], 0.2, idr.PathSettings(start_p_WE=arm.tip_pose(q).p))
    assert idr.check_transitions(path, [near], arm, q) == []


def test_a_canvas_is_a_surface_to_plan_on() -> None:
    canvas = idr.Bowl().canvas()
    path = idr.plan_tip_path([np.array([[0.6, 0.0], [0.62, 0.0]])], canvas)
    middle = path.at(path.duration / 2).reference.p_WD
    assert abs(canvas.closest(middle).distance) < 0.05


def test_joint_sensor_rounds_delays_and_repeats() -> None:
    settings = idr.JointSensorSettings(quantum=1e-3, delay=0.002, velocity="none")
    sensor = idr.JointSensor(settings, 2)
    read = [sensor.read([1e-2 * k + 4e-4, 0.0], [1.0, 0.0])[0][0] for k in range(5)]
    assert read[2:] == pytest.approx([0.0, 1e-2, 2e-2], abs=1e-12)
    noisy = idr.JointSensorSettings(position_noise=1e-3)
    a, b, c = (idr.JointSensor(noisy, 2, seed=s).read([0.0, 0.0], [0.0, 0.0])[0] for s in (1, 1, 2))
    assert (a == b).all() and (a != c).any()
    assert idr.WorldSettings(joint_sensor=noisy).joint_sensor == noisy
    with pytest.raises(ValueError, match="joints"):
        idr.JointSensor(noisy, 0)
    with pytest.raises(ValueError, match="quantum"):
        idr.JointSensor(idr.JointSensorSettings(quantum=-1.0), 2)


NAN3 = np.array([0.0, np.nan, 0.0])
LINE = np.array([[0.0, 0], [0.01, 0]])
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: idr.Canvas.from_mesh(SQUARE * np.nan, [[0, 1, 2]]), "finite"),
        (lambda: idr.Canvas.from_mesh(SQUARE, np.zeros((1, 4))), r"triangles has the shape (1, 4); valid is (N, 3)"),
        (lambda: idr.Canvas.from_mesh(SQUARE, [[0, 1, np.nan]]), "an index of a vertex, 0 to 2"),
        (lambda: idr.Canvas.from_mesh(SQUARE, "abc"), "an array of real numbers"),
        (lambda: idr.Plane().canvas().closest(NAN3), "p_W is [0.0, nan, 0.0]; valid is finite"),
        (lambda: idr.Plane().canvas().closest([1j, 0, 0]), "an array of real numbers"),
        (lambda: idr.SurfaceEstimator(np.zeros((50, 3)), NAN3), "viewpoint is"),
        (lambda: idr.SurfaceEstimator(np.zeros((50, 3)), [0, 0, 1], weight=np.zeros(50)), "positive and finite"),
        (lambda: idr.plan_tip_path([np.full((2, 2), np.nan)], 0.0), "strokes[0]"),
        (lambda: idr.plan_tip_path([np.zeros((0, 2))], 0.0), "at least one point"),
        (lambda: idr.plan_tip_path([LINE], "table"), "surface is 'table'; valid is a number"),  # type: ignore[arg-type]
        (lambda: idr.plan_tip_path([LINE + 9], idr.Plane().canvas()), "leaves the canvas"),
        (lambda: idr.World("/nowhere.urdf"), "/nowhere.urdf"),
        (lambda: idr.World(idr.ArmModel.standard().urdf).step(np.zeros(7), NAN3), "f_push_W is [0.0, nan, 0.0]; valid is finite"),
        (lambda: idr.World(idr.ArmModel.standard().urdf).set_state(np.full(7, np.inf)), "q is"),
        (lambda: idr.World(idr.ArmModel.standard().urdf, settings=idr.WorldSettings(gravity=np.nan)), "gravity"),
        (lambda: idr.JointStateEstimator(idr.JointStateEstimatorSettings(), 7).update(np.zeros(6)), "q_read"),
        (lambda: idr.ArmModel.standard().compute(POSTURE, np.zeros((7, 1))), "v has the shape (7, 1); valid is (N,)"),
    ],
)
def test_bad_input_is_one_line(call: Any, message: str) -> None:
    with pytest.raises(ValueError) as fault:
        call()
    assert message in str(fault.value) and "\n" not in str(fault.value), str(fault.value)


def test_a_surface_that_is_not_known_is_told_in_the_status(arm: idr.ArmModel) -> None:
    t = arm.compute(POSTURE, np.zeros(7))
    n = -t.X_WE.R[:, 2]
    down = idr.TipReference(p_WD=t.X_WE.p, n_WD=n, pen_down=True)
    c = idr.ImpedanceController(idr.ImpedanceSettings(), arm)
    for k in range(100):  # in contact
        assert not c.step(t, down, idr.SurfaceEstimate(status="ok", n_W=n, distance=0.0)).status.bad_input
    for status in ("none", "too_few", "off_edge"):
        out = c.step(t, down, idr.SurfaceEstimate(status=status, n_W=n * np.nan))
        # Without any perception there is nothing to lose: the planned normal is followed.
        assert out.status.surface_lost == (status != "none")
        assert not out.status.bad_input and np.isfinite(out.tau).all()
    for wrong in (n * np.nan, 2 * n):
        out = c.step(t, down, idr.SurfaceEstimate(status="ok", n_W=wrong))
        assert out.status.bad_input and np.isfinite(out.tau).all()


def test_rotors_stand_on_the_diagonal_of_M() -> None:
    bare = idr.ArmModel.standard()
    zero = np.zeros(7)
    M = bare.compute(POSTURE, zero).M
    rotors = [0.3, 0.3, 0.2, 0.2, 0.1, 0.1, 0.05]
    for given_rotors, expected in ((0.1, np.full(7, 0.1)), (rotors, np.array(rotors))):
        arm = idr.ArmModel.from_urdf(bare.urdf, rotor_inertia=given_rotors)
        np.testing.assert_array_equal(arm.rotor_inertia, expected)
        np.testing.assert_allclose(arm.compute(POSTURE, zero).M, M + np.diag(expected), atol=1e-12)
    with pytest.raises(ValueError, match="valid are one entry for all joints"):
        idr.ArmModel.from_urdf(bare.urdf, rotor_inertia=[0.1, 0.2])
    assert idr.ModelErrors(rotor_inertia=0.1).rotor_inertia == [0.1]


def test_points_that_are_nowhere_are_left_out_and_counted() -> None:
    grid = np.stack([*np.meshgrid(np.linspace(-0.1, 0.1, 21), np.linspace(-0.1, 0.1, 21)), np.zeros((21, 21))], -1).reshape(-1, 3)
    organised = np.concatenate([grid, np.full((40, 3), np.nan)])
    weight = np.ones(len(organised))
    with pytest.warns(RuntimeWarning, match="40 of 481 points"):
        seen = idr.SurfaceEstimator(organised, [0, 0, 1], weight=weight)
    whole = idr.SurfaceEstimator(grid, [0, 0, 1], weight=weight[:441])
    assert seen.estimate([0.01, 0.02, 0.003]).distance == whole.estimate([0.01, 0.02, 0.003]).distance
