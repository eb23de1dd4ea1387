"""Fills the tables of docs/force.md from force.json files: of the simulator here, of Drake's iiwa and of franka-sim's FR3.

    ./impedraw judge-force --out runs/judge-force
    tests/foreign/drake/run.py force-all        # 40 minutes
    tests/foreign/franka/run.py force-all       # 8 minutes
    python3 setup/force_tables.py
"""

import json
import pathlib

from quotes import fill_part

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/force.md"
OWN = ROOT / "runs/judge-force"
OTHERS = {"drake": ROOT / "build/foreign/drake/force-all", "franka": ROOT / "build/foreign/franka/force-all"}
JUDGED = {"settling_time": ("settling [s]", "{:.2f}"), "overshoot": ("overshoot [%]", "{:.0f}"), "steady_error": ("steady error [N]", "{:.2f}"), "sd": ("SD [N]", "{:.2f}")}  # fmt: skip
ASKED = "settling_time", "overshoot", "sd"  # in which ours is to be ahead of both


LOST = 4.5  # an error that is nearly the whole command: the pen does not press [N]


def value_of(judged: dict, metric: str) -> float | None:
    lost = (judged["mean"]["steady_error"] or 0.0) > LOST
    return None if lost and metric != "steady_error" else judged["mean"][metric]


def shown(metric: str, judged: dict) -> str:
    ended = sum("ended" in run for run in judged["runs"])
    if ended == len(judged["runs"]):
        return "ended"
    value = value_of(judged, metric)
    if value is None and judged["mean"][metric] is not None:
        return "lost"
    scale = 100 if metric == "overshoot" else 1
    return "–" if value is None else JUDGED[metric][1].format(scale * value)


def is_judged(case: dict, metric: str) -> bool:
    """Whether the case asks for this. A force that never settles has an overshoot all the same."""
    shown_by = "overshoot" if metric == "settling_time" else metric
    return any(run.get(shown_by) is not None for judged in case["controllers"] for run in judged["runs"])


def table(results: dict) -> list[str]:
    """A line for each case, in a cell ours, crisp and impedance; the best is bold."""
    lines = ["| case | " + " | ".join(name for name, _ in JUDGED.values()) + " |", "|---" * (len(JUDGED) + 1) + "|"]
    for case in results["cases"]:
        cells = []
        for metric in JUDGED:
            values = [value_of(judged, metric) for judged in case["controllers"]]
            texts = [shown(metric, judged) for judged in case["controllers"]]
            best = min((abs(v) for v in values if v is not None), default=None)
            cells.append(" · ".join(f"**{t}**" if v is not None and abs(v) == best else t for v, t in zip(values, texts)) if is_judged(case, metric) else "")
        if any(cells):
            lines.append(f"| {case['case']} | " + " | ".join(cells) + " |")
    return lines


def standing(results: dict) -> str:
    """In how many of the judged figures ours is ahead of both peers, and where it is not."""
    behind = {(b["case"], b["metric"]) for b in results["behind"]}
    judged, lacking = 0, []
    for case in results["cases"]:
        ours, *peers = case["controllers"]
        for metric in ASKED:
            values = [value_of(c, metric) for c in (ours, *peers)]
            if not is_judged(case, metric):
                continue
            judged += 1
            if (case["case"], metric) in behind or values[0] is None:
                lacking.append((metric, case["case"]))
    sweep = next(case for case in results["cases"] if case["case"] == "sweep")
    bandwidths = " · ".join(f"{judged['mean']['bandwidth']:.1f}" for judged in sweep["controllers"])
    told = "; ".join(f"{metric}: " + ", ".join(c for m, c in lacking if m == metric) for metric in ASKED if any(m == metric for m, _ in lacking))
    return f"Ours is ahead of both in {judged - len(lacking)} of {judged} figures of settling time, overshoot and SD. It is not in {told}. Bandwidth by the sweep: {bandwidths} Hz."


def main() -> None:
    own = json.loads((OWN / "force.json").read_text())
    fill_part(PAGE, "own", (OWN / "force.md").read_text().rstrip("\n").split("\n") + ["", standing(own)])
    for name, folder in OTHERS.items():
        results = json.loads((folder / "force.json").read_text())
        fill_part(PAGE, name, [*table(results), "", standing(results)])


if __name__ == "__main__":
    main()
