"""The studies: every cell that was asked for, and the quickest ones within their limits."""

import itertools
import math
import re
import subprocess

import numpy as np
import pytest

from conftest import ROOT, command, needs_program, sweep
from impedraw.sweep import load_spec
from impedraw.sweep.dataset import read_dataset
from impedraw.sweep.settings import resolved

COMMON = {"drawing.redraw": False, "preflight.arm": False}


@pytest.fixture
def cells(settings):
    """cells(NAME): case by name, and what each sets beside what all of them do."""

    def load(name):
        found = {}
        for case in load_spec(ROOT / f"studies/{name}.yaml", ROOT, settings).cases():
            assert case.name not in found and not re.search(r"[ ,;\"']", case.name), case.name
            found[case.name] = case
        return found

    return load


def group(cells, name):
    return {n: c for n, c in cells.items() if n.startswith(name + "-")}


def test_the_matrix_has_every_combination_once(cells):
    matrix = group(cells("robustness"), "matrix")
    assert len(matrix) == 120
    for speed, slope, push, how in itertools.product(
            (10, 50, 100, 200), (0, 15, 30, 45, 60), (1, 5, 20), ("nominal", "realistic")):
        case = matrix[f"matrix-{how}-{speed}mm_s-{slope}deg-{push}N"]
        assert case.draw["scenario"] == f"scenarios/robustness-{how}.yaml"
        normal = case.settings.pop("canvas.plane.normal")
        assert math.degrees(math.atan2(normal[1], normal[2])) == pytest.approx(slope, abs=1e-5)
        assert math.hypot(*normal) == pytest.approx(1.0, abs=1e-8)
        assert case.settings == {**COMMON, "path.draw_speed": speed / 1000,
                                 "control.normal_force": push}


def test_each_error_stands_alone_at_three_values(cells, settings):
    for name, least in (("error", 15), ("tuned", 10), ("sensed", 2)):
        values = {}
        for case in group(cells("robustness"), name).values():
            assert (name != "tuned") or case.draw["scenario"] == "scenarios/bowl-sine-real.yaml"
            own = {k: v for k, v in case.settings.items() if k not in COMMON}
            told = [k for k in own if k.endswith("sensing.sensor_delay")]
            assert bool(told) == case.name.endswith("-untold")
            assert all(own.pop(k) == 0 for k in told)
            assert len(own) == (case.name not in ("error-none", "error-none-sensor",
                                                  "tuned-as-it-is")), case.name
            scenario = resolved(ROOT / case.draw["scenario"], settings.defaults())
            for setting, value in own.items():
                assert value not in values.setdefault(setting, [])
                values[setting].append(value)
                if name == "error":  # a row of `tuned` may also have the scenario's own value
                    assert scenario[setting] != value, case.name
        assert len(values) >= least and all(len(v) == 3 for v in values.values()), values


def test_canvases_and_switches_come_in_pairs(cells, settings):
    robustness = cells("robustness")
    kinds = {}
    for case in group(robustness, "canvas").values():
        scenario = resolved(ROOT / case.draw["scenario"], settings.defaults())
        kinds.setdefault({**scenario, **case.settings}["canvas.kind"], set()).add(
            case.draw["scenario"])
        assert case.settings["path.draw_speed"] == 0.05
        assert case.settings["control.normal_force"] == 5
    assert set(kinds) >= {"bowl", "dome", "plane", "wave", "saddle", "cylinder", "trough", "cone",
                          "terrain"} and all(len(v) == 2 for v in kinds.values())
    pairs = {}
    for name in group(robustness, "switch"):
        what, state = name.rsplit("-", 1)
        pairs.setdefault(what, set()).add(state)
    assert len(pairs) >= 9 and all(v == {"off", "on"} for v in pairs.values())


def test_every_drawing_on_every_canvas(cells):
    reach = cells("reach")
    assert len(reach) == 100
    drawings = {(c.draw.get("svg"), c.settings.get("drawing.text.text")) for c in reach.values()}
    assert len(drawings) == 10 == len({c.draw["scenario"] for c in reach.values()})
    for case in reach.values():
        assert not case.draw.get("svg") or (ROOT / case.draw["svg"]).is_file(), case.name


def test_surfaces_of_every_kind(cells):
    surfaces = cells("surfaces")
    assert len(surfaces) >= 120
    assert {c.group for c in surfaces.values()} == {"fractal", "facets", "ridges", "ripple", "step",
                                                    "hole", "lip", "mesh"}
    assert {n.rsplit("-", 1)[1] for n in surfaces} == {"hatch", "spiral", "text"}


