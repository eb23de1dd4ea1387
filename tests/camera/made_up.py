"""Views of a board by a camera whose pose is known."""

import numpy as np
from scipy.spatial.transform import Rotation

from impedraw.camera.hand_eye import View, inverse, pose

K = np.array([[604.0, 0.0, 321.7], [0.0, 603.0, 238.2], [0.0, 0.0, 1.0]])
DISTORTION = np.array([0.02, -0.05, 0.0003, -0.0002, 0.01])
CORNERS = np.array([[0.03 * x, 0.03 * y, 0.0] for y in range(5) for x in range(7)]) - [0.09, 0.06, 0.0]


def looking_at(eye, target, roll=0.0):
    """Pose of a camera at eye: z towards the target."""
    z = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return pose(np.column_stack([x, np.cross(z, x), z]) @ Rotation.from_euler("z", roll).as_matrix(), eye)


def seen(rng, X_CB, X_WE, name, pixel_sigma=0.2, depth_sigma=1e-3):
    """A pinhole camera with OpenCV's distortion, written out."""
    p = CORNERS @ X_CB[:3, :3].T + X_CB[:3, 3]
    x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
    k1, k2, p1, p2, k3 = DISTORTION
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    pixels = np.column_stack([
        K[0, 0] * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + K[0, 2],
        K[1, 1] * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + K[1, 2]])  # fmt: skip
    pixels += pixel_sigma * rng.standard_normal(pixels.shape)
    return View(name, X_WE, CORNERS, pixels, K, DISTORTION, p[:, 2] + depth_sigma * rng.standard_normal(len(p)), depth_sigma)


def about(rng, degrees):
    return Rotation.from_rotvec(np.radians(degrees) * rng.uniform(-1, 1, 3)).as_matrix()


def eye_to_hand(rng, count, one_axis=False, **noise):
    """X_WC, X_EB and views: the board on the tool, half a metre before a camera that is fixed."""
    X_WC = looking_at(rng.uniform(-0.05, 0.05, 3) + [1.3, 0.2, 0.7], [0.6, 0.0, 0.35])
    X_EB = pose(about(rng, 20), rng.uniform(-0.03, 0.03, 3))
    views = []
    for k in range(count):
        turn = Rotation.from_euler("z", 0.12 * (k - count / 2)).as_matrix() if one_axis else about(rng, 35)
        X_CB = pose(np.diag([1.0, -1.0, -1.0]) @ turn, rng.uniform(-0.12, 0.12, 3) + [0.0, 0.0, 0.7])
        views.append(seen(rng, X_CB, X_WC @ X_CB @ inverse(X_EB), f"view {k + 1}", **noise))
    return X_WC, X_EB, views


def eye_in_hand(rng, count, **noise):
    """X_EC, X_WB and views: the board on the table, the camera on the tool."""
    X_EC = pose(about(rng, 10), [0.0, 0.06, -0.05])
    X_WB = pose(about(rng, 5), [0.55, 0.05, 0.02])
    views = []
    for k in range(count):
        X_CB = pose(np.diag([1.0, -1.0, -1.0]) @ about(rng, 35), rng.uniform(-0.1, 0.1, 3) + [0.0, 0.0, 0.5])
        views.append(seen(rng, X_CB, X_WB @ inverse(X_CB) @ inverse(X_EC), f"view {k + 1}", **noise))
    return X_EC, X_WB, views


def difference(X, Y):
    """Metres and degrees between two poses."""
    return np.linalg.norm(X[:3, 3] - Y[:3, 3]), np.degrees(Rotation.from_matrix(X[:3, :3].T @ Y[:3, :3]).magnitude())
