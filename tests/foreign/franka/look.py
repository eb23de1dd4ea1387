"""What MuJoCo's renderer sees of franka-sim's FR3, the bowl and a table, as a capture. Needs EGL.

Usage: look.py FOLDER --start q1,…,q7 [--faults SEED]
"""
import argparse
import math
import os
import pathlib
import sys
import tempfile

os.environ["MUJOCO_GL"] = "egl"
import mujoco  # noqa: E402
import numpy  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import eyes  # noqa: E402
import scene  # noqa: E402

OPENING = 0.18  # [m], radius of the circle at which the standard bowl ends
HIDDEN = 4  # a group of geoms that MuJoCo does not draw


def bowl_xml(rings=240, around=720):
    """The bowl as a closed shell of 5 mm: rings of vertices on the sphere from the middle to the rim, and back outside. MuJoCo wants a volume.
    The plane that bears the pen lies under the tip alone (scene.follow_bowl)."""
    rise = math.asin(OPENING / scene.BOWL_RADIUS) * numpy.arange(1, rings + 1) / rings
    slope, radius = numpy.r_[rise, rise[::-1]], numpy.repeat((scene.BOWL_RADIUS, scene.BOWL_RADIUS + 0.005), rings)
    turn = 2 * math.pi * numpy.arange(around) / around
    vertex = numpy.stack([numpy.outer(radius * numpy.sin(slope), numpy.cos(turn)), numpy.outer(radius * numpy.sin(slope), numpy.sin(turn)),
                          numpy.outer(-radius * numpy.cos(slope), numpy.ones(around))], -1).reshape(-1, 3)  # fmt: skip
    poles = numpy.array([[0, 0, -scene.BOWL_RADIUS], [0, 0, -scene.BOWL_RADIUS - 0.005]])
    k = numpy.arange(2 * rings - 1)[:, None] * around + numpy.arange(around)
    beside = numpy.arange(2 * rings - 1)[:, None] * around + (numpy.arange(around) + 1) % around
    first, last, n = numpy.arange(around), len(vertex) - around + numpy.arange(around), len(vertex)
    faces = numpy.concatenate([
        numpy.stack([k, k + around, beside + around], -1).reshape(-1, 3), numpy.stack([k, beside + around, beside], -1).reshape(-1, 3),
        numpy.stack([numpy.full(around, n), first, numpy.roll(first, -1)], -1),
        numpy.stack([numpy.full(around, n + 1), numpy.roll(last, -1), last], -1),
    ])  # fmt: skip
    return f'<mesh name="bowl" vertex="{scene.text(numpy.concatenate([vertex, poles]).ravel())}" face="{" ".join(map(str, faces.ravel()))}"/>'


def seen_xml(arm, poses):
    """The arm's model with a ball at each joint, for its links have no shape there, with bowl, table and cameras."""
    arm = arm.replace("<joint name=", '<geom type="sphere" size="0.06" mass="0" contype="0" conaffinity="0"/><joint name=')
    cameras = "".join(  # MuJoCo's camera has y up and looks along −z
        f'<camera name="{k}" pos="{scene.text(p)}" xyaxes="{scene.text([*R[:, 0], *-R[:, 1]])}" fovy="{math.degrees(2 * math.atan(eyes.HEIGHT / 2 / eyes.FY)):.12g}"/>'
        for k, (R, p) in enumerate(poses)
    )
    things = (
        f'<geom type="mesh" mesh="bowl" pos="{scene.text(scene.BOWL_CENTRE)}" contype="0" conaffinity="0"/>'
        '<geom type="box" size="0.4 0.6 0.01" pos="0.7 0 -0.01" contype="0" conaffinity="0"/>'
    )
    drawn = f'<statistic extent="1"/><visual><global offwidth="{eyes.WIDTH}" offheight="{eyes.HEIGHT}"/><map znear="0.05" zfar="5"/></visual>'
    return arm.replace("<worldbody>", f"{drawn}<asset>{bowl_xml()}</asset><worldbody>{cameras}{things}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--start", required=True, type=lambda text: numpy.array([float(x) for x in text.split(",")]))
    parser.add_argument("--faults", type=int, help="seed of those of a stereo camera")
    arguments = parser.parse_args()
    poses = list(eyes.cameras((0.60, 0.0, 0.12)))
    with tempfile.TemporaryDirectory() as folder:
        arm = pathlib.Path(scene.arm_xml(f"{folder}/arm.xml")).read_text()
    model = mujoco.MjModel.from_xml_string(seen_xml(arm, poses))
    model.geom_group[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "bowl")] = HIDDEN
    data = mujoco.MjData(model)
    data.qpos[:7] = arguments.start
    mujoco.mj_forward(model, data)
    renderer = mujoco.Renderer(model, eyes.HEIGHT, eyes.WIDTH)
    renderer.enable_depth_rendering()
    images = []
    for k in range(len(poses)):
        renderer.update_scene(data, str(k))
        depth = renderer.render().astype(float)
        depth[depth > 4.0] = 0.0
        images.append(depth if arguments.faults is not None else numpy.round(1e3 * depth).astype(numpy.uint16))
    lens = (eyes.FY, eyes.FY, (eyes.WIDTH - 1) / 2, (eyes.HEIGHT - 1) / 2)
    eyes.write_capture(arguments.folder, images, poses, arguments.start, arguments.faults, lens)


if __name__ == "__main__":
    main()
