"""Pose of a camera, from views of a board and the arm's pose at each.

In view k the camera C sees the board B at X_CB_k = A⁻¹ G_k B, with the two unknowns A and B:

=============  =============  ======  =======  ========
camera         board          A       G_k      B
=============  =============  ======  =======  ========
fixed          on the tool    X_WC    X_WE_k   X_EB
on the tool    fixed          X_EC    X_EW_k   X_WB
fixed          fixed          X_WC    1        X_WB
=============  =============  ======  =======  ========

Poses are 4 × 4 matrices, X_AB maps points of B to A; lengths are in metres, angles in radians.

The start is in closed form (Shah, "Solving the robot-world/hand-eye calibration problem using the Kronecker
product", J. Mechanisms Robotics 5, 2013). Then the sum over all corners of squared residuals of pixels, depths and
touches, each divided by its standard deviation, is minimised over A and B. The covariance is (JᵀJ)⁻¹, times the
sum's mean square where that is above one.
"""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

DEPTH_SIGMA = 1e-3  # [m]
TOUCH_SIGMA = 5e-4  # of a corner touched by the pen [m]
PIXEL_SIGMA = 0.2  # of a detected corner [px]
LEAST_TURN = np.radians(5.0)  # two poses that differ by less tell almost the same
LEAST_SPREAD = np.radians(10.0)  # rotations about a second axis have this RMS at the least
MOST_OFF = 1e-3  # standard deviation at the board with which one can draw [m]
MOST_PIXELS = 1.5  # RMS of the corners' residuals [px]
MOST_STRETCH = 0.01  # of measured depths against those of the board's size


class Refused(Exception):
    """A result that is not good enough to draw with."""


@dataclasses.dataclass
class View:
    """One image of the board."""

    name: str
    X_WE: np.ndarray  # (4, 4); the identity where the arm holds neither camera nor board
    points: np.ndarray  # corners in B, (n, 3) [m]
    pixels: np.ndarray  # where the camera sees them, (n, 2) [px]
    K: np.ndarray  # (3, 3) [px]
    distortion: np.ndarray  # OpenCV's coefficients
    depths: np.ndarray | None = None  # along z_C, NaN where there is none, (n,) [m]
    depth_sigma: float = DEPTH_SIGMA  # [m]


@dataclasses.dataclass
class Calibration:
    A: np.ndarray  # X_WC, or X_EC of a camera on the tool, (4, 4)
    B: np.ndarray  # X_EB, or X_WB of a board that is fixed, (4, 4)
    covariance: np.ndarray  # of A's (rotation in C [rad], position in W or E [m]), (6, 6)
    pixel_rms: float
    depth_rms: float  # [m]; NaN without depths
    touch_rms: float  # [m]; NaN without touches
    at_canvas: float  # standard deviation of a point at the board's distance [m]
    distance: float  # median, of the board from the camera [m]
    focal: float  # [px]
    left_out: list[str]  # views that do not fit the others, with the reason
    alike: list[tuple[str, str]]  # views whose poses hardly differ


def pose(R: np.ndarray, p: np.ndarray) -> np.ndarray:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, np.ravel(p)
    return X


def inverse(X: np.ndarray) -> np.ndarray:
    return pose(X[:3, :3].T, -X[:3, :3].T @ X[:3, 3])


def quaternion_wxyz(X: np.ndarray) -> list[float]:
    return np.roll(Rotation.from_matrix(X[:3, :3]).as_quat(), 1).tolist()


def board_pose(view: View) -> np.ndarray:
    """X_CB from one view alone."""
    ok, rotation, p = cv2.solvePnP(view.points, view.pixels, view.K, view.distortion)
    if not ok:
        raise Refused(f"{view.name}: the board's pose cannot be told from its {len(view.points)} corners")
    return pose(cv2.Rodrigues(rotation)[0], p)


def _nearest_rotation(M: np.ndarray) -> np.ndarray:
    U, _, V = np.linalg.svd(M)
    return U @ np.diag([1.0, 1.0, np.linalg.det(U @ V)]) @ V


