"""The rig under a foreign simulator's arm in the force benchmark: what src/judge/force_rig.h orders, at each time."""
import json
import math
import os
import pathlib

import numpy

SHAPES = "bowl", "flat", "roof"
FALL, HALF = math.radians(10.0), 0.18  # of the roof's sides; of the sheets [m] (src/judge/force_case.h)


class Rig:
    def __init__(self, file):
        self.file = pathlib.Path(file)
        self.stamp, self.order, self.began = None, None, 0.0
        self.readings = []  # run, time since its first torque [s], force along the true normal [N]

    def look(self, t):
        """After a command that answers the state at `t`: whether it begins a run."""
        try:
            stamp = os.stat(self.file).st_mtime_ns
        except FileNotFoundError:
            return False
        if stamp == self.stamp:
            return False
        self.stamp, self.order, self.began = stamp, json.loads(self.file.read_text()), t
        for name in ("poses", "stiffness", "hand"):
            self.order[name] = numpy.array(self.order[name])
        return True

    def _at(self, name, t, before):
        values = self.order[name] if self.order else ()
        if not len(values):
            return None
        i = round((t - self.began - self.order["start"]) / self.order["period"])
        return before if i < 0 else values[min(i, len(values) - 1)]

    @property
    def shape(self):
        return self.order["shape"] if self.order else "bowl"

    def pose(self, t):
        """Position, quaternion (w first) of the piece's frame, which is W while it stands."""
        at = self._at("poses", t, None)
        return numpy.array([0.0, 0, 0, 1, 0, 0, 0]) if at is None else at

    def velocity(self, t, dt):
        """Angular and linear, of the frame's origin: those that lead to the next step's pose."""
        a, b = self.pose(t), self.pose(t + dt)
        (w, x, y, z), (W, X, Y, Z) = a[3:], b[3:]
        turn = numpy.array([w * X - x * W - y * Z + z * Y, w * Y - y * W - z * X + x * Z, w * Z - z * W - x * Y + y * X])  # b a*
        return 2.0 * turn / dt, (b[:3] - a[:3]) / dt

    def stiffness(self, t):
        return self._at("stiffness", t, self.order["stiffness"][0] if self.order and len(self.order["stiffness"]) else None)

    def hand(self, t):
        at = self._at("hand", t, None)
        return numpy.zeros(3) if at is None else at

    def read(self, t, force):
        if self.order:
            self.readings.append((self.order["run"], t - self.began, force))

    def write(self, file):
        """The sensor's file."""
        partial = pathlib.Path(file).with_suffix(".part")
        partial.write_text("run,time,force\n" + "".join(f"{run},{t:.3f},{force:.6g}\n" for run, t, force in self.readings))
        partial.rename(file)
