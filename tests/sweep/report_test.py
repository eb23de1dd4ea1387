"""The page tells means, failures and commands, is one file, and escapes what it shows."""

import re
import subprocess
import sys

from conftest import ROOT, sweep
from impedraw.sweep.dataset import read_dataset
from impedraw.sweep.statistics import mean_over_seeds

SPEC = """name: page
about: a <b> & c
scenario: scenarios/robustness-nominal.yaml
seeds: 3
axes:
  path.draw_speed: [0.01, 0.05]
  tip: {levels: {"<soft>": {world.tip.stiffness: 1e4}, hard: {world.tip.stiffness: 1e5}}}
accept: {some: value < 0.8}
report:
  metrics: [value]
  maps: [{x: path.draw_speed, y: tip, metric: value}]
  lines: [{x: path.draw_speed, by: tip, metric: value}]
  tables: [{rows: tip, columns: path.draw_speed}]
"""


def page_of(tmp_path, text=SPEC):
    file = tmp_path / "page.yaml"
    file.write_text(text, encoding="utf-8")
    done = sweep(file, tmp_path / "d", "--serial")
    assert done.returncode == 0, done.stderr
    return (tmp_path / "d/report.html").read_text(encoding="utf-8")


def test_the_page_shows_means_with_intervals_and_every_failed_run(tmp_path):
    page = page_of(tmp_path)
    rows = read_dataset(tmp_path / "d")[0].to_pylist()
    for speed in (0.01, 0.05):
        for tip in ("<soft>", "hard"):
            mean = mean_over_seeds(
                (r["seed"], r["value"], r["failed"]) for r in rows
                if r["path.draw_speed"] == speed and r["axis:tip"] == tip)
            assert mean.seeds == 3
            assert page.count(f"{mean.mean:.3g} ± {mean.half:.1g}") >= 2  # map and table
    bad = [r for r in rows if r["failed"]]
    assert bad and f"Failed runs: {len(bad)}" in page
    for row in bad:
        assert row["case"] in page
    assert page.count("<polyline") == 2


def test_the_page_is_one_file_and_escapes(tmp_path):
    page = page_of(tmp_path)
    assert "a &lt;b&gt; &amp; c" in page and "<b> &" not in page and "<soft>" not in page
    assert "default-src 'none'" in page
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:)?//", page)


def test_without_a_wish_every_axis_is_shown(tmp_path):
    page = page_of(tmp_path, SPEC[: SPEC.index("report:")])
    assert page.count("<svg") == 1 and page.count("class=map") == 1
    assert "<h2>tip</h2>" in page and "<h2>path.draw_speed [m/s]</h2>" in page


def test_the_page_can_be_written_again_with_another_wish(tmp_path):
    page_of(tmp_path)
    file = tmp_path / "page.yaml"
    file.write_text(SPEC.replace("metrics: [value]", "metrics: [no_such]"), encoding="utf-8")
    done = sweep(file, tmp_path / "d", "--report")
    assert done.returncode == 2 and "no_such is no metric" in done.stderr
    file.write_text(SPEC.replace("metrics: [value]", "metrics: [sparse]"), encoding="utf-8")
    assert sweep(file, tmp_path / "d", "--report").returncode == 0
    file.write_text(SPEC.replace("seeds: 3", "seeds: 4"), encoding="utf-8")
    done = sweep(file, tmp_path / "d", "--report")
    assert done.returncode == 2 and "another specification" in done.stderr


def test_importing_the_package_is_cheap():
    code = ("import sys, impedraw.sweep; "
            "print([m for m in ('ray', 'pyarrow', 'optuna', 'numpy') if m in sys.modules])")
    done = subprocess.run([sys.executable, "-P", "-c", code], cwd=ROOT,
                          capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr
