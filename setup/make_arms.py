"""Writes models/arms/*.urdf, the arms without a tool, from the descriptions that pinned packages ship. One file per arm: kinematics,
masses, limits, rest posture. Bodies are cylinders along the links and spheres at the joints: what the cameras see and what keeps clear.

Usage: setup/make_arms.py WHEELS [ARM …]    (a folder with the packages of ARMS below, `pip download --no-deps`)
"""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree
import zipfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
OUT = ROOT / "models/arms"

FRANKA_RADII = [0.08, 0.07, 0.07, 0.065, 0.06, 0.06, 0.05, 0.045]
ROBOSUITE = dict(wheel="robosuite-1.5.2-py3-none-any.whl")
ROBOSUITE_SOURCE = "robosuite 1.5.2 (MIT), models/assets/robots/%s/robot.xml"
ARMS = {
    "fr3": dict(
        title="Franka Research 3",
        wheel="franka_sim-1.1.7-py3-none-any.whl",
        path="franka_sim/models/fr3.urdf",
        source="franka-sim 1.1.7 (Apache-2.0), models/fr3.urdf, which libfranka's tests and its simulated arm use",
        radii=FRANKA_RADII,
        flange=((0, 0, 0.107), (0, 0, 0)),
        rest=[0, -0.3, 0, -2.2, 0, 1.9, 0.785],
        torque_rate=1000,
    ),
    "panda": dict(
        title="Franka Emika Panda",
        wheel="example_robot_data-6.0.0-0-py3-none-any.whl",
        path="cmeel.prefix/share/example-robot-data/robots/panda_description/urdf/panda.urdf",
        source="example-robot-data 6.0.0 (the panda's description there is BSD-3), panda.urdf",
        radii=FRANKA_RADII,
        flange=((0, 0, 0.107), (0, 0, 0)),
        rest=[0, -0.3, 0, -2.2, 0, 1.9, 0.785],
        torque_rate=1000,
        joints=[f"panda_joint{i}" for i in range(1, 8)],
    ),
    "iiwa7": dict(
        ROBOSUITE,
        title="KUKA LBR iiwa 7 R800",
        path="robosuite/models/assets/robots/iiwa/robot.xml",
        source=ROBOSUITE_SOURCE % "iiwa",
        limits="Speeds and torques: KUKA's data sheet.",
        radii=[0.08, 0.07, 0.07, 0.065, 0.065, 0.055, 0.05, 0.04],
        rest=[0, 0.6, 0, -1.4, 0, 1.1, 0],
        torque_rate=4000,
        override={"velocity": numpy.radians([98, 98, 100, 130, 140, 180, 180]), "effort": [176, 176, 110, 110, 110, 40, 40]},
    ),
    "ur5e": dict(
        ROBOSUITE,
        title="Universal Robots UR5e",
        path="robosuite/models/assets/robots/ur5e/robot.xml",
        source=ROBOSUITE_SOURCE % "ur5e",
        limits="Speeds: Universal Robots' data sheet, 180 degrees a second.",
        radii=[0.07, 0.06, 0.055, 0.05, 0.045, 0.045, 0.04],
        rest=[0, -1.9, 2.0, -1.67, -1.57, 0],
        torque_rate=4000,
        override={"velocity": [numpy.pi] * 6},
    ),
    "gen3": dict(
        ROBOSUITE,
        title="Kinova Gen3, seven joints",
        path="robosuite/models/assets/robots/kinova3/robot.xml",
        source=ROBOSUITE_SOURCE % "kinova3",
        limits="Speeds: Kinova's user guide. Joints that turn without end may turn by 2 pi here.",
        radii=[0.05, 0.045, 0.045, 0.045, 0.045, 0.04, 0.04, 0.04],
        rest=[0, 0.4, 3.1416, -1.9, 0, -0.85, 1.5708],
        torque_rate=4000,
        override={"velocity": [1.39] * 4 + [1.22] * 3},
    ),
}


def numbers(text, default=(0.0, 0.0, 0.0)):
    return numpy.array([float(x) for x in text.split()]) if text else numpy.array(default)


def from_urdf(text, names):
    """(joints, links) of a chain of revolute joints: name, xyz, rpy, axis, limits; mass, com, com's axes, inertia."""
    robot = ElementTree.fromstring(text)
    joints, links = [], []
    revolute = {j.get("name"): j for j in robot.findall("joint") if j.get("type") in ("revolute", "continuous")}
    chosen = [revolute[n] for n in names] if names else list(revolute.values())
    for joint in chosen:
        origin, limit = joint.find("origin"), joint.find("limit")
        joints.append(
            dict(
                xyz=numbers(origin.get("xyz")),
                rpy=numbers(origin.get("rpy")),
                axis=numbers(joint.find("axis").get("xyz")),
                lower=float(limit.get("lower", -6.2832)),
                upper=float(limit.get("upper", 6.2832)),
                effort=float(limit.get("effort")),
                velocity=float(limit.get("velocity")),
            )
        )
    bodies = {link.get("name"): link for link in robot.findall("link")}
    for name in [chosen[0].find("parent").get("link")] + [j.find("child").get("link") for j in chosen]:
        inertial = bodies[name].find("inertial")
        if inertial is None:
            links.append(None)
            continue
        origin = inertial.find("origin")
        links.append(
            dict(
                mass=float(inertial.find("mass").get("value")),
                xyz=numbers(origin.get("xyz") if origin is not None else None),
                rpy=numbers(origin.get("rpy") if origin is not None else None),
                inertia={k: float(v) for k, v in inertial.find("inertia").attrib.items()},
            )
        )
    return joints, links


def rotation(quat):
    w, x, y, z = numpy.array(quat) / numpy.linalg.norm(quat)
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rpy_of(quat):
    R = rotation(quat)
    if abs(R[2, 0]) > 1 - 1e-9:  # only roll minus or plus yaw counts
        return numpy.array([numpy.arctan2(-R[0, 1] * numpy.sign(R[2, 0]), R[1, 1]), -numpy.sign(R[2, 0]) * numpy.pi / 2, 0.0])
    return numpy.array([numpy.arctan2(R[2, 1], R[2, 2]), -numpy.arcsin(R[2, 0]), numpy.arctan2(R[1, 0], R[0, 0])])


def from_mjcf(text):
    """The same of MuJoCo's format, and the flange: the body right_hand."""
    root = ElementTree.fromstring(text)
    motors = {m.get("joint"): float(m.get("ctrlrange").split()[1]) for m in root.iter("motor")}
    joints, links, flange = [], [None], None
    body = root.find("worldbody/body/body[@name='fixed_base_link']")
    while True:
        below = [b for b in body.findall("body") if b.find("joint") is not None or b.get("name") == "right_hand"]
        if not below:
            break
        (body,) = below
        quat = numbers(body.get("quat"), (1, 0, 0, 0))
        place = numbers(body.get("pos")), rpy_of(quat)
        if body.get("name") == "right_hand":
            flange = place
            break
        joint, inertial = body.find("joint"), body.find("inertial")
        lower, upper = numbers(joint.get("range"), (-2 * numpy.pi, 2 * numpy.pi))
        joints.append(
            dict(xyz=place[0], rpy=place[1], axis=numbers(joint.get("axis"), (0, 0, 1)), lower=lower, upper=upper,
                 effort=motors[joint.get("name")], velocity=1.0, armature=float(joint.get("armature", 0)))
        )
        if inertial.get("fullinertia"):
            xx, yy, zz, xy, xz, yz = numbers(inertial.get("fullinertia"))
        else:
            (xx, yy, zz), (xy, xz, yz) = numbers(inertial.get("diaginertia")), (0, 0, 0)
        links.append(
            dict(mass=float(inertial.get("mass")), xyz=numbers(inertial.get("pos")), rpy=rpy_of(numbers(inertial.get("quat"), (1, 0, 0, 0))),
                 inertia=dict(ixx=xx, iyy=yy, izz=zz, ixy=xy, ixz=xz, iyz=yz))
        )
    return joints, links, flange


def text_of(values):
    return " ".join(f"{x:.10g}" for x in values)


def rpy_to(direction):
    """Roll and pitch that turn z into a direction."""
    x, y, z = direction / numpy.linalg.norm(direction)
    roll = -numpy.arcsin(y)
    return roll, numpy.arctan2(x, z), 0.0


