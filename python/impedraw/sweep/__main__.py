"""./impedraw sweep SPEC.yaml: see docs/sweeps.md."""

import argparse
import os
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from .errors import COMMAND, SweepError
from .settings import Settings, flat
from .spec import Case, Spec, load_spec

FINISHED, BAD_INPUT, INTERRUPTED = 0, 2, 130

_EXAMPLES = """
Examples:
  ./impedraw sweep studies/robustness.yaml --dry-run
  ./impedraw sweep studies/robustness.yaml --only 'matrix-nominal-50mm_s'
  ./impedraw sweep my.yaml --out runs/mine --workers 2     # the same command goes on after a kill
  ./impedraw sweep my.yaml --address 10.0.0.5:6379         # on a Ray cluster
  ./impedraw sweep my.yaml --report                        # only the page, from what is there
"""


# Commands that are studies: what follows `--study` on the command line of this module.
_STUDIES = {
    "robustness": "vary speed, slope, force, canvas and model errors cell by cell",
    "reach": "draw ten drawings on ten canvases: what is drawn, how well, what is not and why",
}
_STUDY_EXAMPLES = {
    "robustness": """
After ctrl-C, the same command continues. Cells that fail are findings: the exit code is 0 once all
have run.
Examples:
  ./impedraw robustness
  ./impedraw robustness --only '^matrix-nominal-200mm_s' --out /tmp/fast
  ./impedraw robustness --list | grep -A1 wave
""",
    "reach": """
After ctrl-C, the same command continues. Combinations that miss a limit are findings: the exit code
is 0 once all have run.
Examples:
  ./impedraw reach
  ./impedraw reach --only '^koi-on' --out /tmp/koi
  ./impedraw reach --list | grep -A1 wall
""",
}


