"""impedraw/Draw-v0: Gymnasium's own checker, reproducibility, vectors of environments."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("gymnasium")
import impedraw.gym  # noqa: E402  registers the environment
from gymnasium.utils.env_checker import check_env  # noqa: E402


def episode(seed: int, steps: int, action_seed: int=5) -> Any:
    env = gymnasium.make("impedraw/Draw-v0")
    rng = np.random.default_rng(action_seed)
    trace, (seen, info) = [], env.reset(seed=seed)
    trace.append(seen)
    for _ in range(steps):
        seen, reward, terminated, truncated, info = env.step(rng.uniform(-1, 1, 4).astype(np.float32))
        trace += [seen, reward, terminated, info["coverage"], info["ink_error_rms"]]
        if terminated or truncated:
            seen, info = env.reset()
            trace.append(seen)
    return trace


def test_gymnasiums_checker_has_nothing_to_say() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("impedraw/Draw-v0").unwrapped, skip_render_check=True)


def test_1000_steps_are_bit_identical_for_a_seed() -> None:
    a, b, other = episode(11, 1000), episode(11, 1000), episode(12, 50)
    assert len(a) == len(b) and all(np.array_equal(x, y) for x, y in zip(a, b))
    assert not np.array_equal(a[0], other[0])


def test_the_controller_alone_draws_the_line() -> None:
    env = gymnasium.make("impedraw/Draw-v0")
    for seed in range(3):
        env.reset(seed=seed)
        total, done = 0.0, False
        while not done:
            _, reward, done, cut, info = env.step(np.zeros(4, np.float32))
            total += float(reward)
            assert not cut
        assert not info["failed"] and info["coverage"] == 1.0 and info["ink_error_rms"] < 0.2, info
        assert total > 5


def test_offsets_move_pen_and_force() -> None:
    """A reference offset moves the ink by as much; a force offset the force."""
    env = gymnasium.make("impedraw/Draw-v0").unwrapped
    assert isinstance(env, impedraw.gym.DrawEnv)
    forces = {}
    for a in (-1.0, 0.0, 1.0):
        env.reset(seed=4)
        felt, done = [], False
        while not done:
            seen, _, done, _, info = env.step(np.array([0, a, 0, 0], np.float32))
            if env._reference.stroke >= 0:
                felt.append(10 * seen[13])
        forces[a] = np.mean(felt[len(felt) // 2 :])
    assert forces[0.0] == pytest.approx(5, abs=0.4)
    assert forces[1.0] - forces[-1.0] == pytest.approx(4, abs=0.4)
    env.reset(seed=4)
    way = env._line[1] - env._line[0]
    across = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    done = False
    while not done:
        _, _, done, _, info = env.step(np.r_[0, 0, across / max(abs(across))].astype(np.float32))
    assert info["ink_error_rms"] == pytest.approx(1.0 / max(abs(across)), abs=0.2)


def test_vectors_are_as_single_ones() -> None:
    envs = gymnasium.make_vec("impedraw/Draw-v0", num_envs=2, vectorization_mode="sync")
    seen, _ = envs.reset(seed=[11, 12])  # type: ignore[arg-type]
    for i, seed in enumerate((11, 12)):
        alone, _ = gymnasium.make("impedraw/Draw-v0").reset(seed=seed)
        assert np.array_equal(seen[i], alone)
    seen, rewards, *_ = envs.step(np.zeros((2, 4), np.float32))
    assert seen.shape == (2, 20) and rewards.shape == (2,)


@pytest.mark.parametrize(
    "given, message",
    [({"control_steps": 0}, "control_steps is 0"), ({"length": (0.1, 0.05)}, "length is"), ({"noise": -1}, "noise is -1"), ({"normal_force": 99}, "normal_force is 99")],
)
def test_bad_arguments_are_refused(given: Any, message: Any) -> None:
    with pytest.raises(ValueError, match=message):
        impedraw.gym.DrawEnv(**given)


def test_bad_actions_are_refused() -> None:
    env = impedraw.gym.DrawEnv()
    env.reset(seed=0)
    for action in (np.full(4, np.nan, np.float32), np.zeros(3, np.float32)):
        with pytest.raises(ValueError, match="valid are 4 finite numbers"):
            env.step(action)
