"""Writes docs/surface_cells.md, docs/other_surface_cells.md, docs/robustness.md, docs/reach.md or docs/moving.md, and their pictures, from a sweep's data set.

    ./impedraw figures --pages              runs the studies and writes their pages; --check compares, and writes nothing
    ./impedraw figures --pages moving reach only these

    ./impedraw reach --out /tmp/reach && .venv/bin/python setup/study_pages.py reach /tmp/reach       one, from a data set that is there

A page is measured on a clean commit: data sets of changed sources are refused.
"""
import datetime
import difflib
import json
import math
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import quotes

ROOT = pathlib.Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
BLUE, ORANGE, GREEN, RED = "#163a8a", "#d9822b", "#2f8f6b", "#b22222"
READ = """import json, sys, pyarrow.parquet
keep = ("case", "group", "scenario", "svg", "set", "state", "cause", "failed", "not_drawn", "key")
table = pyarrow.parquet.read_table(sys.argv[1])
names = [n for n in table.column_names if n in keep or "." not in n]
json.dump(table.select(names).to_pylist(), sys.stdout, default=str)"""


def rows_of(folder):
    """pyarrow stands in the sweeps' environment, matplotlib in the program's."""
    command = [ROOT / "build/sweep-venv/bin/python", "-c", READ, folder / "runs.parquet"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def stamp(folder):
    """When and with which sources the sweep was begun."""
    head = folder / "sweep.json"
    day = datetime.datetime.fromtimestamp(head.stat().st_mtime, datetime.UTC)
    return f"{day:%Y-%m-%d}, commit {json.loads(head.read_text())['commit']}"


STAMP = re.compile(r"\d{4}-\d\d-\d\d, commit \w*\+?")


def stale(name, old, new):
    """What two versions of a page differ in, but for when they were measured and for one in a last digit; a place each."""
    old, new = ([STAMP.sub("", line) for line in lines] for lines in (old, new))
    words = ([quotes.NUMBER.sub("#", line) for line in lines] for lines in (old, new))
    told = []
    for kind, a, b, c, d in difflib.SequenceMatcher(None, *words, autojunk=False).get_opcodes():
        pairs = zip(old[a:b], new[c:d]) if kind == "equal" else [("\n    ".join(old[a:b]), "\n    ".join(new[c:d]))]
        told += [f"{name}:{a + 1 + i}: has\n    {x}\n  measured is\n    {y}" for i, (x, y) in enumerate(pairs) if not quotes.same_but_for_digits(x, y)]
    return told


def digits(x):
    if x is None or not math.isfinite(x):
        return "–"
    if x < 1e-4:
        return "0" if x == 0 else "<0.0001"
    return f"{x:.{min(4, max(0, 1 - math.floor(math.log10(x))))}f}"


def command(row):
    words = ["./impedraw draw", row["scenario"]] + (["--svg", row["svg"]] if row["svg"] else [])
    for name, value in json.loads(row["set"]).items():
        text = f"{name}={value if isinstance(value, str) else json.dumps(value)}"
        words.append(f"--set '{text}'" if " " in text else f"--set {text}")
    return " ".join(words)


def failed_list(rows):
    lines = []
    for row in rows:
        if row["failed"]:
            lines += [f"- `{row['case']}`: {row['cause']}", f"  `{command(row)}`"]
    return lines


def failure(row):
    return "" if not row["failed"] else f"**✗ {(row['cause'] or row['state']).split(':')[0].split(' ')[0]}** "


def kept(name, begin, end):
    """The lines of a page as it is from one heading up to another: text by hand, and what another study writes between its markers."""
    page = (DOCS / name).read_text().splitlines()
    return page[page.index(begin) : page.index(end)]


def kept_paragraph(name, begin):
    """The paragraph of a page that begins so, as it is."""
    page = (DOCS / name).read_text().splitlines()
    first = next(i for i, line in enumerate(page) if line.startswith(begin))
    return page[first : page.index("", first)]


def with_part(name, marker, lines):
    """The lines of a page with `lines` between <!-- marker --> and <!-- /marker -->."""
    page = (DOCS / name).read_text().splitlines()
    return page[: page.index(f"<!-- {marker} -->") + 1] + lines + page[page.index(f"<!-- /{marker} -->") :]


UNSTABLE = ("above its speed limit", "with torques at their limits", "hammered", "unstable")


def share(rows):
    asked = sum(row["length_asked"] or 0.0 for row in rows)
    return sum(row["length_promised"] or 0.0 for row in rows) / asked if asked else 0.0


FLOOR = 0.4  # of what a planner that knows the true surface could draw


def shy(row):
    """Less than FLOOR of what a perfect planner could draw is promised; where nothing is, nothing was measured."""
    return row["state"] == "nothing" or (row["length_promised"] or 0.0) < FLOOR * (row["length_reachable"] or 0.0)


def shy_list(rows):
    lines = []
    for row in filter(shy, rows):
        told = "nothing" if row["state"] == "nothing" else f"{100 * row['length_promised'] / row['length_reachable']:.0f} %"
        reasons = ", ".join(f"{k} {v}" for k, v in json.loads(row["not_drawn"] or "{}").items())
        lines.append(f"- `{row['case']}`: {told}" + (f" ({reasons})" if reasons else ""))
    return lines or ["None."]


def other_surfaces(rows, folder):
    _, lines, draw = surfaces(rows, folder, "Other surfaces", "`./impedraw sweep studies/other-surfaces.yaml`", "studies/other-surfaces.yaml")
    return "other_surface_cells.md", lines, draw


def surfaces(rows, folder, title="Surfaces", called="`./impedraw robustness --part surfaces`", study="studies/surfaces.yaml"):
    drawings = ("text", "spiral", "hatch")
    bad = sum(row["failed"] for row in rows)
    unstable = sum(any(words in (row["cause"] or "") for words in UNSTABLE) for row in rows)
    lines = [f"# {title}", "",
             f"{called}, {stamp(folder)}: {len(rows)} cells of `{study}`; **{bad} missed a limit**, "
             f"{unstable} were unstable; {100 * share(rows):.0f} % of the length that was asked for is promised. Each entry gives *ink error RMS [mm] / "
             "standard deviation of the normal force [N] / mean speed [mm/s] / share of the length promised*. **✗** marks a cell that stopped or "
             "missed a limit; the list below says which.", "",
             "The depths that the cameras measure have no noise here, and the wrench is the true one: on an arm with real sensors, expect larger errors. `scenarios/bowl-sine-realistic.yaml` "
             "shows what they cost on a smooth bowl, and `studies/other-surfaces.yaml` has meshes with noise in themselves.", "",
             f"A cell is also listed if less than {100 * FLOOR:.0f} % is promised of what a planner could draw that knows the true surface: what has the canvas below it where that leans "
             f"by less than 75°, within the arm's reach (`length_reachable`). {sum(map(shy, rows))} of {len(rows)} cells are."]  # fmt: skip
    for group in dict.fromkeys(row["group"] for row in rows):
        cells = {row["case"]: row for row in rows if row["group"] == group}
        lines += ["", f"## {group}", "", f"{100 * share(cells.values()):.0f} % of the length is promised.", "",
                  "| | " + " | ".join(drawings) + " |", "|---" * (len(drawings) + 1) + "|"]  # fmt: skip
        for surface in dict.fromkeys(case.rsplit("-", 1)[0] for case in cells):
            entries = []
            for drawing in drawings:
                row = cells.get(f"{surface}-{drawing}")
                if row is None:
                    entries.append("")
                    continue
                values = [digits(row[name]) for name in ("ink_error_rms", "force_sd", "speed_mean")]
                entries.append(("**✗** " if row["failed"] else "") + " / ".join([*values, f"{share([row]):.2f}"]))
            lines.append(f"| {surface} | " + " | ".join(entries) + " |")
    lines += ["", f"## Cells with less than {100 * FLOOR:.0f} % of what could be drawn", "", "Share promised of what a perfect planner could draw, and the pre-flight's reasons.", "", *shy_list(rows)]
    return "surface_cells.md", [*lines, "", "## Cells that missed a limit", "", *(failed_list(rows) or ["None."])], None


def entry(row, mean_force=False):
    if row is None:
        return ""
    if row["ink_error_rms"] is None:
        return failure(row).strip() or "–"
    values = [digits(row["ink_error_rms"]), digits(row["force_sd"])] + ([f"{row['force_mean']:.2f}"] if mean_force else [])
    return failure(row) + " / ".join(values)


def axis_of(cells):
    """The setting that the cells of a group differ in."""
    sets = [json.loads(row["set"]) for row in cells]
    return next((name for name in sets[0] if len({json.dumps(s.get(name)) for s in sets}) > 1), list(sets[0])[0])


def robustness(rows, folder):
    by_case, bad = {row["case"]: row for row in rows}, sum(row["failed"] for row in rows)
    slopes, speeds, forces = (0, 15, 30, 45, 60), (10, 50, 100, 200), (1, 5, 20)
    lines = ["# Robustness", "",
             f"`./impedraw robustness`, {stamp(folder)}: {len(rows)} cells, **{bad} failed**. Each entry gives *ink error RMS [mm] / standard deviation of the "
             "normal force [N]*, and in the last table also the *mean normal force [N]*. The desired force is 5 N unless the row gives another.", "",
             "The matrix of speeds, slopes and forces draws a circle on a leaning plane (`scenarios/robustness-nominal.yaml`, `robustness-realistic.yaml`). "
             "All other cells draw the standard sine and change what their row names. Every cell also sets `drawing.redraw=false` and "
             "`preflight.arm=false`, so that the law is judged without a second pass, also where the pre-flight would refuse.", "",
             "**✗** marks a failed cell. A cell fails if it is refused (the drawing cannot be planned), stops or takes too long; if a stroke has no ink "
             "(missed), if less than 98 % of the pen-down samples have ink (contact), if more than 5 % of the ink's length is over 1 mm from its target "
             "(astray), or if its mean speed is below 90 % of the desired speed (slow). `runs.parquet` of the [sweep](sweeps.md) has every setting and "
             "metric of each cell.", "",
             "![Error and force against slope, speed, force and each model error](robustness.png)"]  # fmt: skip
    for state in ("nominal", "realistic"):
        lines += ["", f"## Speed, slope and normal force: {state}", "", "| | " + " | ".join(f"{s}°" for s in slopes) + " |", "|---" * 6 + "|"]
        for force in forces:
            for speed in speeds:
                cells = [by_case.get(f"matrix-{state}-{speed}mm_s-{slope}deg-{force}N") for slope in slopes]
                lines.append(f"| {force} N, {speed} mm/s | " + " | ".join(map(entry, cells)) + " |")
    for prefix, title, tuning in (("error", "Each model error alone", "bowl-sine"),
                                  ("tuned", "What the controller is not told, under the tuning for real arms", "bowl-sine-real"),
                                  ("sensed", "What the controller is not told, under the nominal tuning with an ideal sensor", "bowl-sine-sensor")):  # fmt: skip
        lines += ["", f"## {title}", "", f"On `{tuning}`, where a row names no other scenario.", "", "| | first value | second | third |", "|---|---|---|---|"]
        for group in dict.fromkeys(row["group"] for row in rows if row["group"].startswith(prefix)):
            cells = [row for row in rows if row["group"] == group]
            if len(cells) == 1:
                lines.append(f"| {group.removeprefix(prefix + '-').replace('-', ' ')} | {entry(cells[0])} | | |")
                continue
            name = axis_of(cells)
            other = "" if (run := pathlib.Path(cells[0]["scenario"]).stem) == tuning else f", `{run}`"
            untold = ", not told" if any(k.endswith("sensor_delay") and not v for k, v in json.loads(cells[0]["set"]).items()) else ""
            lines.append(f"| `{name}`{other}{untold} | " + " | ".join(f"{json.loads(row['set'])[name]:g}: {entry(row)}" for row in cells) + " |")
    lines += ["", *kept("robustness.md", "## Two errors at once", "## Canvases, at 50 mm/s and 5 N")]
    lines += ["## Canvases, at 50 mm/s and 5 N", "", "| | nominal | realistic |", "|---|---|---|"]
    for canvas in dict.fromkeys(row["case"].split("-")[1] for row in rows if row["group"] == "canvas"):
        cells = [by_case.get(f"canvas-{canvas}-{state}") for state in ("nominal", "realistic")]
        lines.append(f"| {canvas.replace('_', ' ')} | " + " | ".join(map(entry, cells)) + " |")
    lines += ["", "## Effect of each switch", "", "| | off | on |", "|---|---|---|"]
    for case in dict.fromkeys(row["case"].rsplit("-", 1)[0] for row in rows if row["group"].startswith("switch")):
        group = by_case[f"{case}-off"]["group"]
        label = f"{group.removeprefix('switch-').replace('_', ' ')}: {case.removeprefix(group + '-')}"
        lines.append(f"| {label} | " + " | ".join(entry(by_case.get(f"{case}-{s}"), True) for s in ("off", "on")) + " |")
    return "robustness.md", [*lines, "", "## Failed cells", "", *failed_list(rows)], lambda: picture_of_robustness(rows, by_case, slopes, speeds, forces)


def two_errors(rows, folder):
    """The part of robustness.md between its markers: ink RMS / force SD of each pair, and of each error alone on the diagonal."""
    names = list(dict.fromkeys(name for row in rows for name in row["case"].split("-")[1].split("+")))
    cells = {frozenset(row["case"].split("-")[1].split("+")): row for row in rows}
    bad = sum(row["failed"] for row in rows)
    part = [f"`./impedraw sweep studies/two-errors.yaml`, {stamp(folder)}: {len(rows)} runs of `bowl-sine-real`, **{bad} failed**. The law is told none of them. On the "
            "diagonal one error alone; *ink error RMS [mm] / standard deviation of the normal force [N]*.", "",
            "| | " + " | ".join(name.replace("_", " ") for name in names) + " |", "|---" * (len(names) + 1) + "|"]  # fmt: skip
    for i, one in enumerate(names):
        part.append(f"| {one.replace('_', ' ')} | " + " | ".join(entry(cells.get(frozenset({one, other}))) if j >= i else "" for j, other in enumerate(names)) + " |")
    return "robustness.md", with_part("robustness.md", "two-errors", [*part, *(["", *failed_list(rows)] if bad else [])]), None


def picture_of_robustness(rows, by_case, slopes, speeds, forces):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e6e6ea"})
    groups = [g for g in dict.fromkeys(row["group"] for row in rows)
              if g.startswith(("error", "tuned", "sensed")) and sum(row["group"] == g for row in rows) > 1]  # fmt: skip
    across = 4
    down = math.ceil(len(groups) / across)
    figure = pyplot.figure(figsize=(14.5, 7.5 + 2.3 * down), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=[7, 2.3 * down])
    axes = top.subplots(2, 3, sharey="row")
    for i, (metric, title) in enumerate((("ink_error_rms", "ink error, RMS [mm]"), ("force_sd", "normal force, standard deviation [N]"))):
        for j, (label, values) in enumerate((("slope [deg]", slopes), ("speed [mm/s]", speeds), ("push [N]", forces))):
            ax = axes[i][j]
            for state, colour in (("nominal", BLUE), ("realistic", ORANGE)):
                for a in (speeds, slopes, slopes)[j]:
                    for b in (forces, forces, speeds)[j]:
                        def case(x, a=a, b=b, j=j, state=state):
                            speed, slope, force = ((a, x, b), (x, a, b), (b, a, x))[j]
                            return by_case.get(f"matrix-{state}-{speed}mm_s-{slope}deg-{force}N")
                        main = (a, b) == ((50, 5), (30, 5), (30, 50))[j]
                        found = [(x, row) for x in values if (row := case(x)) and row[metric]]
                        ax.plot([x for x, _ in found], [row[metric] for _, row in found], color=colour, lw=2 if main else 0.7, alpha=1 if main else 0.25,
                                marker="o" if main else "", ms=4, label=f"{state}, the others at 50 mm/s, 30°, 5 N" if main else None)  # fmt: skip
                        wrong = [(x, row[metric]) for x, row in found if row["failed"]]
                        ax.plot([x for x, _ in wrong], [y for _, y in wrong], "x", color=RED, ms=6, mew=2, zorder=3)
            ax.set_yscale("log")
            if j:
                ax.set_xscale("log")
            ax.set_xticks(values, [str(v) for v in values])
            ax.minorticks_off()
            ax.set_xlabel(label)
            ax.set_title(title if j == 0 else "", loc="left", fontsize=9)
    handles, labels = axes[0][0].get_legend_handles_labels()
    handles.append(pyplot.Line2D([], [], marker="x", color=RED, ls="", mew=2))
    top.legend(handles, [*labels, "failed"], loc="outside upper left", ncols=3, frameon=False)
    bottom.suptitle("Each model error alone (error), and what the controller is not told under the tuning for real arms (tuned) and the nominal one (sensed); all on the sine at 50 mm/s",
                    fontsize=10, x=0.01, ha="left")  # fmt: skip
    panels = bottom.subplots(down, across, squeeze=False, sharey=True)
    for ax, group in zip(panels.flat, groups):
        cells = [row for row in rows if row["group"] == group]
        name = axis_of(cells)
        places = range(len(cells))
        for metric, colour, mark, label in (("ink_error_rms", BLUE, "o", "ink error, RMS [mm]"), ("force_sd", GREEN, "s", "force, SD [N]")):
            found = [(x, row) for x, row in zip(places, cells) if row[metric]]
            ax.plot([x for x, _ in found], [row[metric] for _, row in found], color=colour, marker=mark, ms=4, label=label)
        for x, row in zip(places, cells):
            if row["failed"]:
                ax.plot([x], [row["ink_error_rms"] or 20.0], "x", color=RED, ms=7, mew=2)
        ax.set_yscale("log")
        ax.set_ylim(1e-3, 30)
        ax.set_xticks(list(places), [f"{json.loads(row['set'])[name]:g}" for row in cells])
        ax.set_xlim(-0.3, len(cells) - 0.7)
        ax.set_title(f"{group.split('-')[0]}: {name.split('.', 1)[1] if name.startswith('world.') else name}", loc="left", fontsize=8)
    for ax in list(panels.flat)[len(groups):]:
        ax.set_visible(False)
    panels[0][0].legend(frameon=False, fontsize=7, loc="upper left")
    figure.savefig(DOCS / "robustness.png", dpi=100)


def reach(rows, folder):
    text = (DOCS / "reach.md").read_text()
    tail = text[text.index("## Drawings"): text.index("## Parts that are not drawn")].rstrip()
    drawings = list(dict.fromkeys(row["case"].split("-on-")[0] for row in rows))
    canvases = list(dict.fromkeys(row["case"].split("-on-")[1] for row in rows))
    by_case, bad = {row["case"]: row for row in rows}, sum(row["failed"] for row in rows)
    asked, promised = (sum(row[n] or 0.0 for row in rows) / 1e3 for n in ("length_asked", "length_promised"))
    lines = ["# Reach", "",
             f"`./impedraw reach`, {stamp(folder)}: ten drawings on ten canvases. {len(rows)} combinations were run, and **{bad} missed a limit**. The pre-flight "
             f"promised {promised:.1f} m of the {asked:.1f} m asked for, and named the rest with its reason.", "",
             "A combination meets its limits if every stroke is drawn or named by the pre-flight, the coverage of the promised length is at least 0.995, the "
             "ink error is at most 0.2 mm RMS where the canvas leans by less than 45° from the drawing axis, and the program does not crash. `runs.parquet` of "
             "the [sweep](sweeps.md) has the other figures of each combination. `./impedraw reach --list` prints the command that draws it alone.", "",
             "![Each drawing on each canvas](reach.png)", "", "## Ink error [mm] / coverage", "",
             "| | " + " | ".join(canvases) + " |", "|---" * (len(canvases) + 1) + "|"]  # fmt: skip

    def of(drawing, canvas, write):
        row = by_case.get(f"{drawing}-on-{canvas}")
        return "" if row is None else ("**✗** " if row["failed"] else "") + write(row)

    def error(row):
        return f"{digits(row['ink_error_rms_to_45'] or row['ink_error_rms'])} / {row['coverage']:.4f}" if row["coverage"] is not None else "nothing"

    def length(row):
        promised, asked = round(row["length_promised"] or 0.0), round(row["length_asked"] or 0.0)
        return f"{asked} mm" if promised >= asked else f"**{promised}** of {asked} mm"

    for drawing in drawings:
        lines.append(f"| {drawing} | " + " | ".join(of(drawing, c, error) for c in canvases) + " |")
    lines += ["", "## Promised length", "", "Length in the drawing plane that the pre-flight promised. Bold: less than asked for.", "",
              "| | " + " | ".join(canvases) + " |", "|---" * (len(canvases) + 1) + "|"]  # fmt: skip
    for drawing in drawings:
        lines.append(f"| {drawing} | " + " | ".join(of(drawing, c, length) for c in canvases) + " |")
    lines += ["", tail, "", "## Parts that are not drawn", "",
              "Parts of strokes by reason. `./impedraw plan` with scenario and drawing lists them one by one.", "", "| | [mm] | parts by reason |", "|---|---|---|"]  # fmt: skip
    for row in rows:
        if row["length_undrawable"]:
            reasons = json.loads(row["not_drawn"] or "{}")
            lines.append(f"| `{row['case']}` | {row['length_undrawable']:.0f} | " + "; ".join(f"{k} {v}" for k, v in reasons.items()) + " |")
    lines += ["", "## Combinations that missed a limit", "", *failed_list(rows)] if bad else []
    return "reach.md", lines, lambda: picture_of_reach(by_case, drawings, canvases, folder)


def picture_of_reach(by_case, drawings, canvases, folder):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(len(drawings), len(canvases), figsize=(1.7 * len(canvases), 1.9 * len(drawings)), layout="constrained")
    for i, drawing in enumerate(drawings):
        for j, canvas in enumerate(canvases):
            ax, row = axes[i][j], by_case.get(f"{drawing}-on-{canvas}")
            ax.set_xticks([])
            ax.set_yticks([])
            found = sorted((folder / "kept").glob(f"{row['key']}*/**/ink_top.png")) if row else []
            if found:
                ax.imshow(pyplot.imread(found[0]))
            if row:
                ax.set_xlabel("nothing to draw" if row["coverage"] is None else f"{digits(row['ink_error_rms_to_45'])} mm  {row['coverage']:.4f}", fontsize=7)
            if i == 0:
                ax.set_title(canvas, fontsize=9)
            if j == 0:
                ax.set_ylabel(drawing, fontsize=9)
    figure.savefig(DOCS / "reach.png", dpi=100)


# What the scenarios of a moving canvas shall keep to: contact at least; ink RMS, ink max [mm], force SD [N], tilt [deg], touchdown [N] at most.
MOVING = {
    "moving-conveyor": ("60 mm/s along −y", 0.999, 0.3, 1.0, 0.2, 1, 8),
    "moving-turntable": ("10 °/s about the bowl's axis", 0.999, 0.4, 1.2, 0.2, 1, 8),
    "moving-heave": ("± 50 mm vertical at 0.5 Hz", 0.999, 0.4, 1.2, 0.3, 1, 9),
    "moving-sway": ("± 50 mm along y at 0.5 Hz, ± 5° of roll at 0.3 Hz", 0.995, 0.6, 2, 0.4, 1.5, 9),
    "moving-jolts": ("noise, flat to 1 Hz, 15 mm RMS per axis", 0.99, 1.0, 4, 0.6, 2, 10),
    "moving-lost": ("conveyor; no frames for 0.5 s; the arm hides half of the bowl", 0, math.inf, math.inf, math.inf, math.inf, 10),
    "standing-noisy": ("none", 1, 0.05, 0.25, 0.1, 0.3, 8),
}
MOVING_METRICS = (("contact_fraction", 3), ("ink_error_rms", 3), ("ink_error_max", 3), ("force_sd", 3), ("tilt_mean", 2), ("touchdown_peak", 1), ("coverage", 2))
SWITCHES = {"both": "as it is", "no_prediction": "without prediction", "no_feedforward": "without feed-forward"}
BUDGET = {
    "nothing": "nothing",
    "noise": "the marks' noise",
    "latency": "latency, jitter and lost frames",
    "estimate": "the estimate: the pose is told exactly (`perception.canvas_pose=true`)",
}
MAPS = {"both": "", "no_prediction": "-no_prediction", "no_feedforward": "-no_feedforward"}  # how their cases end


def worst_of_scenario(rows, group, prefix):
    """The worst of each metric, marked where it misses its limit."""
    cells = [row for row in rows if row["group"] == group and row["case"].startswith(prefix)]
    limits = next(limits for name, (_, *limits) in MOVING.items() if name in prefix)
    texts = []
    for (metric, places), limit in zip(MOVING_METRICS, limits + [0]):
        least = metric in ("contact_fraction", "coverage")
        worst = (min if least else max)((0 if least else math.inf) if row[metric] is None else row[metric] for row in cells)
        missed = worst < limit if least else worst > limit
        texts.append(("**✗** " if missed else "") + f"{worst:.{places}f}")
    return texts


HANDS = {  # worst allowed: contact, ink RMS, coverage; touchdown and largest force [N]
    "hand": ("hand, 10 mm RMS, its spectrum falls as f⁻⁴ above 0.5 Hz", 0.995, 0.7, 0.85, 9, math.inf),
    "hand-tremor": ("the same, and 0.15 mm RMS at 9 Hz", 0.99, 0.7, 0, 9, math.inf),
    "turning-hand": ("hand, 5 mm and 0.5° RMS, the same spectrum", 0.99, 0.5, 0, 9, math.inf),
    "turning-hand-tremor": ("the same, and 0.15 mm RMS at 9 Hz", 0.99, 0.5, 0, 9, math.inf),
    "jolts-2Hz": ("noise, flat to 2 Hz, 5 mm RMS per axis", 0.99, 1.0, 0, 12, math.inf),
    "indexing": ("conveyor, 40 mm in 0.6 s, rests of 0.9 s", 0.99, 0.6, 0, 9, math.inf),
    "bumps": ("bumps, 6 mm vertical in 0.3 s, every 1.5 s", 0.98, 0.5, 0, 12, 12),
    "hits": ("80 mm vertical there and back in 1 s, at up to 0.3 m/s", 0, math.inf, 0, math.inf, 12),
}


def hands(rows, folder):
    """The part of moving.md between its markers: the worst of each kind of motion, marked where it misses its limit."""
    shown = (("contact_fraction", 3), ("ink_error_rms", 2), ("ink_error_max", 2), ("force_sd", 2), ("contact_force_max", 1), ("touchdown_peak", 1), ("coverage", 2))
    lines = [f"`./impedraw sweep studies/hands.yaml`, {stamp(folder)}: the worst of sine and M on six seeds of the motion; hits: of \"hi\", whose strokes the pen lifts between.", "",
             "| motion | runs | contact | ink RMS [mm] | ink max [mm] | force SD [N] | largest force [N] | touchdown [N] | coverage |", "|---" * 9 + "|"]  # fmt: skip
    for kind, (what, contact, ink, coverage, touchdown, largest) in HANDS.items():
        cells = [row for row in rows if re.fullmatch(rf"{kind}-\d-\w+", row["case"])]
        limits = {"contact_fraction": contact, "ink_error_rms": ink, "coverage": coverage, "touchdown_peak": touchdown, "contact_force_max": largest}
        texts = []
        for metric, places in shown:
            sign = -1.0 if metric in ("contact_fraction", "coverage") else 1.0
            worst = max((math.inf if row[metric] is None else sign * row[metric]) for row in cells)
            missed = worst > sign * limits.get(metric, math.inf)
            texts.append(("**✗** " if missed else "") + (f"{sign * worst:.{places}f}" if math.isfinite(worst) else "–"))
        lines.append(f"| {what} | {len(cells)} | " + " | ".join(texts) + " |")
    return "moving.md", with_part("moving.md", "hands", lines + ["", *failed_list(rows)]), None


def moving(rows, folder):
    by_case, bad = {row["case"]: row for row in rows}, [row for row in rows if row["failed"]]
    as_it_is = [row for row in bad if not row["case"].endswith(("-no_prediction", "-no_feedforward"))]
    lines = ["# A canvas that moves", "",
             "Three cameras keep capturing at 30 Hz, 60 ms late with 10 ms of jitter, one frame in twenty dropped; they find four marks on the bowl's rim, each with "
             "0.3 mm of noise per axis, camera and frame. The surface is known from one snapshot with 1 mm of depth noise at 1 m, unless frames have depths. The arm watches for 6 s, then draws "
             "with 5 N at 50 mm/s along the canvas. All errors are measured in the canvas's own frame.", "",
             *kept_paragraph("moving.md", "The arm is ideal here"), "",
             f"`./impedraw sweep studies/moving.yaml`, {stamp(folder)}: {len(rows)} runs, **{len(bad)} failed**, all but {len(as_it_is)} of them without prediction or feed-forward. A "
             "run fails if it stops, if a stroke has no ink, if the pen is off the canvas for more than 2 % of the time, or if the ink error is over 1 mm RMS.", "",
             "![The arm draws \"Hi\" on a bowl that sways and rolls, three times as fast as it goes](images/moving-sway.webp)", "",
             "![Ink error and force against speed, latency, amplitude and frequency](moving.png)", "",
             "## Scenarios", "", *kept_paragraph("moving.md", "The worst of sine and M on five seeds."), "",
             "| scenario | motion | contact | ink RMS [mm] | ink max [mm] | force SD [N] | tilt mean [deg] | touchdown [N] | coverage |", "|---" * 9 + "|"]  # fmt: skip
    for name, (motion, *_) in MOVING.items():
        lines.append(f"| `{name}` | {motion} | " + " | ".join(worst_of_scenario(rows, "scenarios", name + "-")) + " |")
    lines += ["", *kept("moving.md", "## Hands and machines", "## Where the error comes from")]
    lines += ["## Where the error comes from", "",
              "Ink RMS [mm] / force SD [N] of the sine, without one source of error at a time. A canvas with acceleration a, not foreseen, moves by ½ a τ² while a frame is τ = "
              "60 ms + half a frame's interval, 77 ms, late: by 1.0 mm RMS in sway (a = 350 mm/s² RMS) if only its velocity were known, by 1.4 mm in jolts (460 mm/s² "
              "RMS, 265 mm/s² per axis).", "",
              "| left out | sway | jolts |", "|---|---|---|"]  # fmt: skip
    for part, what in BUDGET.items():
        lines.append(f"| {what} | " + " | ".join(entry(by_case[f"{on}-both" if part == "nothing" else f"budget-{on}-{part}"]) for on in ("sway", "jolts")) + " |")
    lines += ["", "What the controller adds is the last line. Without the marks' noise a sway is foreseen almost exactly. Jolts are not: the later the frames, the further a motion "
              "that noise blurs is extrapolated.", "", "## What prediction and feed-forward are worth", "", "Sine, ink RMS [mm] / force SD [N] / contact.", "",
              "| | " + " | ".join(SWITCHES.values()) + " |", "|---" * 4 + "|"]  # fmt: skip
    for motion in dict.fromkeys(row["case"].split("-")[0] for row in rows if row["group"].endswith("-switched")):
        cells = [by_case[f"{motion}-{switch}"] for switch in SWITCHES]
        lines.append(f"| {motion} | " + " | ".join(f"{entry(c)} / {c['contact_fraction']:.3f}" for c in cells) + " |")
    lines += ["", "## Depths in the frames", "",
              "Each frame of 320 × 240 px also has depths (`perception.frames.depth=true`), in which the surface is found again: in each frame (30 Hz), or "
              "in every sixth (5 Hz). The worst of sine and M on two seeds. `./impedraw bench` "
              "measures what frames cost.", "",
              "| scenario | depths | contact | ink RMS [mm] | ink max [mm] | force SD [N] | tilt mean [deg] | touchdown [N] | coverage |", "|---" * 9 + "|"]  # fmt: skip
    for name in MOVING:
        for depths in ("30Hz", "5Hz"):
            case = f"{depths}-{name}-"
            lines.append(f"| `{name}` | {depths.replace('Hz', ' Hz')} | " + " | ".join(worst_of_scenario(rows, "depths", case)) + " |")
    lines += ["", "Terrain has no marks, and moves as in `moving-sway`: its shape alone tells where it is. Sine, the worse of two seeds.", "",
              "| depths | ink RMS [mm] | force SD [N] | contact |", "|---" * 4 + "|"]  # fmt: skip
    for depths in ("30Hz", "5Hz"):
        cells = [row for row in rows if row["case"].startswith(f"shape-{depths}-")]
        worst = [max(row[m] or math.inf for row in cells) for m in ("ink_error_rms", "force_sd")]
        lines.append(f"| {depths.replace('Hz', ' Hz')} | {worst[0]:.3f} | {worst[1]:.3f} | {min(row['contact_fraction'] for row in cells):.3f} |")
    lines += ["", "## What frames add to the surface", "",
              "A canvas that stands, with depths in each frame. The surface under the pen is that of one snapshot (`perception.frames.grow_surface=false`), or that "
              "of all frames so far. Sine, the worse of two seeds.", "",
              "| surface | normal off, mean [deg] | tilt mean [deg] | ink RMS [mm] | ink max [mm] | force SD [N] |", "|---" * 6 + "|"]  # fmt: skip
    for surface in ("snapshot", "grown"):
        cells = [row for row in rows if row["group"] == "standing" and row["case"].startswith(f"standing-{surface}-")]
        worst = [max(row[m] for row in cells) for m in ("normal_error_mean", "tilt_mean", "ink_error_rms", "ink_error_max", "force_sd")]
        lines.append(f"| {surface} | " + " | ".join(f"{x:.3f}" for x in worst) + " |")
    speeds, latencies = levels(rows, "conveyor", r"conveyor-(.+)mm_s-(.+)s")
    amplitudes, frequencies = levels(rows, "heave", r"heave-(.+)mm-(.+)Hz")
    maps = (("Speed and latency", "A letter of 30 mm on a conveyor, ink RMS [mm] / force SD [N].",
             "latency", latencies, lambda y: f"{1e3 * y:g} ms", speeds, "mm/s", lambda x, y: f"conveyor-{x:g}mm_s-{y:g}s"),
            ("Amplitude and frequency", "The same letter in a bowl that heaves, 60 ms late.",
             "amplitude", amplitudes, lambda y: f"± {y:g} mm", frequencies, "Hz", lambda x, y: f"heave-{y:g}mm-{x:g}Hz"))  # fmt: skip
    for title, what, down, ys, label, xs, unit, case in maps:
        lines += ["", f"## {title}", "", what]
        for switch, how in SWITCHES.items():
            lines += ["", f"{how.capitalize()}:", "", f"| {down} | " + " | ".join(f"{x:g} {unit}" for x in xs) + " |", "|---" * (len(xs) + 1) + "|"]
            for y in ys:
                lines.append(f"| {label(y)} | " + " | ".join(entry(by_case[case(x, y) + MAPS[switch]]) for x in xs) + " |")
    lines += ["", "## Where the canvas will be", "",
              "After the arm has watched, and again before each stroke, the plan is checked where the canvas will be ([decision 40](decisions/0040-reach-of-a-moving-canvas.md)). "
              "`scenarios/moving-order.yaml`: a conveyor takes two dashes out of reach one after the other; the one that leaves first is drawn first. `scenarios/moving-swing.yaml`: a "
              "swing of ± 200 mm brings a dash into reach for 3.8 s at a time; the pen waits. A line that fits nowhere as a whole is cut. What fits nowhere is named with when and how far, in `strokes.json` under "
              "`unreached` with `--skip-unreachable`, else the run ends."]  # fmt: skip
    return ("moving.md", [*lines, "", "## Failed runs", "", "With prediction and feed-forward:", "", *failed_list(as_it_is)],
            lambda: picture_of_moving(by_case, speeds, latencies, amplitudes, frequencies))


def levels(rows, group, pattern):
    found = [re.fullmatch(pattern, row["case"]).groups() for row in rows if row["group"] == group]
    return (sorted({float(pair[i]) for pair in found}) for i in (0, 1))


def picture_of_moving(by_case, speeds, latencies, amplitudes, frequencies):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(4, 3, figsize=(16, 15), layout="constrained")
    maps = (("conveyor", "speed along the canvas's way [mm/s]", speeds, "latency of the frames [ms]", latencies, lambda x, y: f"conveyor-{x:g}mm_s-{y:g}s", 1e3),
            ("heave", "frequency [Hz]", frequencies, "amplitude [mm]", amplitudes, lambda x, y: f"heave-{y:g}mm-{x:g}Hz", 1))  # fmt: skip
    metrics = (("ink_error_rms", "ink RMS [mm]", 0.01, 3), ("force_sd", "force SD [N]", 0.01, 3))
    lines = [(one, metric) for one in maps for metric in metrics]
    for line, ((title, x_label, xs, y_label, ys, case, scale), (metric, what, least, most)) in zip(axes, lines):
        for ax, (switch, how) in zip(line, SWITCHES.items()):
            rows = [[by_case[case(x, y) + MAPS[switch]] for x in xs] for y in ys]
            shown = [[math.nan if c[metric] is None else min(max(c[metric], least), most) for c in row] for row in rows]
            image = ax.imshow(shown, origin="lower", aspect="auto", cmap="YlGnBu", norm=matplotlib.colors.LogNorm(least, most))
            for i, row in enumerate(rows):
                for j, c in enumerate(row):
                    dark = not math.isnan(shown[i][j]) and shown[i][j] > math.sqrt(least * most)
                    text = ("" if c[metric] is None else digits(c[metric])) + ("\n✗" if c["failed"] else "")
                    ax.text(j, i, text, ha="center", va="center", fontsize=9, color="#ff8080" if dark and c["failed"] else RED if c["failed"] else "white" if dark else "black")
            ax.set_xticks(range(len(xs)), [f"{x:g}" for x in xs])
            ax.set_yticks(range(len(ys)), [f"{scale * y:g}" for y in ys])
            ax.set_xlabel(x_label)
            ax.set_ylabel(y_label)
            ax.set_title(f"{title}, {how}: {what}", loc="left", fontsize=10)
        figure.colorbar(image, ax=line)
    figure.savefig(DOCS / "moving.png", dpi=100)


PAGES = {"surfaces": surfaces, "other-surfaces": other_surfaces, "robustness": robustness, "two-errors": two_errors, "reach": reach, "moving": moving, "hands": hands}


def page(study, folder, check=False):
    """Writes a study's page and picture from its data set, or says what of the page is stale. Exits where the sources had been changed."""
    rows = rows_of(folder)
    name, lines, draw = PAGES[study](rows, folder)
    if check:
        return stale(f"docs/{name}", (DOCS / name).read_text().splitlines(), lines)
    if stamp(folder).endswith("+"):
        sys.exit(f"{folder}: was measured on changed sources ({stamp(folder)}); commit first, then run it again")
    (DOCS / name).write_text("\n".join(lines) + "\n")
    if draw:
        draw()
    print(f"docs/{name}: {len(rows)} cells, {sum(row['failed'] for row in rows)} missed a limit")
    return []


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in PAGES:
        sys.exit(__doc__)
    page(sys.argv[1], pathlib.Path(sys.argv[2]))


if __name__ == "__main__":
    main()
