"""Measures the numbers that README and docs quote, and writes them into these documents.

    ./impedraw figures                 run everything that README.md and docs quote, write
                                       docs/figures.json, fill in the documents
    ./impedraw figures --check         run it and write nothing; exit code 1 where a quoted number
                                       is off by more than one in its last digit
    ./impedraw figures --rows readme   only what README.md quotes
    ./impedraw figures --fill          run nothing: fill in the documents from docs/figures.json
    ./impedraw figures --speeds        also measure how fast each standard scenario runs, seven
                                       times each; speeds are never compared
    ./impedraw figures --bounds        measure the tests' regression bounds again:
                                       tests/run/bounds.json
    ./impedraw figures --pictures      run what the pictures of README and docs show, and write
                                       docs/images; a picture says in itself what was measured, and
                                       --check compares that, too
    ./impedraw figures --pages [STUDY …]
                                       run the long studies and write their pages (study_pages.py);
                                       with --check, compare
    ./impedraw figures --list          every figure and table that a document can quote

A figure's id is RUN.METRIC, as in bowl-sine.ink_error_rms. METRIC is a key of metrics.json. For a
run with several seeds, RUN is the first seed, RUN@3 is seed 3, and RUN@worst is the worst of all.
quotes.py defines the markers. The runs are those of studies/figures.yaml.

Runs take libm's code for any x86-64 (ANY_PROCESSOR): with FMA, exp, sin and their like differ in the
last bit, and where encoders round, so do figures in their third digit.
"""

import argparse
import functools
import json
import math
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field

sys.dont_write_bytecode = True
import quotes
from figure_tables import STANDARD, TABLES, Tables

ROOT = pathlib.Path(__file__).resolve().parent.parent
BOUNDS = ROOT / "tests/run/bounds.json"
FIGURES = ROOT / "docs/figures.json"
STUDY = ROOT / "studies/figures.yaml"
ANY_PROCESSOR = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"}
REUSE = False  # --reuse: what this build has run already is not run again

UNITS = {
    "mm": "ink_error_rms ink_error_p95 ink_error_max longest_gap ink_up cloud_bias_mean "
    "cloud_bias_sd yield yield_last back back_early ink_error_rms_to_45 length_asked length_promised "
    "length_undrawable length_unnamed length_reachable",
    "N": "force_mean force_sd force_rms_error force_peak touchdown_peak",
    "deg": "tilt_mean tilt_p95 tilt_max normal_error_mean normal_error_p95 slope_max",
    "mm/s": "speed_mean speed_p95",
    "s": "draw_time planned_time",
    "rad": "joint_margin_min",
}
UNIT_OF = {metric: unit for unit, metrics in UNITS.items() for metric in metrics.split()}
# These depend on the machine.
WALL_TIMES = set("step_time_p50 step_time_p99 step_time_p999 real_time_factor".split())

@dataclass
class Run:
    """The cases of one block of STUDY: their commands by seed, as words after `./impedraw`."""

    commands: dict[int, list[str]] = field(default_factory=dict)

    @property
    def seeds(self) -> list[int]:
        return list(self.commands)

    def command(self, seed: int) -> list[str]:
        return self.commands[seed]


def bounds() -> dict:
    return json.loads(BOUNDS.read_text())


def sweep(*arguments: str | pathlib.Path) -> list[str | pathlib.Path]:
    """`./impedraw sweep` of STUDY, whose environment ./impedraw has made."""
    python = ROOT / "build/sweep-venv/bin/python"
    return [python, "-P", "-m", "impedraw.sweep", STUDY, "--root", ROOT, *arguments]


@functools.cache
def runs() -> dict[str, Run]:
    """Every run that a document can quote, in the study's order."""
    listed = subprocess.run(sweep("--list"), capture_output=True, text=True)
    if listed.returncode != 0:
        raise RunFailed(listed.stderr.strip().removeprefix("impedraw: "))
    lines = listed.stdout.splitlines()
    table: dict[str, Run] = {}
    for case, command in zip(lines[::2], lines[1::2], strict=True):
        name, _, seed = case.partition("@")
        table.setdefault(name, Run()).commands[int(seed or 1)] = shlex.split(command)[1:]
    return table