def closed_form(G: list[np.ndarray], X_CB: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """A and B with A X_CB_k = G_k B for all k, in the sense of least squares."""
    # R_A X = G R_B for rotations: Σ R_G ⊗ R_X has vec(R_B), vec(R_A) as its first singular vectors.
    T = sum(np.kron(g[:3, :3], x[:3, :3]) for g, x in zip(G, X_CB))
    U, _, V = np.linalg.svd(T)
    rotations = []
    for M in (U[:, 0].reshape(3, 3), V[0].reshape(3, 3)):
        rotations.append(_nearest_rotation(np.sign(np.linalg.det(M)) * M))
    R_A, R_B = rotations
    # p_A - R_G p_B = p_G - R_A p_X
    left = np.vstack([np.hstack([np.eye(3), -g[:3, :3]]) for g in G])
    right = np.hstack([g[:3, 3] - R_A @ x[:3, 3] for g, x in zip(G, X_CB)])
    p, *_ = np.linalg.lstsq(left, right, rcond=None)
    return pose(R_A, p[:3]), pose(R_B, p[3:])


def second_spread(G: list[np.ndarray]) -> float:
    """RMS of the rotations between views about the axis about which they turn second most [rad]. With rotations
    about one axis alone, the position along it stays open."""
    turns = np.array([Rotation.from_matrix(a[:3, :3].T @ b[:3, :3]).as_rotvec() for i, a in enumerate(G) for b in G[:i]])
    return float(np.sqrt(max(0.0, np.linalg.eigvalsh(turns.T @ turns / len(turns))[1])))


def _moved(X: np.ndarray, change: np.ndarray) -> np.ndarray:
    return pose(X[:3, :3] @ Rotation.from_rotvec(change[:3]).as_matrix(), X[:3, 3] + change[3:])


@dataclasses.dataclass
class _Problem:
    views: list[View]
    G: list[np.ndarray]
    pixel_sigma: float
    touches: tuple[np.ndarray, np.ndarray] | None  # corners in B and where the pen touched them in W, (m, 3) each

    def parts(self, A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals of pixels (Σn, 2), of depths [m] and of touches [m]."""
        pixels, depths = [], []
        for view, g in zip(self.views, self.G):
            X_CB = inverse(A) @ g @ B
            seen, _ = cv2.projectPoints(view.points, cv2.Rodrigues(X_CB[:3, :3])[0], X_CB[:3, 3], view.K, view.distortion)
            pixels.append(seen.reshape(-1, 2) - view.pixels)
            if view.depths is not None:
                z = view.points @ X_CB[2, :3] + X_CB[2, 3]
                depths.append((z - view.depths)[np.isfinite(view.depths)])
        touched = np.zeros(0)
        if self.touches is not None:
            corners, points = self.touches
            touched = (corners @ B[:3, :3].T + B[:3, 3] - points).ravel()
        return np.vstack(pixels), np.hstack(depths) if depths else np.zeros(0), touched

    def residuals(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        pixels, depths, touched = self.parts(A, B)
        sigmas = [np.full(np.isfinite(v.depths).sum(), v.depth_sigma) for v in self.views if v.depths is not None]
        return np.hstack([pixels.ravel() / self.pixel_sigma, depths / np.hstack(sigmas) if sigmas else depths,
                          touched / TOUCH_SIGMA])  # fmt: skip


def check_depths(views: list[View]) -> None:
    """Compares measured depths with those that the board's size tells."""
    ratios = [v.depths / (v.points @ X[2, :3] + X[2, 3]) for v in views if v.depths is not None for X in [board_pose(v)]]
    if ratios and abs(stretch := float(np.nanmedian(np.hstack(ratios))) - 1.0) > MOST_STRETCH:
        raise Refused(f"measured depths are {1.0 + stretch:.3f} times those that the board's size tells, and at most {MOST_STRETCH:.0%} off is"
                      " allowed: check depth_scale, the size of a square, and that depth is aligned to the image")  # fmt: skip


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x)))) if x.size else float("nan")


