"""impedraw's drawings on franka-sim's FR3, judged from MuJoCo's own log, and reflexes that are provoked there.

Usage: .venv/bin/python tests/foreign/franka/run.py [--all] [CASE …]    (default: absent, other-arm, sine)
Exit code 0 if every bound of bounds.json and every check holds. Leaves build/foreign/franka/figures.json.
"""
import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time

import h5py
import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from judge import judge  # noqa: E402

ROOT = HERE.parents[2]
PROGRAM = ROOT / "build/release/src/app/impedraw"
PYTHON = ROOT / "build/franka-venv/bin/python"
OUT = ROOT / "build/foreign/franka"
BOUNDS = json.loads((HERE / "bounds.json").read_text())
with socket.socket() as free:  # the real arm's port is 1337
    free.bind(("127.0.0.1", 0))
    PORT = free.getsockname()[1]
URL = f"arm.url=fci://127.0.0.1:{PORT}"
NAMES = {"torque-step": "controller_torque_discontinuity", "stall": "communication_constraints_violation", "overspeed": "joint_velocity_violation"}


def arm(name="fr3"):
    file = OUT / f"{name}_pen.urdf"
    subprocess.run([PROGRAM, "arm", "make-urdf", "--arm", name, "--out", file], check=True, capture_output=True)
    return file


def start_posture(scenario):
    plan = subprocess.run(
        [PROGRAM, "plan", "--json", scenario, "--set", "arm.driver=sim", "--set", f"arm.urdf={arm()}", "--out", OUT / "plan"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(plan.stdout)["start_q"]


@contextlib.contextmanager
def simulation(file, start, arguments=()):
    """The server, once it listens. Ends by itself after the driver has left; killed at the end at the latest."""
    with open(file.with_suffix(".log"), "w") as log:
        process = subprocess.Popen(
            [PYTHON, HERE / "simulate.py", str(PORT), file, "--start=" + ",".join(map(repr, start)), *arguments], stdout=log, stderr=log
        )
    try:
        for _ in range(600):
            if "listens" in file.with_suffix(".log").read_text():
                break
            if process.poll() is not None:
                raise RuntimeError("simulate.py ended: " + file.with_suffix(".log").read_text()[-500:])
            time.sleep(0.1)
        yield process
        if process.poll() is None:
            process.wait(60)
    finally:
        process.kill()
        process.wait()


def draw_arguments(scenario, folder, urdf):
    return [PROGRAM, "draw", scenario, "--set", f"arm.urdf={urdf}", "--set", URL, "--out", folder]


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


def provoked(kind):
    found, said = draw(kind, arguments=["--provoke", kind])
    require("the reflex is named", NAMES[kind] in said and "recovered" in said, said)
    found["stderr"] = said.strip()
    return found


def require(what, holds, found=""):
    if not holds:
        raise AssertionError(f"{what}: {found}")


def one_line(text):
    return len([line for line in text.strip().splitlines() if not line.startswith("note:")]) == 1


def absent():
    """Nobody there: one line, a code that is not 0, and no log."""
    folder = OUT / "absent"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"fci://127.0.0.1:{free.getsockname()[1]}"
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


def sigterm():
    """SIGTERM in the middle: the pen is lifted, the last torque is zero."""
    scenario, file, folder = HERE / "fr3-sine.yaml", OUT / "sigterm.npz", OUT / "sigterm"
    with simulation(file, start_posture(scenario)):
        run = subprocess.Popen(draw_arguments(scenario, folder, arm()), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        journal = folder / "run.journal"
        for _ in range(600):
            if journal.exists() and journal.stat().st_size > 2_000_000:
                break
            time.sleep(0.05)
        run.send_signal(signal.SIGTERM)
        _, said = run.communicate(timeout=120)
    require("exit code", run.returncode == 128 + signal.SIGTERM and one_line(said), (run.returncode, said))
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
    "torque-step": lambda: provoked("torque-step"),
    "stall": lambda: provoked("stall"),
    "overspeed": lambda: provoked("overspeed"),
    "sigterm": sigterm,
    "hold": hold,
}
USUAL = ["absent", "other-arm", "sine"]


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    names = [n for n in sys.argv[1:] if n != "--all"] or (list(CASES) if "--all" in sys.argv or os.environ.get("IMPEDRAW_LONG") else USUAL)
    unknown = [name for name in names if name not in CASES]
    if unknown:
        sys.exit(f"run.py: no case {unknown[0]}; valid are {', '.join(CASES)}")
    file = OUT / "figures.json"
    figures = json.loads(file.read_text()) if file.exists() else {}
    failed = 0
    for name in names:
        begin = time.perf_counter()
        try:
            found = CASES[name]()
        except Exception as error:  # a case that cannot run is a failed one; the others still run
            print(f"{name}: FAILED: {error}", flush=True)
            failed += 1
            continue
        missed = [f"{key} {found[key]:.4g} not in {low} to {high}" for key, (low, high) in BOUNDS.get(name, {}).items()
                  if not low <= found[key] <= high]  # fmt: skip
        failed += bool(missed)
        figures[name] = found
        file.write_text(json.dumps(figures, indent=1) + "\n")
        shown = ", ".join(f"{key} {value:.4g}" for key, value in found.items() if isinstance(value, float))
        print(f"{name}: {'FAILED: ' + '; '.join(missed) if missed else 'ok'} ({time.perf_counter() - begin:.0f} s) {shown}", flush=True)
    print(f"franka: {len(names)} cases, {failed} failed")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
