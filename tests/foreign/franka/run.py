"""impedraw's drawings on franka-sim's FR3, judged from MuJoCo's own log, and reflexes that are provoked there.

Usage: .venv/bin/python tests/foreign/franka/run.py [--all] [CASE …]    (default: absent, other-arm, sine, slider-sine)
Exit code 0 if every bound of bounds.json and every check holds. Leaves build/foreign/franka/figures.json.
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import cases  # noqa: E402
from cases import PROGRAM, ROOT, make_urdf, one_line, require, unused_port, wait_until_drawing  # noqa: E402
from judge import judge  # noqa: E402

PYTHON = ROOT / "build/franka-venv/bin/python"
OUT = ROOT / "build/foreign/franka"
BOUNDS = json.loads((HERE / "bounds.json").read_text())
PORT = unused_port()  # the real arm's is 1337
URL = f"arm.url=fci://127.0.0.1:{PORT}"
NAMES = {"torque-step": "controller_torque_discontinuity", "stall": "communication_constraints_violation", "overspeed": "joint_velocity_violation"}


def arm(name="fr3"):
    return make_urdf(name, OUT)


def start_posture(scenario):
    return cases.start_posture(scenario, OUT, "--set", f"arm.urdf={arm()}")


def simulation(file, start, arguments=()):
    command = [PYTHON, HERE / "simulate.py", str(PORT), file, "--start=" + ",".join(map(repr, start)), *arguments]
    return cases.simulation(command, file, "listens")


def draw_arguments(scenario, folder, urdf):
    return [PROGRAM, "draw", scenario, "--set", f"arm.urdf={urdf}", "--set", URL, "--out", folder, "--overwrite"]


def coverage(sim, folder):
    """Share of the target, every millimetre of it, that has MuJoCo's ink within a millimetre."""
    with h5py.File(folder / "run.h5") as log:
        target = log["/target/points"][:]
    force = numpy.linalg.norm(sim["force"], axis=1)
    ink = sim["point"][(force > 0.1) & ~numpy.isnan(sim["point"][:, 0])]
    length = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(target, axis=0), axis=1))])
    at = numpy.arange(0, length[-1], 1e-3)
    points = numpy.stack([numpy.interp(at, length, target[:, i]) for i in range(3)], axis=1)
    return float(numpy.mean([numpy.linalg.norm(ink - p, axis=1).min() < 1e-3 for p in points]))


def measure(file, folder):
    found = judge(file, folder)
    sim = numpy.load(file)
    moving = numpy.nonzero(sim["began"])[0]
    # Within a motion: the first torque of one follows on nothing.
    inside = numpy.nonzero(numpy.diff(moving) == 1)[0]
    found["torque_rate"] = float(numpy.abs(sim["torque"][moving[inside + 1]] - sim["torque"][moving[inside]]).max() * 1e3)
    settled = moving[100:]  # the rate is of the last 100 cycles
    found["success_min"] = float(sim["success"][settled].min())
    force = numpy.linalg.norm(sim["force"], axis=1)
    pressed = (force > 3) & (force < 8)
    found["stiffness"] = float(numpy.nanmedian(force[pressed] / sim["depth"][pressed]))
    reflex = numpy.nonzero(numpy.diff((sim["mode"] == 4).astype(int)) == 1)[0]
    found["reflexes"] = int(len(reflex))
    found["coverage"] = coverage(sim, pathlib.Path(folder))
    if len(reflex):
        again = moving[moving > reflex[0] + 5]
        found["recovered_s"] = float(sim["wall"][again[0]] - sim["wall"][reflex[0]]) if len(again) else float("inf")
        found["first_torque"] = float(numpy.abs(sim["torque"][again[0]]).max()) if len(again) else float("inf")
    return found


def draw(name, scenario="fr3-sine.yaml", arguments=()):
    scenario, file, folder = HERE / scenario, OUT / f"{name}.npz", OUT / name
    pid = OUT / "pid"
    with simulation(file, start_posture(scenario), [*arguments, "--pid-file", pid]):
        run = subprocess.Popen(draw_arguments(scenario, folder, arm()), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        pid.write_text(str(run.pid))
        _, said = run.communicate(timeout=300)
    if run.returncode:
        raise RuntimeError(f"impedraw ended with {run.returncode}: {said.strip()}")
    return measure(file, folder), said


def draw_seen(name, seed=None):
    """Arm, contact, clock and eyes are MuJoCo's; no model of the canvas is given."""
    scenario, capture = HERE / "fr3-eyes.yaml", OUT / f"{name}-capture"
    start = start_posture(HERE / "fr3-sine.yaml")
    shutil.rmtree(capture, ignore_errors=True)
    faults = [] if seed is None else ["--faults", str(seed)]
    subprocess.run([PYTHON, HERE / "look.py", capture, "--start=" + ",".join(map(repr, start)), *faults], check=True, capture_output=True)
    with simulation(OUT / f"{name}.npz", start):
        command = [*draw_arguments(scenario, OUT / name, arm()), "--set", f"perception.capture={capture}"]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"impedraw ended with {run.returncode}: {run.stderr.strip()}")
    (OUT / f"{name}.notes").write_text(run.stderr)
    return judge(OUT / f"{name}.npz", OUT / name, seen=True)


