"""Draws reach.csv: the ink of each combination of drawing and canvas, with its figures.

Arguments: the CSV, the PNG. The ink is read from ink/CELL.json beside the CSV (src/app/reach_picture.h). A row a drawing, a column a canvas;
a red frame: a limit was missed.
"""

import csv
import json
import logging
import sys
from pathlib import Path

import matplotlib

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # no word of its list of fonts
matplotlib.use("agg")
import numpy as np  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

INK, LACKING, UNDRAWABLE, TEXT, FRAME = "#173d85", "#b3261e", "#e08a1e", "#20242a", "#b9bec6"
matplotlib.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "text.color": TEXT})


def in_order(rows, column):
    return list(dict.fromkeys(row[column] for row in rows))


def lines(axes, of, colour, width, order):
    axes.add_collection(LineCollection([np.array(line) for line in of if len(line) > 1], colors=colour, linewidths=width, zorder=order,
                                       capstyle="round"))
    dots = np.array([line[0] for line in of if len(line) == 1])
    if dots.size:
        axes.plot(dots[:, 0], dots[:, 1], ".", color=colour, markersize=2 * width, zorder=order)


def caption(row):
    if not row["coverage"]:
        return "nothing to draw" if row["verdict"] == "nothing" else row["verdict"]
    error = f"{float(row['rms_to_45']):.3f} mm" if row["rms_to_45"] else "– mm"
    return f"{error}  {float(row['coverage']):.4f}"


def small_picture(axes, row, folder):
    missed = row["failed"] == "1"
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set(color=LACKING if missed else FRAME, linewidth=2 if missed else 0.6)
    axes.set_xlabel(caption(row), fontsize=8.5, labelpad=2, color=LACKING if missed else TEXT)
    file = folder / "ink" / f"{row['cell']}.json"
    if not file.exists():
        return
    picture = json.loads(file.read_text(encoding="utf-8"))
    shade = np.array([[np.nan if v is None else v for v in r] for r in picture["shade"]], dtype=float)
    axes.imshow(shade, extent=picture["area"], cmap="gray", vmin=-350, vmax=265, interpolation="bilinear", zorder=0)
    lines(axes, picture["undrawable"], UNDRAWABLE, 0.9, 2)
    lines(axes, picture["promised"], LACKING, 0.5, 3)
    lines(axes, picture["ink"], INK, 0.9, 4)
    axes.set_xlim(picture["area"][:2])
    axes.set_ylim(picture["area"][2:])
    axes.set_aspect("equal")


def picture(rows, folder):
    drawings, canvases = in_order(rows, "drawing"), in_order(rows, "canvas")
    width, height = 0.7 + 1.62 * len(canvases), 0.85 + 1.8 * len(drawings)
    figure = Figure(figsize=(max(width, 7.5), height))
    grid = figure.add_gridspec(len(drawings), len(canvases), left=0.65 / max(width, 7.5), right=1 - 0.05 / max(width, 7.5), top=1 - 0.75 / height,
                               bottom=0.25 / height, wspace=0.05, hspace=0.16)
    of = {(row["drawing"], row["canvas"]): row for row in rows}
    for i, drawing in enumerate(drawings):
        for j, canvas in enumerate(canvases):
            axes = figure.add_subplot(grid[i, j])
            if (drawing, canvas) in of:
                small_picture(axes, of[drawing, canvas], folder)
            else:
                axes.axis("off")
            if i == 0:
                axes.set_title(canvas, fontsize=11, pad=5)
            if j == 0:
                axes.text(-0.06, 0.5, drawing, fontsize=11, rotation=90, ha="right", va="center", transform=axes.transAxes)
    figure.legend(handles=[Line2D([], [], color=INK, label="ink"), Line2D([], [], color=UNDRAWABLE, label="reported as not drawable"),
                           Line2D([], [], color=LACKING, label="planned, without ink"),
                           Line2D([], [], linestyle="", label="beneath each: ink error, RMS to 45° of slope; coverage")],
                  loc="upper left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False)
    return figure


def main():
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    picture(rows, Path(sys.argv[1]).parent).savefig(sys.argv[2], dpi=100)


main()
