"""The page of a data set: one HTML file that needs no network.

What it shows follows from the specification's `report`; without one: a table of each axis, lines
over each numeric axis, a map of the first two axes. Means are over seeds, with a 95 % confidence
interval where there are two seeds or more.
"""

import html
import json
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa

from .dataset import write_whole
from .errors import SweepError, nearest
from .settings import DRAW_ARGUMENTS, Settings, plain, text_of
from .spec import Case, Spec
from .statistics import Mean, mean_over_seeds

_METRIC_UNITS = {
    unit: set(names.split()) for unit, names in {
        "mm": "ink_error_rms ink_error_p95 ink_error_max longest_gap ink_up cloud_bias_mean "
              "cloud_bias_sd",
        "N": "force_mean force_sd force_rms_error force_peak touchdown_peak",
        "deg": "tilt_mean tilt_p95 tilt_max normal_error_mean normal_error_p95",
        "mm/s": "speed_mean speed_p95", "s": "draw_time wall_time", "rad": "joint_margin_min",
        "µs": "step_time_p50 step_time_p99 step_time_p999",
    }.items()
}
_DEFAULT_METRICS = ("ink_error_rms", "force_sd")
_MOST_LEVELS = 60  # of an axis in a table or map
_MOST_LINES = 8
_COLOURS = ("#173d85", "#d9822b", "#2e8b6f", "#8e44ad", "#b3261e", "#5a616b", "#0097a7", "#7a6a00")


@dataclass
class Axis:
    """A column that varies."""

    column: str
    title: str
    levels: list[Any]  # in order, as the column has them
    numeric: bool


def write_report(spec: Spec, table: pa.Table, out: Path, settings: Settings,
                 command: str, more: str = "") -> Path:
    """Writes OUT/report.html and returns its path; `more` is HTML. Raises SweepError."""
    page = out / "report.html"
    write_whole(page, Page(spec, table, out, settings, command, more).text().encode("utf-8"))
    return page.resolve()


