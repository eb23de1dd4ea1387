"""Runs one case: the part of a sweep that knows what a run is.

A runner is made once in each worker process, from the sweep's context, and is called with one case
after the other. What it returns is the case's row, short of what the engine adds. It throws
nothing: what goes wrong with a run is its state and cause.
"""

import hashlib
import importlib.util
import json
import os
import pickle
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

from .errors import SweepError
from .expression import Expression
from .located_yaml import read_scenario
from .native_child import LENGTH, send
from .settings import Settings, flat, resolved
from .spec import Case

# A case's state. All but GOOD count as failed; `missed`: a condition of `accept` does not hold;
# `nothing`: all of the drawing was to be left out if it cannot be drawn, and none of it can.
STATES = ("ok", "nothing", "missed", "refused", "stopped", "timeout", "crashed", "error")
GOOD = ("ok", "nothing")
_NOTHING = re.compile(r"(^|: )nothing can be drawn: ")  # as src/experiment/plan.cc says

# Metrics that depend on the machine: kept, and left out where two data sets are compared.
WALL_METRICS = ("step_time_p50", "step_time_p99", "step_time_p999", "real_time_factor")


@dataclass
class Context:
    """What every worker of a sweep needs to know. Sent once."""

    runner: str
    root: str  # the tree: scenarios are relative to it
    program: str  # build/release/src/app/impedraw
    out: str  # the data set's folder
    columns: dict[str, str]  # settings with a column, and its type (Settings.column_types)
    axes: list[str]  # named axes
    accept: dict[str, str] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=lambda: {"time": 120.0, "memory": 8.0})
    options: dict[str, Any] = field(default_factory=dict)  # of the runner; for tests


@dataclass
class Outcome:
    """What a run gave."""

    state: str
    cause: str = ""
    metrics: dict[str, float | None] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)  # why a metric is null
    settings: dict[str, Any] = field(default_factory=dict)  # every one, resolved
    not_drawn: dict[str, int] = field(default_factory=dict)  # findings of the pre-flight by problem


class Runner(Protocol):
    """See the module."""

    def __call__(self, case: Case) -> Outcome: ...


def judged(outcome: Outcome, accept: dict[str, Expression]) -> Outcome:
    """The outcome; `missed` where a finished run does not meet a condition."""
    if outcome.state != "ok":
        return outcome
    values = {**outcome.settings, **outcome.metrics}
    for name, condition in accept.items():
        try:
            holds = bool(condition(values))
        except ValueError as error:
            return replace(outcome, state="error", cause=f"accept: {name}: {error}")
        if not holds:
            metrics = sorted(n for n in condition.names if n in outcome.metrics)
            told = ", ".join(f"{n} is {_number(outcome.metrics[n])}" for n in metrics)
            cause = f"{name}: {condition.text}" + (f", but {told}" if told else "")
            return replace(outcome, state="missed", cause=cause)
    return outcome


def _number(value: float | None) -> str:
    return "null" if value is None else f"{value:.6g}"


class Noop:
    """Runs nothing: numbers from a hash of the case's key, for tests of the engine.

    Options: `sleep` [s] of each run, `crash` (the process ends at keys that start with it),
    `fail` (keys that start with it are stopped).
    """

    def __init__(self, context: Context) -> None:
        self.options = context.options

    def __call__(self, case: Case) -> Outcome:
        if sleep := self.options.get("sleep"):
            time.sleep(sleep)
        if (crash := self.options.get("crash")) and case.key.startswith(crash):
            os.kill(os.getpid(), signal.SIGKILL)
        digest = hashlib.sha256(case.key.encode()).digest()
        metrics: dict[str, float | None] = {
            "value": int.from_bytes(digest[:6], "big") / 2**48,
            "sparse": None if digest[6] < 128 else digest[7] / 256,
        }
        if (fail := self.options.get("fail")) and case.key.startswith(fail):
            return Outcome("stopped", "stopped: as asked", metrics)
        return Outcome("ok", "", metrics, {}, dict(case.settings))