def main(arguments: list[str] | None = None) -> int:
    arguments = sys.argv[1:] if arguments is None else arguments
    if "--study" in arguments:
        at = arguments.index("--study")
        name = arguments[at + 1]
        options = _study_parser(name).parse_args([*arguments[:at], *arguments[at + 2 :]])
        part = getattr(options, "part", "model")
        options.spec = str(Path(options.root) / "studies" / (
            "surfaces.yaml" if part == "surfaces" else f"{name}.yaml"))
        options.command = " ".join([COMMAND, name,
                                    *(["--part surfaces"] if part == "surfaces" else [])])
    else:
        options = _parser().parse_args(arguments)
        options.command = f"{COMMAND} sweep {options.spec}"
    try:
        return _sweep(options)
    except SweepError as error:
        print(f"impedraw: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED


def help_texts() -> dict[str, str]:
    """The --help of each command, for the documentation."""
    parsers = {"sweep": _parser(), **{name: _study_parser(name) for name in _STUDIES}}
    return {name: "\n".join(line.rstrip() for line in parser.format_help().strip().splitlines())
            for name, parser in parsers.items()}


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> None:  # type: ignore[override]
        name = self.prog.split()[-1]
        print(f"impedraw: {name}: {message}; see {self.prog} --help", file=sys.stderr)
        raise SystemExit(BAD_INPUT)


def _parser() -> argparse.ArgumentParser:
    p = _Parser(prog=f"{COMMAND} sweep", epilog=_EXAMPLES.replace("./impedraw", COMMAND), allow_abbrev=False,
                formatter_class=argparse.RawDescriptionHelpFormatter,
                description="run every case of a specification, into one Parquet data set")
    p.add_argument("spec", help="YAML file, see docs/sweeps.md")
    _add_options(p)
    return p


def _study_parser(name: str) -> argparse.ArgumentParser:
    p = _Parser(prog=f"{COMMAND} {name}", epilog=_STUDY_EXAMPLES[name], allow_abbrev=False,
                formatter_class=argparse.RawDescriptionHelpFormatter,
                description=f"{_STUDIES[name]}; a sweep of studies/{name}.yaml, see docs/sweeps.md")
    if name == "robustness":
        p.add_argument("--part", default="model", choices=["model", "surfaces"],
                       help="model: speeds, slopes, model errors and canvases (default); "
                       "surfaces: rough, stepped and scanned surfaces, studies/surfaces.yaml")
    _add_options(p)
    return p


def _add_options(p: argparse.ArgumentParser) -> None:
    p.add_argument("--out", help="folder of the data set (default: runs/NAME)")
    p.add_argument("--dry-run", action="store_true", help="count the cases, write nothing")
    p.add_argument("--list", action="store_true", help="print name and command of each case")
    p.add_argument("--only", default="", help="only cases whose name matches this expression")
    p.add_argument("--workers", "--jobs", type=_workers, help="runs at a time (default: one a core)")
    p.add_argument("--address", help="of a Ray cluster (default: one of its own, on 127.0.0.1)")
    p.add_argument("--serial", action="store_true", help="in this process, without Ray")
    p.add_argument("--runner", default="process", choices=["process", "native", "noop"],
                   help="process: impedraw draw (default); native: in the worker; noop: nothing")
    p.add_argument("--again", action="store_true", help="discard the data set that is there")
    p.add_argument("--report", action="store_true", help="only write the page again")
    p.add_argument("--root", default=".", help=argparse.SUPPRESS)
    p.add_argument("--program", default="impedraw", help=argparse.SUPPRESS)
    p.add_argument("--noop-options", default="", help=argparse.SUPPRESS)  # JSON, for tests


def _workers(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= 4096:
        raise argparse.ArgumentTypeError(f"'{text}'; valid are 1 to 4096")
    return int(text)


def _sweep(options: argparse.Namespace) -> int:
    root = Path(options.root).resolve()
    settings = Settings.read(root / "docs/scenario.schema.json")
    spec = load_spec(options.spec, root, settings)
    if options.list:
        for case in _selected(spec, options.only):
            print(f"{case.name}\n    {case.command()}")
        return FINISHED
    out = Path(options.out) if options.out else Path("runs") / spec.name
    if options.dry_run:
        count = sum(1 for _ in _selected(spec, options.only))
        if spec.tune is not None:
            trials = spec.tune.get("trials", 100)
            print(f"{spec.name}: {trials} trials of {count} cases, {trials * count} runs; into "
                  f"{out}")
            return FINISHED
        print(f"{spec.name}: {count} cases, {_times(spec, out)}")
        return FINISHED
    return run_loaded(spec, options, root, settings, out)


def run_loaded(spec: Spec, options: argparse.Namespace, root: Path, settings: Settings,
               out: Path) -> int:
    """Runs a checked specification. Returns the exit code. Raises SweepError."""
    count = sum(1 for _ in _selected(spec, options.only))
    if count == 0:
        if options.only:
            raise SweepError(f"--only {options.only}: no case's name matches; --list shows them")
        raise SweepError(f"{spec.file}: no case is left by its conditions")
    if options.address and not options.serial:
        from .engine import require_cluster

        require_cluster(options.address)
    if spec.tune is not None:
        from .tuning import tune

        return tune(spec, options, root, settings, out)
    return run(spec, options, root, settings, out, count)


def run(spec: Spec, options: argparse.Namespace, root: Path, settings: Settings, out: Path,
        count: int) -> int:
    """Runs what the data set lacks, then writes the page."""
    from .dataset import Dataset, read_dataset
    from .engine import Interrupted, Stop
    from .progress import Progress
    from .report import write_report

    if options.report:
        table, identity = read_dataset(out)
        if identity.get("spec") != spec.digest():
            raise SweepError(f"--out {out}: is the data set of another specification")
        print(f"  {write_report(spec, table, out, settings, repeat_command(options))}")
        return FINISHED
    context = make_context(spec, options, root, settings, out)
    data = Dataset(out, identity_of(spec, context, root), options.again)
    stop = Stop()
    try:
        done, failed = data.done()
        left = sum(1 for c in _selected(spec, options.only) if bytes.fromhex(c.key) not in done)
        if done:
            print(f"impedraw: {len(done)} runs are kept from an earlier sweep; --again discards "
                  "them", file=sys.stderr)
        progress = Progress(spec.name, count, count - left, failed)
        cases = (c for c in _selected(spec, options.only) if bytes.fromhex(c.key) not in done)
        interrupted = False
        try:
            execute(context, data, progress, cases, options, stop, left)
        except Interrupted:
            interrupted = True
        finally:
            if left:
                progress.draw(last=True)
        there = data.compact()
        if interrupted:
            print(f"impedraw: interrupted; {there} runs are kept in {out}; the same command "
                  "continues", file=sys.stderr)
            return 128 + stop.signal
        table = data.table()
        page = write_report(spec, table, out, settings, repeat_command(options))
        bad = sum(table["failed"].to_pylist())
        if not getattr(options, "quiet", False):
            print(f"{table.num_rows} runs, {bad} failed")
            print(f"  {out.resolve() / 'runs.parquet'}\n  {page}")
        return FINISHED
    finally:
        stop.restore()
        data.close()


def execute(context, data, progress, cases, options, stop, count=None,  # noqa: ANN001, ANN201
            keep_ray: bool = False) -> None:
    """Runs the cases and writes their rows. Raises Interrupted when what is there is written."""
    from .engine import run_on_ray, run_serial

    if count is None:
        count = len(cases)
    rows = _Buffer(data, progress)
    try:
        if count and options.serial:
            run_serial(context, iter(cases), rows.add, rows.tick, stop)
        elif count:
            run_on_ray(context, iter(cases), count, rows.add, rows.tick, stop, options.address,
                       options.workers, keep_ray)
    finally:
        rows.flush()


PART_SECONDS = 2.0


class _Buffer:
    """Gathers rows: a part is written every two seconds, and not for every batch."""

    def __init__(self, data: "object", progress: "object") -> None:
        self.data, self.progress = data, progress
        self.tables: list = []
        self.since = time.monotonic()

    def add(self, table) -> None:  # noqa: ANN001
        if not self.tables:
            self.since = time.monotonic()
        self.tables.append(table)
        self.progress.count(table.num_rows, sum(table["failed"].to_pylist()))

    def tick(self) -> None:
        if self.tables and time.monotonic() - self.since > PART_SECONDS:
            self.flush()
        self.progress.draw()

    def flush(self) -> None:
        self.data.append(self.tables)
        self.tables = []


def make_context(spec: Spec, options: argparse.Namespace, root: Path, settings: Settings,
                 out: Path):  # noqa: ANN201
    """What every worker needs to know."""
    import json

    from .runners import Context

    columns = settings.columns()
    if options.runner == "noop":
        columns = {n: columns.get(n, "text") for n in sorted(spec.set_names())}
    return Context(options.runner, str(root), str(Path(options.program).resolve()),
                   str(out.resolve()), columns, spec.axis_names(), spec.accept,
                   spec.limits, json.loads(options.noop_options or "{}"))


def identity_of(spec: Spec, context, root: Path) -> dict:  # noqa: ANN001
    """What the data set is of: it is refused where any of this differs."""
    from .engine import content_digest

    program = "-"
    if context.runner == "process":
        if not Path(context.program).is_file():
            raise SweepError(f"--program {context.program}: is no file; {COMMAND} builds it")
        program = content_digest([Path(context.program)])
    if context.runner == "native":
        try:
            from impedraw import _impedraw
        except ImportError as error:
            raise SweepError(f"--runner native: the compiled package is missing: {error}; valid "
                             "are process and noop") from None
        program = content_digest([Path(_impedraw.__file__)])
    return {"spec": spec.digest(), "runner": context.runner, "program": program,
            "inputs": content_digest(input_files(spec, root)), "name": spec.name,
            "commit": commit_of(root), "columns": context.columns, "axes": context.axes}


def commit_of(root: Path) -> str:
    """The commit that the sources are of, with a plus where they were changed since; empty where no
    one knows. It is told, not compared."""
    import subprocess

    try:
        return subprocess.run(["git", "describe", "--always", "--dirty=+", "--exclude=*"], cwd=root,
                              capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def input_files(spec: Spec, root: Path) -> list[Path]:
    """Every file that a case reads: scenarios, what they extend, drawings, meshes."""
    from .located_yaml import read_yaml

    names: set[str] = set()
    for block in spec.blocks:
        sources = [block.draw, block.set, *(p.set for a in block.axes for p in a.points)]
        for values in sources:
            names |= {str(v) for k, v in values.items() if isinstance(v, str) and v
                      and (k in ("scenario", "svg") or k.endswith((".svg", ".file")))}
    found: dict[Path, None] = {}
    waiting = [root / n for n in sorted(names)]
    while waiting:
        file = waiting.pop(0)
        if file in found or not os.path.isfile(file):
            continue
        found[file] = None
        if file.suffix in (".yaml", ".yml"):
            scenario = flat(read_yaml(file))
            waiting += [file.parent / str(v) for k, v in scenario.items() if isinstance(v, str)
                        and v and k.rsplit(".", 1)[-1] in ("extends", "file", "svg")]
    return sorted(found)


def _selected(spec: Spec, pattern: str) -> Iterator[Case]:
    try:
        expression = re.compile(pattern)
    except re.error:
        raise SweepError(f"--only {pattern}: not a valid regular expression") from None
    return (c for c in spec.cases() if expression.search(c.name))


def _times(spec: Spec, out: Path) -> str:
    axes = {}
    for block in spec.blocks:
        for axis in block.axes:
            axes[axis.name] = max(axes.get(axis.name, 0), len(axis.points))
    told = ", ".join(f"{name} {n}" for name, n in axes.items()) or "no axes"
    return f"{len(spec.blocks)} block{'s' if len(spec.blocks) > 1 else ''} ({told}); into {out}"


def repeat_command(options: argparse.Namespace) -> str:
    """The command that goes on with this sweep."""
    words = [options.command]
    if options.out:
        words += ["--out", options.out]
    if options.only:
        words += ["--only", repr(options.only)]
    return " ".join(words)


if __name__ == "__main__":
    sys.exit(main())