# --- Running --------------------------------------------------------------------------------------


class RunFailed(Exception):
    pass


def program() -> str:
    return os.environ.get("IMPEDRAW_PROGRAM", str(ROOT / "build/release/src/app/impedraw"))


# pyarrow stands in the sweep's environment, h5py in the program's.
READ = """import json, sys, pyarrow.parquet
table = pyarrow.parquet.read_table(sys.argv[1])
metrics = [f.name for f in table.schema if f.type == "double" and "." not in f.name]
metrics.remove("wall_time")
json.dump(table.select(["case", "key", "failed", "cause", *metrics]).to_pylist(), sys.stdout, default=str)"""


def swept(names: set[str], folder: pathlib.Path) -> dict[str, dict]:
    """Runs `names` and returns the data set's rows by case. What the study keeps of a case is at
    folder/runs/CASE."""
    cases = "|".join(re.escape(name) for name in sorted(names))
    done = subprocess.run(
        [*sweep("--only", f"^({cases})(@.*)?$", "--program", program(), "--out", folder),
         *([] if REUSE else ["--again"])],
        stdout=subprocess.DEVNULL, env=os.environ | ANY_PROCESSOR,
    )
    if done.returncode != 0:
        raise RunFailed(f"the sweep of {STUDY.relative_to(ROOT)} ended with {done.returncode}")
    table = subprocess.run(
        [ROOT / "build/sweep-venv/bin/python", "-c", READ, folder / "runs.parquet"],
        check=True, capture_output=True, text=True,
    ).stdout
    rows = {row["case"]: row for row in json.loads(table)}
    shutil.rmtree(folder / "runs", ignore_errors=True)
    (folder / "runs").mkdir()
    for case, row in rows.items():
        if row["failed"]:
            name, _, seed = case.partition("@")
            command = shlex.join(runs()[name].command(int(seed or 1)))
            raise RunFailed(f"./impedraw {command}: {row['cause']}")
        if (folder / "kept" / row["key"]).is_dir():
            (folder / "runs" / case).symlink_to(pathlib.Path("../kept") / row["key"])
    return rows


def push_response(folder: pathlib.Path) -> dict:
    """The pen's displacement in bowl-push relative to bowl-sine, during and after the push [mm]."""
    import h5py
    import numpy as np

    with h5py.File(folder / "bowl-push/run.h5") as pushed, h5py.File(
        folder / "bowl-sine/run.h5"
    ) as alone:
        n = min(len(pushed["time"]), len(alone["time"]))  # what the push left without ink is redrawn
        force = pushed["disturbance/force"][:n]
        moved = 1e3 * (pushed["tip/position"][:n] - alone["tip/position"][:n])
    rows = np.flatnonzero(np.linalg.norm(force, axis=1) > 1.0)
    first, last = rows[0], rows[-1]
    unit = force[first : last + 1] / np.linalg.norm(force[first : last + 1], axis=1, keepdims=True)
    along = np.einsum("ij,ij->i", moved[first : last + 1], unit)
    away = np.linalg.norm(moved, axis=1)
    return {
        "yield": along[300:].mean(),
        "yield_last": along[-1],
        "back": away[last + 300 : last + 1300].max(),
        "back_early": away[last + 200 : last + 1300].max(),
    }


def measure(names: set[str], folder: pathlib.Path) -> dict[str, dict]:
    """Runs `names`. Returns the metrics by RUN, RUN@SEED and RUN@worst."""
    if "bowl-push" in names:
        names = names | {"bowl-sine"}
    if not names:
        return {}
    measured = swept(names, folder)
    if "bowl-push" in measured:
        measured["bowl-push"].update(push_response(folder / "runs"))
    for name in names:
        seeds = runs()[name].seeds
        if len(seeds) > 1:
            measured[name] = measured[f"{name}@{seeds[0]}"]
            measured[f"{name}@worst"] = worst([measured[f"{name}@{seed}"] for seed in seeds])
    return measured


