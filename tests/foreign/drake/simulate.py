"""Drake's iiwa with impedraw's pen over its bowl, spoken to over LCM as the real arm is: status out, torque in.

The loop of the driver's side is Drake's own: SimIiwaDriver, IiwaCommandReceiver and IiwaStatusSender. Until the first command, time runs as
the wall's; from then on in lock-step (each status waits for the command that echoes its utime) or free (--free). With --wrench, the
force of Drake's contact on the pen is sent beside, WRENCH_DELAY late. Everything is logged here: what is judged is Drake's own.

With --rig, the workpiece is what a file orders before each run (../rig.py), and OUT is a sensor's file.

Usage: simulate.py URL OUT.npz --start q1,…,q7 [--wrench] [--free] [--seconds S] [--pen-mass 1.2] [--rotor 0.1] [--canvas wave]
       simulate.py URL OUT.csv --start q1,…,q7 --wrench --rig ORDERS.json
"""
import argparse
import collections
import struct
import sys
import tempfile
import time

import numpy
from drake import lcmt_force_torque, lcmt_iiwa_command, lcmt_iiwa_status
from pydrake.geometry import AddRigidHydroelasticProperties, Mesh, ProximityProperties
from pydrake.geometry import AddContactMaterial
from pydrake.lcm import DrakeLcm
from pydrake.manipulation import IiwaCommandReceiver, IiwaControlMode, IiwaDriver, IiwaStatusSender, SimIiwaDriver
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, TriggerType
from pydrake.systems.primitives import Adder
from pydrake.systems.lcm import LcmPublisherSystem, LcmSubscriberSystem

import scene
from workpieces import Workpieces

WRENCH_DELAY = 2  # plant steps
WRENCH_CHANNEL = "IMPEDRAW_TIP_WRENCH"


def build(folder, lcm, arguments):
    builder = DiagramBuilder()
    step = scene.CONTACT["plant_step"]
    plant, graph = AddMultibodyPlant(
        MultibodyPlantConfig(
            time_step=step,
            contact_model=scene.CONTACT["contact_model"],
            discrete_contact_approximation=scene.CONTACT["approximation"],
        ),
        builder,
    )
    urdf = scene.arm_urdf(f"{folder}/arm.urdf", arguments.pen_mass, arguments.rotor, rig=bool(arguments.rig))
    arm = Parser(plant).AddModels(str(urdf))[0]
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("link_0"))
    properties = ProximityProperties()
    friction = CoulombFriction(scene.CONTACT["friction"], scene.CONTACT["friction"])
    AddContactMaterial(dissipation=scene.CONTACT["dissipation"], friction=friction, properties=properties)
    AddRigidHydroelasticProperties(scene.CONTACT["bowl_edge"], properties)
    rig = None
    if arguments.rig:
        rig = Workpieces(arguments.rig, plant, folder, properties)
    else:
        canvas = scene.CANVASES[arguments.canvas](f"{folder}/canvas.obj")
        plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), Mesh(str(canvas), 1.0), "canvas", properties)
    plant.Finalize()

    # The arm that Drake's driver compensates: the true one, as the iiwa's own controller would with its tool told to it.
    model = MultibodyPlant(step)
    Parser(model).AddModels(str(urdf))
    model.WeldFrames(model.world_frame(), model.GetFrameByName("link_0"))
    model.Finalize()

    config = IiwaDriver()
    config.control_mode = "torque_only"
    driver = builder.AddSystem(SimIiwaDriver(config, model))
    receiver = builder.AddSystem(IiwaCommandReceiver(7, IiwaControlMode.kTorqueOnly))
    sender = builder.AddSystem(IiwaStatusSender(7))
    subscriber = builder.AddSystem(
        LcmSubscriberSystem.Make("IIWA_COMMAND", lcmt_iiwa_command, lcm, use_cpp_serializer=True)
    )
    publisher = builder.AddSystem(
        LcmPublisherSystem.Make(
            "IIWA_STATUS", lcmt_iiwa_status, lcm, publish_triggers={TriggerType.kForced}, use_cpp_serializer=True
        )
    )
    builder.Connect(subscriber.get_output_port(), receiver.get_message_input_port())
    builder.Connect(receiver.get_commanded_torque_output_port(), driver.GetInputPort("torque"))
    builder.Connect(plant.get_state_output_port(arm), driver.GetInputPort("state"))
    # Somebody leans on the arm: joint torques that act on it, and that its driver reports as it does those of contact.
    external = builder.AddSystem(Adder(2, 7))
    builder.ExportInput(external.get_input_port(1), "shove")
    if rig:
        builder.ExportInput(plant.get_applied_generalized_force_input_port(), "all_joints")
    else:
        builder.ConnectInput("shove", plant.get_applied_generalized_force_input_port())
    builder.Connect(plant.get_generalized_contact_forces_output_port(arm), external.get_input_port(0))
    builder.Connect(external.get_output_port(), driver.GetInputPort("generalized_contact_forces"))
    builder.Connect(driver.GetOutputPort("actuation"), plant.get_actuation_input_port(arm))
    for port in ("position_commanded", "position_measured", "velocity_estimated", "torque_commanded", "torque_measured", "torque_external"):
        if driver.HasOutputPort(port) and sender.HasInputPort(port):
            builder.Connect(driver.GetOutputPort(port), sender.GetInputPort(port))
    if sender.HasInputPort("position_commanded") and not driver.HasOutputPort("position_commanded"):
        builder.Connect(driver.GetOutputPort("position_measured"), sender.GetInputPort("position_commanded"))
    builder.Connect(sender.get_output_port(), publisher.get_input_port())
    return builder.Build(), plant, graph, arm, publisher, rig


