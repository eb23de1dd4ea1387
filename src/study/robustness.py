"""Draws robustness.csv: ink error and force against slope, speed, force and each model error.

Arguments: the CSV, the PNG. Above, the matrix: one line for each pair of the other two settings, the one through 50 mm/s, 30° and 5 N
strong. Below, each error alone on the standard sine. A cross: that cell failed; at the top edge, without a figure.
"""

import csv
import logging
import math
import re
import sys

import matplotlib

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # no word of its list of fonts
matplotlib.use("agg")
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

NOMINAL, REALISTIC, FORCE, FAILED = "#173d85", "#d9822b", "#2e8b6f", "#b3261e"
ERROR, SD = "ink_error_rms", "force_sd"
IN_EVERY_CELL = {"drawing.redraw=false", "preflight.arm=false"}
TITLES = {ERROR: "ink error, RMS [mm]", SD: "normal force, standard deviation [N]"}
UNITS = {
    "mass_scale": "", "centre_shift": "mm", "joint_friction": "Nm", "viscous_friction": "Nm s/rad", "rotor_inertia": "kg m²",
    "torque_ripple": "Nm", "torque_quantum": "Nm", "loop_delay": "ms", "pen_longer": "mm", "friction": "", "stiffness": "N/m",
    "sigma_at_1m": "mm", "noise_force": "N", "drift_force": "N/min", "delay": "ms",
}

matplotlib.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#8a9099",
    "axes.labelcolor": "#20242a", "xtick.color": "#5a616b", "ytick.color": "#5a616b", "axes.grid": True, "grid.color": "#e3e6ea",
    "grid.linewidth": 0.7, "axes.axisbelow": True, "legend.frameon": False, "legend.fontsize": 9,
})


def number(text):
    try:
        return float(text)
    except ValueError:
        return math.nan


class Cell:
    def __init__(self, row):
        self.row, self.name, self.failed, self.realistic = row, row["cell"], row["failed"] == "1", row["realistic"] == "1"
        # A refused cell has no measured slope, so the slope is taken from its name.
        named = re.fullmatch(r"matrix-\w+-(\d+)mm_s-(\d+)deg-(\d+)N", self.name)
        self.at = dict(zip(("speed", "slope", "push"), map(float, named.groups()))) if named else {}

        self.changed = [a for a in self.row["set"].split("; ") if a and a not in IN_EVERY_CELL]

    def value(self, metric):
        return number(self.row[metric])


def log_axes(axes, cells, metrics):
    """Widens the axis so that crosses fit."""
    values = [v for c in cells for m in metrics if (v := c.value(m)) > 0]
    low, high = min(values, default=1e-3), max(values, default=1)
    axes.set_yscale("log")
    axes.set_ylim(10 ** math.floor(math.log10(low)), 10 ** math.ceil(math.log10(high) + 0.15))


def plot_line(axes, cells, x, metric, **style):
    """Draws a line through the cells that held, and crosses for those that failed."""
    good = [(x(c), c.value(metric)) for c in cells]
    axes.plot([p for p, _ in good], [v for _, v in good], **style)
    for c in cells:
        if c.failed and c.value(metric) > 0:
            axes.plot(x(c), c.value(metric), "x", color=FAILED, markersize=6, markeredgewidth=1.6, zorder=5)
        elif c.failed:
            axes.plot(x(c), 0.965, "x", color=FAILED, markersize=6, markeredgewidth=1.6, zorder=5, transform=axes.get_xaxis_transform())


def matrix_panel(axes, cells, along, metric):
    usual = {"speed": 50.0, "slope": 30.0, "push": 5.0}
    others = [k for k in usual if k != along]
    for realistic, colour in ((False, NOMINAL), (True, REALISTIC)):
        lines = {}
        for c in cells:
            if c.realistic == realistic:
                lines.setdefault(tuple(c.at[k] for k in others), []).append(c)
        for key, line in lines.items():
            line.sort(key=lambda c: c.at[along])
            main = all(v == usual[k] for v, k in zip(key, others))
            plot_line(axes, line, lambda c: c.at[along], metric, color=colour, alpha=1 if main else 0.22, linewidth=2 if main else 0.8,
                      marker="o" if main else None, markersize=4, zorder=3 if main else 2)
    if along != "slope":
        axes.set_xscale("log")
    ticks = sorted({c.at[along] for c in cells})
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.set_xlabel({"speed": "speed [mm/s]", "slope": "slope [deg]", "push": "push [N]"}[along])


def value_text(v):
    if v >= 1e4:
        power = math.floor(math.log10(v) + 1e-9)
        return f"$10^{power}$" if abs(v / 10**power - 1) < 1e-9 else f"${v / 10**power:g}·10^{power}$"
    return f"{v:g}".replace("-", "−")


