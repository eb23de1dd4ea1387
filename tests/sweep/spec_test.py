"""What a specification says, and what is refused, with the line and what would be valid."""

import itertools
import math
import random

import pytest

from conftest import ROOT, sweep
from impedraw.sweep import SweepError
from impedraw.sweep.expression import Expression
from impedraw.sweep.spec import case_key

HEAD = "scenario: scenarios/bowl-sine.yaml\n"


def settings_of(spec):
    return [c.settings for c in spec.cases()]


def test_axes_multiply_and_the_last_changes_fastest(spec):
    s = spec(HEAD + "set: {drawing.redraw: false}\naxes:\n  path.draw_speed: [0.01, 0.02]\n"
             "  control.normal_force: {from: 1, to: 3, step: 1}\nseeds: 2\n")
    expected = [{"drawing.redraw": False, "path.draw_speed": v, "control.normal_force": f,
                 "seed": n} for v, f, n in itertools.product((0.01, 0.02), (1, 2, 3), (1, 2))]
    assert settings_of(s) == expected


def test_ranges_have_their_ends_exactly(spec):
    s = spec(HEAD + "axes:\n  world.tip.stiffness: {from: 1e3, to: 1e6, count: 4, scale: log}\n")
    values = [c["world.tip.stiffness"] for c in settings_of(s)]
    assert values[0] == 1e3 and values[-1] == 1e6
    assert values[1:3] == pytest.approx([1e4, 1e5], rel=1e-11)
    s = spec(HEAD + "axes:\n  path.draw_speed: {from: 0.1, to: 0.3, step: 0.1}\n")
    assert [c["path.draw_speed"] for c in settings_of(s)] == [0.1, 0.2, 0.3]


def test_random_values_are_those_of_their_seed_and_name(spec):
    text = HEAD + "axes:\n  control.normal_force: {uniform: [1, 20], count: 3, seed: %d}\n"
    values = [c["control.normal_force"] for c in settings_of(spec(text % 4))]
    generator = random.Random("4/control.normal_force")
    assert values == [float(f"{generator.uniform(1, 20):.12g}") for _ in range(3)]
    assert values != [c["control.normal_force"] for c in settings_of(spec(text % 5))]
    log = spec(HEAD + "axes:\n  world.tip.stiffness: {loguniform: [1e3, 1e6], count: 400}\n")
    below = sum(c["world.tip.stiffness"] < math.sqrt(1e3 * 1e6) for c in settings_of(log))
    assert 150 < below < 250


def test_zips_levels_and_conditions(spec):
    s = spec(HEAD + "axes:\n"
             "  pair: {zip: {canvas.kind: [bowl, dome], drawing.shape: [sine, circle]}}\n"
             "  tip: {levels: {soft: {world.tip.stiffness: 1e4, world.tip.friction: 0.1},"
             " hard: {world.tip.stiffness: 1e5}}, when: canvas.kind == 'dome'}\n"
             "  path.draw_speed: [0.01, 0.05]\n"
             "when: canvas.kind == 'bowl' or path.draw_speed < 0.05\n")
    assert settings_of(s) == [
        {"canvas.kind": "bowl", "drawing.shape": "sine", "path.draw_speed": 0.01},
        {"canvas.kind": "bowl", "drawing.shape": "sine", "path.draw_speed": 0.05},
        {"canvas.kind": "dome", "drawing.shape": "circle", "world.tip.stiffness": 1e4,
         "world.tip.friction": 0.1, "path.draw_speed": 0.01},
        {"canvas.kind": "dome", "drawing.shape": "circle", "world.tip.stiffness": 1e5,
         "path.draw_speed": 0.01}]
    assert [c.levels.get("tip") for c in s.cases()] == [None, None, "soft", "hard"]


def test_blocks_share_what_stands_above_them_and_equal_cases_are_one(spec):
    s = spec(HEAD + "set: {drawing.redraw: false}\nblocks:\n"
             "  - {name: a, axes: {path.draw_speed: [0.01, 0.02]}, case: 'a-{path.draw_speed}'}\n"
             "  - {name: b, axes: {path.draw_speed: [0.02, 0.03]}}\n")
    cases = list(s.cases())
    assert [(c.group, c.settings["path.draw_speed"]) for c in cases] == [
        ("a", 0.01), ("a", 0.02), ("b", 0.03)]
    assert [c.name for c in cases[:2]] == ["a-0.01", "a-0.02"]
    assert [c.index for c in cases] == [0, 1, 2]
    assert all(c.settings["drawing.redraw"] is False for c in cases)


def test_a_key_is_stable_however_a_case_is_written(spec):
    a = list(spec(HEAD + "axes: {path.draw_speed: [0.01], control.normal_force: [5]}").cases())
    b = list(spec("axes: {control.normal_force: [5.0], path.draw_speed: [1e-2]}\n"
                  "scenario: scenarios/bowl-sine.yaml # a comment\n").cases())
    assert a[0].key == b[0].key
    # Written down: a data set of today is gone on with tomorrow.
    assert case_key({"scenario": "a.yaml"}, {"seed": 1}) == "6e109911306c0260424547a9fa2e7b6d"


def test_the_command_repeats_the_case(spec):
    s = spec(HEAD + "shape: circle\nset: {canvas.plane.normal: [0, 0.5, 0.8], "
             "drawing.redraw: false}\n")
    assert next(s.cases()).command() == (
        "./impedraw draw scenarios/bowl-sine.yaml --shape circle "
        "--set 'canvas.plane.normal=[0, 0.5, 0.8]' --set drawing.redraw=false")