def worst(of: list[dict]) -> dict:
    """For each metric, the value furthest from its best value."""
    best = bounds()["best"]
    return {
        metric: max((m[metric] for m in of), key=lambda v: abs(v - best[metric]))
        for metric in best
        if all(isinstance(m.get(metric), (int, float)) for m in of)
    }


def commit() -> str:
    """HEAD, with a + if files that a drawing depends on have changed since."""

    def git(*arguments):
        return subprocess.run(
            ["git", *arguments], cwd=ROOT, capture_output=True, text=True
        ).stdout.strip()

    return git("rev-parse", "--short", "HEAD") + (
        "+" if git("status", "--porcelain", "--", "src", "scenarios", "models", "artwork") else ""
    )


def machine() -> str:
    model = "unknown processor"
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            model = line.partition(":")[2].strip()
            break
    return f"{model}, {os.cpu_count()} cores"


# --- Figures --------------------------------------------------------------------------------------


def page_figures() -> dict[str, dict]:
    """Figures from the generated pages of the long studies."""
    figures = {}
    page = ROOT / "docs/reach.md"
    cells, rows = [], []
    for line in page.read_text().splitlines() if page.exists() else []:
        if line.startswith("## "):
            rows = cells if line == "## Ink error [mm] / coverage" else []
        rows += [c.split("/") for c in line.split("|") if "/" in c and line.startswith("|")]
    if cells:
        for name, pick, column, unit in (
            ("worst_rms", max, 0, "mm"),
            ("least_coverage", min, 1, "1"),
        ):
            figures[f"reach.{name}"] = {
                "value": pick(float(c[column]) for c in cells),
                "unit": unit,
                "command": "./impedraw reach",
                "scenario": "docs/reach.md",
                "commit": None,
            }
    return figures


def as_figures(measured: dict[str, dict]) -> dict[str, dict]:
    table, at = runs(), commit()
    figures = page_figures()
    for key, metrics in measured.items():
        name, _, which = key.partition("@")
        run = table[name]
        seed = int(which) if which.isdigit() else run.seeds[0]
        command = shlex.join(["./impedraw", *run.command(seed)])
        if which == "worst":
            command = command.replace("seed=1", "seed=" + "|".join(map(str, run.seeds)))
        scenario = next(a for a in run.command(seed) if a.startswith("scenarios/"))
        for metric, value in metrics.items():
            if isinstance(value, (int, float)) and metric not in WALL_TIMES:
                figures[f"{key}.{metric}"] = {
                    "value": float(f"{value:.6g}"),
                    "unit": UNIT_OF.get(metric, "1"),
                    "command": command,
                    "scenario": scenario,
                    "commit": at,
                }
    return figures


def speed(command: list[str], out: pathlib.Path) -> float:
    shutil.rmtree(out, ignore_errors=True)
    done = subprocess.run(
        [program(), *command, "--out", str(out)], cwd=ROOT, capture_output=True, text=True
    )
    if done.returncode != 0:
        raise RunFailed(f"./impedraw {shlex.join(command)}: {done.stderr.strip()}")
    return json.loads((out / "metrics.json").read_text())["real_time_factor"]


def speeds(folder: pathlib.Path) -> dict[str, dict]:
    """Measures real-time factors, one run at a time so that runs do not slow each other."""
    table, at, figures = runs(), commit(), {}
    for name in STANDARD:
        factors = sorted(speed(table[name].command(1), folder / "speed") for _ in range(7))
        for which, value in (("median", factors[3]), ("slowest", factors[0])):
            figures[f"{name}.real_time_factor_{which}"] = {
                "value": float(f"{value:.3g}"),
                "unit": "1",
                "command": shlex.join(["./impedraw", *table[name].command(1)]),
                "scenario": f"scenarios/{name}.yaml",
                "commit": at,
                "machine": machine(),
                "compared": False,
            }
    return figures


