"""Fills the table of docs/arm-iiwa.md from build/foreign/drake/figures.json, which run.py --all leaves.

Usage: python3 tests/foreign/drake/table.py
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "setup"))
from quotes import fill_part  # noqa: E402

figures = json.loads((ROOT / "build/foreign/drake/figures.json").read_text())
PAGE = ROOT / "docs/arm-iiwa.md"
NAMES = {
    "sine": "sine, wrench of Drake's contact 2 ms late",
    "m": "M, the same",
    "sine-no-wrench": "sine, no wrench, natural inertia",
    "m-no-wrench": "M, the same",
    "sine-heavy": "sine, no wrench, rotor inertia 0.1 kg m² and the pen a fifth heavier than believed",
    "sine-heavy-wrench": "the same with the late wrench",
    "sine-heavy-told": "the same, `arm.rotor_inertia` told",
}
lines = [
    "| drawing | contact | ink RMS, max [mm] | force mean ± SD [N] | floor's SD [N] | touchdown [N] | first 10 ms of torque [Nm] | largest joint speed of its limit | unanswered statuses |",
    "|---|---|---|---|---|---|---|---|---|",
]
for name, text in NAMES.items():
    if name not in figures:
        continue
    f = figures[name]
    floor = figures.get("slider-" + name.split("-")[0])
    lines.append(
        f"| {text} | {f['contact_fraction']:.4f} | {f['ink_error_rms']:.3f}, {f['ink_error_max']:.2f} | {f['force_mean']:.3f} ± {f['force_sd']:.3f} "
        f"| {format(floor['force_sd'], '.3f') if floor else '–'} | {f['touchdown_peak']:.2f} | {f['start_torque']:.2f} | {f['joint_speed_share']:.2f} | {f['unanswered'] - f['left']} of {f['statuses_sent']} |"
    )
if "hold" in figures:
    h = figures["hold"]
    lines += [
        "",
        f"Free-running at 1 kHz for 10 s of `arm hold`: {100 * h['answered_share']:.2f} % of {h['statuses']} statuses answered, "
        f"{h['answer_p50_ms']:.2f} ms after they were sent (median; 99 %: {h['answer_p99_ms']:.2f} ms; two cores that others use too), "
        f"drift {h['drift_rad']:.1e} rad.",
    ]
if "speed" in figures:
    s = figures["speed"]
    lines += [
        "",
        f"Real-time factor of the sine in lock-step {s['drawn']:.2f}, of a client that only replays its torques {s['replayed']:.2f}, one after the other "
        f"on {s['cores']} cores at a load of {s['load']:.1f}: Drake and the broker are what takes the time.",
    ]
if "commissioned" in figures:
    c = figures["commissioned"]
    lines += [
        "",
        f"`arm latency` and `arm friction` there: {c['delay_ms']:.1f} ms from a status to its torque, {100 * c['explained']:.1f} % of the last joint's acceleration "
        f"explained; friction of at most {c['most_friction_Nm']:.2f} Nm in any joint, where there is none.",
    ]
for name, text in (("absent", "No broker"), ("other-arm", "An FR3's model"), ("broker-killed", "Broker killed in the middle"), ("sigterm", "SIGTERM in the middle"), ("emergency", "Emergency stop in the middle"), ("shoved", "35 Nm on joint 4 in the middle"), ("stock-rate", "Statuses at Drake's stock 200 Hz")):
    if name in figures:
        lines += ["", f"{text}: `{figures[name]['stderr']}`"]
fill_part(PAGE, "drake", lines)