def _refined(problem: _Problem, A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and A's covariance. A wrong corner or depth counts by its distance alone."""
    found = least_squares(lambda x: problem.residuals(_moved(A, x[:6]), _moved(B, x[6:])), np.zeros(12),
                          loss="soft_l1", f_scale=3.0, x_scale="jac")  # fmt: skip
    A, B = _moved(A, found.x[:6]), _moved(B, found.x[6:])
    scatter = max(1.0, _rms(problem.residuals(A, B)) ** 2)
    return A, B, scatter * np.linalg.pinv(found.jac.T @ found.jac)[:6, :6]


def _start(problem: _Problem, X_CB: list[np.ndarray], fixed: bool) -> tuple[np.ndarray, np.ndarray]:
    if not fixed:
        return closed_form(problem.G, X_CB)
    if problem.touches is None or len(problem.touches[0]) < 3:
        raise Refused("where the arm holds neither camera nor board, at least three corners must be touched by the pen")
    corners, points = problem.touches
    spread = np.linalg.svd(corners - corners.mean(0), compute_uv=False)
    if spread[1] < 0.02:
        raise Refused("the touched corners lie on one line; valid are corners that span the board")
    R, *_ = Rotation.align_vectors(points - points.mean(0), corners - corners.mean(0))
    X_WB = pose(R.as_matrix(), points.mean(0) - R.as_matrix() @ corners.mean(0))
    return X_WB @ inverse(X_CB[0]), X_WB


def calibrate(
    views: list[View], camera: str, board: str, touches: tuple[np.ndarray, np.ndarray] | None = None,
    pixel_sigma: float = PIXEL_SIGMA,
) -> Calibration:  # fmt: skip
    """camera: "fixed" or "tool"; board: "tool" or "fixed". Raises Refused, which says what would help."""
    if camera == board == "tool":
        raise Refused("camera and board are both on the tool: their motions tell nothing")
    fixed = camera == board == "fixed"
    if touches is not None and board == "tool":
        raise Refused("the pen cannot touch a board that is on the tool")
    if len(views) < (1 if fixed else 3):
        raise Refused(f"{len(views)} views show the board; at least 3 are needed, and 10 to 20 are good")

    def g_of(view: View) -> np.ndarray:
        return np.eye(4) if fixed else view.X_WE if camera == "fixed" else inverse(view.X_WE)

    alike = []
    if not fixed:
        G = [g_of(v) for v in views]
        if (spread := second_spread(G)) < LEAST_SPREAD:
            raise Refused(
                f"the poses turn about one axis: about the second they differ by {np.degrees(spread):.1f}° RMS, and at least"
                f" {np.degrees(LEAST_SPREAD):.0f}° are needed; tilt the tool to other sides, too")  # fmt: skip
        alike = [(views[j].name, views[i].name) for i in range(len(views)) for j in range(i)
                 if Rotation.from_matrix(G[i][:3, :3].T @ G[j][:3, :3]).magnitude() < LEAST_TURN]  # fmt: skip

    check_depths(views)
    left_out: list[str] = []
    while True:
        problem = _Problem(views, [g_of(v) for v in views], pixel_sigma, touches)
        A, B, covariance = _refined(problem, *_start(problem, [board_pose(v) for v in views], fixed))
        each = [_rms(_Problem([v], [g], pixel_sigma, None).parts(A, B)[0]) for v, g in zip(views, problem.G)]
        worst, limit = int(np.argmax(each)), 4.0 * float(np.median(each))
        if each[worst] < max(limit, 3.0 * pixel_sigma) or len(views) <= max(3, 2 * len(left_out) + 2):
            break
        left_out.append(f"{views[worst].name}: {each[worst]:.1f} px off, where the median is {np.median(each):.1f} px")
        views = views[:worst] + views[worst + 1 :]

    pixels, depths, touched = problem.parts(A, B)
    p_C = np.array([(inverse(A) @ g @ B @ np.append(v.points.mean(0), 1.0))[:3] for v, g in zip(views, problem.G)])
    # A point p in C lies at R (p + θ × p) + p_A, and np.cross(1, p) is [p]×.
    furthest = p_C[np.argmax(np.linalg.norm(p_C, axis=1))]
    J = np.hstack([-A[:3, :3] @ np.cross(np.eye(3), furthest), np.eye(3)])
    at_canvas = float(np.sqrt(np.linalg.eigvalsh(J @ covariance @ J.T)[-1]))
    result = Calibration(A, B, covariance, _rms(np.linalg.norm(pixels, axis=1)), _rms(depths), _rms(touched),
                         at_canvas, float(np.median(p_C[:, 2])), float(views[0].K[0, 0]), left_out, alike)  # fmt: skip
    faults = [what for bad, what in (
        (result.pixel_rms > MOST_PIXELS, f"corners are {result.pixel_rms:.1f} px off, at most {MOST_PIXELS} are allowed: check the"
         " camera's intrinsics, the board's size, and that arm and image were read at rest"),
        (result.at_canvas > MOST_OFF, f"a point at the board is known to ± {1e3 * result.at_canvas:.1f} mm, at most"
         f" {1e3 * MOST_OFF:.0f} are allowed: more views, turned about more axes, are needed"),
    ) if bad]  # fmt: skip
    if faults:
        raise Refused("; ".join(faults))
    return result
