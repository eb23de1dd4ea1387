"""Points, normals and pose from depth images against small_gicp, which knows nothing of images, cameras or their noise."""

import importlib
import sys
from typing import Any

import numpy as np
import pytest
from test_against_cpp import ORACLE, ask

pytestmark = pytest.mark.skipif(not ORACLE, reason="the oracle is made in a source tree")

WIDTH, HEIGHT, FOV = 160, 120, 45.0
CENTRE = np.array([0.6, 0.0, 0.1])


def height(x: Any, y: Any) -> Any:
    """Of the canvas, which no motion leaves where it is, and its gradient."""
    a, k, m = 0.015, 25.0, 18.0
    u, v = k * (x - 0.6), m * y + 0.5
    return 0.1 + a * np.sin(u) * np.cos(v), a * k * np.cos(u) * np.cos(v), -a * m * np.sin(u) * np.sin(v)


def turn(axis: Any, angle: float) -> Any:
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def look_at(eye: Any) -> Any:
    """R, p of a camera: z ahead, y down."""
    z = (CENTRE - eye) / np.linalg.norm(CENTRE - eye)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z]), np.asarray(eye, dtype=float)


def depth_image(camera: Any, X_WK: Any, rng: Any, sigma: float) -> Any:
    """Depths of the canvas at X_WK: Newton's method along each pixel's ray, to 1e-12 m."""
    R_WC, eye = camera
    R, p = X_WK
    f = 0.5 * HEIGHT / np.tan(np.radians(FOV) / 2)
    i, j = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2, np.arange(HEIGHT) + 0.5 - HEIGHT / 2)
    ray = R.T @ R_WC @ np.stack([i.ravel() / f, j.ravel() / f, np.ones(i.size)])
    start = R.T @ (eye - p)
    d = (0.1 - start[2]) / ray[2]
    for _ in range(60):
        at = start[:, None] + d * ray
        z, zx, zy = height(at[0], at[1])
        d += (z - at[2]) / (ray[2] - zx * ray[0] - zy * ray[1])
    d += sigma * d**2 * rng.normal(size=d.size)
    return d.reshape(HEIGHT, WIDTH)


def points_of(depth: Any, camera: Any) -> Any:
    R_WC, eye = camera
    f = 0.5 * HEIGHT / np.tan(np.radians(FOV) / 2)
    i, j = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2, np.arange(HEIGHT) + 0.5 - HEIGHT / 2)
    return eye + (np.stack([i * depth / f, j * depth / f, depth], axis=-1).reshape(-1, 3) @ R_WC.T)


def samples_of(depth: Any, camera: Any) -> Any:
    R_WC, eye = camera
    told = ask("oracle_depth_samples", 1 + 7 * 5000, depth, WIDTH, HEIGHT, FOV, np.r_[R_WC.ravel(), eye], 5000)
    return told[1 : 1 + 7 * int(told[0])].reshape(-1, 7)


@pytest.fixture
def gicp() -> Any:
    if sys.version_info >= (3, 13):
        pytest.skip("small_gicp's wheel is named as for every CPython from 3.12 on, and loads on 3.12 alone")
    return importlib.import_module("small_gicp")


def cloud_of(small_gicp: Any, points: Any, neighbours: int) -> Any:
    cloud = small_gicp.PointCloud(points)
    tree = small_gicp.KdTree(cloud)
    small_gicp.estimate_normals(cloud, tree, neighbours)
    return cloud, tree


def degrees_between(a: Any, b: Any) -> Any:
    return np.degrees(np.arccos(np.clip(np.abs(np.sum(a * b, axis=1)), 0, 1)))


def off(X_WK: Any, true: Any) -> Any:
    """Of the canvas's centre [m], and in turning [rad]."""
    (R, p), (R_true, p_true) = X_WK, true
    shift = np.linalg.norm(R @ CENTRE + p - R_true @ CENTRE - p_true)
    return shift, np.arccos(np.clip((np.trace(R @ R_true.T) - 1) / 2, -1, 1))


STANDING = (np.eye(3), np.zeros(3))


@pytest.mark.parametrize("seed", range(3))
def test_normals(seed: int, gicp: Any) -> None:
    rng = np.random.default_rng(seed)
    camera = look_at(CENTRE + [0.25, 0.1, 0.5])
    for sigma in (0.0, 1e-3):
        depth = depth_image(camera, STANDING, rng, sigma)
        samples = samples_of(depth, camera)
        assert len(samples) > 500
        _, zx, zy = height(samples[:, 0], samples[:, 1])
        true = np.column_stack([-zx, -zy, np.ones(len(zx))])
        true /= np.linalg.norm(true, axis=1, keepdims=True)
        cloud, tree = cloud_of(gicp, points_of(depth, camera), 81)  # as many pixels as a window has
        nearest = [tree.nearest_neighbor_search(p)[1] for p in samples[:, :3]]
        theirs = np.asarray(cloud.normals())[nearest, :3]
        ours = samples[:, 3:6]
        assert np.all(np.sum(ours * true, axis=1) > 0)
        assert np.median(degrees_between(ours, theirs)) < (1.0 if sigma == 0 else 3.0)
        assert np.median(degrees_between(ours, true)) <= np.median(degrees_between(theirs, true)) + 0.1


@pytest.mark.parametrize("seed", range(5))
def test_pose(seed: int, gicp: Any) -> None:
    rng = np.random.default_rng(seed)
    R = turn(rng.normal(size=3), 0.02)
    X_WK = (R, CENTRE - R @ CENTRE + 4e-3 * rng.uniform(-1, 1, 3))
    before, after = look_at(CENTRE + [0.25, 0.1, 0.5]), look_at(CENTRE + [-0.2, 0.2, 0.5])
    first = depth_image(before, STANDING, rng, 5e-4)
    later = depth_image(after, X_WK, rng, 5e-4)
    model, samples = samples_of(first, before), samples_of(later, after)
    told = ask("oracle_registration", 14, model, len(model), samples, len(samples))
    assert told[12:].tolist() == [1, 0]
    ours = off((told[:9].reshape(3, 3), told[9:12]), X_WK)

    target, tree = cloud_of(gicp, points_of(first, before), 40)
    source, _ = cloud_of(gicp, points_of(later, after), 40)
    result = gicp.align(target, source, tree, registration_type="PLANE_ICP", max_correspondence_distance=0.02)
    X_KW = np.asarray(result.T_target_source)
    R_theirs = X_KW[:3, :3].T
    theirs = off((R_theirs, -R_theirs @ X_KW[:3, 3]), X_WK)

    assert result.converged
    assert ours[0] < 3e-4 and ours[1] < 1.5e-3, (seed, ours, theirs)
    assert ours[0] < theirs[0] + 1e-4 and ours[1] < theirs[1] + 5e-4, (seed, ours, theirs)
