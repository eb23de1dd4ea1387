"""The floor of the forces in this simulator: an ideal slider of 3 kg with impedraw's tip ball, pressed on with 5 N along the sphere's normal
and moved at 50 mm/s along a line, without an arm. What its force varies by is MuJoCo's contact alone.

Usage: slider.py TARGET.npy    (points of the line [m], on the bowl)
"""
import json
import os
import sys

os.environ["MUJOCO_GL"] = "disable"
import mujoco  # noqa: E402
import numpy  # noqa: E402

import scene  # noqa: E402

MASS, PUSH, SPEED, BANDWIDTH = 3.0, 5.0, 0.05, 30.0  # [kg], [N], [m/s], [rad/s] of the tangential tracking; as Drake's slider
SETTLE, JUDGED = 0.5, 0.7  # [s]


def normal(p):
    n = scene.BOWL_CENTRE - p
    return n / numpy.linalg.norm(n)


def slide(line):
    radius = scene.CONTACT["ball_radius"]
    begin = line[0] + (radius - 1e-4) * normal(line[0])
    joints = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option integrator="implicitfast" cone="elliptic" gravity="0 0 0"/><worldbody>'
        '<geom name="bowl" type="plane" size="1 1 0.1" pos="0.6 0 0.1" axisangle="1 0 0 0.1" contype="0" conaffinity="0"/>'
        f'<body pos="{scene.text(begin)}">{joints}<inertial pos="0 0 0" mass="{MASS}" diaginertia="0.003 0.003 0.003"/>'
        f'<geom name="tip" type="sphere" size="{radius}" contype="0" conaffinity="0"/></body>'
        f"</worldbody><contact>{scene.pair_xml()}</contact></mujoco>"
    )
    model.opt.timestep = 1e-3  # franka-sim's
    data = mujoco.MjData(model)
    tip, bowl = (mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name) for name in ("tip", "bowl"))
    length = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(line, axis=0), axis=1))])

    def at(s):
        return numpy.array([numpy.interp(s, length, line[:, i]) for i in range(3)])

    forces = []
    for k in range(int((SETTLE + length[-1] / SPEED) / model.opt.timestep)):
        t = k * model.opt.timestep
        s = max(0.0, t - SETTLE) * SPEED
        velocity = (at(s + 1e-3) - at(s)) / 1e-3 * SPEED if t > SETTLE else numpy.zeros(3)
        p, v = begin + data.qpos, data.qvel
        n = normal(p)
        track = MASS * (BANDWIDTH**2 * (at(s) + radius * n - p) + 2 * BANDWIDTH * (velocity - v))
        track -= n * (n @ track)
        # The path's own bend along the normal: on the sphere the slider must be turned, which takes m v²/R.
        bend = MASS * (v @ v) / scene.BOWL_RADIUS * n
        damping = -2 * BANDWIDTH * MASS * n * (n @ v)  # along the normal, where the contact alone is a spring
        data.qfrc_applied[:] = track - PUSH * n + bend + damping
        mujoco.mj_kinematics(model, data)
        scene.follow_bowl(model, data, tip, bowl)
        mujoco.mj_step(model, data)
        force, *_ = scene.contact_on_tip(model, data, tip)
        if t > JUDGED:
            forces.append(abs(force @ n))
    f = numpy.array(forces)
    return {
        "contact_fraction": float((f > 0.1).mean()),
        "force_mean": float(f.mean()),
        "force_median": float(numpy.median(f)),
        "force_sd": float(f.std()),
    }


if __name__ == "__main__":
    print(json.dumps(slide(numpy.load(sys.argv[1])), indent=2))
