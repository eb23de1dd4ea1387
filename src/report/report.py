"""Lays out compare.html from the data that report.cc computed: a JSON file, the only
argument.

Plots are matplotlib's, as SVG inside the page; the page refers to nothing outside itself.
"""

import base64
import html
import io
import json
import logging
import math
import sys
from pathlib import Path

import matplotlib

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # no word of its list of fonts
matplotlib.use("svg")
from matplotlib.figure import Figure  # noqa: E402

INK, TARGET, SECOND, DOWN, GRID = "#173d85", "#f9b861", "#c8452f", "#eef2f8", "#e3e6ea"

matplotlib.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#8a9099",
    "axes.labelcolor": "#20242a", "xtick.color": "#5a616b", "ytick.color": "#5a616b", "axes.grid": True, "grid.color": GRID,
    "grid.linewidth": 0.7, "axes.axisbelow": True, "lines.linewidth": 1.1, "lines.solid_joinstyle": "round", "legend.frameon": False,
    "legend.fontsize": 8.5, "svg.fonttype": "path", "svg.hashsalt": "impedraw", "path.simplify": False,
})

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #20242a; background: #fff;
  max-width: 1080px; margin: 2.2em auto; padding: 0 1.2em; }
h1 { font-size: 1.7em; margin: 0 0 .1em; } h2 { font-size: 1.15em; margin: 2.2em 0 .6em; }
.sub { color: #5a616b; margin: 0 0 1.6em; }
table { border-collapse: collapse; width: 100%; font-size: .93em; }
th { text-align: left; font-weight: 600; color: #5a616b; border-bottom: 1px solid #b9bec6; } td { border-bottom: 1px solid #eceef1; }
th, td { padding: .28em .7em .28em 0; vertical-align: baseline; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td code { font-size: .95em; } td.why { color: #8a9099; }
.ok { color: #1d7a3e; } .bad { color: #b3261e; font-weight: 600; }
img { width: 100%; height: auto; display: block; }
details { margin-top: 1em; border: 1px solid #e3e6ea; border-radius: 8px; padding: .6em 1em; }
summary { cursor: pointer; font-weight: 600; }
pre { overflow-x: auto; font-size: .86em; line-height: 1.4; }
"""


def number(value, unit="", significant=4):
    """Rounds to significant digits. Counts stay whole; no value is a dash."""
    if value is None:
        return "–"
    if isinstance(value, int):
        text = str(value)
    elif value == 0:
        text = "0"
    else:
        digits = max(0, min(6, significant - 1 - math.floor(math.log10(abs(value)))))
        text = f"{value:.{digits}f}"
        if value < 1 and float(text) == 1:  # 0.9999 must not read as 1
            text = f"{value:.6f}"
        if "." in text and abs(value) < 1e-6:
            text = f"{value:.1e}"
    text = text.replace("-", "−")
    return text if unit in ("", "1") else f"{text}\u202f{unit}"


def limit_text(limit):
    low, high = limit.get("min"), limit.get("max")
    if low is not None and high is not None:
        return f"{low:g} … {high:g}"
    return f"≥ {low:g}" if low is not None else f"≤ {high:g}"


def holds(value, limit):
    if value is None:
        return False
    return limit.get("min", -math.inf) <= value <= limit.get("max", math.inf)


def series(data, name):
    """Times and values. A missing value becomes NaN, which interrupts the line."""
    s = data[name]
    return s["t"], [math.nan if v is None else v for v in s["v"]]


def has_values(data, name):
    return any(v is not None for v in data[name]["v"])


def shade_strokes(axes, data):
    spans = [(a, b - a) for a, b in data["strokes"]]
    if spans:
        axes.broken_barh(spans, (0, 1), transform=axes.get_xaxis_transform(), color=DOWN, linewidth=0, zorder=0)


def as_svg(figure):
    out = io.BytesIO()
    figure.savefig(out, format="svg", metadata={"Creator": None, "Date": None, "Format": None, "Type": None})
    return data_uri(out.getvalue(), "image/svg+xml")


def data_uri(content, kind):
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def caption(axes, text):
    """Puts the label above the panel, horizontally, clear of the tick labels."""
    axes.set_title(text, loc="left", fontsize=9.5, color="#20242a", pad=5)


def draw_force(axes, data):
    axes.plot(*series(data, "force"), color=INK, label="normal force")
    axes.plot(*series(data, "push"), color=SECOND, linestyle=(0, (4, 2)), linewidth=1.3, label="desired")
    caption(axes, "normal force [N]")


def draw_tilt(axes, data):
    axes.plot(*series(data, "tilt"), color=INK, label="pen against true normal")
    if has_values(data, "normal_error"):
        axes.plot(*series(data, "normal_error"), color=SECOND, linewidth=0.9, label="estimated against true normal")
    caption(axes, "tilt [deg]")


def above(axes):
    """Puts the legend above the panel, clear of the curves."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3, borderaxespad=0.1, handlelength=1.8)


def metric_rows(page, columns):
    """One row per metric: name, a value per column, unit, limit if any, meaning or reason for no value."""
    limits = page["limits"]
    rows = []
    for d in page["definitions"]:
        name, limit = d["name"], limits.get(d["name"])
        values = []
        for metrics in columns:
            judged = "" if not limit else " ok" if holds(metrics[name], limit) else " bad"
            values.append(f'<td class="n{judged}">{number(metrics[name])}</td>')
        reasons = {m["reasons"][name] for m in columns if name in m["reasons"]}
        note = html.escape(d["meaning"])
        if reasons:
            note += f' <span class=why>(none: {html.escape("; ".join(sorted(reasons)))})</span>'
        unit = "" if d["unit"] == "1" else d["unit"]
        limit_cell = f'<td class=n>{limit_text(limit) if limit else ""}</td>' if limits else ""
        rows.append(f"<tr><td><code>{name}</code></td>{''.join(values)}<td>{unit}</td>{limit_cell}<td>{note}</td></tr>")
    return "\n".join(rows)


def table(page, columns, titles):
    heads = "".join(f"<th class=n>{html.escape(t)}</th>" for t in titles)
    limit = "<th class=n>limit</th>" if page["limits"] else ""
    return (f"<table><tr><th>metric</th>{heads}<th>unit</th>{limit}<th>meaning</th></tr>\n{metric_rows(page, columns)}</table>")


def scenario(path, title="scenario.yaml"):
    if not path:
        return ""
    return f"<details><summary>{html.escape(title)}</summary><pre>{html.escape(Path(path).read_text(encoding='utf-8'))}</pre></details>"


def write_page(page, title, body):
    text = (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">\n'
            f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>\n{body}\n</body></html>\n")
    Path(page["out"]).write_text(text, encoding="utf-8")


def comparison_figure(page):
    runs = page["runs"]
    x, y = zip(*(p for run in runs for line in run["series"]["target"] + run["series"]["ink"] for p in line)) if any(
        run["series"]["target"] for run in runs) else ((0, 1), (0, 1))
    shape = min(max((max(x) - min(x)) / max(max(y) - min(y), 1e-3), 0.2), 1.2)  # aspect ratio, height to width
    line_height = 5.0 * shape + 0.3  # [inch]
    height = line_height + 6.9
    figure = Figure(figsize=(11.2, height))
    figure.subplots_adjust(left=0.065, right=0.988, top=1 - 0.65 / height, bottom=0.5 / height, hspace=0.28, wspace=0.07)
    axes = figure.subplots(3, 2, sharex="row", sharey="row", height_ratios=[line_height, 2.3, 2.3])
    for column, run in enumerate(runs):
        data = run["series"]
        line, force, tilt = axes[:, column]
        for k, points in enumerate(data["target"]):
            line.plot([-p[1] for p in points], [p[0] for p in points], color=TARGET, linewidth=3.4, solid_capstyle="round",
                      label="target" if k == 0 else None)
        for k, points in enumerate(data["ink"]):
            line.plot([-p[1] for p in points], [p[0] for p in points], color=INK, linewidth=1.1, solid_capstyle="round",
                      label="drawn" if k == 0 else None)
        line.set_aspect("equal", adjustable="box")
        line.xaxis.set_major_formatter(lambda value, _: f"{round(-value):d}".replace("-", "−"))
        line.set_title(run["name"], fontsize=12, fontweight="bold", pad=20)
        line.set_xlabel("y [mm]")
        draw_force(force, data)
        draw_tilt(tilt, data)
        tilt.set_xlabel("time [s]")
        above(line), above(force), above(tilt)
        for a in (force, tilt):
            shade_strokes(a, data)
        if column == 0:
            line.set_ylabel("x [mm]")
    for a in axes[1:, 0]:  # shared axes: set once both runs are drawn
        a.set_ylim(bottom=-0.03 * a.get_ylim()[1])  # keeps a line at zero visible
    axes[1, 0].set_xlim(0, max(max(r["series"]["force"]["t"], default=0) for r in runs) or 1)
    axes[2, 0].set_xlim(axes[1, 0].get_xlim())
    return figure


def comparison_page(page):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = comparison_figure(page)
    picture = as_svg(figure)
    FigureCanvasAgg(figure)  # for the PNG
    figure.savefig(page["picture"], dpi=150, format="png")
    runs = page["runs"]
    folded = "".join(scenario(r["scenario"], f'scenario.yaml: {r["name"]}') for r in runs)
    names = " and ".join(html.escape(r["name"]) for r in runs)
    write_page(page, f'{page["title"]}: comparison', f"""<h1>{html.escape(page["title"])}</h1>
<p class=sub>{names}, side by side on equal axes:
drawn and target line, normal force, and tilt of the pen against the surface normal. Shaded: the plan is drawing a stroke.</p>
<img alt="both runs side by side" src="{picture}">
<h2>Numbers</h2>{table(page, [r["metrics"] for r in runs], [r["name"] for r in runs])}
{folded}""")


def main():
    page = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    comparison_page(page)


main()
