"""Drake's hydroelastic contact of a pad's foam: the numbers that tests/simulation/pad_contact_test.cc compares with.

    python pad.py     in the venv of requirements.txt

The foam is a compliant half-space, whose pressure is modulus × depth / slab: a bed of springs. A rigid disc, tilted and pressed into
it, and a rigid ball stand for the pad on a plane and for the canvas under a wide pad. Drake tessellates them and integrates the
pressure over the surface of contact; it shares no code and no formula with us.
"""
import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticPropertiesForHalfSpace, AddContactMaterial, AddRigidHydroelasticProperties, Cylinder, FramePoseVector, GeometryFrame,
    GeometryInstance, HalfSpace, HydroelasticContactRepresentation, ProximityProperties, SceneGraph, Sphere,
)  # fmt: skip
from pydrake.math import RigidTransform, RotationMatrix

STIFFNESS, SLAB, RADIUS = 2e6, 0.01, 0.015  # [N/m³], [m], [m]


def load(shape, resolution, pose):
    """Force along z and moment about the pose's origin [N, Nm], of the foam on the shape."""
    scene = SceneGraph()
    source = scene.RegisterSource("pad")
    foam = ProximityProperties()
    AddCompliantHydroelasticPropertiesForHalfSpace(SLAB, STIFFNESS * SLAB, foam)
    AddContactMaterial(properties=foam)
    ground = GeometryInstance(RigidTransform(), HalfSpace(), "foam")
    ground.set_proximity_properties(foam)
    scene.RegisterAnchoredGeometry(source, ground)
    frame = scene.RegisterFrame(source, GeometryFrame("rigid"))
    rigid = ProximityProperties()
    AddRigidHydroelasticProperties(resolution, rigid)
    AddContactMaterial(properties=rigid)
    body = GeometryInstance(RigidTransform([0, 0, 0.5 * shape.length() if isinstance(shape, Cylinder) else shape.radius()]), shape, "rigid")
    body.set_proximity_properties(rigid)
    rigid_id = scene.RegisterGeometry(source, frame, body)
    context = scene.CreateDefaultContext()
    poses = FramePoseVector()
    poses.set_value(frame, pose)
    scene.get_source_pose_port(source).FixValue(context, poses)
    query = scene.get_query_output_port().Eval(context)
    force, moment = np.zeros(3), np.zeros(3)
    for surface in query.ComputeContactSurfaces(HydroelasticContactRepresentation.kTriangle):
        mesh = surface.tri_mesh_W()
        # Normals point from N into M: out of the rigid body they push it along themselves, else against.
        sign = 1.0 if surface.id_M() == rigid_id else -1.0
        for t in range(mesh.num_triangles()):
            corners = np.array([mesh.vertex(mesh.triangles()[t].vertex(i)) for i in range(3)])
            p = np.array([surface.tri_e_MN().EvaluateAtVertex(mesh.triangles()[t].vertex(i)) for i in range(3)])
            normal = mesh.face_normal(t)
            if isinstance(shape, Cylinder) and abs(normal @ pose.rotation().matrix()[:, 2]) < 0.5:
                continue  # its wall, which no foam touches on a pad
            for i in range(3):  # the middles of the edges: exact for a moment, of second order in the place
                f = 0.5 * (p[i] + p[i - 1]) * mesh.area(t) / 3.0 * sign * normal
                force += f
                moment += np.cross(0.5 * (corners[i] + corners[i - 1]) - pose.translation(), f)
    return force[2], moment


def main():
    print("shape,depth_m,angle_rad,force_N,moment_Nm")
    for depth in (1e-3, 2e-3, 3.5e-3):
        for angle in (0.0, 0.02, 0.05, 0.2):
            f, m = load(Cylinder(RADIUS, 0.01), 1e-3, RigidTransform(RotationMatrix.MakeXRotation(angle), [0, 0, -depth]))
            print(f"disc,{depth},{angle},{f:.5f},{abs(m[0]):.6f}")
        for radius in (0.02, 0.05):
            f, _ = load(Sphere(radius), 1e-3 * radius / 0.02, RigidTransform([0, 0, -depth]))
            if radius * depth * 2 < RADIUS**2:
                print(f"ball {radius},{depth},0.0,{f:.5f},0.0")


main()
