"""Writes motions of a canvas that a person holds, or that a machine moves in steps, for canvas.motion.file.

    python3 setup/hand_motions.py hand --seed 1 --out /tmp/hand-1.csv
    ./impedraw draw scenarios/moving.yaml --set canvas.motion.file=/tmp/hand-1.csv --set canvas.motion.ramp=2

Noise of a seed, on each axis of its own:

    x(t) = Σ_k a_k cos(2π f_k t + θ_k),   f_k = k / 120 s up to 25 Hz,   θ_k uniform in 0 … 2π
    a_k² ∝ S(f_k),   Σ a_k² / 2 = RMS²

with S = 1 up to a corner and (corner / f)^fall above it. tremor adds a sine of amplitude √2 · 0.15 mm on each axis, of
seeded phase. conveyor and bumps repeat minimum-jerk moves, each after a seeded pause.
"""
import argparse
import pathlib

import numpy as np

RATE, DURATION = 60.0, 120.0  # [Hz], [s]
FASTEST = 25.0                # [Hz]
CENTRE = np.array([0.6, 0.0, 0.1])  # about which hands turn [m]
SHARP = np.inf
# RMS of each axis [m] and [deg], corner [Hz], fall of the power, tremor's RMS [m] and rate [Hz]
NOISES = {
    "hand": (10e-3, 0.0, 0.5, 4.0, 0.0, 9.0),
    "hand-turning": (5e-3, 0.5, 0.5, 4.0, 0.0, 9.0),
    "hand-tremor": (10e-3, 0.0, 0.5, 4.0, 0.15e-3, 9.0),
    "hand-turning-tremor": (5e-3, 0.5, 0.5, 4.0, 0.15e-3, 9.0),
    "hand-cut": (10e-3, 0.0, 0.5, 4.0, 0.0, 9.0),
    "jolts-2Hz": (5e-3, 0.0, 2.0, SHARP, 0.0, 9.0),
}
KINDS = [*NOISES, "conveyor", "bumps"]


def noise(random, t, rms, corner, fall, fastest=FASTEST):
    f = np.arange(1, int(fastest * DURATION) + 1) / DURATION
    power = np.where(f <= corner, 1.0, (corner / f) ** fall)
    a = rms * np.sqrt(2.0 * power / power.sum())
    return (a[:, None] * np.cos(2.0 * np.pi * np.outer(f, t) + random.uniform(0.0, 2.0 * np.pi, (len(f), 1)))).sum(axis=0)


def moves(random, t, way, move, rest, back):
    """Minimum-jerk moves by `way`, each followed by a rest of 0.9 to 1.1 times `rest`; `back`: there and back within one."""
    x, start, done = np.zeros_like(t), random.uniform(0.0, rest), 0.0
    while start < t[-1]:
        u = np.clip((t - start) / move, 0.0, 1.0)
        if back:
            u = 1.0 - np.abs(2.0 * u - 1.0)
        x += way * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
        start += move + rest * random.uniform(0.9, 1.1)
        if not back:
            done += way
            if abs(done) > 0.1:
                way = -way
    return x


def motion(kind, seed):
    """t [s], positions [m], rotation vectors [rad]."""
    random, t = np.random.default_rng(seed), np.arange(0.0, DURATION, 1.0 / RATE)
    p, phi = np.zeros((3, len(t))), np.zeros((3, len(t)))
    if kind in NOISES:
        rms, turn, corner, fall, tremor, rate = NOISES[kind]
        fastest = 1.0 if kind == "hand-cut" else FASTEST
        for i in range(3):
            p[i] = noise(random, t, rms, corner, fall, fastest)
            phi[i] = noise(random, t, np.radians(turn), corner, fall, fastest)
            p[i] += np.sqrt(2.0) * tremor * np.cos(2.0 * np.pi * (rate * t + random.uniform()))
    elif kind == "conveyor":
        p[1] = moves(random, t, -0.04, 0.6, 0.9, False)
    else:
        p[2] = moves(random, t, 6e-3, 0.3, 1.2, True)
    return t, p.T, phi.T


def quaternion(phi):
    angle = np.linalg.norm(phi)
    return np.array([np.cos(0.5 * angle), *(0.5 * np.sinc(0.5 * angle / np.pi) * phi)])


def rows(kind, seed):
    t, p, phi = motion(kind, seed)
    lines = ["t,x,y,z,qw,qx,qy,qz"]
    for time, x, turn in zip(t, p, phi):
        lines.append(",".join(f"{value:.9g}" for value in (time, *(CENTRE + x), *quaternion(turn))))
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    arguments.out.write_text(rows(arguments.kind, arguments.seed))
