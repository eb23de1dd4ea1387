"""impedraw's drawings on Drake's iiwa, judged from Drake's own log, and what happens when something is missing or dies.

Usage: .venv/bin/python tests/foreign/drake/run.py [--all] [CASE …]    (default: absent, sine, slider-sine, broker-killed, sigterm)
Exit code 0 if every bound of bounds.json and every check holds. Leaves build/foreign/drake/figures.json.
"""
import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time

import h5py
import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from judge import judge  # noqa: E402

ROOT = HERE.parents[2]
PROGRAM = ROOT / "build/release/src/app/impedraw"
DRAKE = ROOT / "build/drake-venv/bin/python"
OUT = ROOT / "build/foreign/drake"
BOUNDS = json.loads((HERE / "bounds.json").read_text())

# scenario, arguments of simulate.py
DRAWINGS = {
    "sine": ("iiwa-sine.yaml", ["--wrench"]),
    "m": ("iiwa-m.yaml", ["--wrench"]),
    "sine-no-wrench": ("iiwa-sine-no-wrench.yaml", []),
    "m-no-wrench": ("iiwa-m-no-wrench.yaml", []),
    "sine-heavy": ("iiwa-sine-no-wrench.yaml", ["--rotor", "0.1", "--pen-mass", "1.2"]),
    # No bound: what docs/arms.md says of the observer.
    "sine-heavy-wrench": ("iiwa-sine.yaml", ["--wrench", "--rotor", "0.1", "--pen-mass", "1.2"]),
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
    plan = subprocess.run(
        [PROGRAM, "plan", "--json", scenario, "--set", "arm.driver=sim", "--out", OUT / "plan"], capture_output=True, text=True, check=True
    )
    return json.loads(plan.stdout)["start_q"]


@contextlib.contextmanager
def simulation(url, file, start, arguments):
    """Drake, once it sends statuses. Ends by itself after the driver has left; killed at the end at the latest."""
    with open(file.with_suffix(".log"), "w") as log:
        process = subprocess.Popen(
            [DRAKE, HERE / "simulate.py", url, file, "--start=" + ",".join(map(repr, start)), *arguments], stdout=log, stderr=log
        )
    try:
        for _ in range(600):
            if "statuses begin" in file.with_suffix(".log").read_text():
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


def draw_arguments(scenario, url, folder):
    return [PROGRAM, "draw", scenario, "--arm", "iiwa-lcm", "--set", f"arm.url={url}", "--out", folder]


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


def require(what, holds, found=""):
    if not holds:
        raise AssertionError(f"{what}: {found}")


def one_line(text):
    return len([line for line in text.strip().splitlines() if not line.startswith("note:")]) == 1


def absent():
    """No broker: one line, a code that is not 0, and no log."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"tcpq://127.0.0.1:{free.getsockname()[1]}"
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
        journal = OUT / name / "run.journal"
        for _ in range(600):
            if journal.exists() and journal.stat().st_size > 2_000_000:
                break
            time.sleep(0.05)
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
    require("exit code", run.returncode == 128 + kind, (run.returncode, said))
    found = numpy.load(file)
    require("the last command is zero", not found["last_torque"].any(), found["last_torque"])
    require("the arm rests", abs(found["v"][-1]).max() < 0.05, found["v"][-1])
    return {"stderr": said.strip(), "seconds": took, "last_torque": 0.0}


def hold():
    """Free-running at 1 kHz: how many statuses are answered, and how soon."""
    with broker() as (url, _), simulation(url, OUT / "hold.npz", [0, 0.5, 0, -1.2, 0, 1.2, 0], ["--free", "--seconds", "10"]):
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
            urdf = OUT / f"{name}_pen.urdf"
            subprocess.run([PROGRAM, "arm", "make-urdf", "--arm", name, "--out", urdf], check=True, capture_output=True)
            run = subprocess.run([*draw_arguments(scenario, url, OUT / "other"), "--set", f"arm.urdf={urdf}"], capture_output=True, text=True)
            require("refused", run.returncode != 0 and one_line(run.stderr) and "arm.urdf" in run.stderr, run.stderr)
            said[name] = run.stderr.strip()
        drake.kill()
    return {"stderr": said["fr3"], "ur5e": said["ur5e"]}


OTHER = {
    "absent": absent,
    "other-arm": other_arm,
    "broker-killed": lambda: interrupted("broker-killed", "broker"),
    "sigint": lambda: interrupted("sigint", signal.SIGINT),
    "sigterm": lambda: interrupted("sigterm", signal.SIGTERM),
    "hold": hold,
    "speed": speed,
}
USUAL = ["absent", "sine", "slider-sine", "broker-killed", "sigterm"]
EVERY = [name for name in DRAWINGS if name in BOUNDS] + ["slider-sine", "slider-m"] + list(OTHER)


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    names = [name for name in sys.argv[1:] if name != "--all"] or (EVERY if "--all" in sys.argv or os.environ.get("IMPEDRAW_LONG") else USUAL)
    unknown = [name for name in names if name not in EVERY and name not in DRAWINGS]
    if unknown:
        sys.exit(f"run.py: no case {unknown[0]}; valid are {', '.join(dict.fromkeys([*DRAWINGS, *EVERY]))}")
    file = OUT / "figures.json"
    figures = json.loads(file.read_text()) if file.exists() else {}
    failed = 0
    for name in names:
        begin = time.perf_counter()
        try:
            found = draw(name) if name in DRAWINGS else slider(name) if name.startswith("slider-") else OTHER[name]()
        except Exception as error:  # a case that cannot run is a failed one; the others still run
            print(f"{name}: FAILED: {error}", flush=True)
            failed += 1
            continue
        missed = [f"{key} {found[key]:.4g} not in {low} to {high}" for key, (low, high) in BOUNDS.get(name, {}).items()
                  if not low <= found[key] <= high]
        failed += bool(missed)
        figures[name] = found
        file.write_text(json.dumps(figures, indent=1) + "\n")
        shown = ", ".join(f"{key} {value:.4g}" for key, value in found.items() if isinstance(value, float))
        print(f"{name}: {'FAILED: ' + '; '.join(missed) if missed else 'ok'} ({time.perf_counter() - begin:.0f} s) {shown}", flush=True)
    print(f"drake: {len(names)} cases, {failed} failed")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