def error_panel(axes, setting, cells, normal):
    short = setting.split(".")[-1]
    scale = 1e3 if UNITS.get(short) in ("mm", "ms") else 1.0  # settings are in m and s

    def x(c):
        return scale * number(c.row[setting])

    cells = sorted([*cells, *([normal] if normal else [])], key=x)
    log_axes(axes, cells, (ERROR, SD))
    plot_line(axes, cells, x, ERROR, color=NOMINAL, linewidth=1.6, marker="o", markersize=3.5)
    plot_line(axes, cells, x, SD, color=FORCE, linewidth=1.6, marker="s", markersize=3.5)
    values = [x(c) for c in cells]
    if min(values) > 0 and max(values) / min(values) > 100:
        axes.set_xscale("log")
        axes.minorticks_off()
    places = [axes.transData.transform((v, 1))[0] for v in values]
    narrow = [i + 1 < len(places) and places[i + 1] - places[i] < 0.11 * (places[-1] - places[0]) for i in range(len(places))]
    hidden = {i + 1 if i == 0 else i for i, n in enumerate(narrow) if n}  # labels that would overlap a neighbour's
    axes.set_xticks(values, ["" if i in hidden else value_text(v) for i, v in enumerate(values)])
    axes.set_ylim(1e-3, 30)
    unit = f" [{UNITS[short]}]" if UNITS.get(short) else ""
    label = {"friction": "friction of the tip", "stiffness": "stiffness of the tip", "delay": "delay of the sensor",
             "noise_force": "noise of the sensor", "drift_force": "drift of the sensor", "sigma_at_1m": "depth noise at 1 m",
             "loop_delay": "loop delay", "pen_longer": "pen longer than modelled", "mass_scale": "true mass over modelled mass",
             "centre_shift": "shift of the centres of mass", "rotor_inertia": "rotor inertia", "torque_ripple": "torque ripple",
             "torque_quantum": "torque quantum", "joint_friction": "dry joint friction",
             "viscous_friction": "viscous joint friction"}.get(short, short)
    axes.set_title(label + unit, loc="left", fontsize=9.5, color="#20242a", pad=5)
    if normal:
        axes.axvline(x(normal), color="#b9bec6", linewidth=0.9, linestyle=(0, (3, 2)), zorder=1)


def changed_setting(cell):
    return cell.changed[0].split("=")[0] if len(cell.changed) == 1 else None


def picture(rows):
    cells = [Cell(r) for r in rows]
    matrix = [c for c in cells if c.row["group"] == "matrix" and c.at]
    errors = {}
    for c in cells:
        if c.row["group"] == "error" and (setting := changed_setting(c)):
            errors.setdefault(setting, []).append(c)
    normals = {c.row["base"]: c for c in cells if c.row["group"] == "error" and not c.changed}
    columns, below = 4, -(-len(errors) // 4)
    height = 7.9 + 2.35 * below
    figure = Figure(figsize=(13.2, height))
    upper = figure.add_gridspec(2, 3, left=0.05, right=0.99, top=1 - 0.75 / height, bottom=1 - 6.9 / height, hspace=0.36, wspace=0.14)
    for row, metric in enumerate((ERROR, SD)):
        for column, along in enumerate(("slope", "speed", "push")):
            axes = figure.add_subplot(upper[row, column])
            if matrix:
                log_axes(axes, matrix, (metric,))
                matrix_panel(axes, matrix, along, metric)
            axes.set_title(TITLES[metric], loc="left", fontsize=9.5, color="#20242a", pad=5)
    cross = Line2D([], [], linestyle="", marker="x", color=FAILED, markeredgewidth=1.6, label="failed (top edge: no figure)")
    figure.legend(handles=[Line2D([], [], color=NOMINAL, marker="o", markersize=4, label="nominal"),
                           Line2D([], [], color=REALISTIC, marker="o", markersize=4, label="realistic"),
                           Line2D([], [], color="#20242a", linewidth=2, label="at 50 mm/s, 30°, 5 N"),
                           Line2D([], [], color="#20242a", linewidth=0.8, alpha=0.35, label="each other pair"), cross],
                  loc="upper left", bbox_to_anchor=(0.04, 1 - 0.05 / height), ncols=5)
    if errors:
        lower = figure.add_gridspec(below, columns, left=0.05, right=0.99, top=1 - 8.25 / height, bottom=0.35 / height, hspace=0.45,
                                    wspace=0.2)
        figure.legend(handles=[Line2D([], [], color=NOMINAL, marker="o", markersize=4, label=TITLES[ERROR]),
                               Line2D([], [], color=FORCE, marker="s", markersize=4, label=TITLES[SD]),
                               Line2D([], [], color="#b9bec6", linestyle=(0, (3, 2)), label="no model error"), cross],
                      loc="upper left", bbox_to_anchor=(0.04, 1 - 7.45 / height), ncols=4,
                      title="Each model error alone, on the sine in the bowl at 50 mm/s and 5 N", alignment="left",
                      title_fontproperties={"weight": "bold", "size": 9.5})
        for i, (setting, of_it) in enumerate(errors.items()):
            error_panel(figure.add_subplot(lower[i // columns, i % columns]), setting, of_it, normals.get(of_it[0].row["base"]))
    return figure


def main():
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    picture(rows).savefig(sys.argv[2], dpi=110)


main()