def test_hands_are_drawn_on_as_the_setup_makes_them(cells, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "setup"))
    import hand_motions

    hands, seeds = cells("hands"), range(1, 7)
    drawn = [k for k in hand_motions.KINDS if k != "hits"]
    assert set(hands) == {f"{k}-{s}-{d}" for k in drawn for s in seeds for d in ("sine", "M")} | {
        f"hits-{s}-text" for s in seeds}
    for name, case in hands.items():
        motion = name.rsplit("-", 1)[0]
        assert case.settings["canvas.motion.file"] == f"build/motions/{motion}.csv"
    for kind, (rms, turn, *_, tremor) in hand_motions.NOISES.items():
        _, p, phi = hand_motions.motion(kind, 7)
        assert np.std(p, axis=0) == pytest.approx(math.hypot(rms, tremor), rel=0.02), kind
        assert np.std(phi, axis=0) == pytest.approx(math.radians(turn), rel=0.02, abs=1e-9), kind
    for kind, (axis, way, move, rest, back) in hand_motions.MOVES.items():
        t, p, _ = hand_motions.motion(kind, 7)
        assert np.ptp(np.delete(p, axis, 1)) == 0.0
        assert np.ptp(p[:, axis]) == pytest.approx(abs(way) * (1 if back else 3), rel=0.01)
        moves = np.abs(np.gradient(p[:, axis], t)) > 1e-9
        assert np.mean(moves) == pytest.approx(move / (move + rest), abs=0.08), kind


# Those of each study that take the least time, and surfaces that the cameras do not resolve.
QUICK = {
    "robustness": ["matrix-nominal-200mm_s-0deg-5N", "matrix-nominal-200mm_s-60deg-20N",
                   "matrix-nominal-100mm_s-45deg-1N", "matrix-realistic-200mm_s-30deg-5N",
                   "matrix-realistic-100mm_s-60deg-1N", "canvas-plane_at_30_deg-nominal",
                   "canvas-sphere_outside_to_60_deg-nominal", "canvas-cone_around_it-realistic",
                   "error-mass_scale-1.2", "error-loop_delay-0.002"],
    "reach": ["hand-on-ball", "hand-on-cone", "hand-on-leaning", "hand-on-wall", "hand-on-bowl",
              "hand-on-terrain", "hand-on-cylinder", "hand-on-tile", "logo-on-cone",
              "logo-on-ball", "spiral-on-ball"],
    "surfaces": ["fractal-20deg-08mm-spiral", "fractal-20deg-15mm-hatch", "facets-10mm-hatch",
                 "ripple-15mm-spiral", "hole-20mm-spiral", "lip-10mm-hatch",
                 "fractal-40deg-02mm-text", "fractal-30deg-02mm-hatch", "facets-02mm-spiral",
                 "facets-10mm-text", "fractal-30deg-08mm-text", "step-02mm-text"],
}


@needs_program
@pytest.mark.parametrize("name", QUICK)
def test_the_quickest_meet_their_limits(name, tmp_path):
    only = "^(" + "|".join(map(re.escape, QUICK[name])) + ")$"
    done = sweep(ROOT / f"studies/{name}.yaml", tmp_path / "d", "--workers", "2", "--only", only,
                 runner="process")
    assert done.returncode == 0, done.stderr
    rows = {r["case"]: r for r in read_dataset(tmp_path / "d")[0].to_pylist()}
    assert rows.keys() == set(QUICK[name])
    for cell, row in rows.items():
        assert not row["failed"], f"{cell}: {row['cause']}"
        if row["state"] == "nothing":
            assert cell == "spiral-on-ball" and row["coverage"] is None
            continue
        assert row["length_promised"] + row["length_undrawable"] == pytest.approx(
            row["length_asked"], abs=0.2)
        assert bool(row["not_drawn"]) == (row["length_undrawable"] > 0)
        if slope := re.search(r"matrix.*-(\d+)deg", cell):
            assert row["slope_max"] == pytest.approx(float(slope[1]), abs=0.05)


@needs_program
@pytest.mark.parametrize(("words", "spec"), [
    (["robustness"], "robustness"), (["reach"], "reach"),
    (["robustness", "--part", "surfaces"], "surfaces")])
def test_the_commands_are_the_studies(words, spec):
    base = command("", "", runner="process")[:6]  # python -P -m impedraw.sweep --root ROOT
    told = [subprocess.run([*base, *more, "--list"], capture_output=True, text=True, check=True,
                           cwd="/").stdout
            for more in (["--study", *words], [str(ROOT / f"studies/{spec}.yaml")])]
    assert told[0] == told[1] and told[0].count("\n    ./impedraw draw ") >= 100
    for wrong in (["--only", "no-such-cell"], ["--only", "("], ["--jobs", "0"], ["--nothing"]):
        done = subprocess.run([*base, "--study", *words, *wrong], capture_output=True, text=True,
                              cwd="/")
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
