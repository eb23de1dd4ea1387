"""The floor of the forces in this simulator: an ideal slider of 3 kg with impedraw's tip ball, pressed on with 5 N along the sphere's normal
and moved at 50 mm/s along a line, without an arm. What its force varies by is Drake's contact alone.

Usage: slider.py TARGET.npy    (points of the line [m], on the bowl)
"""
import json
import sys
import tempfile

import numpy
from pydrake.geometry import AddCompliantHydroelasticProperties, AddContactMaterial, AddRigidHydroelasticProperties, Mesh, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import scene

MASS, PUSH, SPEED, BANDWIDTH = 3.0, 5.0, 0.05, 30.0  # [kg], [N], [m/s], [rad/s] of the tangential tracking


def slide(line):
    builder = DiagramBuilder()
    c = scene.CONTACT
    plant, _ = AddMultibodyPlant(
        MultibodyPlantConfig(
            time_step=c["plant_step"], contact_model=c["contact_model"], discrete_contact_approximation=c["approximation"]
        ),
        builder,
    )
    model = plant.AddModelInstance("slider")
    tiny = SpatialInertia(0.0, numpy.zeros(3), UnitInertia(1e-9, 1e-9, 1e-9))
    bodies = [plant.AddRigidBody(n, model, tiny) for n in "ab"]
    full = SpatialInertia(MASS, numpy.zeros(3), UnitInertia.SolidSphere(0.05))
    bodies.append(plant.AddRigidBody("c", model, full))
    parent = plant.world_frame()
    for axis, body in enumerate(bodies):
        joint = plant.AddJoint(PrismaticJoint(f"j{axis}", parent, body.body_frame(), numpy.eye(3)[axis]))
        plant.AddJointActuator(f"m{axis}", joint)
        parent = body.body_frame()
    plant.set_gravity_enabled(model, False)
    friction = CoulombFriction(c["friction"], c["friction"])
    soft, hard = ProximityProperties(), ProximityProperties()
    AddContactMaterial(dissipation=c["dissipation"], friction=friction, properties=soft)
    AddContactMaterial(dissipation=c["dissipation"], friction=friction, properties=hard)
    AddCompliantHydroelasticProperties(c["ball_resolution"], c["modulus"], soft)
    AddRigidHydroelasticProperties(c["bowl_edge"], hard)
    plant.RegisterCollisionGeometry(bodies[2], RigidTransform(), Sphere(c["ball_radius"]), "ball", soft)
    folder = tempfile.TemporaryDirectory()
    bowl = scene.bowl_obj(f"{folder.name}/bowl.obj")
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), Mesh(str(bowl), 1.0), "bowl", hard)
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    pc = plant.GetMyContextFromRoot(context)
    length = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(line, axis=0), axis=1))])

    def normal(p):
        return (scene.BOWL_CENTRE - p) / numpy.linalg.norm(scene.BOWL_CENTRE - p)

    plant.SetPositions(pc, line[0] + (c["ball_radius"] - 5e-4) * normal(line[0]))
    port = plant.get_actuation_input_port()
    results = plant.get_contact_results_output_port()
    forces, depths = [], []
    settle = 0.5
    steps = int((settle + length[-1] / SPEED) / c["plant_step"])
    simulator.Initialize()
    for k in range(steps):
        t = k * c["plant_step"]
        s = max(0.0, t - settle) * SPEED
        wanted = numpy.array([numpy.interp(s, length, line[:, i]) for i in range(3)])
        ahead = numpy.array([numpy.interp(s + 1e-3, length, line[:, i]) for i in range(3)])
        velocity = (ahead - wanted) / 1e-3 * SPEED if t > settle else numpy.zeros(3)
        p, v = plant.GetPositions(pc), plant.GetVelocities(pc)
        n = normal(p)
        track = MASS * (BANDWIDTH**2 * (wanted + c["ball_radius"] * n - p) + 2 * BANDWIDTH * (velocity - v))
        track -= n * (n @ track)
        # The path's own bend along the normal: on the sphere the slider must be turned, which takes m v²/R.
        bend = MASS * (v @ v) / scene.BOWL_RADIUS * n
        damping = -2 * BANDWIDTH * MASS * n * (n @ v)  # along the normal, where the contact alone is a spring
        port.FixValue(pc, track - PUSH * n + bend + damping)
        simulator.AdvanceTo((k + 1) * c["plant_step"])
        contact = results.Eval(pc)
        f = 0.0
        for i in range(contact.num_hydroelastic_contacts()):
            info = contact.hydroelastic_contact_info(i)
            F = info.F_Ac_W().translational()
            f += abs(F @ n)
        if t > settle + 0.2:
            forces.append(f)
            depths.append(c["ball_radius"] + numpy.linalg.norm(p - scene.BOWL_CENTRE) - scene.BOWL_RADIUS)
    f = numpy.array(forces)
    return {
        "contact_fraction": float((f > 0.1).mean()),
        "force_mean": float(f.mean()),
        "force_median": float(numpy.median(f)),
        "force_sd": float(f.std()),
        "depth_mm": float(1e3 * numpy.mean(depths)),
    }


if __name__ == "__main__":
    print(json.dumps(slide(numpy.load(sys.argv[1])), indent=2))