class Process:
    """Runs `impedraw draw` as a child process, limited in time and memory."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.scratch = Path(tempfile.mkdtemp(prefix="impedraw-sweep-", dir=_scratch(context)))
        self.prefix = _limited(context)

    def __call__(self, case: Case) -> Outcome:
        folder = self.scratch / "run"
        shutil.rmtree(folder, ignore_errors=True)
        command = [*self.prefix, self.context.program, "draw", *case.arguments(), "--out",
                   str(folder)]
        limit = self.context.limits["time"]
        try:
            done = subprocess.run(command, cwd=self.context.root, timeout=limit,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE)
        except subprocess.TimeoutExpired:
            outcome = Outcome("timeout", f"timeout: took longer than {limit:g} s")
        except OSError as error:
            return Outcome("error", f"error: {self.context.program}: {error.strerror}")
        else:
            outcome = self._outcome(folder, done.returncode,
                                    done.stderr.decode("utf-8", "replace"))
        self._keep(case, folder, outcome)
        shutil.rmtree(folder, ignore_errors=True)
        return outcome

    def _outcome(self, folder: Path, code: int, told: str) -> Outcome:
        lines = [line.removeprefix("impedraw: ").replace(self.context.root + "/", "")
                 for line in told.splitlines() if line.startswith("impedraw: ")]
        cause = lines[-1] if lines else (told.strip().splitlines() or [""])[-1]
        outcome = Outcome("ok")
        if code < 0:
            return Outcome("crashed", f"crashed: signal {-code} ({_signal_name(-code)})")
        if code == 2:
            return _refused(cause)
        if code not in (0, 3):
            return Outcome("crashed", f"crashed: exit code {code}: {cause}")
        try:
            metrics = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
            scenario = read_scenario(folder / "scenario.yaml")
        except (OSError, ValueError) as error:
            return Outcome("error", f"error: what the run left cannot be read: {error}")
        outcome.reasons = metrics.pop("reasons", {})
        outcome.not_drawn = metrics.pop("not_drawn", {})
        metrics.pop("wall_seconds", None)
        outcome.metrics = {k: v for k, v in metrics.items()
                           if v is None or isinstance(v, (int, float))}
        outcome.settings = flat(scenario)
        if code == 3:
            outcome.state, outcome.cause = "stopped", f"stopped: {cause}"
        return outcome

    def _keep(self, case: Case, folder: Path, outcome: Outcome) -> None:
        accept = {k: Expression(v) for k, v in self.context.accept.items()}
        failed = judged(outcome, accept).state not in GOOD
        wanted = {what for what, when in case.keep.items() if when == "always"
                  or (when == "failed" and failed)}
        if not wanted or not folder.is_dir():
            return
        kept = Path(self.context.out) / "kept" / case.key
        new = kept.with_name(f".{case.key}-{os.getpid()}")
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir(parents=True)
        files = ["scenario.yaml", "metrics.json"]
        if "log" in wanted:
            files += ["run.h5", "strokes.json", "inputs"]
        if "pictures" in wanted:
            files += [f.name for f in folder.glob("*.png")] + ["report.html"]
        for name in files:
            if (folder / name).is_dir():
                shutil.copytree(folder / name, new / name)
            elif (folder / name).exists():
                shutil.copyfile(folder / name, new / name)
        shutil.rmtree(kept, ignore_errors=True)
        os.replace(new, kept)


class Native:
    """Draws by the compiled package, in one child process that goes from run to run. The scene
    (canvas, arm, snapshot of the cameras) of the last runs is kept there, and nothing is written: a
    short run takes a tenth of what `impedraw draw` takes. Limits of time and memory are those of a
    run; a child that ends is made anew. `settings` holds what the scenario and the case set."""

    def __init__(self, context: Context) -> None:
        if importlib.util.find_spec("impedraw._impedraw") is None:
            raise ImportError("impedraw._impedraw is not installed")
        self.context = context
        self.defaults = Settings.read(
            Path(context.root) / "docs/scenario.schema.json").defaults()
        self.scenarios: dict[str, dict[str, Any]] = {}
        self.keeper: Process | None = None
        self.accept = {k: Expression(v) for k, v in context.accept.items()}
        self.prefix = _limited(context)
        self.child: subprocess.Popen[bytes] | None = None

    def __call__(self, case: Case) -> Outcome:
        words = case.draw.get("arguments", [])
        path = os.path.join(self.context.root, case.draw["scenario"])
        if path not in self.scenarios:
            self.scenarios[path] = resolved(Path(path), self.defaults)
        svg = case.draw.get("svg")
        request = {
            "settings": self._settings(case), "scenario": path,
            "svg": os.path.join(self.context.root, svg) if svg else None,
            "text": case.draw.get("text"), "shape": case.draw.get("shape"),
            "no_perception": "--no-perception" in words, "keep_order": "--keep-order" in words,
            "skip_unreachable": "--skip-unreachable" in words}
        if fault := self.context.options.get("fault", {}).get(case.name):
            request["fault"] = fault
        answer = self._asked(request)
        if isinstance(answer, Outcome):
            outcome = answer
        elif "refused" in answer:
            return _refused(self._within(answer["refused"]))
        elif "error" in answer:
            return Outcome("error", f"error: {self._within(answer['error'])}")
        else:
            got = answer["result"]
            outcome = Outcome("ok", "", got["metrics"], got["reasons"],
                              {**self.scenarios[path], **case.settings}, got["not_drawn"])
            if got["end"] != "finished":
                outcome.state = "stopped"
                outcome.cause = f"stopped: {self._within(got['cause'])}"
        asked = set(case.keep.values())
        if "always" in asked or ("failed" in asked
                                 and judged(outcome, self.accept).state not in GOOD):
            self.keeper = self.keeper or Process(self.context)
            self.keeper(case)  # once more, with all its files
        return outcome

    def _asked(self, request: dict[str, Any]) -> Any:
        """The child's answer; an Outcome where there is none."""
        limit = self.context.limits["time"]
        try:
            if self.child is None:
                self._start()
            assert self.child is not None and self.child.stdin is not None
            send(self.child.stdin, request)
            answer = self._answer(limit)
        except TimeoutError:
            self._end()
            return Outcome("timeout", f"timeout: took longer than {limit:g} s")
        except (EOFError, OSError):
            code = self._end()
            return Outcome("crashed", f"crashed: signal {-code} ({_signal_name(-code)})"
                           if code < 0 else f"crashed: exit code {code}")
        if "memory" in answer:
            self._end()
            return Outcome("crashed", "crashed: out of memory: the limit is "
                           f"{self.context.limits['memory']:g} GB")
        return answer

    def _start(self) -> None:
        self.child = subprocess.Popen(
            [*self.prefix, sys.executable, "-P", "-m", "impedraw.sweep.native_child"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            cwd=self.context.root)
        self._answer(60.0)

    def _answer(self, limit: float) -> Any:
        assert self.child is not None and self.child.stdout is not None
        handle, until = self.child.stdout.fileno(), time.monotonic() + limit
        content, wanted = b"", LENGTH.size
        while len(content) < wanted:
            ready, _, _ = select.select([handle], [], [], max(0.0, until - time.monotonic()))
            if not ready:
                raise TimeoutError
            piece = os.read(handle, 1 << 20)
            if not piece:
                raise EOFError
            content += piece
            if wanted == LENGTH.size and len(content) >= wanted:
                wanted += LENGTH.unpack(content[:wanted])[0]
        return pickle.loads(content[LENGTH.size :])

    def _end(self) -> int:
        """Ends the child and returns its exit code."""
        child, self.child = self.child, None
        if child is None:
            return 0
        try:
            code = child.wait(0.2)  # it may have ended by itself
        except subprocess.TimeoutExpired:
            child.kill()
            code = child.wait()
        for stream in (child.stdin, child.stdout):
            try:
                if stream:
                    stream.close()
            except OSError:
                pass
        return code

    def __del__(self) -> None:
        self._end()

    def _settings(self, case: Case) -> dict[str, Any]:
        """With files from the root of the tree, as the worker's working directory is another."""
        return {k: os.path.join(self.context.root, v) if v and k.endswith((".file", ".svg")) else v
                for k, v in case.settings.items()}

    def _within(self, text: str) -> str:
        return text.replace(self.context.root + "/", "")


def _refused(cause: str) -> Outcome:
    if _NOTHING.search(cause):
        return Outcome("nothing", cause)
    return Outcome("refused", f"refused: {cause}")


def _limited(context: Context) -> list[str]:
    """What stands before a child's command, for its limits."""
    prlimit, setpriv = shutil.which("prlimit"), shutil.which("setpriv")
    words: list[str] = []
    if setpriv:  # a child must not outlive a worker that was killed
        words += [setpriv, "--pdeathsig", "KILL", "--"]
    if prlimit:
        memory = int(context.limits["memory"] * 1e9)
        words += [prlimit, f"--as={memory}", f"--data={memory}", "--core=0", "--"]
    return words


def _scratch(context: Context) -> str | None:
    """A folder of the data set where it can be seen, so that what is left over can be removed."""
    folder = Path(context.out) / "scratch"
    try:
        folder.mkdir(exist_ok=True)
    except OSError:
        return None  # another machine: its own temporary folder
    return str(folder)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"


RUNNERS: dict[str, type] = {"noop": Noop, "process": Process, "native": Native}


def make_runner(context: Context) -> Runner:
    """The runner that the context names. Raises SweepError."""
    try:
        return RUNNERS[context.runner](context)
    except ImportError as error:
        raise SweepError(f"--runner {context.runner}: the compiled package is missing: {error}; "
                         "valid are process and noop") from None
