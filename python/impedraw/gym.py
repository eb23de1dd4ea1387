"""A Gymnasium environment: ``gymnasium.make("impedraw/Draw-v0")`` after ``import impedraw.gym``.

A simulated arm draws a straight line on a canvas that its controller knows from a noisy cloud alone.
The action offsets what the impedance controller is asked for; all zero is the controller as it is.

Observation, float32, shape (20,), clipped to ±10:
    0–2    desired tip − tip, W                        [cm]
    3–5    velocity of the tip, W                      [0.1 m/s]
    6–8    velocity of the desired tip, W              [0.1 m/s]
    9–11   estimated normal of the surface, W
    12     distance of the tip from it                 [cm]
    13     normal force felt by the wrench sensor      [10 N]
    14     normal force asked for                      [10 N]
    15–18  contact: approach, contact, lift, retreat   0 or 1
    19     share of the path's time
Action, float32, shape (4,), −1 to 1:
    0      stiffness along the surface × 2**a
    1      normal force + 2 a                          [N]
    2, 3   desired tip + 1 a along W's x and y         [mm]
Reward of a step, while the plan has the pen down on its stroke (weights: the arguments):
    coverage · newly covered share of the line
    − ink · distance of the ink from the line [mm]
    − force · |f − F_n| / F_n
and −1 where the run fails, which ends the episode.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from . import _impedraw as core
from .canvases import Bowl, CanvasShape

Array = NDArray[np.float64]

_POSTURE = np.array([0.0, 0.55, 0.0, -1.45, 0.0, 1.15, 0.0])
_INK = 0.1  # least force that leaves ink [N]


def _reach(arm: core.ArmModel, q: Array, p_W: Array, n_W: Array) -> Array:
    """Posture with the tip at p_W and the pen along −n_W, near q: damped Gauss–Newton steps."""
    q = q.copy()
    for _ in range(100):
        t = arm.compute(q, np.zeros_like(q))
        turn = np.cross(t.X_WE.R[:, 2], -n_W)
        error = np.r_[p_W - t.X_WE.p, turn]
        if np.linalg.norm(error) < 1e-9:
            break
        J = t.J
        q += J.T @ np.linalg.solve(J @ J.T + 1e-8 * np.eye(6), error)
    return q


class DrawEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """See the module. The same seed gives the same episode, bit for bit."""

    metadata = {"render_modes": []}

    def __init__(
        self,
        canvas: CanvasShape | None = None,
        *,
        control_steps: int = 10,
        length: tuple[float, float] = (0.03, 0.08),
        noise: float = 0.0003,
        normal_force: float = 5.0,
        coverage: float = 10.0,
        ink: float = 0.05,
        force: float = 0.02,
    ) -> None:
        """control_steps: of 1 ms in a step. length: of the line, least and most [m]. noise: of the
        cloud's points [m]. normal_force: F_n [N]. Raises ValueError for a value out of range."""
        if control_steps < 1:
            raise ValueError(f"control_steps is {control_steps}; valid is 1 or more")
        if not 0 < length[0] <= length[1] <= 0.15:
            raise ValueError(f"length is {length}; valid is least and most, above 0 to 0.15 m")
        if not 0 <= noise <= 0.01:
            raise ValueError(f"noise is {noise}; valid is 0 to 0.01 m")
        if not 3 <= normal_force <= 40:
            raise ValueError(f"normal_force is {normal_force}; valid is 3 to 40 N")
        self.observation_space = gymnasium.spaces.Box(-10.0, 10.0, (20,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)
        self._steps, self._length, self._noise = control_steps, length, noise
        self._force, self._weights = normal_force, (coverage, ink, force)
        self._canvas = (canvas or Bowl()).canvas()
        self._arm = core.ArmModel.standard()
        self._world = core.World(self._arm.urdf, self._canvas)
        limits = self._arm.limits
        self._settings = core.ImpedanceSettings(
            normal_force=normal_force,
            joint_range=core.JointRangeSettings(lower=limits.lower, upper=limits.upper),
            limits=core.LimitSettings(torque=limits.torque),
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        super().reset(seed=seed)
        rng = self.np_random
        centre = np.array([0.6, 0.0]) + rng.uniform(-0.03, 0.03, 2)
        heading, half = rng.uniform(0, 2 * np.pi), rng.uniform(*self._length) / 2
        along = np.array([np.cos(heading), np.sin(heading)])
        self._line = np.array([centre - half * along, centre + half * along])
        self._estimator = self._look(centre, half + 0.04, rng)
        start = self._surface_at(self._line[0])
        n = np.asarray(start.n_W)
        p = np.asarray(start.p_W) + 0.02 * n
        q = _reach(self._arm, _POSTURE, p, n)
        self._world.set_state(q)
        self._settings.null_space.q_0 = q
        self._controller = core.ImpedanceController(self._settings, self._arm)
        terms = self._arm.compute(q, np.zeros_like(q))
        self._path = core.plan_tip_path(
            [self._line],
            self._estimator,
            core.PathSettings(start_p_WE=terms.X_WE.p, start_n_W=-terms.X_WE.R[:, 2], safe_height=0.015),
        )
        self._time = 0.0
        self._F_ext = np.zeros(6)
        self._out: core.ImpedanceTorque | None = None
        self._covered = np.zeros(max(1, int(np.ceil(2 * half / 5e-4))), dtype=bool)
        self._errors: list[float] = []
        self._observe()
        return self._observation(), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        a = np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0)
        if a.shape != (4,) or not np.isfinite(a).all():
            raise ValueError(f"action is {action!r}; valid are 4 finite numbers")
        K = self._settings.stiffness
        stiffness = core.TipGain(
            linear=core.AxialGain(tangent=K.linear.tangent * 2.0 ** a[0], normal=K.linear.normal),
            angular=K.angular,
        )
        asked = self._force + 2.0 * a[1]
        self._controller.retune(stiffness, asked)
        offset = np.array([1e-3 * a[2], 1e-3 * a[3], 0.0])
        reward = 0.0
        failed = False
        for _ in range(self._steps):
            reward += self._control_step(offset)
            assert self._out is not None
            status = self._out.status
            failed = (
                self._world.failure is not None
                or self._world.touching_link != ""
                or status.bad_input
                or not np.isfinite(self._world.state.v).all()
            )
            if failed:
                reward -= 1.0
                break
        done = failed or self._time >= self._path.duration
        return self._observation(), float(reward), done, False, {**self._info(), "failed": failed}

    # The controller's view of the world at this instant.
    def _observe(self) -> None:
        state = self._world.state
        self._terms = self._arm.compute(state.q, state.v)
        self._reference = self._path.at(self._time)
        self._surface = self._estimator.estimate(self._terms.X_WE.p)

    def _control_step(self, offset: Array) -> float:
        self._observe()
        reference = self._reference.reference
        if reference.pen_down:
            reference.p_WD = reference.p_WD + offset
        out = self._controller.step(self._terms, reference, self._surface, self._F_ext)
        self._out = out
        contact = self._world.step(out.tau)
        f_W = np.asarray(contact.f_W)
        arm_of_force = np.asarray(contact.p_WC) - np.asarray(self._terms.X_WE.p)
        self._F_ext = np.r_[f_W, np.cross(arm_of_force, f_W)] if contact.touching else np.zeros(6)
        self._time += self._settings.timing.dt
        if self._reference.stroke < 0:
            return 0.0
        return self._ink(contact)

    def _ink(self, contact: core.TipContact) -> float:
        coverage, ink, force = self._weights
        f = float(np.dot(contact.f_W, contact.n_W)) if contact.touching else 0.0
        reward = -force * abs(f - self._force) / self._force
        if f <= _INK:
            return reward
        way = self._line[1] - self._line[0]
        length = float(np.linalg.norm(way))
        u = way / length
        d = np.asarray(contact.p_WC)[:2] - self._line[0]
        s = float(d @ u)
        off = abs(float(u[0] * d[1] - u[1] * d[0]))
        error = 1e3 * float(np.hypot(off, max(0.0, -s, s - length)))
        self._errors.append(error)
        reward -= ink * error
        if error <= 0.5:
            first = int(np.clip((s - 5e-4) / length * len(self._covered), 0, len(self._covered) - 1))
            last = int(np.clip((s + 5e-4) / length * len(self._covered), 0, len(self._covered) - 1))
            before = int(self._covered.sum())
            self._covered[first : last + 1] = True
            reward += coverage * (int(self._covered.sum()) - before) / len(self._covered)
        return reward

    def _look(self, centre: Array, radius: float, rng: np.random.Generator) -> core.SurfaceEstimator:
        """A cloud as a camera above would see it: points of a grid, with noise along the view."""
        grid = np.arange(-radius, radius, 0.003)
        points = []
        for x in centre[0] + grid:
            for y in centre[1] + grid:
                points.append(self._surface_at(np.array([x, y])).p_W)
        cloud = np.array(points)
        cloud[:, 2] += rng.normal(0.0, 1.0, len(cloud)) * self._noise
        return core.SurfaceEstimator(cloud, [centre[0], centre[1], 1.5])

    def _surface_at(self, xy: Array) -> core.SurfacePoint:
        """The canvas above (x, y), seen along z: secant steps on the closest point."""
        p = np.array([xy[0], xy[1], 0.2])
        for _ in range(20):
            point = self._canvas.closest(p)
            n = np.asarray(point.n_W)
            if abs(point.distance) < 1e-9 or n[2] < 0.05:
                break
            p = p - np.array([0.0, 0.0, float((p - np.asarray(point.p_W)) @ n) / n[2]])
        return self._canvas.closest(p)

    def _observation(self) -> NDArray[np.float32]:
        self._observe()
        t, r, s = self._terms, self._reference.reference, self._surface
        ok = s.status == core.SurfaceStatus.ok
        n = np.asarray(s.n_W) if ok else np.asarray(r.n_WD)
        modes = core.ContactMode.approach, core.ContactMode.contact, core.ContactMode.lift, core.ContactMode.retreat
        values = [
            *(100.0 * (np.asarray(r.p_WD) - np.asarray(t.X_WE.p))),
            *(10.0 * np.asarray(t.V_WE)[:3]),
            *(10.0 * np.asarray(r.v_WD)),
            *n,
            100.0 * s.distance if ok else 10.0,
            0.1 * float(self._F_ext[:3] @ n),
            0.1 * self._force,
            *(float(self._out is not None and self._out.mode == mode) for mode in modes),
            min(1.0, self._time / self._path.duration),
        ]
        seen: NDArray[np.float32] = np.clip(np.nan_to_num(np.array(values)), -10.0, 10.0).astype(np.float32)
        return seen

    def _info(self) -> dict[str, Any]:
        """coverage: share of the line; ink_error_rms [mm]; time [s]."""
        rms = float(np.sqrt(np.mean(np.square(self._errors)))) if self._errors else 0.0
        return {"coverage": float(self._covered.mean()), "ink_error_rms": rms, "time": self._time}


if "impedraw/Draw-v0" not in gymnasium.registry:
    gymnasium.register("impedraw/Draw-v0", "impedraw.gym:DrawEnv", max_episode_steps=2000)
