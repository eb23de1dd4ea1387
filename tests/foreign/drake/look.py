"""What Drake's depth cameras (RgbdSensor, rendered by VTK) see of the iiwa, what it draws on and a table, as a capture.

Usage: look.py FOLDER --start q1,…,q7 [--canvas bowl|wave|FILE.obj] [--faults SEED]
"""
import argparse
import pathlib
import sys
import tempfile

import numpy
from pydrake.geometry import (
    Box, ClippingRange, DepthRange, DepthRenderCamera, GeometryInstance, MakeRenderEngineVtk, Mesh, PerceptionProperties, RenderCameraCore, RenderEngineVtkParams,
)  # fmt: skip
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo, RgbdSensor

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import eyes  # noqa: E402
import scene  # noqa: E402


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--start", required=True, type=lambda text: numpy.array([float(x) for x in text.split(",")]))
    parser.add_argument("--canvas", default="bowl")
    parser.add_argument("--faults", type=int, help="seed of those of a stereo camera")
    arguments = parser.parse_args()

    builder = DiagramBuilder()
    plant, graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    graph.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams()))
    with tempfile.TemporaryDirectory() as folder:
        arm = Parser(plant).AddModels(str(scene.arm_urdf(f"{folder}/arm.urdf", seen=True)))[0]
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("link_0"))
        canvas = scene.CANVASES[arguments.canvas](f"{folder}/canvas.obj") if arguments.canvas in scene.CANVASES else arguments.canvas
        source = graph.RegisterSource("canvas")
        table = Box(0.8, 1.2, 0.02)
        for name, X, shape in (("canvas", [0, 0, 0], Mesh(str(canvas), 1.0)), ("table", [0.7, 0, -0.01], table)):
            body = GeometryInstance(RigidTransform(X), shape, name)
            body.set_perception_properties(PerceptionProperties())
            graph.RegisterAnchoredGeometry(source, body)
        plant.Finalize()
        # Drake's principal point counts from the pixel's corner.
        lens = CameraInfo(eyes.WIDTH, eyes.HEIGHT, eyes.FX, eyes.FY, eyes.CX + 0.5, eyes.CY + 0.5)
        camera = DepthRenderCamera(RenderCameraCore("vtk", lens, ClippingRange(0.05, 5.0), RigidTransform()), DepthRange(0.1, 4.0))
        poses = list(eyes.cameras((0.60, 0.0, 0.12)))
        sensors = []
        for R, p in poses:
            X = RigidTransform(RotationMatrix(R), p)
            sensors.append(builder.AddSystem(RgbdSensor(graph.world_frame_id(), X, depth_camera=camera)))
            builder.Connect(graph.get_query_output_port(), sensors[-1].query_object_input_port())
        diagram = builder.Build()
        context = diagram.CreateDefaultContext()
        plant.SetPositions(plant.GetMyContextFromRoot(context), arm, arguments.start)
        images = []
        for sensor in sensors:
            at = sensor.GetMyContextFromRoot(context)
            port = sensor.depth_image_16U_output_port() if arguments.faults is None else sensor.depth_image_32F_output_port()
            image = numpy.array(port.Eval(at).data)[:, :, 0]
            images.append(image if arguments.faults is None else numpy.where(numpy.isfinite(image), image, 0).astype(float))
    # Drake's "too far".
    images = [numpy.where(image == 65535, 0, image) for image in images]
    eyes.write_capture(arguments.folder, images, poses, arguments.start, arguments.faults)


if __name__ == "__main__":
    main()
