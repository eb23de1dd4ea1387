"""5. A residual policy in 40 lines: a linear map from observations to offsets of the controller, tuned by random search.

Run: python 5_residual_policy.py [iterations]   (needs: pip install gymnasium)
"""

import sys

import gymnasium
import numpy as np

import impedraw.gym  # noqa: F401  registers impedraw/Draw-v0

iterations = int(sys.argv[1]) if len(sys.argv) > 1 else 3
env = gymnasium.make("impedraw/Draw-v0", length=(0.03, 0.04))
shape = (4, 20)


def episode(policy: np.ndarray, seed: int) -> float:
    """The sum of rewards with offsets tanh(policy · observation)."""
    seen, _ = env.reset(seed=seed)
    total, done = 0.0, False
    while not done:
        seen, reward, terminated, truncated, _ = env.step(np.tanh(policy @ seen).astype(np.float32))
        total, done = total + float(reward), terminated or truncated
    return total


rng = np.random.default_rng(0)
best = np.zeros(shape)  # the controller alone
score = episode(best, seed=0)
print(f"the controller alone: {score:.4f}")
for i in range(iterations):
    tried = best + rng.normal(0, 0.02, shape)
    reached = episode(tried, seed=0)
    if reached > score:
        best, score = tried, reached
    print(f"{i + 1}: {reached:.4f}, best {score:.4f}")
assert score > 5
