"""Figures of a drawing on a bowl that moves, judged in the bowl's frame by code that shares nothing with the program's: where the pen touched follows from
the logged poses of tip and bowl and from the bowl's formula, not from the program's contact point."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/foreign"))
from judge import distance_to_line  # noqa: E402

PROGRAM = pathlib.Path(os.environ.get("IMPEDRAW_PROGRAM", ROOT / "build/release/src/app/impedraw"))
CENTRE, RADIUS, TIP = numpy.array([0.60, 0.0, 0.40]), 0.30, 1e-3  # of the bowl and of the pen's ball [m]
INK, SETTLING = 0.1, 0.2  # [N], [s]


def matrices(quaternions):
    """Rotation matrices of quaternions w x y z."""
    w, x, y, z = (quaternions / numpy.linalg.norm(quaternions, axis=1)[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return numpy.moveaxis(numpy.array(rows), 2, 0)


def judge(log, pose="/canvas/pose"):
    time, stroke = log["/time"][:], log["/stroke"][:]
    tip, R_WE = log["/tip/position"][:], matrices(log["/tip/orientation"][:])
    R_WK, p_WK = matrices(log[pose][:, 3:]), log[pose][:, :3]
    ball = tip - TIP * R_WE[:, :, 2]
    ball_K = numpy.einsum("nji,nj->ni", R_WK, ball - p_WK)
    normal_K = (CENTRE - ball_K) / numpy.linalg.norm(CENTRE - ball_K, axis=1)[:, None]
    point_K = CENTRE - RADIUS * normal_K
    force_K = numpy.einsum("nji,nj->ni", R_WK, log["/contact/force"][:])
    f = numpy.einsum("ni,ni->n", force_K, normal_K)
    axis_K = numpy.einsum("nji,nj->ni", R_WK, -R_WE[:, :, 2])
    tilt = numpy.degrees(numpy.arccos(numpy.clip((axis_K * normal_K).sum(axis=1), -1.0, 1.0)))
    ink, down = f > INK, stroke >= 0
    error, settled, touchdown = [], [], 0.0
    for s in numpy.unique(stroke[down]):
        own = numpy.nonzero(stroke == s)[0]
        line = log["/target/points"][:][log["/target/stroke"][:] == s]
        error.append(distance_to_line(point_K[own][ink[own]], line))
        before = numpy.nonzero((stroke[: own[0]] >= 0) | (time[: own[0]] < time[own[0]] - 2.0))[0]
        begin = before[-1] + 1 if len(before) else 0
        touch = begin + numpy.nonzero(ink[begin:])[0][0]
        touchdown = max(touchdown, f[(time >= time[touch]) & (time <= time[touch] + SETTLING)].max())
        late = own[ink[own] & (time[own] > time[touch] + SETTLING)]
        settled.append(f[late])
    error, settled = 1e3 * numpy.concatenate(error), numpy.concatenate(settled)
    return {
        "contact_fraction": (down & ink).sum() / down.sum(),
        "ink_error_rms": numpy.sqrt((error**2).mean()),
        "ink_error_max": error.max(),
        "force_mean": settled.mean(),
        "force_sd": settled.std(),
        "touchdown_peak": touchdown,
        "tilt_mean": tilt[down & ink].mean(),
    }


class MovingBowl(unittest.TestCase):
    def test_figures_in_the_canvas_frame(self):
        # The mesh is of flat triangles of 1.5 mm: 1 µm from the sphere.
        tolerances = {
            "contact_fraction": 1e-4,
            "ink_error_rms": 1e-3,
            "ink_error_max": 4e-3,
            "force_mean": 5e-3,
            "force_sd": 5e-3,
            "touchdown_peak": 2e-2,
            "tilt_mean": 0.05,
        }
        with tempfile.TemporaryDirectory() as folder:
            for name in ("moving-sway",):
                out = pathlib.Path(folder) / name
                subprocess.run([PROGRAM, "draw", ROOT / f"scenarios/{name}.yaml", "--out", out], check=True, cwd=ROOT, capture_output=True)
                metrics = json.loads((out / "metrics.json").read_text())
                with h5py.File(out / "run.h5") as log:
                    found, still = judge(log), judge(log, "/canvas/estimated_pose")
                for key, tolerance in tolerances.items():
                    self.assertAlmostEqual(found[key], metrics[key], delta=tolerance, msg=f"{name}: {key}")
                # It can fail: by the estimated pose, which the program does not judge by, the ink lies elsewhere.
                self.assertGreater(abs(still["ink_error_rms"] - metrics["ink_error_rms"]), 2e-3, name)


if __name__ == "__main__":
    unittest.main()
