"""franka-sim's server with its FR3, impedraw's pen and the bowl, as --strict runs it: every limit that it knows ends the motion by a
reflex. Two differences from its command line: it listens on the loopback alone, and physics is stepped by the message loop, in lock-step
with the answers and not paced once a motion has begun. (By itself physics runs free of the messages: a joint moved 2.217 rad while its
speeds summed to 1.650.) Everything is logged here; what is judged is MuJoCo's own.

With --rig, the workpiece is what a file orders before each run (../rig.py), and OUT is a sensor's file.

Usage: simulate.py PORT OUT.npz --start q1,…,q7 [--free] [--provoke torque-step|stall|overspeed --at S --pid-file FILE]
       simulate.py PORT OUT.csv --start q1,…,q7 --rig ORDERS.json
"""
import argparse
import collections
import logging
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time

os.environ["MUJOCO_GL"] = "disable"
import mujoco  # noqa: E402
import numpy  # noqa: E402
from franka_sim import mujoco_franka_sim  # noqa: E402
from franka_sim.control_modes import ControlMode  # noqa: E402
from franka_sim.franka_protocol import RobotMode  # noqa: E402
from franka_sim.franka_sim_server import FrankaSimServer  # noqa: E402
from franka_sim.server import state_stream  # noqa: E402

import scene  # noqa: E402
import workpieces  # noqa: E402

STALL = 60  # cycles


class Arm(mujoco_franka_sim.MujocoFrankaSim):
    def __init__(self, model_path, arguments):
        super().__init__(model_path=model_path)
        self.arguments = arguments
        self.server = self.publisher = None
        self.answered = threading.Event()
        self.rows = collections.defaultdict(list)
        self.steps, self.began, self.provoked, self.stalled, self.pushed = 0, None, False, 0, 0
        self.waits, self.last_torque = [], numpy.zeros(7)
        self.rig = workpieces.Workpieces(arguments.rig) if arguments.rig else None

    def initialize_simulation(self):
        super().initialize_simulation()
        self.tip = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_GEOM, "tip")
        self.bowl = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_GEOM, "bowl")
        self.data.qpos[self.arm_qpos_adr] = self.arguments.start
        self.data.qvel[:] = 0.0
        if self.rig:
            self.rig.begin(self.model, self.data)
            self.rig.apply(0.0, self.dt)
        mujoco.mj_forward(self.model, self.data)
        self._read_and_publish_state()

    def get_robot_state(self):
        if threading.get_ident() == self.publisher:
            self.advance()
        return self._state_snapshot

    def due(self, kind):
        if self.provoked or self.arguments.provoke != kind or self.began is None:
            return False
        self.provoked = (self.steps - self.began) * self.dt >= self.arguments.at
        return self.provoked

    def advance(self):
        server = self.server
        if self.due("stall"):
            self.client = int(pathlib.Path(self.arguments.pid_file).read_text())
            os.kill(self.client, signal.SIGSTOP)
            self.stalled = STALL
        if self.stalled:
            self.stalled -= 1
            if not self.stalled:
                os.kill(self.client, signal.SIGCONT)
        elif server.comm.awaiting_answer and server.robot_state.state["robot_mode"] == RobotMode.kMove and not self.arguments.free:
            before = time.perf_counter()
            self.answered.wait(2.0)
            self.waits.append(time.perf_counter() - before)
        q, v = numpy.float32(self._state_snapshot["q"]), self._state_snapshot["dq"]
        moving = self.control_mode == ControlMode.TORQUE
        if moving and self.began is None:
            self.began = self.steps
        if self.due("overspeed"):
            self.pushed = 300
        self._apply_control()
        self.pushed = max(0, self.pushed - 1) if moving else 0
        if self.pushed:
            self.data.qfrc_applied[self.arm_dofs_idx[0]] += 80.0
        torque = numpy.array(self.latest_torques) if moving else numpy.zeros(7)
        mujoco.mj_kinematics(self.model, self.data)
        if not self.rig or self.rig.shape == "bowl":
            scene.follow_bowl(self.model, self.data, self.tip, self.bowl)
        if self.rig:
            t = self.steps * self.dt
            if moving:
                self.rig.look(t)
            self.rig.apply(t, self.dt)
            self.rig.push(t)
        mujoco.mj_step(self.model, self.data)
        force, point, depth, along = scene.contact_on_tip(self.model, self.data, self.tip)
        if self.rig:
            if moving:
                self.rig.read(t, along)
            return self.go_on()
        for name, value in (
            ("time", self.steps * self.dt),
            ("q", q),
            ("v", v),
            ("force", force),
            ("point", point),
            ("depth", depth),
            ("pen", self.data.site("tip").xmat.reshape(3, 3)[:, 2].copy()),
            ("torque", torque),
            ("began", moving),
            ("wall", time.perf_counter()),
            ("success", server.robot_state.state["control_command_success_rate"]),
            ("mode", int(server.robot_state.state["robot_mode"])),
            ("errors", numpy.array(server.robot_state.state["errors"], dtype=bool)),
        ):
            self.rows[name].append(value)
        self.go_on()

    def go_on(self):
        self.steps += 1
        self._read_and_publish_state()
        self.answered.clear()