class Page:
    def __init__(self, spec: Spec, table: pa.Table, out: Path, settings: Settings,
                 command: str, more: str) -> None:
        self.more = more
        self.spec, self.table, self.out = spec, table, out
        self.settings, self.command = settings, command
        self.columns = {n: table[n].to_pylist() for n in table.column_names
                        if n in self._needed(table)}
        self.count = table.num_rows
        self.metrics = self._metrics()

    def _needed(self, table: pa.Table) -> set[str]:
        report = json.dumps(self.spec.report)
        named = {n for n in table.column_names if n in report or n in _DEFAULT_METRICS}
        names = {"index", "key", "case", "group", "state", "cause", "failed", "set", "seed",
                 "wall_time", *DRAW_ARGUMENTS, *self.spec.set_names(), "value"}
        accept = " ".join(self.spec.accept.values())
        named |= {n for n in table.column_names if n in accept}
        return names | named | {f"axis:{a}" for a in self.spec.axis_names()}

    def _metrics(self) -> list[str]:
        wanted = self.spec.report.get("metrics")
        if wanted is None:
            found = [m for m in _DEFAULT_METRICS if m in self.columns]
            return found or (["value"] if "value" in self.columns else [])
        return [self._metric(m) for m in wanted]

    def _metric(self, name: Any) -> str:
        if name not in self.columns:
            raise SweepError(f"{self.spec.file}: report: {name} is no metric of the runs; "
                             + nearest(str(name), self.table.column_names))
        if not all(v is None or isinstance(v, (int, float)) for v in self.columns[name]):
            raise SweepError(f"{self.spec.file}: report: {name} is no number; valid is a metric")
        return str(name)

    # --- what varies ---------------------------------------------------------------------------

    def axis(self, name: str, rows: list[int]) -> Axis:
        """The axis of that name, with the levels that the rows have."""
        column = f"axis:{name}" if f"axis:{name}" in self.columns else name
        if column not in self.columns:
            valid = [a.name for b in self.spec.blocks for a in b.axes]
            raise SweepError(f"{self.spec.file}: report: {name} is no axis; "
                             + nearest(name, valid))
        values = [self.level(column, i) for i in rows]
        levels = list(dict.fromkeys(v for v in values if v is not None))
        numeric = bool(levels) and all(isinstance(v, (int, float)) and not isinstance(v, bool)
                                       for v in levels)
        return Axis(column, self.title(name), sorted(levels) if numeric else levels, numeric)

    def level(self, column: str, row: int) -> Any:
        value = self.columns[column][row]
        return text_of(plain(value)) if isinstance(value, list) else value

    def title(self, name: str) -> str:
        for unit, names in _METRIC_UNITS.items():
            if name in names:
                return f"{name} [{unit}]"
        unit = re.search(r"\[([^\]]+)\]$", self.settings.leaves.get(name, {}).get("description",
                                                                                  ""))
        return f"{name} [{unit[1]}]" if unit else name

    def rows_of(self, group: str | None) -> list[int]:
        if group is None:
            return list(range(self.count))
        rows = [i for i, g in enumerate(self.columns["group"]) if g == group]
        if not rows and group not in {b.name for b in self.spec.blocks}:
            raise SweepError(f"{self.spec.file}: report: {group} is no block; "
                             + nearest(group, [b.name for b in self.spec.blocks]))
        return rows

    def mean(self, metric: str, rows: list[int]) -> Mean:
        seeds = self.columns.get("seed")
        return mean_over_seeds((seeds[i] if seeds else 0, self.columns[metric][i],
                                self.columns["failed"][i]) for i in rows)

    def split(self, axis: Axis, rows: list[int]) -> dict[Any, list[int]]:
        parts: dict[Any, list[int]] = {level: [] for level in axis.levels}
        for i in rows:
            if (level := self.level(axis.column, i)) in parts:
                parts[level].append(i)
        return parts

    # --- parts of the page ---------------------------------------------------------------------

    def text(self) -> str:
        body = [self.summary(), self.more]
        report = self.spec.report
        if any(k in report for k in ("tables", "maps", "lines")):
            for kind, draw in (("maps", self.map), ("lines", self.lines),
                               ("tables", self.cross_table)):
                for wanted in report.get(kind) or []:
                    body.append(draw(wanted))
        else:
            body.append(self.default_parts())
        body.append(self.worst())
        body.append(self.failures())
        return _PAGE.format(title=html.escape(self.spec.name), style=_STYLE, script=_SCRIPT,
                            body="\n".join(b for b in body if b))

    def summary(self) -> str:
        states: dict[str, int] = {}
        for state in self.columns["state"]:
            states[state] = states.get(state, 0) + 1
        told = ", ".join(f"{n} {state}" for state, n in sorted(states.items(),
                                                               key=lambda s: -s[1]))
        wall = math.fsum(t or 0.0 for t in self.columns["wall_time"])
        accept = "".join(f"<li><b>{html.escape(n)}</b> <code>{html.escape(c)}</code></li>"
                         for n, c in self.spec.accept.items())
        return (f"<h1>{html.escape(self.spec.name)}</h1><p>{html.escape(self.spec.about)}</p>"
                f"<p class=figures>{self.count} runs: {html.escape(told)}; {wall:.3g} s of one "
                f"core</p><p>{_command(self.command)}</p>"
                + (f"<p>A run has failed that does not meet:</p><ul>{accept}</ul>" if accept
                   else ""))

    def default_parts(self) -> str:
        axes = []
        rows = list(range(self.count))
        for name in dict.fromkeys(a.name for b in self.spec.blocks for a in b.axes):
            if name != "seed" and len((axis := self.axis(name, rows)).levels) > 1:
                axes.append((name, axis))
        parts = []
        if len(axes) > 1 and all(len(a.levels) <= _MOST_LEVELS for _, a in axes[:2]):
            parts += [self.map({"x": axes[1][0], "y": axes[0][0], "metric": m})
                      for m in self.metrics]
        parts += [self.lines({"x": n, "metric": m}) for n, a in axes if a.numeric
                  for m in self.metrics]
        parts += [self.axis_table(n) for n, a in axes if len(a.levels) <= _MOST_LEVELS]
        return "\n".join(parts)

    def axis_table(self, name: str) -> str:
        axis = self.axis(name, list(range(self.count)))
        lines = []
        for level, rows in self.split(axis, list(range(self.count))).items():
            cells = "".join(f"<td>{_mean_text(self.mean(m, rows))}</td>" for m in self.metrics)
            bad = sum(self.columns["failed"][i] for i in rows)
            lines.append(f"<tr><th>{html.escape(_short(level))}</th><td>{len(rows)}</td>"
                         f"<td{' class=bad' if bad else ''}>{bad}</td>{cells}</tr>")
        heads = "".join(f"<th>{html.escape(self.title(m))}</th>" for m in self.metrics)
        return (f"<section><h2>{html.escape(axis.title)}</h2><div class=wide><table><tr><th></th>"
                f"<th>runs</th><th>failed</th>{heads}</tr>{''.join(lines)}</table></div>"
                "</section>")

    def cross_table(self, wanted: dict[str, Any]) -> str:
        """rows, columns; each entry gives the metrics, separated by a slash."""
        group = wanted.get("block")
        rows = self.rows_of(group)
        if not rows:
            return ""
        down, across = self._axes(wanted, ("rows", "columns"), rows)
        metrics = [self._metric(m) for m in wanted.get("metrics", self.metrics)]
        lines = []
        for level, in_row in self.split(down, rows).items():
            cells = []
            for part in self.split(across, in_row).values():
                cells.append(self._entry(part, metrics))
            lines.append(f"<tr><th>{html.escape(_short(level))}</th>{''.join(cells)}</tr>")
        heads = "".join(f"<th>{html.escape(_short(v))}</th>" for v in across.levels)
        legend = " / ".join(self.title(m) for m in metrics)
        return (f"<section><h2>{html.escape(self._heading(wanted, group))}</h2><p>"
                f"{html.escape(legend)}; {html.escape(down.title)} down, "
                f"{html.escape(across.title)} across</p><div class=wide><table><tr><th></th>"
                f"{heads}</tr>{''.join(lines)}</table></div></section>")

    def _entry(self, rows: list[int], metrics: list[str]) -> str:
        if not rows:
            return "<td></td>"
        text = " / ".join(_mean_text(self.mean(m, rows)) for m in metrics)
        bad = [i for i in rows if self.columns["failed"][i]]
        if not bad:
            return f"<td>{text}</td>"
        cause = self.columns["cause"][bad[0]] or self.columns["state"][bad[0]]
        word = html.escape(cause.split(":")[0])
        return f"<td class=bad title=\"{html.escape(cause)}\">✗ {word} {text}</td>"

    def _heading(self, wanted: dict[str, Any], group: str | None) -> str:
        return str(wanted.get("title") or group or self.spec.name)

    def _axes(self, wanted: dict[str, Any], keys: tuple[str, ...], rows: list[int]) -> list[Axis]:
        for key in keys:
            if key not in wanted:
                raise SweepError(f"{self.spec.file}: report: no {key}; valid is the name of an "
                                 "axis")
        return [self.axis(str(wanted[key]), rows) for key in keys]

    def map(self, wanted: dict[str, Any]) -> str:
        """x, y, metric: a heat map, by colour and number."""
        group = wanted.get("block")
        rows = self.rows_of(group)
        if not rows:
            return ""
        across, down = self._axes(wanted, ("x", "y"), rows)
        metric = self._metric(wanted.get("metric", self.metrics[0] if self.metrics else ""))
        if max(len(across.levels), len(down.levels)) > _MOST_LEVELS:
            return (f"<p>{html.escape(metric)} over {html.escape(across.title)} and "
                    f"{html.escape(down.title)}: more than {_MOST_LEVELS} levels, no map.</p>")
        cells = {}
        for y, in_row in self.split(down, rows).items():
            for x, part in self.split(across, in_row).items():
                cells[x, y] = self.mean(metric, part)
        return (f"<section><h2>{html.escape(self._heading(wanted, group))}: "
                f"{html.escape(self.title(metric))}</h2>"
                f"{_heat_map(across, down, cells)}</section>")

    def lines(self, wanted: dict[str, Any]) -> str:
        """x, metric, by: lines over a numeric axis, with confidence intervals over seeds."""
        group = wanted.get("block")
        rows = self.rows_of(group)
        if not rows:
            return ""
        (across,) = self._axes(wanted, ("x",), rows)
        metric = self._metric(wanted.get("metric", self.metrics[0] if self.metrics else ""))
        if not across.numeric:
            raise SweepError(f"{self.spec.file}: report: lines over {across.column}, which is not "
                             "numeric; valid is a table")
        parts = {"": rows}
        if "by" in wanted:
            by = self.axis(str(wanted["by"]), rows)
            split = self.split(by, rows)
            parts = {f"{by.title} {_short(k)}": v for k, v in split.items()}
        left = len(parts) - _MOST_LINES
        shown = dict(list(parts.items())[:_MOST_LINES])
        series = {name: [(x, self.mean(metric, part))
                         for x, part in self.split(across, of).items()]
                  for name, of in shown.items()}
        more = f"<p>{left} more levels are not drawn.</p>" if left > 0 else ""
        return (f"<section><h2>{html.escape(self._heading(wanted, group))}: "
                f"{html.escape(self.title(metric))} over {html.escape(across.title)}</h2>"
                f"{_line_plot(across.title, self.title(metric), series)}{more}</section>")

    def worst(self) -> str:
        wanted = self.spec.report.get("worst") or {}
        if not isinstance(wanted, dict):
            raise SweepError(f"{self.spec.file}: report: worst: valid is {{metric: NAME, count: "
                             "N}")
        name = wanted.get("metric", self.metrics[0] if self.metrics else None)
        if name is None:
            return ""
        metric, count = self._metric(name), int(wanted.get("count", 10))
        values = self.columns[metric]
        order = sorted((i for i in range(self.count) if values[i] is not None),
                       key=lambda i: (values[i], i), reverse=wanted.get("least") is not True)
        lines = "".join(self._case_row(i, f"{values[i]:.4g}") for i in order[:count])
        word = "smallest" if wanted.get("least") is True else "largest"
        return (f"<section><h2>Worst cases: {word} {html.escape(self.title(metric))}</h2>"
                f"<div class=wide><table class=cases>{lines}</table></div></section>")

    def failures(self) -> str:
        bad = [i for i in range(self.count) if self.columns["failed"][i]]
        lines = "".join(self._case_row(i, self.columns["cause"][i] or "") for i in bad[:200])
        more = f"<p>{len(bad) - 200} more are in runs.parquet.</p>" if len(bad) > 200 else ""
        table = f"<div class=wide><table class=cases>{lines}</table></div>" if bad else "<p>None."
        return f"<section><h2>Failed runs: {len(bad)}</h2>{table}{more}</section>"

    def _case_row(self, i: int, figure: str) -> str:
        key = self.columns["key"][i]
        kept = ""
        for name in ("report.html", "run.h5"):
            if (self.out / "kept" / key / name).exists():
                kept += f" <a href=\"kept/{key}/{name}\">{name}</a>"
        return (f"<tr><th>{html.escape(self.columns['case'][i])}</th><td>{html.escape(figure)}"
                f"{kept}</td><td>{_command(self.case(i).command())}</td></tr>")

    def case(self, i: int) -> Case:
        """The case of a row, from what the data set says."""
        draw = {n: self.columns[n][i] for n in DRAW_ARGUMENTS if self.columns[n][i]}
        if "arguments" in draw:
            draw["arguments"] = draw["arguments"].split()
        return Case(self.columns["index"][i], self.columns["key"][i], self.columns["case"][i],
                    self.columns["group"][i], draw, json.loads(self.columns["set"][i]))