# --- Documents ------------------------------------------------------------------------------------


def documents(rows: str) -> list[pathlib.Path]:
    return [ROOT / "README.md"] + (
        [] if rows == "readme" else sorted((ROOT / "docs").rglob("*.md"))
    )


def shown(rows: str) -> list[pathlib.Path]:
    """The pictures that say what was measured; of README, the one with numbers to read."""
    images = ROOT / "docs/images"
    return [images / "drawn.png"] if rows == "readme" else sorted(images.glob("*.png"))


def text_of(page: pathlib.Path) -> str:
    """A document, or what a picture says of itself, in the same markers."""
    if page.suffix != ".png":
        return page.read_text()
    from PIL import Image

    with Image.open(page) as picture:
        return picture.info.get("figures", "")


def tables(figure: Callable[[str], dict | None]) -> Tables:
    commands = {n: shlex.join(["./impedraw", *r.command(r.seeds[0])]) for n, r in runs().items()}
    return Tables(figure, bounds(), commands)


def needed_runs(pages: list[pathlib.Path]) -> set[str]:
    """The runs that the documents quote. A table reports the figures that it uses."""
    asked = set()
    table = tables(lambda key: asked.add(key))
    for page in pages:
        numbers, names = quotes.wanted(text_of(page))
        asked |= set(numbers)
        for name in set(names) & set(TABLES):
            table(name)
    return {key.rpartition(".")[0].partition("@")[0] for key in asked} & set(runs())


def fill_all(pages: list[pathlib.Path], figures: dict[str, dict], write: bool) -> list[str]:
    stale = []

    def value(key):
        if key not in figures:
            raise KeyError("./impedraw figures --list has those that there are")
        return figures[key]["value"]

    for page in pages:
        text = text_of(page)
        name = str(page.relative_to(ROOT))
        filled, old = quotes.fill(name, text, value, tables(figures.get))
        stale += old
        if page.suffix == ".png" and not text:
            stale.append(f"{name}: does not say what was measured; ./impedraw figures --pictures "
                         "draws it again")
        if write and filled != text and page.suffix != ".png":
            page.write_text(filled)
    return stale


def write_figures(figures: dict[str, dict]) -> None:
    lines = ",\n".join(
        "  " + json.dumps({"id": key, **figures[key]}, ensure_ascii=False)
        for key in sorted(figures)
    )
    FIGURES.write_text("[\n" + lines + "\n]\n")


def read_figures() -> dict[str, dict]:
    entries = json.loads(FIGURES.read_text()) if FIGURES.exists() else []
    return {e.pop("id"): e for e in entries}


def write_bounds(measured: dict[str, dict]) -> None:
    table = bounds()
    for name, entry in table["runs"].items():
        of = measured.get(f"{name}@worst", measured[name])
        for metric, bound in entry["bounds"].items():
            bound["measured"] = float(f"{of[metric]:.6g}")
    lines = []
    for name, entry in table["runs"].items():
        inner = ",\n".join(
            f'        "{metric}": {json.dumps(b)}' for metric, b in entry["bounds"].items()
        )
        lines.append(
            f'    "{name}": {{\n      "scenario": {json.dumps(entry["scenario"])}, '
            f'"set": {json.dumps(entry["set"])}, '
            f'"seeds": {json.dumps(entry["seeds"])},\n      "bounds": {{\n{inner}\n      }}\n    }}'
        )
    BOUNDS.write_text(
        '{\n  "best": '
        + json.dumps(table["best"])
        + ',\n  "resolution": '
        + json.dumps(table["resolution"])
        + ',\n  "runs": {\n'
        + ",\n".join(lines)
        + "\n  }\n}\n"
    )


