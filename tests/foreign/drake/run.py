"""impedraw's drawings on Drake's iiwa, judged from Drake's own log, and what happens when something is missing or dies.

Usage: .venv/bin/python tests/foreign/drake/run.py [--all] [CASE …]    (default: absent, sine, slider-sine, eyes-sine, broker-killed, sigterm)
Exit code 0 if every bound of bounds.json and every check holds. Leaves build/foreign/drake/figures.json.
"""
import contextlib
import functools
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import cases  # noqa: E402
from cases import PROGRAM, ROOT, make_urdf, one_line, require, unused_port, wait_until_drawing  # noqa: E402
from judge import bowl, judge, wave  # noqa: E402

DRAKE = ROOT / "build/drake-venv/bin/python"
OUT = ROOT / "build/foreign/drake"
CANVASES = {"bowl": bowl, "wave": wave}
BOUNDS = json.loads((HERE / "bounds.json").read_text())

# scenario, arguments of simulate.py
DRAWINGS = {
    "sine": ("iiwa-sine.yaml", ["--wrench"]),
    "m": ("iiwa-m.yaml", ["--wrench"]),
    "sine-no-wrench": ("iiwa-sine-no-wrench.yaml", []),
    "m-no-wrench": ("iiwa-m-no-wrench.yaml", []),
    "sine-heavy": ("iiwa-sine-no-wrench.yaml", ["--rotor", "0.1", "--pen-mass", "1.2"]),
    "sine-heavy-wrench": ("iiwa-sine.yaml", ["--wrench", "--rotor", "0.1", "--pen-mass", "1.2"]),
    "sine-heavy-told": ("iiwa-sine-rotors.yaml", ["--wrench", "--rotor", "0.1", "--pen-mass", "1.2"]),
}
# Drake's eyes, too: what it stands before, the drawing, and a seed for the faults of its cameras.
SEEN = {
    "eyes-sine": ("bowl", ["--shape", "sine"], None),
    "eyes-m": ("bowl", ["--shape", "M"], None),
    "eyes-text": ("wave", ["--text", "Hello"], None),
    "eyes-sine-faulty": ("bowl", ["--shape", "sine"], 1),
    "eyes-m-faulty": ("bowl", ["--shape", "M"], 2),
    "eyes-text-faulty": ("wave", ["--text", "Hello"], 3),
}


@contextlib.contextmanager
def broker():
    process = subprocess.Popen([sys.executable, HERE / "broker.py", "0"], stdout=subprocess.PIPE, text=True)
    try:
        yield f"tcpq://127.0.0.1:{int(process.stdout.readline())}", process
    finally:
        process.kill()
        process.wait()


def start_posture(scenario):
    return cases.start_posture(scenario, OUT)


def simulation(url, file, start, arguments):
    command = [DRAKE, HERE / "simulate.py", url, file, "--start=" + ",".join(map(repr, start)), *arguments]
    return cases.simulation(command, file, "statuses begin")


def draw_arguments(scenario, url, folder):
    return [PROGRAM, "draw", scenario, "--arm", "iiwa-lcm", "--set", f"arm.url={url}", "--out", folder, "--overwrite"]


def draw(name):
    scenario, arguments = DRAWINGS[name]
    scenario, file = HERE / scenario, OUT / f"{name}.npz"
    with broker() as (url, _), simulation(url, file, start_posture(scenario), arguments):
        run = subprocess.run(draw_arguments(scenario, url, OUT / name), capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"impedraw ended with {run.returncode}: {run.stderr.strip()}")
    found = judge(file, OUT / name)
    # The last status is one that comes after the driver has left.
    found["unanswered"] = found["statuses_sent"] - found["statuses_answered"]
    return found