# --- texts and pictures --------------------------------------------------------------------------


def _command(text: str) -> str:
    return f"<code class=command>{html.escape(text)}</code>"


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return text_of(value)


def _mean_text(mean: Mean) -> str:
    if mean.mean is None:
        return "–"
    return f"{mean.mean:.3g}" + (f" ± {mean.half:.1g}" if mean.half is not None else "")


def _colour(share: float) -> tuple[str, str]:
    """Background and text colour of 0 (light) to 1 (dark)."""
    stops = ((247, 251, 255), (198, 219, 239), (107, 174, 214), (33, 113, 181), (8, 48, 107))
    at = min(max(share, 0.0), 1.0) * (len(stops) - 1)
    i = min(int(at), len(stops) - 2)
    rgb = [round(a + (b - a) * (at - i)) for a, b in zip(stops[i], stops[i + 1])]
    return f"rgb({rgb[0]},{rgb[1]},{rgb[2]})", "#20242a" if share < 0.55 else "#ffffff"


def _heat_map(across: Axis, down: Axis, cells: dict[tuple[Any, Any], Mean]) -> str:
    values = [m.mean for m in cells.values() if m.mean is not None]
    low, high = (min(values), max(values)) if values else (0.0, 1.0)
    log = low > 0 and high / low > 20

    def share(value: float) -> float:
        if high <= low:
            return 0.3
        if log:
            return math.log(value / low) / math.log(high / low)
        return (value - low) / (high - low)

    lines = []
    for y in reversed(down.levels) if down.numeric else down.levels:
        row = [f"<th>{html.escape(_short(y))}</th>"]
        for x in across.levels:
            mean = cells[x, y]
            if not mean.all:
                row.append("<td class=none></td>")
            elif mean.mean is None:
                row.append("<td class=bad>✗</td>")
            else:
                back, ink = _colour(share(mean.mean))
                mark = "✗ " if mean.failed else ""
                row.append(f"<td style=\"background:{back};color:{ink}\" title=\"{mean.runs} runs, "
                           f"{mean.failed} failed\">{mark}{_mean_text(mean)}</td>")
        lines.append(f"<tr>{''.join(row)}</tr>")
    heads = "".join(f"<th>{html.escape(_short(x))}</th>" for x in across.levels)
    scale = "logarithmic" if log else "linear"
    return (f"<div class=wide><table class=map>{''.join(lines)}<tr><th></th>{heads}</tr></table>"
            f"</div><p>{html.escape(across.title)} across, {html.escape(down.title)} up; {scale} "
            "colours; ✗ a run failed.</p>")


