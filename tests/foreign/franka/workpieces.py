"""The force benchmark's workpieces for MuJoCo: a table that is moved, a roof and the bowl, as a rig is told (../rig.py), with the hand."""
import math
import pathlib
import sys

import mujoco
import numpy

import scene

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import rig  # noqa: E402

AWAY = -10.0  # [m]
OWN_STIFFNESS = 2e4  # of the tip, by contact.toml [N/m]


def xml():
    """Assets, bodies and pairs of a table, which is driven, and a roof."""
    slope = rig.HALF * math.tan(rig.FALL)
    corners = [(x, y, -slope if x else 0) for x in (-rig.HALF, 0, rig.HALF) for y in (-rig.HALF, rig.HALF)]
    corners += [(x, y, -0.1) for x in (-rig.HALF, rig.HALF) for y in (-rig.HALF, rig.HALF)]
    middle = scene.BOWL_CENTRE - [0, 0, scene.BOWL_RADIUS]
    return (
        f'<asset><mesh name="roof" vertex="{" ".join(scene.text(c) for c in corners)}"/></asset>',
        '<body name="table" gravcomp="1"><freejoint name="table"/><inertial pos="0 0 0" mass="100" diaginertia="10 10 10"/>'
        f'<geom name="flat" type="box" size="{rig.HALF} {rig.HALF} 0.05" pos="{scene.text(middle - [0, 0, 0.05])}" contype="0" conaffinity="0"/></body>'
        f'<geom name="roof" type="mesh" mesh="roof" pos="{scene.text(middle)}" contype="0" conaffinity="0"/>',
        scene.pair_xml("flat") + scene.pair_xml("roof"),
    )


class Workpieces(rig.Rig):
    def begin(self, model, data):
        self.model, self.data = model, data
        names = {name: mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name) for name in (*rig.SHAPES, "tip")}
        self.geoms, self.roof_z = names, model.geom_pos[names["roof"]][2]
        table = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, "table")
        self.q, self.v = model.jnt_qposadr[table], model.jnt_dofadr[table]
        self.pen = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "pen")
        self.pair = next(i for i in range(model.npair) if names["flat"] in (model.pair_geom1[i], model.pair_geom2[i]))

    def apply(self, t, step):
        """Moves the pieces over the next step."""
        model, data = self.model, self.data
        if self.shape != "bowl":
            model.geom_pos[self.geoms["bowl"]][2] = AWAY
        model.geom_pos[self.geoms["roof"]][2] = self.roof_z if self.shape == "roof" else AWAY
        at, (w, v) = self.pose(t), self.velocity(t, step)
        if self.shape != "flat":
            at, w, v = numpy.array([0, 0, AWAY, 1.0, 0, 0, 0]), numpy.zeros(3), numpy.zeros(3)
        data.qpos[self.q : self.q + 7] = at
        turned = numpy.zeros(3)
        mujoco.mju_rotVecQuat(turned, w, at[3:] * [1, -1, -1, -1])  # a free joint's angular velocity is in its own frame
        data.qvel[self.v : self.v + 6] = numpy.concatenate([v, turned])
        stiffness = self.stiffness(t)
        share = 1.0 if stiffness is None else stiffness / OWN_STIFFNESS
        k, d = scene.CONTACT["solref"]
        model.pair_solref[self.pair] = k * share, d * math.sqrt(share)

    def push(self, t):
        """Adds the hand's force on the tip to what acts on the joints."""
        hand = self.hand(t)
        if hand.any():
            tip = self.data.site("tip").xpos
            mujoco.mj_applyFT(self.model, self.data, hand, numpy.zeros(3), tip, self.pen, self.data.qfrc_applied)
