"""Judges a drawing from the foreign simulator's own log: contact results and poses of its simulate.py's file. impedraw's log gives only what was planned: the
strokes' times and the target.

Usage: judge.py SIMULATION.npz RUN_FOLDER [--json]
Terms as in docs/metrics.md; contact point and force are the simulator's, the normal is the canvas's in closed form. Where the program
knew the canvas by its eyes alone, the target that it logged lies on what it saw: it is put onto the true one, along the drawing axis z.
"""
import json
import pathlib
import sys

import h5py
import numpy

BOWL_CENTRE, BOWL_RADIUS = numpy.array([0.60, 0.0, 0.40]), 0.30
WAVE_CENTRE, WAVE_AMPLITUDE, WAVE_NUMBER = numpy.array([0.60, 0.0, 0.10]), 0.015, 2 * numpy.pi / 0.20
SPEED = numpy.radians([85, 85, 100, 75, 130, 135, 135])  # the iiwa 14's limits [rad/s]
INK, SETTLING = 0.1, 0.2  # [N], [s]


def bowl(p):
    """Height over W's x and y, and the normal there, of each point."""
    across = p[:, :2] - BOWL_CENTRE[:2]
    down = numpy.sqrt(BOWL_RADIUS**2 - (across**2).sum(1))
    normal = BOWL_CENTRE - p
    return BOWL_CENTRE[2] - down, normal / numpy.linalg.norm(normal, axis=1)[:, None]


def wave(p):
    phase = WAVE_NUMBER * (p[:, 0] - WAVE_CENTRE[0])
    normal = numpy.stack([-WAVE_AMPLITUDE * WAVE_NUMBER * numpy.cos(phase), 0 * phase, 1 + 0 * phase], 1)
    return WAVE_CENTRE[2] + WAVE_AMPLITUDE * numpy.sin(phase), normal / numpy.linalg.norm(normal, axis=1)[:, None]


def distance_to_line(points, line):
    """Of each point to a polyline [m]."""
    best = numpy.full(len(points), numpy.inf)
    for a, b in zip(line[:-1], line[1:]):
        d = b - a
        s = numpy.clip((points - a) @ d / max(d @ d, 1e-18), 0.0, 1.0)
        best = numpy.minimum(best, numpy.linalg.norm(points - a - s[:, None] * d, axis=1))
    return best


def shifts(time, q, sim):
    """Of the simulator's clock to the run's, for each row: by the joint positions, which the states carry bit by bit. After a fault that
    the arm recovered from, the run's clock goes on where it stopped. Postures that occur more than once count as those before."""
    where = {}
    for i, posture in enumerate(sim["q"]):
        where.setdefault(posture.astype(q.dtype).tobytes(), []).append(i)
    shift = numpy.full(len(time), numpy.nan)
    for i, posture in enumerate(q):
        found = where.get(posture.tobytes(), ())
        if len(found) == 1:
            shift[i] = sim["time"][found[0]] - time[i]
    known = numpy.nonzero(~numpy.isnan(shift))[0]
    assert len(known) > 0.5 * len(time), f"{len(known)} of {len(time)} rows have joint positions that the simulator had"
    before = numpy.maximum.accumulate(numpy.where(numpy.isnan(shift), 0, numpy.arange(len(shift))))
    before[: known[0]] = known[0]
    return shift[before]


def covered(target, ink, within=5e-4):
    """Share of a line's length, every half millimetre of it, that has ink near."""
    length = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(target, axis=0), axis=1))])
    points = numpy.stack([numpy.interp(numpy.arange(0, length[-1], 5e-4), length, target[:, i]) for i in range(3)], axis=1)
    return [len(ink) > 0 and distance_to_line(p[None], ink)[0] < within for p in points]