class Commands:
    def __init__(self, lcm):
        self.utime, self.torque, self.count = None, numpy.zeros(7), 0
        self.arrivals = {}  # utime echoed: when it arrived
        lcm.Subscribe("IIWA_COMMAND", self.receive)

    def receive(self, data):
        self.utime = struct.unpack_from(">q", data, 8)[0]
        self.torque = numpy.array(struct.unpack_from(">7d", data, 24))
        self.count += 1
        self.arrivals[self.utime] = time.perf_counter()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("url")
    parser.add_argument("out")
    parser.add_argument("--start", required=True, type=lambda text: numpy.array([float(x) for x in text.split(",")]))
    parser.add_argument("--wrench", action="store_true")
    parser.add_argument("--free", action="store_true")
    parser.add_argument("--seconds", type=float, default=600.0, help="longest time to simulate after the first command")
    parser.add_argument("--pen-mass", type=float, default=1.0)
    parser.add_argument("--rotor", type=float, default=0.0)
    parser.add_argument("--rate", type=float, default=1000.0, help="of the statuses [Hz]")
    parser.add_argument("--canvas", choices=scene.CANVASES, default="bowl")
    parser.add_argument("--rig", help="file of the orders for the workpiece")
    parser.add_argument("--shove", type=float, default=0.0, help="torque on joint 4, 3 s after the first command [Nm]")
    arguments = parser.parse_args()

    lcm = DrakeLcm(arguments.url)
    commands = Commands(lcm)
    folder = tempfile.TemporaryDirectory()
    diagram, plant, graph, arm, publisher, rig = build(folder.name, lcm, arguments)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant_context = plant.GetMyContextFromRoot(context)
    publisher_context = publisher.GetMyContextFromRoot(context)
    plant.SetPositions(plant_context, arm, arguments.start)
    diagram.GetInputPort("shove").FixValue(context, numpy.zeros(7))
    if rig:
        rig.begin(diagram, context, plant, graph, arm)
        rig.apply(0.0)
    simulator.Initialize()
    (ball,) = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("pen"))
    tip = plant.GetFrameByName("tip")
    results = plant.get_contact_results_output_port()
    step = scene.CONTACT["plant_step"]
    every = round(1 / (arguments.rate * step))
    late = collections.deque([(0.0, numpy.zeros(6))] * WRENCH_DELAY)
    rows = collections.defaultdict(list)
    waits, answered, sent = [], 0, 0
    began = ended = None
    print("statuses begin", flush=True)
    sent_at_of = {}  # utime: when it was sent, where time runs free
    wall = time.perf_counter()
    first_wall, k = wall, 0
    while True:
        t = k * step
        # Contact over the last step, from Drake's results.
        force, point, moment = numpy.zeros(3), numpy.full(3, numpy.nan), numpy.zeros(3)
        X_WE = tip.CalcPoseInWorld(plant_context)
        contact = results.Eval(plant_context)
        for i in range(contact.num_hydroelastic_contacts()):
            info = contact.hydroelastic_contact_info(i)
            F, point = info.F_Ac_W(), info.contact_surface().centroid()
            sign = 1.0 if info.contact_surface().id_M() == ball else -1.0  # F acts on the body of M
            force = sign * F.translational()
            moment = sign * F.rotational() + numpy.cross(point - X_WE.translation(), force)
        touch = rig.hand(t) if rig else numpy.zeros(3)  # a sensor at the flange feels it, too
        late.append((t, numpy.concatenate([force + touch, moment])))
        measured_at, wrench = late.popleft()
        if arguments.shove and began is not None and t - began > 3.0:
            diagram.GetInputPort("shove").FixValue(context, numpy.eye(7)[3] * arguments.shove)
        publish = k % every == 0
        if publish:
            if arguments.wrench:
                message = lcmt_force_torque()
                message.timestamp = round(1e6 * measured_at)
                message.fx, message.fy, message.fz, message.tx, message.ty, message.tz = wrench
                lcm.Publish(WRENCH_CHANNEL, message.encode())
            publisher.ForcedPublish(publisher_context)
            sent_at = time.perf_counter()
            own_utime = int(1e6 * context.get_time())  # cut, as IiwaStatusSender does; an echo of another one would show
            if began is None:
                # By the wall's clock, and every message that is there: a driver must never run ahead of the arm.
                while lcm.HandleSubscriptions(1 if time.perf_counter() < wall + t else 0) or time.perf_counter() < wall + t:
                    pass
                if commands.utime is not None:
                    began = t
                    first_wall = time.perf_counter()
            if began is not None and not arguments.free:
                sent += 1
                deadline = time.perf_counter() + (5.0 if sent < 5 else 2.0)
                while commands.utime != own_utime and time.perf_counter() < deadline:
                    lcm.HandleSubscriptions(100)
                if commands.utime != own_utime:
                    ended = t  # it has left
                    break
                answered += 1
                waits.append(time.perf_counter() - sent_at)
                if rig and rig.look(t):
                    rig.set_ball()
            elif began is not None:
                sent += 1
                sent_at_of[own_utime] = sent_at
                lcm.HandleSubscriptions(0)
                while time.perf_counter() < wall + t:
                    lcm.HandleSubscriptions(0)
                    time.sleep(5e-5)
        if rig:
            if began is not None:
                rig.read(t, rig.along(t, force, point))
            rig.apply(t)
        for name, value in () if rig else (
            ("time", t),
            ("q", plant.GetPositions(plant_context, arm)),
            ("v", plant.GetVelocities(plant_context, arm)),
            ("tip", X_WE.translation()),
            ("pen", X_WE.rotation().matrix()[:, 2]),
            ("force", force),
            ("point", point),
            ("torque", commands.torque),
            ("began", began is not None),
        ):
            rows[name].append(value)
        if (not rig and began is not None and t - began >= arguments.seconds) or (began is None and t > 60.0):
            break
        k += 1
        simulator.AdvanceTo(k * step)
    if rig:
        return rig.write(arguments.out)
    if arguments.free:
        waits = [commands.arrivals[utime] - at for utime, at in sent_at_of.items() if utime in commands.arrivals]
        answered = len(waits)
    took = time.perf_counter() - first_wall
    numpy.savez(
        arguments.out,
        waits=waits,
        delays=waits,
        sent=sent,
        answered=answered,
        commands=commands.count,
        last_torque=commands.torque,
        real_time_factor=(t - (began or 0.0)) / took,
        left=ended is not None,
        **rows,
    )


if __name__ == "__main__":
    main()