REFUSED = {
    "axis: {}": (2, "axis", "did you mean axes"),
    "axes:\n  path.draw_sped: [1]": (3, "path.draw_sped", "path.draw_speed"),
    "axes:\n  path.draw_speed: []": (3, "path.draw_speed", "no values"),
    "axes:\n  path.draw_speed:": (3, "path.draw_speed", "no axis"),
    "axes:": (2, "axes", "empty"),
    "axes:\n  path.draw_speed: [fast]": (3, "path.draw_speed", "a number"),
    "axes:\n  path.draw_speed: [99]": (3, "path.draw_speed", "valid are 0"),
    "axes:\n  canvas.kind: [bowel]": (3, "canvas.kind", "bowl"),
    "axes:\n  path.draw_speed: {from: 1}": (3, "path.draw_speed", "to: NUMBER"),
    "axes:\n  path.draw_speed: {from: 1, to: 2}": (3, "path.draw_speed", "count or step"),
    "axes:\n  path.draw_speed: {from: 0, to: 1, count: 3, scale: log}": (3, "scale", "above 0"),
    "axes:\n  path.draw_speed: {uniform: [1, 0], count: 3}": (3, "uniform", "[low, high]"),
    "axes:\n  path.draw_speed: {uniform: [0, 1]}": (3, "count", "1 to"),
    "axes:\n  path.draw_speed: {unifrom: [0, 1], count: 2}": (3, "path.draw_speed", "uniform"),
    "axes:\n  z: {zip: {path.draw_speed: [0.1, 0.2], control.normal_force: [1]}}":
        (3, "z", "different lengths"),
    "axes:\n  l: {levels: {}}": (3, "l", "no levels"),
    "axes:\n  path.draw_speed: [0.1]\n  path.draw_speed: [0.2]": (4, "path.draw_speed", "twice"),
    "axes:\n  seed: [1]\nseeds: 2": (2, "axes", "seed is set by"),
    "seeds: 0": (2, "seeds", "number of seeds"),
    "when: __import__('os')": (2, "when", "no meaning"),
    "when: path.draw_speed <": (2, "when", "no condition"),
    "keep: {log: sometimes}": (2, "log", "never, failed, always"),
    "keep: {logs: never}": (2, "logs", "log"),
    "limits: {time: -1}": (2, "time", "above 0"),
    "accept: {a: 'x +'}": (2, "a", "no condition"),
    "svg: no-such.svg": (2, "svg", "is no file"),
    "arguments: ['--out', /etc]": (2, "arguments", "not valid"),
    "blocks: []": (2, "blocks", "empty"),
    "axes: {path.draw_speed: [0.1}": (2, "", "no valid YAML"),
    "report: {maps: [{x: path.draw_sped, y: seed}]}": (2, "report: maps: x", "no axis"),
    "report: {maps: [{z: seed}]}": (2, "report: maps: z", "no such key"),
    "report: {lines: [{x: seed, block: b}]}": (2, "report: lines: block", "no block b"),
    "report: {lines: 3}": (2, "report: lines", "a list"),
    "set: {world: {tip: 3}}": (2, "world", "no setting"),
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_wrong_is_told_in_one_line(spec, text):
    line, key, said = REFUSED[text]
    with pytest.raises(SweepError) as refused:
        list(spec(HEAD + text + "\n").cases())
    message = str(refused.value)
    assert "\n" not in message
    assert key in message and said in message
    assert f"s.yaml:{line}" in message


def test_a_refused_specification_writes_nothing(tmp_path):
    file, out = tmp_path / "s.yaml", tmp_path / "out"
    file.write_text(HEAD + "axes: {path.draw_speed: []}\n", encoding="utf-8")
    done = sweep(file, out)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and not out.exists()


def test_dry_run_counts_and_writes_nothing(tmp_path):
    file, out = tmp_path / "s.yaml", tmp_path / "out"
    file.write_text(HEAD + "axes: {path.draw_speed: [0.1, 0.2], seed: [1, 2, 3]}\n",
                    encoding="utf-8")
    done = sweep(file, out, "--dry-run")
    assert done.returncode == 0 and "6 cases" in done.stdout and not out.exists()


def test_conditions_against_python():
    values = {"a": 2.0, "b.c": 5, "name": "bowl", "none": None}
    for text, expected in {
        "a * b.c == 10": True, "a < b.c < 7": True, "a < 1 or not b.c < 5": True,
        "name in ['bowl', 'dome']": True, "none < 1": False, "none >= 1": False,
        "none == null": True, "abs(-a) == sqrt(4)": True, "-a ** 2 == -4": True,
        "min(a, b.c) + 1 == 3": True, "true and false": False,
    }.items():
        assert bool(Expression(text)(values)) is expected, text
    for text in ("a.b()", "[x for x in a]", "lambda: 1", "a if b else c", "open('x')", "a[0]",
                 "f'{a}'", "(a := 1)", "a" * 2001):
        with pytest.raises(ValueError):
            Expression(text)
    with pytest.raises(ValueError):
        Expression("9 ** 999999")(values)


def test_the_studies_are_valid(settings):
    from impedraw.sweep import load_spec

    studies = sorted((ROOT / "studies").glob("*.yaml"))
    assert studies
    for file in studies:
        names = [c.name for c in load_spec(file, ROOT, settings).cases()]
        assert len(names) == len(set(names)) > 0, file