def judge(simulation, folder, canvas=bowl, seen=False):
    sim = numpy.load(simulation)
    with h5py.File(pathlib.Path(folder) / "run.h5") as log:
        time, stroke, q = log["/time"][:], log["/stroke"][:], log["/joint/position"][:]
        scale = log["/time_scale"][:]
        target, of = log["/target/points"][:], log["/target/stroke"][:]
    if seen:
        target[:, 2] = canvas(target)[0]
    shift = shifts(time, q, sim)
    # Drake's contact is that of the step that ended, MuJoCo's that of the step that begins.
    at = numpy.rint(1e3 * (time + shift)).astype(int) + int(sim.get("contact_offset", 1))
    kept = at < len(sim["time"])
    time, stroke, scale, at = time[kept], stroke[kept], scale[kept], at[kept]
    point = sim["point"][at]
    normal = canvas(point)[1]
    f = numpy.nan_to_num(numpy.einsum("ij,ij->i", sim["force"][at], normal))
    ink, runs = f > INK, scale >= 0.2
    down = stroke >= 0
    error, settled, touchdown, has_ink = [], [], 0.0, []
    for s in numpy.unique(stroke[down]):
        own = stroke == s
        drawn = own & ink & runs
        if drawn.any():
            error.append(distance_to_line(point[drawn], target[of == s]))
        if seen:
            has_ink += covered(target[of == s], point[drawn][::5])
        # The first touch may come before the stroke's own first step.
        begin = numpy.nonzero(own)[0][0]
        before = numpy.nonzero((stroke[:begin] >= 0) | (time[:begin] < time[begin] - 2.0))[0]
        first = numpy.nonzero(ink[(before[-1] + 1 if len(before) else 0) :])[0]
        if not len(first):
            continue
        touch = (before[-1] + 1 if len(before) else 0) + first[0]
        touchdown = max(touchdown, f[(time >= time[touch]) & (time <= time[touch] + SETTLING)].max())
        settled.append(f[drawn & (time > time[touch] + SETTLING)])
    error, settled = 1e3 * numpy.concatenate(error or [[numpy.nan]]), numpy.concatenate(settled or [[numpy.nan]])
    spectrum = numpy.abs(numpy.fft.rfft(settled - settled.mean())) if len(settled) > 100 else numpy.zeros(2)
    more = {}
    if seen:
        more["coverage"] = float(numpy.mean(has_ink))
        cosine = -numpy.einsum("ij,ij->i", sim["pen"][at], normal)[down & ink & runs]
        more["tilt_mean"] = float(numpy.degrees(numpy.arccos(numpy.clip(cosine, -1, 1))).mean())
    return {
        **more,
        "contact_fraction": float((down & ink & runs).sum() / (down & runs).sum()),
        "ink_error_rms": float(numpy.sqrt((error**2).mean())),
        "ink_error_max": float(error.max()),
        "force_mean": float(settled.mean()),
        "force_median": float(numpy.median(settled)),
        "force_sd": float(settled.std()),
        "force_loudest_hz": float(numpy.argmax(spectrum) * 1e3 / max(len(settled), 1)),
        "touchdown_peak": float(touchdown),
        "time_scale_mean": float(scale[down].mean()),
        # Of the first 10 ms of commands: without a bump, all that the ramp lets through of it.
        "start_torque": float(numpy.abs(sim["torque"][sim["began"]][:10]).max()),
        "joint_speed_share": float((numpy.abs(sim["v"]) / sim.get("speed_limit", SPEED)).max()),
        "statuses_sent": int(sim["sent"]),
        "statuses_answered": int(sim["answered"]),
        "left": bool(sim["left"]),
        "last_torque": float(numpy.abs(sim["last_torque"]).max()),
        "real_time_factor": float(sim["real_time_factor"]),
        "wait_median_ms": float(1e3 * numpy.median(sim["waits"])) if len(sim["waits"]) else None,
        "wait_p99_ms": float(1e3 * numpy.percentile(sim["waits"], 99)) if len(sim["waits"]) else None,
    }


if __name__ == "__main__":
    found = judge(sys.argv[1], sys.argv[2])
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
    else:
        for name, value in found.items():
            print(f"{name:20} {value if not isinstance(value, float) else format(value, '.4g')}")