def bodies_along(to, radius):
    shapes = [f'<origin xyz="0 0 0" rpy="0 0 0"/><geometry><sphere radius="{radius}"/></geometry>']
    length = numpy.linalg.norm(to)
    if length > 0.02:
        shapes.append(
            f'<origin xyz="{text_of(to / 2)}" rpy="{text_of(rpy_to(to))}"/><geometry><cylinder radius="{radius}" length="{length:.6g}"/></geometry>'
        )
    return "".join(f"    <{kind}>{shape}</{kind}>\n" for shape in shapes for kind in ("visual", "collision"))


def write(name, arm, joints, links):
    n = len(joints)
    xyz, rpy = arm["flange"]
    armature = [joint.get("armature", 0) for joint in joints]
    rotors = f' rotor_inertia="{text_of(armature)}"' if any(armature) else ""
    out = [
        '<?xml version="1.0"?>\n'
        f"<!-- {arm['title']} without a tool. Kinematics, masses and inertias: {arm['source']}.\n"
        f"     {arm.get('limits', 'Limits: the same.')} Bodies: cylinders and spheres along the links.\n"
        "     Written by setup/make_arms.py; ./impedraw arm make-urdf adds the pen. -->\n"
        f'<robot name="{name}">\n'
        f'  <impedraw rest_posture="{text_of(arm["rest"])}" torque_rate="{arm["torque_rate"]}"{rotors}/>\n'
    ]
    for i in range(n + 1):
        if i:
            j = joints[i - 1]
            out.append(
                f'\n  <joint name="joint_{i}" type="revolute">\n    <parent link="link_{i - 1}"/><child link="link_{i}"/>\n'
                f'    <origin xyz="{text_of(j["xyz"])}" rpy="{text_of(j["rpy"])}"/><axis xyz="{text_of(j["axis"])}"/>\n'
                f'    <limit lower="{j["lower"]:.6g}" upper="{j["upper"]:.6g}" effort="{j["effort"]:g}" velocity="{j["velocity"]:.6g}"/>\n  </joint>\n'
            )
        out.append(f'  <link name="link_{i}">\n')
        link = links[i]
        if link:
            out.append(
                f'    <inertial><origin xyz="{text_of(link["xyz"])}" rpy="{text_of(link["rpy"])}"/><mass value="{link["mass"]:.10g}"/>'
                "<inertia " + " ".join(f'{k}="{link["inertia"][k]:.10g}"' for k in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")) + "/></inertial>\n"
            )
        to = joints[i]["xyz"] if i < n else numpy.array(xyz, float)
        out.append(bodies_along(to, arm["radii"][i]) + "  </link>\n")
    out.append(
        f'\n  <joint name="flange_joint" type="fixed"><parent link="link_{n}"/><child link="flange"/>'
        f'<origin xyz="{text_of(xyz)}" rpy="{text_of(rpy)}"/></joint>\n  <link name="flange"/>\n</robot>\n'
    )
    (OUT / f"{name}.urdf").write_text("".join(out))


def main():
    wheels = pathlib.Path(sys.argv[1])
    standard = (ROOT / "models/iiwa14_pen.urdf").read_text()
    bare = standard[: standard.index("  <!-- The pen:")].rstrip() + "\n</robot>\n"
    bare = bare.replace(" with a pen fixed to its flange: the one description that feeds the controller's model and the simulator's.", " without a tool: models/iiwa14_pen.urdf without its pen.")
    bare = bare[: bare.index("\n     Frame tip")] + " -->" + bare[bare.index(" -->") + 4 :]
    bare = bare.replace('<robot name="iiwa14_pen">', '<robot name="iiwa14">\n  <impedraw rest_posture="0 0.6 0 -1.4 0 1.1 0" torque_rate="4000"/>')
    (OUT / "iiwa14.urdf").write_text(bare)
    for name in sys.argv[2:] or ARMS:
        arm = ARMS[name]
        with zipfile.ZipFile(wheels / arm["wheel"]) as wheel:
            text = wheel.read(arm["path"]).decode()
        if arm["path"].endswith(".urdf"):
            joints, links = from_urdf(text, arm.get("joints"))
        else:
            joints, links, arm["flange"] = from_mjcf(text)
        for key, values in arm.get("override", {}).items():
            for joint, value in zip(joints, values):
                joint[key] = value
        write(name, arm, joints, links)
        print(name, len(joints), "joints,", round(sum(link["mass"] for link in links if link), 3), "kg")


if __name__ == "__main__":
    main()
