"""Compares a sweep of studies/NAME.yaml with what `impedraw NAME` wrote, cell by cell.

    compare_with_engine.py OUT/runs.parquet OUT/NAME.csv

Prints the cells whose verdict or figures (6 digits) differ; exit code 1 if there are any.
"""

import csv
import sys

import pyarrow.parquet as pq

from impedraw.sweep.rows import WALL_COLUMNS


def same(a: str, b: str) -> bool:
    try:
        return float(a) == float(b)
    except ValueError:
        return a == b or {a, b} == {"", "null"}


def main(parquet: str, table: str) -> int:
    mine = {row["case"]: row for row in pq.read_table(parquet).to_pylist()}
    with open(table, newline="", encoding="utf-8") as file:
        theirs = {row["cell"]: row for row in csv.DictReader(file)}
    both = [name for name in theirs if name in mine]
    figures = different = 0
    for name in both:
        a, b = mine[name], theirs[name]
        told = []
        if a["failed"] != (b["failed"] == "1"):
            told.append(f"failed {a['failed']}, {b['failed']}")
        if (a["cause"] or "").split(":")[0] != b["cause"].split(":")[0]:
            told.append(f"cause {a['cause']}, {b['cause']}")
        for metric in {"coverage", "rms"} & b.keys() | {m for m in b if m in a}:
            value = a.get({"rms": "ink_error_rms"}.get(metric, metric))
            if metric in WALL_COLUMNS or isinstance(value, (str, bool, list)):
                continue
            text = "" if value is None else f"{value:.6g}"
            figures += 1
            if not same(text, b[metric]):
                told.append(f"{metric} {text}, {b[metric]}")
        if told:
            different += 1
            print(f"{name}: {'; '.join(told)}")
    print(f"{len(both)} cells, {figures} figures compared; {different} cells differ")
    return int(different > 0 or not both)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
