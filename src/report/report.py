"""Lays out report.html and compare.html from the data that report.cc computed: a JSON file, the only
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
TOO_LARGE_SVG = 2_000_000  # bytes; a picture beyond it is shown as PNG

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
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 12px; }
.tile { border: 1px solid #e3e6ea; border-radius: 8px; padding: .7em .9em; }
.tile b { display: block; font-size: 1.45em; font-weight: 600; white-space: nowrap; } .tile span { color: #5a616b; font-size: .87em; }
table { border-collapse: collapse; width: 100%; font-size: .93em; }
th { text-align: left; font-weight: 600; color: #5a616b; border-bottom: 1px solid #b9bec6; } td { border-bottom: 1px solid #eceef1; }
th, td { padding: .28em .7em .28em 0; vertical-align: baseline; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td code { font-size: .95em; } td.why { color: #8a9099; }
.ok { color: #1d7a3e; } .bad { color: #b3261e; font-weight: 600; }
img { width: 100%; height: auto; display: block; }
.top { max-width: 640px; margin: 0 auto; } .page { max-width: 820px; margin: 1.5em auto 0; }
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


def picture_uri(path):
    svg = Path(path)
    if svg.stat().st_size <= TOO_LARGE_SVG or not svg.with_suffix(".png").exists():
        return data_uri(svg.read_bytes(), "image/svg+xml")
    return data_uri(svg.with_suffix(".png").read_bytes(), "image/png")


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


def draw_mode(axes, data):
    t, v = series(data, "mode")
    axes.plot(t, v, color=INK, drawstyle="steps-post")
    names = data["mode_names"]
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(-0.5, max(len(names) - 0.5, 0.5))
    caption(axes, "contact state")


def above(axes):
    """Puts the legend above the panel, clear of the curves."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3, borderaxespad=0.1, handlelength=1.8)


def time_plots(data):
    figure = Figure(figsize=(10.2, 12.6))  # fixed margins: matplotlib's layout engines draw everything several times
    figure.subplots_adjust(left=0.088, right=0.988, top=0.975, bottom=0.037, hspace=0.32)
    axes = figure.subplots(6, 1, sharex=True, height_ratios=[1.35, 1.1, 1.1, 0.8, 0.9, 0.9])
    draw_force(axes[0], data)
    above(axes[0])
    axes[1].plot(*series(data, "ink_error"), color=INK)
    caption(axes[1], "ink error [mm]")
    draw_tilt(axes[2], data)
    above(axes[2])
    draw_mode(axes[3], data)
    axes[4].plot(*series(data, "speed"), color=INK)
    caption(axes[4], "speed of the contact point [mm/s]")
    axes[5].plot(*series(data, "torque"), color=INK)
    caption(axes[5], "largest joint torque [% of its limit]")
    axes[5].set_xlabel("time [s]")
    for a in axes:
        shade_strokes(a, data)
        if a is not axes[3]:
            a.set_ylim(bottom=0)
    axes[0].set_xlim(0, max(data["force"]["t"], default=0) or 1)
    return figure


def step_time_plot(data):
    figure = Figure(figsize=(10.2, 2.5))
    figure.subplots_adjust(left=0.088, right=0.988, top=0.87, bottom=0.2)
    axes = figure.subplots()
    axes.stairs(data["step_time"]["counts"], data["step_time"]["edges"], color=INK, fill=True, alpha=0.85)
    axes.set_yscale("log")
    axes.set_xlabel("controller step [µs]; the last bar holds all that took longer")
    caption(axes, "steps")
    return figure


def tile(metrics, units, name, label):
    return f"<div class=tile><b>{number(metrics[name], units[name], 3)}</b><span>{label}</span></div>"


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


def wall_text(metrics):
    wall = metrics.get("wall_seconds", {})
    names = {"start_up": "start-up", "loop": "loop", "writing": "rest of the log"}
    return ", ".join(f"{label} {wall[key]:.2f} s" for key, label in names.items() if wall.get(key) is not None)


def run_page(page):
    metrics, data = page["metrics"], page["series"]
    units = {d["name"]: d["unit"] for d in page["definitions"]}
    tiles = "".join([
        tile(metrics, units, "ink_error_rms", "ink error, RMS"), tile(metrics, units, "coverage", "of the target covered"),
        tile(metrics, units, "contact_fraction", "contact fraction"), tile(metrics, units, "force_mean", "normal force, mean"),
        tile(metrics, units, "force_sd", "its standard deviation"), tile(metrics, units, "tilt_mean", "tilt, mean")])
    attributes = ", ".join(f"{html.escape(k)} {html.escape(v)}" for k, v in page["attributes"].items() if k != "scenario" and len(v) < 60)
    duration = max(data["force"]["t"], default=0)
    facts = "; ".join(x for x in (f"{duration:.1f} s simulated", wall_text(metrics), attributes) if x)
    top, flat = page["pictures"]
    pictures = f'<img class=top alt="ink against target, seen from above" src="{picture_uri(top)}">' if top else ""
    if flat:
        pictures += f'<img class=page alt="ink against target, on the page" src="{picture_uri(flat)}">'
    steps = f'<h2>Controller step</h2><img alt="histogram of step times" src="{as_svg(step_time_plot(data))}">' if data["step_time"] else ""
    write_page(page, page["title"], f"""<h1>{html.escape(page["title"])}</h1><p class=sub>{facts}</p>
<div class=tiles>{tiles}</div>
<h2>Ink against target</h2>{pictures}
<h2>Over time</h2><p class=sub>Shaded: the plan is drawing a stroke. Of many rows each point shows the least and the largest.</p>
<img alt="force, ink error, tilt, contact state, speed and torque over time" src="{as_svg(time_plots(data))}">
<h2>Numbers</h2>{table(page, [metrics], ["value"])}
{steps}{scenario(page["scenario"])}""")


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
    {"run": run_page, "comparison": comparison_page}[page["kind"]](page)


main()