class Pace:
    """The module `time` for the server's loop of states: in lock-step a motion waits for answers, not for the clock."""

    def __init__(self, arm):
        self.arm = arm

    def __getattr__(self, name):
        return getattr(time, name)

    def sleep(self, seconds):
        if self.arm.arguments.free or self.arm.stalled or not self.arm.server.comm.active:
            time.sleep(min(seconds, 1e-3))  # its schedule may be seconds ahead after a fast motion


class Server(FrankaSimServer):
    def start_robot_state_transmission(self, client_address, client_udp_port):
        self.physics_sim.publisher = threading.get_ident()
        self.connected = True
        super().start_robot_state_transmission(client_address, client_udp_port)
        self.left = True

    def _absorb_within_motion_limits(self, command, *, fresh):
        if self.physics_sim.due("torque-step"):
            command["tau_J_d"] = (command["tau_J_d"][0] + 5.0, *command["tau_J_d"][1:])
        taken = super()._absorb_within_motion_limits(command, fresh=fresh)
        if not taken:
            self.physics_sim.answered.set()  # by a reflex
        return taken

    def _dispatch_control_command(self, command, **more):
        super()._dispatch_control_command(command, **more)
        self.physics_sim.last_torque = numpy.array(command["tau_J_d"])
        self.physics_sim.answered.set()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("port", type=int)
    parser.add_argument("out")
    parser.add_argument("--start", required=True, type=lambda text: numpy.array([float(x) for x in text.split(",")]))
    parser.add_argument("--free", action="store_true")
    parser.add_argument("--provoke", choices=("torque-step", "stall", "overspeed"))
    parser.add_argument("--at", type=float, default=4.0, help="after the first torque [s]")
    parser.add_argument("--pid-file")
    parser.add_argument("--rig", help="file of the orders for the workpiece")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, stream=sys.stdout)
    sys.setswitchinterval(1e-4)  # three threads of Python share a millisecond
    mujoco_franka_sim.ARM_INITIAL_Q = arguments.start
    folder = tempfile.TemporaryDirectory()
    arm = Arm(scene.arm_xml(f"{folder.name}/fr3.xml", *([workpieces.xml()] if arguments.rig else [])), arguments)
    server = Server(host="127.0.0.1", port=arguments.port, physics_sim=arm, enable_gripper=False, enforce_comm_constraints=True, enforce_motion_limits=True)
    server.connected = server.left = False
    arm.server = server
    state_stream.time = Pace(arm)
    arm.initialize_simulation()
    server._bind_listener()
    threading.Thread(target=server.run_server, daemon=True).start()
    print("listens", flush=True)
    patience = time.monotonic() + 60
    while not server.left and (server.connected or time.monotonic() < patience):
        time.sleep(0.05)
    if arm.rig:
        arm.rig.write(arguments.out)
        os._exit(0)
    rows = {name: numpy.array(values) for name, values in arm.rows.items()}
    moving = numpy.nonzero(rows["began"])[0] if rows else []
    if len(moving):
        took = rows["wall"][moving[-1]] - rows["wall"][moving[0]]
        factor = (rows["time"][moving[-1]] - rows["time"][moving[0]]) / took
    else:
        factor = numpy.nan
    numpy.savez(
        arguments.out,
        contact_offset=0,
        speed_limit=numpy.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26]),
        waits=numpy.array(arm.waits),
        sent=len(moving),
        answered=len(moving) - int((numpy.array(arm.waits) >= 2.0).sum()),
        last_torque=arm.last_torque,
        real_time_factor=factor,
        left=server.left,
        **rows,
    )
    os._exit(0)  # the server's threads are daemons that may hold the interpreter


if __name__ == "__main__":
    main()
