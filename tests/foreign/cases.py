"""What the cases against each foreign simulator share: impedraw's program, a simulator beside it, checks, bounds and figures."""
import contextlib
import json
import os
import pathlib
import socket
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/src/app/impedraw"


def unused_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def make_urdf(name, folder):
    file = folder / f"{name}_pen.urdf"
    subprocess.run([PROGRAM, "arm", "make-urdf", "--arm", name, "--out", file], check=True, capture_output=True)
    return file


def start_posture(scenario, out, *arguments):
    plan = subprocess.run(
        [PROGRAM, "plan", "--json", scenario, "--set", "arm.driver=sim", *arguments, "--out", out / "plan"], capture_output=True, text=True, check=True
    )
    return json.loads(plan.stdout)["start_q"]


@contextlib.contextmanager
def simulation(command, file, ready):
    """The simulator, once its log says `ready`. Ends by itself after the driver has left; killed at the end at the latest."""
    with open(file.with_suffix(".log"), "w") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log)
    try:
        for _ in range(600):
            if ready in file.with_suffix(".log").read_text():
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


def wait_until_drawing(folder):
    """Until the journal shows that the drawing is well under way."""
    journal = folder / "run.journal"
    for _ in range(600):
        if journal.exists() and journal.stat().st_size > 2_000_000:
            break
        time.sleep(0.05)


# A workpiece of each kind: one that stands, one that slides, one that gives way, an edge; and a hand.
FORCE_CASES = "contact-10,steps,hold-still,hold-sliding,hold-stiffening,edged-25,hand-across"
FORCE_ARGUMENTS = ("--set", "arm.start=[0.6,0,0.13]", "--set", "arm.rotor_inertia=0.1")


# Every case. After the last one the arm may not be usable: a peer's joint nears its rated speed at the edge, and an FR3 does not always recover.
FORCE_SESSIONS = (
    "contact-10,contact-30,contact-100,steps,ramps,sweep,hold-still,hold-sliding,hold-tilting,hold-stiffening",
    "straight-50,straight-150,curved-50,curved-150,edged-25,hand-across,hand-lifting",
    "edged-75",
)


def merged(parts):
    """Results of several sessions as those of one."""
    whole = parts[0]
    for part in parts[1:]:
        for key in ("cases", "behind"):
            whole[key] += part[key]
    return whole


def judge_force(command, out, simulation, long=False):
    """The force benchmark's figures, by a sensor under the workpiece: of each case and controller, the mean of steady_error, sd and overshoot.
    `simulation`: of a readings' file and arguments. `long`: every case, five runs; else one run of FORCE_CASES."""
    out.mkdir(exist_ok=True)
    orders, readings, parts = out / "orders.json", out / "sensor.csv", []
    for names in FORCE_SESSIONS if long else (FORCE_CASES,):
        for file in (orders, readings):
            file.unlink(missing_ok=True)
        which = ["--cases", names, "--runs", "5" if long else "1", "--rig", orders, "--sensor", readings, "--out", out]
        with simulation(readings, ["--rig", orders]), open(out / "judge.log", "w") as log:
            run = subprocess.run([*command, *which, *FORCE_ARGUMENTS], stdout=log, stderr=log)
        if run.returncode and names != FORCE_SESSIONS[-1]:
            raise RuntimeError(f"judge-force ended with {run.returncode}: {(out / 'judge.log').read_text().strip()[-500:]}")
        parts.append(json.loads((out / "force.json").read_text()))
        require("every case", len(parts[-1]["cases"]) == len(names.split(",")), len(parts[-1]["cases"]))
    results, found = merged(parts), {}
    (out / "force.json").write_text(json.dumps(results, indent=1) + "\n")
    for case in results["cases"]:
        for judged in case["controllers"]:
            if judged["controller"] == "ours":
                require(f"each run of {case['case']} is whole", all("ended" not in run for run in judged["runs"]), judged["runs"])
            for metric in ("steady_error", "sd", "overshoot"):
                if judged["mean"][metric] is not None:
                    found[f"{case['case']}.{judged['controller']}.{metric}"] = judged["mean"][metric]
    return found


def require(what, holds, found=""):
    if not holds:
        raise AssertionError(f"{what}: {found}")


def one_line(text):
    return len([line for line in text.strip().splitlines() if not line.startswith("note:")]) == 1


def main(simulator, out, bounds, cases, usual, every):
    """Runs the cases that the command line names, by default the usual ones. `cases`: a function for each name."""
    out.mkdir(parents=True, exist_ok=True)
    names = [name for name in sys.argv[1:] if name != "--all"] or (every if "--all" in sys.argv or os.environ.get("IMPEDRAW_LONG") else usual)
    unknown = [name for name in names if name not in cases]
    if unknown:
        sys.exit(f"run.py: no case {unknown[0]}; valid are {', '.join(cases)}")
    file = out / "figures.json"
    figures = json.loads(file.read_text()) if file.exists() else {}
    failed = 0
    for name in names:
        begin = time.perf_counter()
        try:
            found = cases[name]()
        except Exception as error:  # a case that cannot run is a failed one; the others still run
            print(f"{name}: FAILED: {error}", flush=True)
            failed += 1
            continue
        missed = [f"{key} {found[key]:.4g} not in {low} to {high}" for key, (low, high) in bounds.get(name, {}).items()
                  if not low <= found[key] <= high]  # fmt: skip
        failed += bool(missed)
        figures[name] = found
        file.write_text(json.dumps(figures, indent=1) + "\n")
        shown = ", ".join(f"{key} {value:.4g}" for key, value in found.items() if isinstance(value, float))
        print(f"{name}: {'FAILED: ' + '; '.join(missed) if missed else 'ok'} ({time.perf_counter() - begin:.0f} s) {shown}", flush=True)
    print(f"{simulator}: {len(names)} cases, {failed} failed")
    sys.exit(bool(failed))