def _line_plot(x_title: str, y_title: str, series: dict[str, list[tuple[Any, Mean]]]) -> str:
    width, height, left, right, top, bottom = 760, 340, 70, 15, 15, 48
    points = [(x, m) for line in series.values() for x, m in line if m.mean is not None]
    if not points:
        return "<p>No run has this metric.</p>"
    xs = [float(x) for x, _ in points]
    ys = [v for _, m in points for v in (m.mean - (m.half or 0.0), m.mean + (m.half or 0.0))]
    x_of = _scale(min(xs), max(xs), left, width - right)
    y_low = [m.mean for _, m in points]
    log_y = min(y_low) > 0 and max(y_low) / min(y_low) > 20
    if log_y:
        ys = [max(v, min(y_low) / 2) for v in ys]
    y_of = _scale(min(ys), max(ys), height - bottom, top, log_y)
    parts = []
    for value, text in y_of.ticks:
        y = y_of(value)
        parts.append(f"<line x1={left} x2={width - right} y1={y:.1f} y2={y:.1f} class=grid />"
                     f"<text x={left - 8} y={y + 4:.1f} text-anchor=end>{text}</text>")
    for value, text in x_of.ticks:
        x = x_of(value)
        parts.append(f"<line x1={x:.1f} x2={x:.1f} y1={height - bottom} y2={height - bottom + 5} "
                     f"class=tick /><text x={x:.1f} y={height - bottom + 19} "
                     f"text-anchor=middle>{text}</text>")
    legend = []
    for (name, line), colour in zip(series.items(), _COLOURS * 9):
        good = [(x_of(float(x)), m) for x, m in line if m.mean is not None]
        path = " ".join(f"{x:.1f},{y_of(m.mean):.1f}" for x, m in good)
        parts.append(f"<polyline points=\"{path}\" fill=none stroke=\"{colour}\" "
                     "stroke-width=1.8 />")
        for x, m in good:
            if m.half is not None:
                low = max(m.mean - m.half, min(ys))
                parts.append(f"<line x1={x:.1f} x2={x:.1f} y1={y_of(low):.1f} "
                             f"y2={y_of(m.mean + m.half):.1f} stroke=\"{colour}\" "
                             "stroke-width=3 opacity=0.35 />")
            mark = (f"<text x={x:.1f} y={y_of(m.mean) + 4:.1f} text-anchor=middle fill=\"#b3261e\" "
                    "class=cross>✗</text>" if m.failed else
                    f"<circle cx={x:.1f} cy={y_of(m.mean):.1f} r=3 fill=\"{colour}\" />")
            parts.append(mark)
        if name:
            legend.append(f"<span><i style=\"background:{colour}\"></i>{html.escape(name)}</span>")
    parts.append(f"<text x={(left + width - right) / 2} y={height - 8} text-anchor=middle>"
                 f"{html.escape(x_title)}</text>")
    bars = " Bars: 95 % over seeds." if any(m.half is not None for _, m in points) else ""
    return (f"<div class=legend>{''.join(legend)}</div><div class=wide><svg viewBox=\"0 0 {width} "
            f"{height}\" width={width} role=img aria-label=\"{html.escape(y_title)} over "
            f"{html.escape(x_title)}\">{''.join(parts)}</svg></div><p>{html.escape(y_title)}, "
            f"mean.{bars}</p>")


