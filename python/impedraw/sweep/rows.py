"""Rows of the data set: from outcomes to Arrow tables, with the same columns in every worker."""

import json
import time
from collections.abc import Iterable, Iterator
from typing import Any

import pyarrow as pa

from .expression import Expression
from .runners import GOOD, WALL_METRICS, Context, Outcome, Runner, judged
from .spec import Case

# Columns that are not the same when a run is repeated.
WALL_COLUMNS = ("wall_time", *WALL_METRICS)

_TYPES = {
    "bool": pa.bool_(), "int": pa.int64(), "number": pa.float64(),
    "numbers": pa.list_(pa.float64()), "text": pa.string(),
}
_HEAD = [("index", pa.int64()), ("key", pa.string()), ("case", pa.string()),
         ("group", pa.string()), ("scenario", pa.string()), ("svg", pa.string()),
         ("text", pa.string()), ("shape", pa.string()), ("arguments", pa.string()),
         ("set", pa.string()), ("state", pa.string()), ("cause", pa.string()),
         ("failed", pa.bool_()), ("not_drawn", pa.string()), ("null_metrics", pa.string())]


def run_cases(context: Context, runner: Runner, cases: Iterable[Case]) -> pa.Table:
    """Runs the cases one after the other; a row each."""
    return table_of(context, list(rows_of(context, runner, cases)))


def rows_of(context: Context, runner: Runner, cases: Iterable[Case]) -> Iterator[dict[str, Any]]:
    """The same, a row as soon as its run has ended. A table of many rows costs little more than
    one of a single row."""
    accept = {name: Expression(text) for name, text in context.accept.items()}
    for case in cases:
        start = time.perf_counter()
        try:
            outcome = runner(case)
        except Exception as error:  # noqa: BLE001: a fault of one run is its row
            outcome = Outcome("error", f"error: {type(error).__name__}: {error}")
        outcome = judged(outcome, accept)
        yield _row(case, outcome, time.perf_counter() - start)


def failed_table(context: Context, case: Case, state: str, cause: str) -> pa.Table:
    """The row of a case that could not be run to its end."""
    return table_of(context, [_row(case, Outcome(state, cause), 0.0)])


def table_of(context: Context, rows: list[dict[str, Any]]) -> pa.Table:
    names = sorted({name for row in rows for name in row["metrics"]})
    metrics = [n for n in names if n not in WALL_METRICS]
    arrays, fields = [], []

    def add(name: str, kind: pa.DataType, values: list[Any]) -> None:
        fields.append(pa.field(name, kind))
        arrays.append(pa.array(values, kind))

    for name, kind in _HEAD:
        add(name, kind, [row[name] for row in rows])
    for name in context.axes:
        add(f"axis:{name}", pa.string(), [row["levels"].get(name) for row in rows])
    for name, word in context.columns.items():
        add(name, _TYPES[word], [_value(row["settings"].get(name), word) for row in rows])
    for name in metrics + [n for n in WALL_METRICS if n in names]:
        add(name, pa.float64(), [_value(row["metrics"].get(name), "number") for row in rows])
    add("wall_time", pa.float64(), [row["wall_time"] for row in rows])
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def _row(case: Case, outcome: Outcome, wall_time: float) -> dict[str, Any]:
    draw = case.draw
    return {
        "index": case.index, "key": case.key, "case": case.name, "group": case.group,
        "scenario": draw.get("scenario"), "svg": draw.get("svg"), "text": draw.get("text"),
        "shape": draw.get("shape"), "arguments": " ".join(draw.get("arguments", [])) or None,
        "set": json.dumps(case.settings, ensure_ascii=False, separators=(",", ":")),
        "state": outcome.state, "cause": outcome.cause or None, "failed": outcome.state not in GOOD,
        "not_drawn": json.dumps(outcome.not_drawn, sort_keys=True) if outcome.not_drawn else None,
        "null_metrics": json.dumps(outcome.reasons, ensure_ascii=False, sort_keys=True)
        if outcome.reasons else None,
        "levels": case.levels, "settings": {**case.settings, **outcome.settings},
        "metrics": outcome.metrics, "wall_time": wall_time,
    }


def _value(value: Any, word: str) -> Any:
    """As the column holds it; null where it does not fit."""
    if value is None:
        return None
    if word == "bool":
        return value if isinstance(value, bool) else None
    if word in ("int", "number"):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return None
        return int(value) if word == "int" else float(value)
    if word == "numbers":
        return [float(v) for v in value] if isinstance(value, (list, tuple)) and all(
            isinstance(v, (int, float)) for v in value) else None
    if isinstance(value, str):
        return value
    return json.dumps(value, ensure_ascii=False, sort_keys=True)


def in_column_order(names: Iterable[str], columns: Iterable[str], axes: Iterable[str]) -> list[str]:
    """The data set's order, whatever the order in which rows came."""
    names = set(names)
    head = [n for n, _ in _HEAD] + [f"axis:{a}" for a in axes] + list(columns)
    tail = [n for n in WALL_METRICS if n in names] + ["wall_time"]
    return head + sorted(names - set(head) - set(tail)) + tail
