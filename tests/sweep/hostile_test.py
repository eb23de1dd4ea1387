"""Specifications and data sets that nobody should trust: refused in one line, in bounded memory."""

import json
import os
import subprocess
import sys

import pytest

from conftest import ROOT, sweep
from dataset_test import IDENTITY, rows
from impedraw.sweep import SweepError
from impedraw.sweep.dataset import Dataset, read_dataset
from impedraw.sweep.expression import Expression

HEAD = "scenario: scenarios/bowl-sine.yaml\n"
AXIS = HEAD + "axes:\n  path.draw_speed: "
NAMES = ["../../x", "/tmp/x", "..", ".", "a/b", "a\\b", ".hidden", " ", "", "x" * 300, "nul",
         "COM1.txt", "a\n", "a/../../b", "~/x:", "-x"]
HOSTILE = {
    "nine aliases, ten deep": HEAD + "about: &a0 [1]\n" + "".join(
        f"x{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 11)),
    "mappings of aliases": HEAD + "set: &m0 {a: 1}\n" + "".join(
        f"y{i}: &m{i} {{{', '.join(f'k{j}: *m{i - 1}' for j in range(9))}}}\n"
        for i in range(1, 11)),
    "an alias of itself": HEAD + "set: &s {a: *s}\n",
    "deep lists": HEAD + "when: " + "[" * 50_000,
    "deep mappings": HEAD + "set: " + "{a: " * 400 + "1" + "}" * 400 + "\n",
    "a large file": HEAD + "#" * 2_000_000,
    "a long text": HEAD + f"about: {'a' * 20_000}\n",
    "a long key": HEAD + "set: {? " + "control." * 1_200 + " : 1}\n",
    "a long axis": HEAD + "axes: {? " + "world.tip" * 1_000 + " : [1]}\n",
    "a NUL": HEAD + 'text: "a\\0b"\n',
    "half a character": HEAD + 'text: "\\ud800"\n',
    "10^12 cells": AXIS + "{from: 0.01, to: 1, count: 1000000}\nseeds: 1000000\n",
    "10^12 cells of two axes": AXIS + "{from: 0.01, to: 1, count: 1000000}\n"
    "  control.normal_force: {uniform: [1, 2], count: 1000000}\n",
    "many blocks": HEAD + "blocks:\n" + "  - {seeds: 1000000}\n" * 1000,
    "many zips": HEAD + "axes:\n  z: {zip: {" + ", ".join(
        f"{a}: {{from: 0, to: 1, count: 600000}}" for a in ("world.joint_friction",
                                                            "control.friction")) + "}}\n",
    "cases of long texts": HEAD + f"text: {'a' * 9_999}\nseeds: 1000000\n",
    "a step of nothing": AXIS + "{from: 0, to: 1, step: 1e-300}\n",
    "ends too far apart": AXIS + "{from: -1.7e308, to: 1.7e308, step: 1e-300}\n",
    "ends too far apart, linear": AXIS + "{from: -1.7e308, to: 1.7e308, count: 5}\n",
    "ends too far apart, random": AXIS + "{uniform: [-1.7e308, 1.7e308], count: 5}\n",
    "a huge deviation": AXIS + "{normal: [0, 1.7e308], count: 500}\n",
    "a big integer": HEAD + f"seeds: {'9' * 9_000}\n",
    "a bigger integer": HEAD + f"seeds: {'9' * 9_999}{'9' * 20_000}\n",
    "an integer of 70 bits": HEAD + f"seeds: [{2**70}]\n",
    "no number": HEAD + "seeds: !!int many\n",
    "Python's own": HEAD + "about: !!python/object/apply:os.system [ls]\n",
    "Python's name": HEAD + "about: !!python/name:os.system x\n",
    "a tower of powers": HEAD + "when: 9**9**9**9**9\nseeds: 1\n",
    "a tower to the left": HEAD + "when: (((9**99)**99)**99)**99 > 0\nseeds: 1\n",
    "a long shift": HEAD + "when: 1 << 9999999999\nseeds: 1\n",
    "a text times a number": HEAD + "when: \"'a' * 9999999999 == 'b'\"\nseeds: 1\n",
    "a list times a number": HEAD + 'when: "[1] * 9999999999 == 1"\nseeds: 1\n',
    "a width": HEAD + "when: \"'%9999999999d' % 1 == 'b'\"\nseeds: 1\n",
    "a formatted text": HEAD + "when: \"f'{1:9999999999}' == 'b'\"\nseeds: 1\n",
    "a comprehension": HEAD + 'when: "[x for x in [1]] == 1"\nseeds: 1\n',
    "attributes": HEAD + 'when: "[].__class__.__base__ == 1"\nseeds: 1\n',
    "a root below zero": HEAD + "when: (-8) ** 0.5 > 1\nseeds: 1\n",
    "many signs": HEAD + f"when: {'-' * 1900}1 > 0\nseeds: 1\n",
    "many nots": HEAD + f"when: {'not ' * 450}true\nseeds: 1\n",
    "many dots": HEAD + f"when: a{'.a' * 900} > 0\nseeds: 1\n",
    "many brackets": HEAD + f'when: "{"(" * 900}1{")" * 900}"\nseeds: 1\n',
    "lines in a condition": HEAD + 'when: "a\\nb\\n= ="\nseeds: 1\n',
    "a path that is too long": HEAD + f"svg: {'a' * 5_000}\nseeds: 1\n",
    "a device": "scenario: /dev/zero\nseeds: 1\n",
    "names that grow": HEAD + f"text: {'a' * 2_000}\ncase: '{'{text}' * 1_000}'\nseeds: 1\n",
    "limits without end": HEAD + "limits: {memory: 1e300}\nseeds: 1\n",
    "a list as an axis of the page": HEAD + "report: {maps: [{x: [1], y: seed}]}\nseeds: 1\n",
    "a mapping as a block": HEAD + "report: {lines: [{x: seed, block: {a: 1}}]}\nseeds: 1\n",
    "metrics of lists": HEAD + "report: {metrics: [[1]]}\nseeds: 1\n",
    "the worst 10^300": HEAD + "report: {worst: {count: 1e300}}\nseeds: 1\n",
    "a text of trials": HEAD + "tune: {settings: {control.friction: {uniform: [0, 1]}}, "
    "objective: '1', trials: many}\nseeds: 1000000\n",
    **{f"the name {name[:20]!r}": HEAD + f"name: {json.dumps(name)}\nseeds: 1\n" for name in NAMES},
}
READ = """import json, sys
from pathlib import Path
from impedraw.sweep import SweepError, load_spec
from impedraw.sweep.settings import Settings
root, folder = Path(sys.argv[1]), Path(sys.argv[2])
settings, told = Settings.read(root / "docs/scenario.schema.json"), {}
for name, text in json.loads((folder / "hostile.json").read_text()).items():
    (folder / "s.yaml").write_text(text)
    try:
        spec = load_spec(folder / "s.yaml", root, settings)
        told[name] = f"accepted: {sum(1 for _ in spec.cases())} cases"
    except SweepError as error:
        told[name] = "refused: " + str(error)
print(json.dumps(told))"""


def test_each_hostile_specification_is_refused_in_one_line_within_1_GB(tmp_path):
    (tmp_path / "hostile.json").write_text(json.dumps(HOSTILE))
    done = subprocess.run(["prlimit", "--as=1000000000", "--cpu=240", sys.executable, "-P", "-c",
                           READ, ROOT, tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout)
    assert told.keys() == HOSTILE.keys()
    for name, message in told.items():
        assert message.startswith("refused: "), f"{name}: {message}"
        assert len(message.splitlines()) == 1 and len(message) < 700, f"{name}: {message}"


def test_a_pipe_a_folder_and_a_device_are_no_specification(tmp_path, settings):
    from impedraw.sweep import load_spec

    os.mkfifo(tmp_path / "pipe")
    for file in (tmp_path / "pipe", tmp_path, "/dev/zero", tmp_path / ("x" * 400)):
        with pytest.raises(SweepError, match="cannot be read"):
            load_spec(file, ROOT, settings)


def test_scenarios_that_extend_each_other_end(tmp_path):
    from impedraw.sweep.settings import resolved

    (tmp_path / "a.yaml").write_text("extends: b.yaml\n")
    (tmp_path / "b.yaml").write_text("extends: a.yaml\n")
    with pytest.raises(SweepError, match="or itself"):
        resolved(tmp_path / "a.yaml", {})


def test_arithmetic_is_that_of_float():
    values = {"a": 3, "b": 2.5, "big": 2**62}
    for text in ("a ** 5", "a * b - 1", "a / 2", "-a", "big + 1", "a ** -2", "1e300 * 1e300"):
        assert Expression(text)(values) == float(eval(text, {}, values)), text


@pytest.mark.parametrize("damage", [b"", b"PAR1", b"PAR1" + b"x" * 1000 + b"PAR1", "half", "bits"])
@pytest.mark.parametrize("name", ["runs.parquet", "parts/00000002.parquet"])
def test_a_damaged_file_of_a_data_set_is_one_line(tmp_path, name, damage):
    folder = tmp_path / "d"
    data = Dataset(folder, IDENTITY)
    data.append([rows(0, 1)])
    data.compact()
    data.append([rows(2)])
    data.close()
    whole = (folder / name).read_bytes()
    if damage == "half":
        damage = whole[: len(whole) // 2]
    elif damage == "bits":
        damage = whole[:-200] + bytes(b ^ 255 for b in whole[-200:])
    (folder / name).write_bytes(damage)
    data = Dataset(folder, IDENTITY)
    for read in (data.done, data.table, data.compact, lambda: read_dataset(folder)):
        with pytest.raises(SweepError, match=f"{name}: is damaged") as told:
            read()
        assert "\n" not in str(told.value)


def test_rows_of_another_kind_and_heads_of_nothing_are_one_line(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    folder = tmp_path / "d"
    Dataset(folder, IDENTITY).close()
    pq.write_table(pa.table({"key": ["zz"], "failed": [None]}), folder / "runs.parquet")
    data = Dataset(folder, IDENTITY)
    for read in (data.done, data.table, lambda: read_dataset(folder)):
        with pytest.raises(SweepError, match="is damaged"):
            read()
    data.close()
    for head in ("[]", "{}", "3", "{"):
        (folder / "sweep.json").write_text(head)
        with pytest.raises(SweepError):
            Dataset(folder, IDENTITY)
        with pytest.raises(SweepError):
            read_dataset(folder)


def test_the_command_tells_it_in_one_line(tmp_path):
    file, out = tmp_path / "s.yaml", tmp_path / "out"
    file.write_text(HEAD + "seeds: 3\n")
    assert sweep(file, out, "--serial").returncode == 0
    (out / "runs.parquet").write_bytes(b"PAR1")
    for more in ((), ("--report",)):
        done = sweep(file, out, "--serial", *more)
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
        assert "runs.parquet: is damaged" in done.stderr
    file.write_text(HEAD + "name: ../../x\nseeds: 1\n")
    done = sweep(file, out, "--dry-run")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "no name for a" in done.stderr