class _scale:
    """From values to pixels, linear or logarithmic, with ticks at round values."""

    def __init__(self, low: float, high: float, first: float, last: float,
                 log: bool | None = None) -> None:
        self.log = (low > 0 and high / low >= 10) if log is None else log
        if high <= low:
            low, high = low - (abs(low) or 1.0) * 0.5, high + (abs(high) or 1.0) * 0.5
            self.log = False
        if self.log:
            self.ticks = [(v, f"{v:g}") for e in range(math.floor(math.log10(low)) - 1,
                                                        math.ceil(math.log10(high)) + 1)
                          for d in (1, 2, 5) if low <= (v := float(f"{d}e{e}")) <= high]
        else:
            step = 10 ** math.floor(math.log10((high - low) / 2))
            step = next(s for s in (step / 5, step / 2, step, 2 * step, 5 * step)
                        if (high - low) / s <= 7)
            n = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
            self.ticks = [(i * step, f"{round(i * step, 12):g}") for i in n]
        self.low, self.high, self.first, self.last = low, high, first, last

    def __call__(self, value: float) -> float:
        if self.log:
            share = math.log(value / self.low) / math.log(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return self.first + share * (self.last - self.first)


_STYLE = """
:root{color-scheme:light dark;--ink:#20242a;--back:#fff;--soft:#5a616b;--line:#dfe3e8;--bad:#b3261e}
@media(prefers-color-scheme:dark){:root{--ink:#e6e8eb;--back:#15181c;--soft:#a3abb5;--line:#343a42;
--bad:#ff8a80}}
body{font:15px/1.5 system-ui,"DejaVu Sans",sans-serif;color:var(--ink);background:var(--back);
max-width:1100px;margin:2rem auto;padding:0 1rem}
h1{margin:0 0 .3rem}h2{font-size:1.1rem;margin:2.2rem 0 .6rem;overflow-wrap:anywhere}
.figures{font-size:1.15rem}.wide{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
td,th{padding:.25rem .6rem;border-bottom:1px solid var(--line);text-align:right;white-space:nowrap;
font-weight:400}
th{color:var(--soft)}table.map td{text-align:center;border:1px solid var(--back);min-width:3.2rem}
table.map tr:last-child th{text-align:center;border:0}.bad{color:var(--bad)}
table.cases td,table.cases th{text-align:left;vertical-align:top;white-space:normal}
table.cases td:nth-child(2){min-width:14rem}
code{font:12.5px/1.45 ui-monospace,"DejaVu Sans Mono",monospace;overflow-wrap:anywhere}
code.command{cursor:copy}code.copied{outline:2px solid #2e8b6f}
svg{max-width:100%;height:auto}svg text{font-size:12px;fill:var(--soft)}svg .grid{
stroke:var(--line)}svg .tick{stroke:var(--soft)}svg text.cross{font-size:14px;fill:var(--bad)}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1rem}.legend i{display:inline-block;width:1.1rem;
height:.25rem;margin:0 .4rem .2rem 0}section p{color:var(--soft);margin:.4rem 0}
"""
_SCRIPT = """
document.addEventListener("click",e=>{const c=e.target.closest("code.command");if(!c)return;
navigator.clipboard&&navigator.clipboard.writeText(c.textContent).then(()=>{
c.classList.add("copied");setTimeout(()=>c.classList.remove("copied"),600)})});
"""
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy"
content="default-src 'none';style-src 'unsafe-inline';script-src 'unsafe-inline'">
<title>{title}</title><style>{style}</style></head><body>
{body}
<script>{script}</script></body></html>
"""
