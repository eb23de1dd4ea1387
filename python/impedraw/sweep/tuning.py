"""Tuning: Optuna proposes settings, the workers of a sweep run every case with them.

Trials come in rounds of ROUND, asked for before any of them is run and told in order. So what is
proposed depends on the results alone, and not on how many workers there are or when they end; the
same command after a kill proposes the same trials again and runs only what is missing.

The first trial is what the scenarios set themselves. A trial's objective is the mean over the
cases of the specification; a case that fails, or breaks a constraint, makes it infeasible.
"""

import argparse
import html
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .errors import SweepError
from .expression import Expression
from .settings import Settings, plain, resolved, text_of
from .spec import Case, Spec, case_key

ROUND = 10
_INFEASIBLE = 1e6  # the objective of a trial without one


def tune(spec: Spec, options: argparse.Namespace, root: Path, settings: Settings,
         out: Path) -> int:
    """Runs the trials that the data set lacks, then writes the page. Returns the exit code."""
    import optuna

    from .__main__ import execute, identity_of, make_context, repeat_command
    from .dataset import Dataset
    from .engine import Interrupted, Stop
    from .progress import Progress
    from .report import write_report

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    assert spec.tune is not None
    if options.only or options.report:
        raise SweepError("--only and --report do not go with a specification that has tune")
    base = list(spec.cases())
    plan = {"trials": 100, "seed": 1, "startup": 20, "constraints": {}, **spec.tune}
    first = first_trial(plan["settings"], base, root, settings, str(spec.file))
    trials = Trials(plan, base, first)
    context = make_context(spec, options, root, settings, out)
    context.axes = [*context.axes, "trial"]
    context.columns = {**context.columns, **{n: settings.column_type(n)
                                             for n in plan["settings"]}}
    identity = identity_of(spec, context, root)
    identity["spec"] = case_key({"spec": identity["spec"]}, {"tune": json.dumps(plan)})
    data = Dataset(out, identity, options.again)
    stop = Stop()
    total = plan["trials"] * len(base)
    try:
        done, failed = data.done()
        progress = Progress(spec.name, total, len(done), failed)
        interrupted = False
        try:
            while cases := trials.next_round():
                left = [c for c in cases if bytes.fromhex(c.key) not in done]
                last = trials.asked >= plan["trials"]
                execute(context, data, progress, left, options, stop, keep_ray=not last)
                trials.tell(data.table().filter(_among([c.key for c in cases])).to_pylist())
        except Interrupted:
            interrupted = True
        finally:
            progress.draw(last=True)
        there = data.compact()
        if interrupted:
            print(f"impedraw: interrupted; {there} runs are kept in {out}; the same command "
                  "continues", file=sys.stderr)
            return 128 + stop.signal
        page = write_report(spec, data.table(), out, settings, repeat_command(options),
                            trials.section())
        print(trials.told())
        print(f"  {out.resolve() / 'runs.parquet'}\n  {page}")
        return 0
    finally:
        stop.restore()
        data.close()


def first_trial(space: dict[str, Any], base: list[Case], root: Path, settings: Settings,
                file: str) -> dict[str, Any]:
    """What the cases have of the tuned settings. Raises SweepError where they do not agree."""
    defaults, found = settings.defaults(), {}
    scenarios: dict[str, dict[str, Any]] = {}
    for case in base:
        scenario = case.draw["scenario"]
        if scenario not in scenarios:
            scenarios[scenario] = resolved(root / scenario, defaults)
        for name in space:
            if name in case.settings:
                raise SweepError(f"{file}: tune: {name} is also set by the cases")
            value = plain(scenarios[scenario].get(name))
            if found.setdefault(name, value) != value:
                raise SweepError(f"{file}: tune: {name}: the scenarios have {found[name]} and "
                                 f"{value}; valid is one value to begin with")
    for name, how in space.items():
        kind, values = next(iter(how.items()))
        value = found[name]
        good = (value in [plain(v) for v in values] if kind == "choice" else
                isinstance(value, (int, float)) and values[0] <= value <= values[1])
        if not good:
            raise SweepError(f"{file}: tune: {name}: {text_of(value)}, which the scenarios have, "
                             f"is not in {text_of(list(values))}")
    return found