def look(name, start, canvas, seed):
    """The capture of Drake's cameras, the arm at its start in the picture."""
    folder = OUT / f"{name}-capture"
    shutil.rmtree(folder, ignore_errors=True)
    faults = [] if seed is None else ["--faults", str(seed)]
    subprocess.run([DRAKE, HERE / "look.py", folder, "--start=" + ",".join(map(repr, start)), "--canvas", canvas, *faults], check=True, capture_output=True)
    return folder


def draw_seen(name):
    """Arm, contact, clock and eyes are Drake's; no model of the canvas is given."""
    canvas, drawing, seed = SEEN[name]
    scenario = HERE / ("iiwa-eyes.yaml" if seed is None else "iiwa-eyes-faulty.yaml")
    file, start = OUT / f"{name}.npz", start_posture(HERE / "iiwa-sine.yaml")
    capture = look(name, start, canvas, seed)
    with broker() as (url, _), simulation(url, file, start, ["--wrench", "--canvas", canvas]):
        run = subprocess.run([*draw_arguments(scenario, url, OUT / name), *drawing, "--set", f"perception.capture={capture}"], capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"impedraw ended with {run.returncode}: {run.stderr.strip()}")
    (OUT / f"{name}.notes").write_text(run.stderr)
    found = judge(file, OUT / name, CANVASES[canvas], seen=True)
    found["unanswered"] = found["statuses_sent"] - found["statuses_answered"]
    return found


def slider(name):
    drawn = OUT / name.removeprefix("slider-")
    with h5py.File(drawn / "run.h5") as log:
        target, stroke = log["/target/points"][:], log["/target/stroke"][:]
    numpy.save(OUT / "target.npy", target[stroke == 0])
    return json.loads(subprocess.run([DRAKE, HERE / "slider.py", OUT / "target.npy"], capture_output=True, text=True, check=True).stdout)


def speed():
    """Real-time factor of the sine, as a share of that with a client that only replays its torques; run one after the other."""
    drawn = draw("sine")["real_time_factor"]
    with broker() as (url, _), simulation(url, OUT / "replay.npz", start_posture(HERE / "iiwa-sine.yaml"), ["--wrench"]):
        subprocess.run([DRAKE, HERE / "replay.py", url, OUT / "sine.npz"], check=True, capture_output=True)
    replayed = float(numpy.load(OUT / "replay.npz")["real_time_factor"])
    return {"drawn": drawn, "replayed": replayed, "share": drawn / replayed, "cores": os.cpu_count(), "load": os.getloadavg()[0]}


def force(long=False):
    """The force benchmark, by the force of Drake's contact, with the law of scenarios/force-benchmark.yaml."""
    scenario, law = HERE / "iiwa-sine.yaml", ("--set", "control.inertia=shaped", "--set", "control.damping_ratio=1.4")
    start = cases.start_posture(scenario, OUT, *cases.FORCE_ARGUMENTS)
    with broker() as (url, _):
        return cases.judge_force(
            [PROGRAM, "judge-force", scenario, "--arm", "iiwa-lcm", "--set", f"arm.url={url}", *law], OUT / ("force-all" if long else "force"),
            lambda file, arguments: simulation(url, file, start, ["--wrench", "--rotor", "0.1", *arguments]), long,
        )  # fmt: skip


def absent():
    """No broker: one line, a code that is not 0, and no log."""
    url = f"tcpq://127.0.0.1:{unused_port()}"
    with tempfile.TemporaryDirectory() as folder:
        for command in (draw_arguments(HERE / "iiwa-sine.yaml", url, f"{folder}/run"), [PROGRAM, "arm", "check", "--set", f"arm.url={url}"]):
            run = subprocess.run(command, capture_output=True, text=True)
            require("no broker", run.returncode == 3 and one_line(run.stderr), (run.returncode, run.stderr))
        require("no broker", not pathlib.Path(folder, "run/run.h5").exists())
    return {"stderr": run.stderr.strip()}


