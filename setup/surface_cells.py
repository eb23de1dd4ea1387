"""Writes docs/surface_cells.md from the data set of the surfaces' sweep.

    ./impedraw robustness --part surfaces --out /tmp/surfaces
    build/sweep-venv/bin/python setup/surface_cells.py /tmp/surfaces
"""
import json
import math
import pathlib
import subprocess
import sys

import pyarrow.parquet

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/surface_cells.md"
DRAWINGS = ("text", "spiral", "hatch")


def two_digits(x):
    if x is None or not math.isfinite(x):
        return "–"
    return f"{x:.{max(0, 1 - math.floor(math.log10(x)))}f}" if 1e-4 <= x < 10 else f"{x:.0f}"


def entry(row):
    asked, promised = row["length_asked"] or 0.0, row["length_promised"] or 0.0
    values = [two_digits(row[name]) for name in ("ink_error_rms", "force_sd", "speed_mean")]
    text = " / ".join([*values, f"{promised / asked:.2f}" if asked else "–"])
    return f"**✗** {text}" if row["failed"] else text


def command(row):
    words = ["./impedraw draw", row["scenario"]]
    if row["svg"]:
        words += ["--svg", row["svg"]]
    for name, value in json.loads(row["set"]).items():
        words.append(f"--set {name}={value if isinstance(value, str) else json.dumps(value)}")
    return " ".join(words)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rows = pyarrow.parquet.read_table(pathlib.Path(sys.argv[1]) / "runs.parquet").to_pylist()
    commit = subprocess.run(["git", "describe", "--always", "--dirty=+", "--exclude=*"], cwd=ROOT, capture_output=True,
                            text=True, check=True).stdout.strip()
    day = subprocess.run(["date", "-u", "+%F"], capture_output=True, text=True, check=True).stdout.strip()
    failed = [row for row in rows if row["failed"]]
    unstable = sum("far above its speed limit" in (row["cause"] or "") or "unstable" in (row["cause"] or "") for row in rows)
    asked = sum(row["length_asked"] or 0.0 for row in rows)
    promised = sum(row["length_promised"] or 0.0 for row in rows)
    lines = [
        "# Surfaces: all cells",
        "",
        f"`./impedraw robustness --part surfaces`, {day}, commit {commit}: {len(rows)} cells of `studies/surfaces.yaml`, "
        f"**{len(failed)} missed a limit**, {unstable} unstable; {100 * promised / asked:.0f} % of the length that was asked for is promised. "
        "Each entry gives *ink error RMS [mm] / standard deviation of the normal force [N] / mean speed [mm/s] / share of the "
        "length promised*. **✗** marks a cell that stopped or missed a limit; the last list says which.",
    ]
    groups = list(dict.fromkeys(row["group"] for row in rows))
    for group in groups:
        cells = [row for row in rows if row["group"] == group]
        length = sum(row["length_asked"] or 0.0 for row in cells)
        share = sum(row["length_promised"] or 0.0 for row in cells) / length if length else 0.0
        lines += ["", f"## {group}", "", f"{100 * share:.0f} % of the length is promised.", "",
                  "| | " + " | ".join(DRAWINGS) + " |", "|---" * (len(DRAWINGS) + 1) + "|"]
        by_name = {row["case"]: row for row in cells}
        for surface in dict.fromkeys(row["case"].rsplit("-", 1)[0] for row in cells):
            found = [by_name.get(f"{surface}-{drawing}") for drawing in DRAWINGS]
            lines.append(f"| {surface} | " + " | ".join(entry(row) if row else "" for row in found) + " |")
    lines += ["", "## Cells that missed a limit", ""]
    for row in failed:
        lines += [f"- `{row['case']}`: {row['cause']}", f"  `{command(row)}`"]
    PAGE.write_text("\n".join(lines) + "\n")
    print(f"{PAGE}: {len(rows)} cells, {len(failed)} missed a limit")


if __name__ == "__main__":
    main()
