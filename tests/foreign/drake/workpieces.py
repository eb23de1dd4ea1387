"""The force benchmark's workpieces for Drake: bodies that are moved as a rig is told (../rig.py), with the hand and the spring."""
import math
import pathlib
import sys

import numpy
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Mesh, ProximityProperties, RoleAssign
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import DistanceConstraintParams
from pydrake.multibody.tree import JacobianWrtVariable, PrismaticJoint, SpatialInertia, UnitInertia

import scene

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import rig  # noqa: E402

MIDDLE = scene.BOWL_CENTRE - [0, 0, scene.BOWL_RADIUS]
AWAY = {shape: RigidTransform([0, 0, -10.0 - i]) for i, shape in enumerate(rig.SHAPES)}  # rigid bodies must not touch
TABLE_MASS, PLATE_MASS = 100.0, 0.05  # [kg]: a table is driven, so that its mass only has to be large
OWN_STIFFNESS, HARD_BALL = 2.7e4, 2e6  # of the ball at 5 N, and of one on a plate with a spring, which then is the softer one [N/m]


class Workpieces(rig.Rig):
    def __init__(self, file, plant, folder, properties):
        super().__init__(file)
        self.bodies = {}
        for shape in rig.SHAPES:
            model = plant.AddModelInstance(shape)
            inertia = SpatialInertia(TABLE_MASS, numpy.zeros(3), UnitInertia.SolidBox(1, 1, 1))
            self.bodies[shape] = plant.AddRigidBody(shape, model, inertia)
            plant.set_gravity_enabled(model, False)
        on = RigidTransform(), Mesh(str(scene.bowl_obj(f"{folder}/bowl.obj")), 1.0)
        plant.RegisterCollisionGeometry(self.bodies["bowl"], *on, "bowl", properties)
        plant.RegisterCollisionGeometry(self.bodies["roof"], RigidTransform(), Mesh(str(roof_obj(f"{folder}/roof.obj")), 1.0), "roof", properties)
        # A plate on the table: locked, or on a spring.
        model = self.bodies["flat"].model_instance()
        plate = plant.AddRigidBody("plate", model, SpatialInertia(PLATE_MASS, numpy.zeros(3), UnitInertia.SolidBox(0.36, 0.36, 0.02)))
        self.slide = plant.AddJoint(PrismaticJoint("slide", self.bodies["flat"].body_frame(), plate.body_frame(), [0, 0, 1]))
        plant.RegisterCollisionGeometry(plate, RigidTransform(MIDDLE - [0, 0, 0.01]), Box(0.36, 0.36, 0.02), "flat", properties)
        self.spring = plant.AddDistanceConstraint(self.bodies["flat"], [0, 0, -1], plate, [0, 0, 0], 1.0, 1e6, 0.0)

    def begin(self, diagram, context, plant, graph, arm):
        self.diagram, self.context, self.plant, self.graph, self.arm = diagram, context, plant, graph, arm
        self.plant_context = plant.GetMyMutableContextFromRoot(context)
        self.graph_context = graph.GetMyMutableContextFromRoot(context)
        self.slide.Lock(self.plant_context)
        (self.ball,) = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("pen"))
        self.tip = plant.GetFrameByName("tip")
        self.soft = None

    def set_ball(self):
        """For the run that begins: the ball's own stiffness, or a hard one."""
        soft = self.stiffness(self.began) is not None
        if soft == self.soft:
            return
        self.soft = soft
        properties = ProximityProperties(self.graph.model_inspector().GetProximityProperties(self.ball))
        modulus = scene.CONTACT["rig_modulus"] * ((HARD_BALL / OWN_STIFFNESS) ** 2 if soft else 1.0)  # F ~ E d^2
        properties.UpdateProperty("hydroelastic", "hydroelastic_modulus", modulus)
        self.graph.AssignRole(self.graph_context, self.plant.get_source_id(), self.ball, properties, RoleAssign.kReplace)
        if soft:
            self.slide.Unlock(self.plant_context)
        else:
            self.slide.set_translation(self.plant_context, 0.0)
            self.slide.set_translation_rate(self.plant_context, 0.0)
            self.slide.Lock(self.plant_context)

    def placed(self, t):
        at = self.pose(t)
        return RigidTransform(Quaternion(at[3:] / numpy.linalg.norm(at[3:])), at[:3])

    def apply(self, t):
        """Moves the pieces over the next step, and lets the hand push."""
        step = scene.CONTACT["plant_step"]
        for shape, body in self.bodies.items():
            used = shape == self.shape
            self.plant.SetFreeBodyPose(self.plant_context, body, self.placed(t) if used else AWAY[shape])
            w, v = self.velocity(t, step) if used else (numpy.zeros(3), numpy.zeros(3))
            self.plant.SetFreeBodySpatialVelocity(self.plant_context, body, SpatialVelocity(w, v))
        stiffness = self.stiffness(t)
        if stiffness is not None:
            k = stiffness / (1.0 - stiffness / HARD_BALL)
            ends = self.bodies["flat"].index(), [0, 0, -1], self.plant.GetBodyByName("plate").index(), [0, 0, 0]
            spring = DistanceConstraintParams(*ends, 1.0, k, 10.0 * math.sqrt(k / 2e4))
            self.plant.SetDistanceConstraintParams(self.plant_context, self.spring, spring)
        tau = numpy.zeros(self.plant.num_velocities())
        hand = self.hand(t)
        if hand.any():
            J = self.plant.CalcJacobianTranslationalVelocity(
                self.plant_context, JacobianWrtVariable.kV, self.tip, numpy.zeros(3), self.plant.world_frame(), self.plant.world_frame())
            tau = J.T @ hand
        self.diagram.GetInputPort("all_joints").FixValue(self.context, tau)
        self.diagram.GetInputPort("shove").FixValue(self.context, self.plant.GetVelocitiesFromArray(self.arm, tau))

    def along(self, t, force, point):
        """The contact force along the piece's normal."""
        if not force.any():
            return 0.0
        if self.shape == "bowl":
            n = (scene.BOWL_CENTRE - point) / numpy.linalg.norm(scene.BOWL_CENTRE - point)
        else:
            n = numpy.array([0.0, 0, 1])
            if self.shape == "roof":
                side = numpy.clip((point[0] - MIDDLE[0]) / 1e-4, -1, 1) * rig.FALL
                n = numpy.array([math.sin(side), 0, math.cos(side)])
            n = self.placed(t).rotation().matrix() @ n
        return float(n @ force)


def roof_obj(out):
    """Two sheets that meet at an edge along y."""
    slope = math.tan(rig.FALL)
    vertices = [MIDDLE + [x, y, -slope * abs(x)] for x in (-rig.HALF, 0, rig.HALF) for y in (-rig.HALF, rig.HALF)]
    return scene.write_obj(out, numpy.array(vertices), [f for i in (0, 2) for f in ((i, i + 2, i + 3), (i, i + 3, i + 1))])
