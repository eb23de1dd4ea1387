import os

import numpy as np
import pytest
from made_up import CORNERS, difference, eye_in_hand, eye_to_hand, looking_at, pose, seen
from scipy.spatial.transform import Rotation

from impedraw.camera.hand_eye import Refused, calibrate, closed_form, inverse

LONG = 200 if os.environ.get("IMPEDRAW_LONG") else 8


@pytest.mark.parametrize("make, camera, board", [(eye_to_hand, "fixed", "tool"), (eye_in_hand, "tool", "fixed")])
def test_exact_views_give_the_pose(make, camera, board):
    A, B, views = make(np.random.default_rng(1), 8, pixel_sigma=0.0, depth_sigma=0.0)
    for view in views:
        view.depth_sigma = 1e-3
    found = calibrate(views, camera, board)
    assert max(difference(found.A, A)) < 1e-6 and max(difference(found.B, B)) < 1e-6
    assert found.pixel_rms < 1e-6


def test_closed_form_is_exact_without_noise():
    rng = np.random.default_rng(2)
    A, B, views = eye_to_hand(rng, 5, pixel_sigma=0.0)
    G = [v.X_WE for v in views]
    found = closed_form(G, [inverse(A) @ g @ B for g in G])
    assert max(difference(found[0], A)) < 1e-9 and max(difference(found[1], B)) < 1e-9


def trials(make, camera, board):
    return np.array([difference(*pair) for pair in (
        (calibrate(views, camera, board).A, A) for A, _, views in (make(np.random.default_rng(seed), 15) for seed in range(LONG)))])  # fmt: skip


@pytest.mark.parametrize("make, camera, board", [(eye_to_hand, "fixed", "tool"), (eye_in_hand, "tool", "fixed")])
def test_fifteen_poses_with_noise(make, camera, board):
    found = np.quantile(trials(make, camera, board), 0.95, axis=0)
    print(f"95 %: {1e3 * found[0]:.2f} mm, {found[1]:.3f} degrees")
    assert found[0] <= 0.5e-3 and found[1] <= 0.08


def test_the_covariance_tells_the_scatter():
    """Errors in units of their own standard deviation have squares of mean six."""
    squares = []
    for seed in range(LONG):
        A, _, views = eye_to_hand(np.random.default_rng(100 + seed), 10)
        found = calibrate(views, "fixed", "tool")
        error = np.hstack([Rotation.from_matrix(found.A[:3, :3].T @ A[:3, :3]).as_rotvec(), A[:3, 3] - found.A[:3, 3]])
        squares.append(error @ np.linalg.solve(found.covariance, error))
    assert 3.0 < np.mean(squares) < 9.0


def test_the_deviation_at_the_canvas_is_what_points_there_scatter_by():
    errors = []
    for seed in range(LONG):
        A, B, views = eye_to_hand(np.random.default_rng(200 + seed), 10)
        found = calibrate(views, "fixed", "tool")
        p_C = [0.0, 0.0, found.distance, 1.0]
        errors.append(np.linalg.norm((found.A - A) @ p_C) / found.at_canvas)
    # It is that of the worst direction, of three.
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 2.0


def test_poses_about_one_axis_are_refused():
    *_, views = eye_to_hand(np.random.default_rng(3), 15, one_axis=True)
    with pytest.raises(Refused, match="one axis"):
        calibrate(views, "fixed", "tool")


def test_a_wrong_view_is_left_out_by_name():
    A, _, views = eye_to_hand(np.random.default_rng(4), 15)
    views[6].X_WE = views[6].X_WE @ pose(np.eye(3), [0.01, 0.0, 0.0])
    found = calibrate(views, "fixed", "tool")
    assert len(found.left_out) == 1 and found.left_out[0].startswith("view 7:")
    assert difference(found.A, A)[0] < 1e-3


def test_wrong_intrinsics_and_depth_scales_are_refused():
    *_, views = eye_to_hand(np.random.default_rng(5), 15)
    for view in views:
        view.K = view.K * np.array([[1.05], [1.0], [1.0]])
        view.depths = None
    with pytest.raises(Refused, match="intrinsics"):
        calibrate(views, "fixed", "tool")
    *_, views = eye_to_hand(np.random.default_rng(5), 15)
    for view in views:
        view.depths = 1.03 * view.depths
    with pytest.raises(Refused, match="depth_scale"):
        calibrate(views, "fixed", "tool")


def test_touches_alone_tell_a_fixed_camera_before_a_fixed_board():
    rng = np.random.default_rng(6)
    X_WC, X_WB = looking_at([1.2, 0.1, 0.8], [0.6, 0.0, 0.0]), pose(np.eye(3), [0.6, 0.0, 0.0])
    views = [seen(rng, inverse(X_WC) @ X_WB, np.eye(4), f"view {k}") for k in range(3)]
    corners = CORNERS[[0, 6, 28, 34]]
    touched = corners + X_WB[:3, 3] + 1e-4 * rng.standard_normal((4, 3))
    found = calibrate(views, "fixed", "fixed", (corners, touched))
    # The camera's own place is known less well than that of what it sees near the touched corners.
    centre_C = inverse(X_WC) @ X_WB @ [0.0, 0.0, 0.0, 1.0]
    assert np.linalg.norm((found.A - X_WC) @ centre_C) < 4e-4 and difference(found.B, X_WB)[0] < 3e-4
    with pytest.raises(Refused, match="three corners"):
        calibrate(views, "fixed", "fixed")
    with pytest.raises(Refused, match="on one line"):
        calibrate(views, "fixed", "fixed", (CORNERS[:4], CORNERS[:4] + X_WB[:3, 3]))
