"""Fills the table of docs/arm-franka.md from build/foreign/franka/figures.json, which run.py --all leaves.

Usage: python3 tests/foreign/franka/table.py
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "setup"))
from quotes import fill_part  # noqa: E402

PAGE = ROOT / "docs/arm-franka.md"
figures = json.loads((ROOT / "build/foreign/franka/figures.json").read_text())
lines = [
    "| drawing | contact | ink RMS, max [mm] | force median, SD [N] | touchdown [N] | largest torque rate [Nm/s] | first 10 ms of torque [Nm] | command success, least | largest joint speed of its limit |",
    "|---|---|---|---|---|---|---|---|---|",
]
for name in ("sine", "m"):
    f = figures[name]
    lines.append(
        f"| {'sine' if name == 'sine' else 'M'}, no wrench, natural inertia | {f['contact_fraction']:.4f} | {f['ink_error_rms']:.3f}, {f['ink_error_max']:.2f} "
        f"| {f['force_median']:.3f}, {f['force_sd']:.3f} | {f['touchdown_peak']:.2f} | {f['torque_rate']:.0f} | {f['start_torque']:.2f} | {f['success_min']:.2f} "
        f"| {f['joint_speed_share']:.2f} |"
    )
lines += [
    "",
    f"The tip felt a stiffness of {figures['sine']['stiffness'] / 1e3:.1f} kN/m. No reflex in either.",
    "",
    "| provoked in the simulator, 4 s after the first torque | the arm's name for it | first torque again after [s] | that torque [Nm] | ink RMS, max [mm] | of the target with ink |",
    "|---|---|---|---|---|---|",
]
for name, text in (
    ("torque-step", "5 Nm more in one command"),
    ("stall", "the program stopped for 60 cycles (SIGSTOP)"),
    ("overspeed", "80 Nm on the first joint"),
):
    f = figures[name]
    reflex = f["stderr"].split("reflex ")[1].split(" (")[0]
    lines.append(
        f"| {text} | `{reflex}` | {f['recovered_s']:.1f} | {f['first_torque']:.2f} | {f['ink_error_rms']:.3f}, {f['ink_error_max']:.2f} | {f['coverage']:.3f} |"
    )
lines += ["", "Of the time until the first torque, 0.7 s is franka-sim's own wait for a standstill; a busy machine's two cores did the rest."]
if "slider-sine" in figures:
    f = figures["slider-sine"]
    lines += ["", f"The floor, an ideal slider of 3 kg along the same line: {f['force_median']:.3f} N (median), SD {f['force_sd']:.3f} N, contact {f['contact_fraction']:.4f}."]
for name, text in (("absent", "No arm"), ("other-arm", "A Panda's model"), ("sigterm", "SIGTERM in the middle"), ("emergency", "Emergency stop in the middle")):
    if name in figures:
        lines += ["", f"{text}: `{figures[name]['stderr']}`"]
if "hold" in figures:
    h = figures["hold"]
    lines += ["", f"Free-running, `arm hold` for 10 s at a load of {h['load']:.1f} on two cores: `{h['hold']}`; {100 * h['success_mean']:.1f} % of the commands in time, drift {h['drift_rad']:.1e} rad."]
fill_part(PAGE, "franka", lines)
