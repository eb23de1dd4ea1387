"""The arm and what it draws on for Drake: files made from impedraw's own URDF and from the bowl's and the wave's parameters."""
import math
import pathlib
import xml.etree.ElementTree as ElementTree

import numpy
import yaml

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
CONTACT = yaml.safe_load((HERE / "contact.yaml").read_text())

# impedraw's standard bowl (canvas.cap in docs/settings.md): the lowest part of a sphere, drawn on from inside.
BOWL_RADIUS, BOWL_CENTRE, BOWL_OPENING = 0.30, numpy.array([0.60, 0.0, 0.40]), 0.18


# Its standard wave (canvas.wave).
WAVE_CENTRE, WAVE_SIDE, WAVE_AMPLITUDE, WAVE_LENGTH = numpy.array([0.60, 0.0, 0.10]), 0.36, 0.015, 0.20


def arm_urdf(out, mass_of_pen=1.0, rotor_inertia=0.0, seen=False, rig=False):
    """models/iiwa14_pen.urdf as Drake needs it: a motor on each joint, no bodies that collide but a compliant ball at the tip.
    `seen`: with the shapes that a camera sees. `rig`: with the ball of the force benchmark."""
    radius, modulus, resolution = (CONTACT["rig_" * rig + name] for name in ("ball_radius", "modulus", "ball_resolution"))
    tree = ElementTree.parse(ROOT / "models/iiwa14_pen.urdf")
    robot = tree.getroot()
    for link in robot.findall("link"):
        for kind in ("collision",) if seen else ("collision", "visual"):
            for element in link.findall(kind):
                link.remove(element)
    if mass_of_pen != 1.0:
        inertial = robot.find("link[@name='pen']/inertial")
        inertial.find("mass").set("value", str(mass_of_pen * float(inertial.find("mass").get("value"))))
        for key, value in inertial.find("inertia").attrib.items():
            inertial.find("inertia").set(key, str(mass_of_pen * float(value)))
    for joint in robot.findall("joint"):
        if joint.get("type") != "revolute":
            continue
        transmission = ElementTree.SubElement(robot, "transmission")
        ElementTree.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
        at = ElementTree.SubElement(transmission, "joint", name=joint.get("name"))
        ElementTree.SubElement(at, "hardwareInterface").text = "EffortJointInterface"
        motor = ElementTree.SubElement(transmission, "actuator", name="motor_" + joint.get("name"))
        if rotor_inertia:
            # Reflected at the joint: gear ratio 1.
            ElementTree.SubElement(motor, "drake:rotor_inertia", value=str(rotor_inertia))
            ElementTree.SubElement(motor, "drake:gear_ratio", value="1")
    robot.set("xmlns:drake", "https://drake.mit.edu/")
    pen = robot.find("link[@name='pen']")
    ball = ElementTree.SubElement(pen, "collision", name="tip_ball")
    ElementTree.SubElement(ball, "origin", xyz=f"0 0 {0.12 - radius}")
    ElementTree.SubElement(ElementTree.SubElement(ball, "geometry"), "sphere", radius=str(radius))
    properties = ElementTree.SubElement(ball, "drake:proximity_properties")
    ElementTree.SubElement(properties, "drake:compliant_hydroelastic")
    for name, value in (
        ("hydroelastic_modulus", modulus),
        ("mesh_resolution_hint", resolution),
        ("hunt_crossley_dissipation", CONTACT["dissipation"]),
        ("mu_dynamic", CONTACT["friction"]),
        ("mu_static", CONTACT["friction"]),
    ):
        ElementTree.SubElement(properties, f"drake:{name}", value=str(value))
    tree.write(out)
    return out


def bowl_obj(out):
    """The bowl as rings of triangles whose vertices lie on the sphere; normals to the sphere's centre."""
    edge, top = CONTACT["bowl_edge"], math.asin(BOWL_OPENING / BOWL_RADIUS)
    rings = math.ceil(BOWL_RADIUS * top / edge)
    points, faces, before = [(0.0, 0.0, -BOWL_RADIUS)], [], [0]
    for ring in range(1, rings + 1):
        angle = top * ring / rings
        radius = BOWL_RADIUS * math.sin(angle)
        count = 6 * ring
        now = list(range(len(points), len(points) + count))
        points += [
            (radius * math.cos(2 * math.pi * i / count), radius * math.sin(2 * math.pi * i / count), -BOWL_RADIUS * math.cos(angle))
            for i in range(count)
        ]
        # Between two rings: always the step whose vertex is further behind.
        i = j = 0
        inner, outer = len(before), count
        while i < (inner if inner > 1 else 0) or j < outer:
            if inner > 1 and i < inner and (j >= outer or (i + 1) / inner <= (j + 1) / outer):
                faces.append((before[i % inner], now[j % outer], before[(i + 1) % inner]))
                i += 1
            else:
                faces.append((before[i % inner], now[j % outer], now[(j + 1) % outer]))
                j += 1
        before = now
    vertices = numpy.array(points) + BOWL_CENTRE
    a, b, c = (vertices[[face[k] for face in faces]] for k in range(3))
    inward = numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), BOWL_CENTRE - a)
    assert (inward > 0).all() or (inward < 0).all(), "triangles of both orientations"
    if inward[0] < 0:
        faces = [(f[0], f[2], f[1]) for f in faces]
    return write_obj(out, vertices, faces)


def wave_obj(out):
    """The wave on a grid whose vertices lie on it."""
    n = math.ceil(WAVE_SIDE / CONTACT["wave_edge"])
    x, y = (a.ravel() for a in numpy.meshgrid(*2 * [WAVE_SIDE * (numpy.arange(n + 1) / n - 0.5)]))
    z = WAVE_AMPLITUDE * numpy.sin(2 * math.pi * x / WAVE_LENGTH)
    first = [row * (n + 1) + column for row in range(n) for column in range(n)]
    faces = [f for i in first for f in ((i, i + 1, i + n + 2), (i, i + n + 2, i + n + 1))]
    return write_obj(out, numpy.stack([x, y, z], 1) + WAVE_CENTRE, faces)


def write_obj(out, vertices, faces):
    """With normals of the vertices, which Drake's renderer asks for."""
    f = numpy.array(faces)
    a, b, c = (vertices[f[:, k]] for k in range(3))
    normals = numpy.zeros_like(vertices)
    for k in range(3):
        numpy.add.at(normals, f[:, k], numpy.cross(b - a, c - a))
    normals /= numpy.linalg.norm(normals, axis=1)[:, None]
    with open(out, "w") as file:
        file.writelines(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in vertices)
        file.writelines(f"vn {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in normals)
        file.writelines(f"f {i}//{i} {j}//{j} {k}//{k}\n" for i, j, k in f + 1)
    return out


CANVASES = {"bowl": bowl_obj, "wave": wave_obj}