def study_pages_of(names: list[str], folder: pathlib.Path, check: bool) -> int:
    import study_pages

    stale = []
    for name in names or study_pages.PAGES:
        if name not in study_pages.PAGES:
            raise RunFailed(f"--pages {name}: no study; valid are {', '.join(study_pages.PAGES)}")
        if name == "other-surfaces":
            subprocess.run([sys.executable, ROOT / "setup/other_surfaces.py"], check=True)
        if name == "hands":
            subprocess.run([sys.executable, ROOT / "setup/hand_motions.py", ROOT / "build/motions"], check=True)
        command = [*sweep("--program", program(), "--out", folder / name)]
        command[command.index(STUDY)] = ROOT / f"studies/{name}.yaml"
        if not REUSE:
            command.append("--again")
        done = subprocess.run(command, stdout=subprocess.DEVNULL, env=os.environ | ANY_PROCESSOR)
        if done.returncode != 0:
            raise RunFailed(f"the sweep of studies/{name}.yaml ended with {done.returncode}")
        stale += study_pages.page(name, folder / name, check)
    for line in stale:
        print(line)
    if check:
        print(f"{len(stale)} places of pages are stale" if stale else "every page holds")
    return 1 if stale else 0


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="impedraw figures",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--rows", choices=["readme", "all"], default="all")
    parser.add_argument("--fill", action="store_true")
    parser.add_argument("--speeds", action="store_true")
    parser.add_argument("--bounds", action="store_true")
    parser.add_argument("--pictures", action="store_true")
    parser.add_argument("--pages", nargs="*", metavar="STUDY")
    parser.add_argument("--list", action="store_true")
    parser.add_argument(
        "--out", type=pathlib.Path, default=ROOT / "build/figures-runs", help="where the runs go"
    )
    parser.add_argument("--reuse", action="store_true", help="take runs that this build has made already")
    options = parser.parse_args()
    global REUSE
    REUSE = options.reuse
    try:
        return work(options)
    except (quotes.QuoteError, RunFailed, KeyError) as error:
        print(f"impedraw figures: {error}", file=sys.stderr)
        return 2 if isinstance(error, quotes.QuoteError) else 3


def work(options) -> int:
    if options.list:
        for key, f in sorted(read_figures().items()):
            print(f"{key:<48} {f['value']:>12g} {f['unit']:<5} {f['command']}")
        print("tables: " + ", ".join(TABLES))
        return 0
    if options.bounds:
        write_bounds(measure(set(bounds()["runs"]), options.out))
        print(f"wrote {BOUNDS.relative_to(ROOT)}")
        return 0
    if options.pages is not None:
        return study_pages_of(options.pages, options.out, options.check)
    if options.pictures:
        import pictures

        figures = as_figures(measure(set(pictures.RUNS), options.out))
        pictures.make(program(), ROOT, options.out / "runs", lambda key: figures[key]["value"])
        print("wrote docs/images")
        return 0
    pages = documents(options.rows) + shown(options.rows)
    before = read_figures()
    if options.fill:
        figures = before
    else:
        figures = as_figures(measure(needed_runs(pages), options.out))
        if options.speeds and not options.check:
            figures |= speeds(options.out)
        figures |= {
            key: f
            for key, f in before.items()
            if key not in figures and (options.rows == "readme" or not f.get("compared", True))
        }
    stale = fill_all(pages, figures, write=not options.check)
    for line in stale:
        print(line)
    if options.check:
        print(
            f"{len(stale)} quoted numbers are stale; ./impedraw figures writes them again"
            if stale
            else "every quoted number holds"
        )
        return 1 if stale else 0
    if not options.fill:
        write_figures(figures)
    print(f"{len(figures)} figures; {len(stale)} stale numbers in the documents were replaced")
    return 0


if __name__ == "__main__":
    sys.exit(main())