def provoked(kind):
    found, said = draw(kind, arguments=["--provoke", kind])
    require("the reflex is named", NAMES[kind] in said and "recovered" in said, said)
    found["stderr"] = said.strip()
    return found


def force(long=False):
    """The force benchmark, by the force of MuJoCo's contact."""
    scenario = HERE / "fr3-sine.yaml"
    start = cases.start_posture(scenario, OUT, "--set", f"arm.urdf={arm()}", *cases.FORCE_ARGUMENTS)
    return cases.judge_force(
        [PROGRAM, "judge-force", scenario, "--arm", "franka", "--set", f"arm.urdf={arm()}", "--set", URL], OUT / ("force-all" if long else "force"),
        lambda file, arguments: simulation(file, start, arguments), long,
    )  # fmt: skip


def absent():
    """Nobody there: one line, a code that is not 0, and no log."""
    folder = OUT / "absent"
    url = f"fci://127.0.0.1:{unused_port()}"
    command = draw_arguments(HERE / "fr3-sine.yaml", folder, arm())
    run = subprocess.run([*command, "--set", f"arm.url={url}"], capture_output=True, text=True)
    require("no arm", run.returncode == 3 and one_line(run.stderr), (run.returncode, run.stderr))
    require("no log", not (folder / "run.h5").exists())
    return {"stderr": run.stderr.strip()}


def other_arm():
    """The model of another arm is refused by name before anything moves: a Panda's limits, an iiwa's joints."""
    said = {}
    for name in ("panda", "iiwa14"):
        file = OUT / f"other-{name}.npz"
        with simulation(file, start_posture(HERE / "fr3-sine.yaml")):
            run = subprocess.run(draw_arguments(HERE / "fr3-sine.yaml", OUT / "other", arm(name)), capture_output=True, text=True)
        require("refused", run.returncode != 0 and one_line(run.stderr) and "another arm" in run.stderr, run.stderr)
        require("nothing moved", not numpy.load(file)["began"].any())
        said[name] = run.stderr.strip()
    return {"stderr": said["panda"], "iiwa": said["iiwa14"]}


def slider(name):
    """The floor, along the line that was drawn before."""
    with h5py.File(OUT / name / "run.h5") as log:
        target, stroke = log["/target/points"][:], log["/target/stroke"][:]
    numpy.save(OUT / "target.npy", target[stroke == 0])
    return json.loads(subprocess.run([PYTHON, HERE / "slider.py", OUT / "target.npy"], capture_output=True, text=True, check=True).stdout)


def interrupted(name, kind):
    """A signal in the middle: SIGTERM lifts the pen, SIGQUIT is the emergency stop; the last torque is zero."""
    scenario, file, folder = HERE / "fr3-sine.yaml", OUT / f"{name}.npz", OUT / name
    with simulation(file, start_posture(scenario)):
        run = subprocess.Popen(draw_arguments(scenario, folder, arm()), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        wait_until_drawing(folder)
        run.send_signal(kind)
        _, said = run.communicate(timeout=120)
    code = 3 if kind == signal.SIGQUIT else 128 + kind
    require("exit code", run.returncode == code and one_line(said), (run.returncode, said))
    require("incident", (folder / "incident.html").exists() == (kind == signal.SIGQUIT))
    found = numpy.load(file)
    require("the last torque is zero", not found["last_torque"].any(), found["last_torque"])
    return {"stderr": said.strip(), "last_torque": 0.0}


def hold():
    """Free-running: the server's own pace, answered without lock-step."""
    with simulation(OUT / "hold.npz", [0.0, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785], ["--free"]):
        run = subprocess.run(
            [PROGRAM, "arm", "hold", "--arm", "franka", "--seconds", "10", "--set", f"arm.urdf={arm()}", "--set", URL,
             "--set", "arm.max_silence=1"], capture_output=True, text=True)  # fmt: skip
    # Without lock-step, what a busy machine loses is the machine's: it is told, not judged.
    sim = numpy.load(OUT / "hold.npz")
    moving = numpy.nonzero(sim["began"])[0]
    return {
        "hold": (run.stdout + run.stderr).strip(),
        "success_mean": float(sim["success"][moving].mean()),
        "drift_rad": float(numpy.abs(sim["q"][moving[-1]] - sim["q"][moving[0]]).max()),
        "load": os.getloadavg()[0],
    }


CASES = {
    "absent": absent,
    "other-arm": other_arm,
    "sine": lambda: draw("sine")[0],
    "m": lambda: draw("m", "fr3-m.yaml")[0],
    "eyes-sine": lambda: draw_seen("eyes-sine"),
    "eyes-sine-faulty": lambda: draw_seen("eyes-sine-faulty", 1),
    "slider-sine": lambda: slider("sine"),
    "slider-m": lambda: slider("m"),
    "torque-step": lambda: provoked("torque-step"),
    "stall": lambda: provoked("stall"),
    "overspeed": lambda: provoked("overspeed"),
    "sigterm": lambda: interrupted("sigterm", signal.SIGTERM),
    "emergency": lambda: interrupted("emergency", signal.SIGQUIT),
    "hold": hold,
    "force": force,
    "force-all": lambda: force(True),
}
USUAL = ["absent", "other-arm", "sine", "slider-sine"]


if __name__ == "__main__":
    cases.main("franka", OUT, BOUNDS, CASES, USUAL, [name for name in CASES if name != "force-all"])