class Trials:
    """Asks Optuna for rounds of settings and tells it what came of them."""

    def __init__(self, plan: dict[str, Any], base: list[Case], first: dict[str, Any]) -> None:
        import optuna

        self.plan, self.base, self.first = plan, base, first
        self.objective = Expression(str(plan["objective"]))
        self.constraints = {n: Expression(str(t)) for n, t in plan["constraints"].items()}
        sampler = optuna.samplers.TPESampler(
            seed=plan["seed"], n_startup_trials=plan["startup"], constant_liar=True,
            constraints_func=lambda trial: trial.user_attrs.get("broken", (1.0,)))
        self.study = optuna.create_study(sampler=sampler)
        self.study.enqueue_trial(first)
        self.running: list[tuple[Any, dict[str, Any], list[Case]]] = []
        self.asked = 0
        self.results: list[dict[str, Any]] = []

    def next_round(self) -> list[Case]:
        """The cases of the next trials; empty when all are done."""
        self.running = []
        for _ in range(min(ROUND, self.plan["trials"] - self.asked)):
            trial = self.study.ask()
            chosen = {name: self._suggested(trial, name, how)
                      for name, how in self.plan["settings"].items()}
            cases = []
            for i, case in enumerate(self.base):
                both = {**case.settings, **chosen}
                # The trial is part of the key: Optuna may propose the same settings twice.
                key = case_key({**case.draw, "trial": self.asked + 1}, both)
                cases.append(Case(self.asked * len(self.base) + i, key,
                                  f"trial-{self.asked}/{case.name}", case.group, case.draw, both,
                                  {**case.levels, "trial": str(self.asked)}, case.keep))
            self.running.append((trial, chosen, cases))
            self.asked += 1
        return [c for _, _, cases in self.running for c in cases]

    def tell(self, rows: list[dict[str, Any]]) -> None:
        """The rows of the round's cases."""
        by_key = {row["key"]: row for row in rows}
        for trial, chosen, cases in self.running:
            value, broken = self._judged([by_key[c.key] for c in cases])
            trial.set_user_attr("broken", (float(len(broken)),))
            self.study.tell(trial, _INFEASIBLE if value is None else value)
            self.results.append({"trial": trial.number, "value": value, "broken": broken,
                                 "settings": chosen})

    def _suggested(self, trial: Any, name: str, how: dict[str, Any]) -> Any:
        kind, values = next(iter(how.items()))
        if kind == "choice":
            return trial.suggest_categorical(name, [plain(v) for v in values])
        value = trial.suggest_float(name, values[0], values[1], log=kind == "loguniform")
        return plain(float(f"{value:.6g}"))

    def _judged(self, rows: list[dict[str, Any]]) -> tuple[float | None, list[str]]:
        """The objective, and what is broken in any case."""
        values, broken = [], []
        for row in rows:
            if row["failed"]:
                broken.append(f"{row['case']}: {row['cause']}")
                continue
            try:
                broken += [f"{row['case']}: {name}" for name, condition in self.constraints.items()
                           if not condition(row)]
                value = self.objective(row)
            except ValueError as error:
                raise SweepError(f"tune: {error}") from None
            if not isinstance(value, (int, float)) or not math.isfinite(value):
                broken.append(f"{row['case']}: no objective")
            else:
                values.append(float(value))
        return (math.fsum(values) / len(values) if values and len(values) == len(rows) else None,
                broken)

    def ranked(self) -> list[dict[str, Any]]:
        """Feasible trials, the best first."""
        good = [r for r in self.results if not r["broken"] and r["value"] is not None]
        return sorted(good, key=lambda r: (r["value"], r["trial"]))

    def told(self) -> str:
        """One line: the shipped settings against the best."""
        first, good = self.results[0], self.ranked()
        shipped = "infeasible" if first["broken"] or first["value"] is None else (
            f"{first['value']:.6g}")
        if not good:
            return f"{len(self.results)} trials, none feasible; shipped settings: {shipped}"
        best = good[0]
        rank = next((i + 1 for i, r in enumerate(good) if r["trial"] == 0), None)
        return (f"{len(self.results)} trials, {len(good)} feasible; objective of the shipped "
                f"settings {shipped}" + (f" (place {rank})" if rank else "")
                + f", of the best {best['value']:.6g} (trial {best['trial']})")

    def section(self) -> str:
        """For the page."""
        good, first = self.ranked(), self.results[0]
        shown = good[:10]
        row: Callable[[str, list[str]], str] = lambda head, cells: (
            f"<tr><th>{html.escape(head)}</th>" + "".join(f"<td>{html.escape(c)}</td>"
                                                          for c in cells) + "</tr>")
        lines = [row("trial", ["shipped", *(str(r["trial"]) for r in shown)]),
                 row(self.objective.text, [_short(first["value"]),
                                           *(_short(r["value"]) for r in shown)])]
        for name in self.plan["settings"]:
            lines.append(row(name, [_short(r["settings"][name]) for r in [first, *shown]]))
        broken = "".join(f"<li>{html.escape(b)}</li>" for b in first["broken"])
        rules = "".join(f"<li><b>{html.escape(n)}</b> <code>{html.escape(c.text)}</code></li>"
                        for n, c in self.constraints.items())
        return (f"<section><h2>Tuning</h2><p>{html.escape(self.told())}</p><div class=wide><table>"
                f"{''.join(lines)}</table></div>"
                + (f"<p>Constraints:</p><ul>{rules}</ul>" if rules else "")
                + (f"<p>The shipped settings break:</p><ul>{broken}</ul>" if broken else "")
                + "</section>")


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else text_of(value)


def _among(keys: list[str]) -> Any:
    import pyarrow.compute as pc

    return pc.field("key").isin(keys)
