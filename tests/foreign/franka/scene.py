"""The FR3 with impedraw's pen over the standard bowl for MuJoCo. Arm: the URDF that franka-sim ships, not impedraw's copy."""
import math
import pathlib
import tomllib
import xml.etree.ElementTree as ElementTree

import franka_sim
import mujoco
import numpy

HERE = pathlib.Path(__file__).resolve().parent
CONTACT = tomllib.loads((HERE / "contact.toml").read_text())
URDF = pathlib.Path(franka_sim.__file__).parent / "models/fr3.urdf"
BOWL_RADIUS, BOWL_CENTRE = 0.30, numpy.array([0.60, 0.0, 0.40])
PEN_LENGTH, PEN_MASS, PEN_RADIUS, FLANGE = 0.12, 0.05, 0.005, 0.107


def text(values):
    return " ".join(f"{float(x):.12g}" for x in values)


def quat(rpy):
    """MuJoCo's quaternion of a URDF's roll, pitch, yaw."""
    halves = [0.5 * x for x in rpy]
    (cr, cp, cy), (sr, sp, sy) = map(math.cos, halves), map(math.sin, halves)
    return (cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy)


def follow_bowl(model, data, tip, plane):
    """Lays the bowl's tangent plane under the tip: MuJoCo's meshes are convex, and a height field is a set of flat cells. From one
    step to the next the tip moves by 50 um, where plane and sphere differ by 4 nm. (Its first placement is no identity, or MuJoCo takes
    that of the world for it.)"""
    normal = BOWL_CENTRE - data.geom_xpos[tip]
    normal /= numpy.linalg.norm(normal)
    model.geom_pos[plane] = BOWL_CENTRE - BOWL_RADIUS * normal
    axis = numpy.cross((0, 0, 1), normal)
    sine, cosine = numpy.linalg.norm(axis), normal[2]
    half = 0.5 * math.atan2(sine, cosine)
    model.geom_quat[plane] = (math.cos(half), *(math.sin(half) * axis / max(sine, 1e-12)))


def pair_xml(piece="bowl"):
    c = CONTACT
    return (
        f'<pair geom1="{piece}" geom2="tip" condim="3" friction="{c["friction"]} {c["friction"]} 0.005 0.0001 0.0001" '
        f'solref="{text(c["solref"])}" solimp="{text(c["solimp"])}" solreffriction="{text(c["solreffriction"])}"/>'
    )


def inertial_xml(link):
    inertial = link.find("inertial")
    if inertial is None:
        return ""
    origin, inertia = inertial.find("origin"), inertial.find("inertia")
    assert all(abs(float(x)) < 1e-12 for x in origin.get("rpy", "0 0 0").split())
    return f'<inertial pos="{origin.get("xyz")}" mass="{inertial.find("mass").get("value")}" fullinertia="' + " ".join(
        inertia.get(k) for k in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    ) + '"/>'


def arm_xml(out, more=("", "", "")):
    """`more`: further assets, bodies and pairs."""
    robot = ElementTree.parse(URDF).getroot()
    links = {link.get("name"): link for link in robot.findall("link")}
    joints = [joint for joint in robot.findall("joint") if joint.get("type") == "revolute"]
    c = CONTACT
    body, end = '<body name="link0">' + inertial_xml(links["link0"]), "</body>"
    for i, joint in enumerate(joints, 1):
        origin, limit = joint.find("origin"), joint.find("limit")
        body += (
            f'<body name="link{i}" pos="{origin.get("xyz")}" quat="{text(quat([float(x) for x in origin.get("rpy").split()]))}">'
            + inertial_xml(links[f"link{i}"])
            + f'<joint name="joint{i}" axis="{joint.find("axis").get("xyz")}" range="{limit.get("lower")} {limit.get("upper")}" limited="true" '
            f'armature="{c["armature"]}" damping="{c["damping"]}" frictionloss="{c["frictionloss"]}"/>'
        )
        end += "</body>"
    along = PEN_MASS * (PEN_RADIUS**2 / 4 + PEN_LENGTH**2 / 12)
    body += (
        f'<body name="pen" pos="0 0 {FLANGE}"><inertial pos="0 0 {PEN_LENGTH / 2}" mass="{PEN_MASS}" '
        f'diaginertia="{along} {along} {PEN_MASS * PEN_RADIUS**2 / 2}"/>'
        f'<geom name="tip" type="sphere" size="{c["ball_radius"]}" pos="0 0 {PEN_LENGTH - c["ball_radius"]}" contype="0" conaffinity="0"/>'
        f'<site name="tip" pos="0 0 {PEN_LENGTH}"/></body>'
    )
    assets, pieces, pairs = more
    pathlib.Path(out).write_text(
        f'<mujoco model="fr3_pen"><compiler angle="radian"/><option integrator="implicitfast" cone="elliptic"/>{assets}'
        '<worldbody><geom name="bowl" type="plane" size="1 1 0.1" pos="0.6 0 0.1" axisangle="1 0 0 0.1" contype="0" conaffinity="0"/>'
        f"{body}{end}{pieces}</worldbody><contact>{pair_xml()}{pairs}</contact></mujoco>"
    )
    return out


def contact_on_tip(model, data, tip):
    """Force of the bowl on the tip in W [N], where it acts [m], how deep the tip is in the bowl [m], NaN where there is none; and its part along the normal [N]."""
    force, point, weight, one, depth = numpy.zeros(3), numpy.zeros(3), 0.0, numpy.zeros(6), numpy.nan
    for i in range(data.ncon):
        contact = data.contact[i]
        if tip not in (contact.geom1, contact.geom2):
            continue
        mujoco.mj_contactForce(model, data, i, one)
        F = contact.frame.reshape(3, 3).T @ one[:3] * (1 if contact.geom2 == tip else -1)
        force += F
        point += one[0] * contact.pos
        weight += one[0]
        depth = -contact.dist
    return force, point / weight if weight > 0 else numpy.full(3, numpy.nan), depth, weight