def interrupted(name, kind):
    """Killed in the middle of the drawing: the broker, or the driver by a signal."""
    scenario, file = HERE / "iiwa-sine.yaml", OUT / f"{name}.npz"
    with broker() as (url, process), simulation(url, file, start_posture(scenario), ["--wrench"]) as drake:
        run = subprocess.Popen(draw_arguments(scenario, url, OUT / name), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        wait_until_drawing(OUT / name)
        require("the drawing began", run.poll() is None)
        if kind == "broker":
            process.kill()
        else:
            run.send_signal(kind)
        began = time.perf_counter()
        _, said = run.communicate(timeout=120)
        took = time.perf_counter() - began
        if kind == "broker":
            drake.kill()
    require("one line", one_line(said), said)
    if kind == "broker":
        require("exit code 3", run.returncode == 3, run.returncode)
        return {"stderr": said.strip()}
    emergency = kind == signal.SIGQUIT
    require("exit code", run.returncode == (3 if emergency else 128 + kind), (run.returncode, said))
    if emergency:
        require("named", "emergency stop" in said, said)
        require("an incident is left", (OUT / name / "incident.html").exists())
    found = numpy.load(file)
    require("the last command is zero", not found["last_torque"].any(), found["last_torque"])
    require("the arm rests", abs(found["v"][-1]).max() < 0.05, found["v"][-1])
    return {"stderr": said.strip(), "seconds": took, "last_torque": 0.0}


def hold():
    """Free-running at 1 kHz: how many statuses are answered, and how soon."""
    with broker() as (url, process), simulation(url, OUT / "hold.npz", [0, 0.5, 0, -1.2, 0, 1.2, 0], ["--free", "--seconds", "10"]) as drake:
        # What stands for the arm and its network is given the priority that the loop asks for.
        for other in (process, drake):
            with contextlib.suppress(PermissionError):
                os.sched_setscheduler(other.pid, os.SCHED_FIFO, os.sched_param(50))
        check = subprocess.run([PROGRAM, "arm", "check", "--seconds", "2", "--set", f"arm.url={url}"], capture_output=True, text=True)
        run = subprocess.run([PROGRAM, "arm", "hold", "--seconds", "12", "--set", f"arm.url={url}", "--set", "arm.max_silence=1"],
                             capture_output=True, text=True)
    found = numpy.load(OUT / "hold.npz")
    delays = found["delays"]
    return {
        "check": check.stdout.strip().splitlines(),
        "hold": (run.stdout + run.stderr).strip().splitlines(),
        "statuses": int(found["sent"]),
        "answered_share": float(found["answered"] / found["sent"]),
        "answer_p50_ms": float(1e3 * numpy.percentile(delays, 50)),
        "answer_p99_ms": float(1e3 * numpy.percentile(delays, 99)),
        "drift_rad": float(abs(found["q"][-1] - found["q"][0]).max()),
    }


def other_arm():
    """The model of another arm is refused by name before anything is sent: a joint's range of an FR3, six joints of a UR5e."""
    scenario, said = HERE / "iiwa-sine.yaml", {}
    with broker() as (url, _), simulation(url, OUT / "other.npz", start_posture(scenario), ["--wrench", "--seconds", "1"]) as drake:
        for name in ("fr3", "ur5e"):
            urdf = make_urdf(name, OUT)
            run = subprocess.run([*draw_arguments(scenario, url, OUT / "other"), "--set", f"arm.urdf={urdf}"], capture_output=True, text=True)
            require("refused", run.returncode != 0 and one_line(run.stderr) and "arm.urdf" in run.stderr, run.stderr)
            said[name] = run.stderr.strip()
        drake.kill()
    return {"stderr": said["fr3"], "ur5e": said["ur5e"]}


def shoved():
    """Somebody leans on joint 4: the driver ends the session by name before the arm's own does at 30 Nm, damped, and zero comes last."""
    scenario, file = HERE / "iiwa-sine.yaml", OUT / "shoved.npz"
    with broker() as (url, _), simulation(url, file, start_posture(scenario), ["--wrench", "--shove", "35"]):
        run = subprocess.run(draw_arguments(scenario, url, OUT / "shoved"), capture_output=True, text=True)
    require("a fault", run.returncode == 3 and one_line(run.stderr), (run.returncode, run.stderr))
    require("by name", "an external torque of" in run.stderr and "on joint 4" in run.stderr, run.stderr)
    found = numpy.load(file)
    require("the last command is zero", not found["last_torque"].any(), found["last_torque"])
    return {"stderr": run.stderr.strip(), "last_torque": 0.0}


def commissioned():
    """The commissioning commands move Drake's arm: its delay is found, friction of which it has none, and where its tip rests."""
    scenario, folder = HERE / "iiwa-sine-no-wrench.yaml", OUT / "commissioning"
    shutil.rmtree(folder, ignore_errors=True)

    def step(name, *arguments):
        with broker() as (url, _), simulation(url, OUT / f"commission-{name}.npz", start_posture(scenario), []):
            run = subprocess.run(
                [PROGRAM, "arm", name, scenario, "--arm", "iiwa-lcm", "--set", f"arm.url={url}", "--into", folder, *arguments],
                capture_output=True, text=True)  # fmt: skip
        require(name, run.returncode == 0, run.stderr)

    for name in ("latency", "friction"):
        step(name)
    found = json.loads((folder / "commissioning.json").read_text())
    return {
        "delay_ms": 1e3 * found["latency"]["delay_s"],
        "explained": found["latency"]["explained"],
        "most_friction_Nm": max(abs(joint["coulomb_Nm"]) for joint in found["friction"]),
    }


def stock_rate():
    """Drake's iiwa at its stock 200 Hz: refused with the reason, and no torque is sent."""
    scenario, file = HERE / "iiwa-sine.yaml", OUT / "stock-rate.npz"
    with broker() as (url, _), simulation(url, file, start_posture(scenario), ["--rate", "200", "--seconds", "1"]) as drake:
        run = subprocess.run(draw_arguments(scenario, url, OUT / "stock-rate"), capture_output=True, text=True)
        require("refused", run.returncode == 3 and one_line(run.stderr), (run.returncode, run.stderr))
        require("with the reason", "200" in run.stderr or "5.0" in run.stderr, run.stderr)
        check = subprocess.run([PROGRAM, "arm", "check", "--seconds", "1", "--set", f"arm.url={url}"], capture_output=True, text=True)
        require("arm check tells, too", check.returncode == 1 and "draw is refused" in check.stderr, (check.returncode, check.stderr))
        require("nothing was sent", drake.poll() is None)
        drake.kill()
    return {"stderr": run.stderr.strip(), "check": check.stderr.strip()}


CASES = {
    **{name: functools.partial(draw, name) for name in DRAWINGS},
    **{name: functools.partial(draw_seen, name) for name in SEEN},
    **{name: functools.partial(slider, name) for name in ("slider-sine", "slider-m")},
    "absent": absent,
    "other-arm": other_arm,
    "broker-killed": lambda: interrupted("broker-killed", "broker"),
    "sigint": lambda: interrupted("sigint", signal.SIGINT),
    "sigterm": lambda: interrupted("sigterm", signal.SIGTERM),
    "emergency": lambda: interrupted("emergency", signal.SIGQUIT),
    "commissioned": commissioned,
    "shoved": shoved,
    "stock-rate": stock_rate,
    "hold": hold,
    "force": force,
    "force-all": lambda: force(True),
    "speed": speed,
}
USUAL = ["absent", "sine", "slider-sine", "eyes-sine", "broker-killed", "sigterm"]
EVERY = [name for name in CASES if name in BOUNDS or name not in DRAWINGS and name != "force-all"]

if __name__ == "__main__":
    cases.main("drake", OUT, BOUNDS, CASES, USUAL, EVERY)
