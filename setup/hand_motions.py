"""Writes motions of a canvas that a person holds, or that a machine moves by steps, for canvas.motion.file.

    python setup/hand_motions.py FOLDER              hand-1.csv, hand-2.csv … : each kind from six seeds
    python setup/hand_motions.py FOLDER hand 7       hand-7.csv alone
    ./impedraw draw scenarios/moving.yaml --set canvas.motion.ramp=2 --set canvas.motion.file=FOLDER/hand-7.csv

Noise on each axis, and about it, of its own:

    x(t) = Σ_k a_k cos(2π f_k t + θ_k),    f_k = k / 60 s up to 25 Hz,    θ_k uniform in 0 … 2π by the seed
    a_k² ∝ S(f_k),    Σ_k a_k² / 2 = RMS² / 3,    S = 1 up to the corner f_c, and (f_c / f)^4 or 0 above it

RMS is of the length of all three axes together; of jolts, of each. A tremor adds √2 · 0.15 mm · sin(2π 9 Hz t + θ) on each axis.
The conveyor's and the bumps' moves have the least jerk, and rests of 0.9 to 1.1 times their mean.
"""
import pathlib
import sys

import numpy as np

RATE, DURATION, FASTEST = 60.0, 60.0, 25.0  # [Hz], [s], [Hz]
CENTRE = np.array([0.6, 0.0, 0.1])  # about which hands turn [m]
# Of each axis: RMS [m], turn [deg]; corner [Hz], fall of the power, tremor [m].
NOISES = {
    "hand": (10e-3 / np.sqrt(3.0), 0.0, 0.5, 4.0, 0.0),
    "hand-tremor": (10e-3 / np.sqrt(3.0), 0.0, 0.5, 4.0, 0.15e-3),
    "turning-hand": (5e-3 / np.sqrt(3.0), 0.5 / np.sqrt(3.0), 0.5, 4.0, 0.0),
    "turning-hand-tremor": (5e-3 / np.sqrt(3.0), 0.5 / np.sqrt(3.0), 0.5, 4.0, 0.15e-3),
    "jolts-2Hz": (5e-3, 0.0, 2.0, np.inf, 0.0),
}
# Axis, way [m], its time and the rest after it [s], and back within that time.
MOVES = {"indexing": (1, -0.04, 0.6, 0.9, False), "bumps": (2, 6e-3, 0.3, 1.2, True), "hits": (2, 0.08, 1.0, 1.5, True)}
KINDS = [*NOISES, *MOVES]


def noise(random, t, rms, corner, fall):
    f = np.arange(1, int(FASTEST * DURATION) + 1) / DURATION
    power = np.where(f <= corner, 1.0, (corner / f) ** fall)
    a, phase = rms * np.sqrt(2.0 * power / power.sum()), random.uniform(0.0, 2.0 * np.pi, len(f))
    return np.cos(2.0 * np.pi * np.outer(t, f) + phase) @ a


def moves(random, t, way, move, rest, back):
    """A bump and a hit, at up to 0.3 m/s, go there and back within their time; a conveyor turns round after three steps."""
    x, start, steps = np.zeros_like(t), random.uniform(0.0, rest), 0
    while start < t[-1]:
        u = np.clip((t - start) / move, 0.0, 1.0)
        u = 1.0 - np.abs(2.0 * u - 1.0) if back else u
        x += way * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
        start += move + rest * random.uniform(0.9, 1.1)
        steps += 1
        way = -way if not back and steps % 3 == 0 else way
    return x


def motion(kind, seed):
    """t [s], positions [m], rotation vectors [rad]."""
    random, t = np.random.default_rng(seed), np.arange(0.0, DURATION, 1.0 / RATE)
    p, phi = np.zeros((len(t), 3)), np.zeros((len(t), 3))
    if kind in MOVES:
        axis, *move = MOVES[kind]
        p[:, axis] = moves(random, t, *move)
        return t, p, phi
    rms, turn, corner, fall, tremor = NOISES[kind]
    for i in range(3):
        p[:, i] = noise(random, t, rms, corner, fall)
        p[:, i] += np.sqrt(2.0) * tremor * np.sin(2.0 * np.pi * (9.0 * t + random.uniform()))
        phi[:, i] = noise(random, t, np.radians(turn), corner, fall)
    return t, p, phi


def write(folder, kind, seed):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    t, p, phi = motion(kind, seed)
    half = 0.5 * np.linalg.norm(phi, axis=1)
    turn = 0.5 * np.sinc(half / np.pi)[:, None] * phi
    rows = np.column_stack([t, CENTRE + p, np.cos(half), turn])
    header = f"# setup/hand_motions.py {kind} {seed}\nt,x,y,z,qw,qx,qy,qz"
    np.savetxt(folder / f"{kind}-{seed}.csv", rows, fmt="%.8g", delimiter=",", header=header, comments="")


def write_all(folder):
    for kind in KINDS:
        for seed in range(1, 7):
            write(folder, kind, seed)


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[2] in KINDS:
        write(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    elif len(sys.argv) == 2:
        write_all(sys.argv[1])
    else:
        sys.exit(f"usage: python setup/hand_motions.py FOLDER [KIND SEED]; kinds are {', '.join(KINDS)}")
