"""Drawings in this process against the command line, and the simulated world."""

import html
import json
import os
import pathlib
import re
import subprocess
import sys
import threading
import types
from typing import Any

import numpy as np
import pytest

import impedraw as idr
from impedraw import _runner

WALL = {"step_time_p50", "step_time_p99", "step_time_p999", "real_time_factor"}
LINE = '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10"><path d="M0 5 H20" stroke="black" fill="none"/></svg>'


@pytest.fixture(scope="module")
def line(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    file = tmp_path_factory.mktemp("artwork") / "line.svg"
    file.write_text(LINE)
    return file


PLANE = {"canvas.kind": "plane", "drawing.placement.scale": 1}


@pytest.fixture(scope="module")
def drawn(line: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[idr.Run, list[float]]:
    seen = []
    out = tmp_path_factory.mktemp("run") / "line"
    run = idr.draw(line, canvas=idr.Plane(), settings={"drawing": {"placement": {"scale": 1}}}, out=out,
                   progress=lambda what, share: seen.append(share))
    return run, seen


def counted(metrics: Any) -> Any:
    return {k: v for k, v in metrics.items() if k not in WALL}


def test_draw_leaves_a_run(drawn: tuple[idr.Run, list[float]]) -> None:
    run, seen = drawn
    assert run.end == "finished" and run.name == "line"
    written = json.loads((run.folder / "metrics.json").read_text())
    assert {k: run.metrics[k] for k in run.metrics} == {k: written[k] for k in run.metrics}
    assert run.metrics.ink_error_rms is not None and run.metrics.ink_error_rms < 0.1
    assert run.metrics.gaps == 0 and isinstance(run.metrics.gaps, int)
    assert "[mm]" in (type(run.metrics).ink_error_rms.__doc__ or "")
    force = run.log["contact/force"]
    assert force.shape == (len(run.log["time"]), 3) and run.log.unit("contact/force") == "N"
    assert "time" in run.log and "nothing" not in list(run.log)
    with pytest.raises(KeyError, match="no dataset 'nothing'"):
        run.log["nothing"]
    assert seen and all(0 <= share <= 1 for share in seen)
    assert "<iframe" in run._repr_html_()
    again = idr.Run.open(run.folder)
    assert counted(again.metrics) == counted(run.metrics)
    assert (again.end, again.cause, again.incident) == ("finished", "", None)
    assert again.metrics.drawn == 1 and again.not_drawn_mm == run.not_drawn_mm == {}


def test_a_run_that_drew_nothing_says_so(tmp_path: pathlib.Path) -> None:
    homes = (pathlib.Path(__file__).parents[2], pathlib.Path(idr.__file__).parent / "data")  # the tree's, a wheel's
    scenario = next(home for home in homes if (home / "scenarios").is_dir()) / "scenarios/bowl-sine-blind.yaml"
    run = idr.draw(scenario=scenario, settings={"world.gravity": 8.455}, out=tmp_path / "run")
    again = idr.Run.open(tmp_path / "run")
    assert run.end == again.end == "nothing_drawn" and run.cause == again.cause and "never pressed" in run.cause
    assert run.metrics.drawn == 0 and list(run.not_drawn_mm) == ["no_ink"]
    bare = _runner.run({"world.gravity": 8.455}, scenario)
    assert bare["end"] == "nothing_drawn" and bare["not_drawn_mm"] == run.not_drawn_mm


def test_show_in_a_notebook_and_elsewhere(drawn: tuple[idr.Run, list[float]], monkeypatch: pytest.MonkeyPatch) -> None:
    run = drawn[0]
    shown: list[Any] = []
    opened: list[str] = []
    notebook, display = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    setattr(notebook, "get_ipython", lambda: notebook)
    setattr(display, "display", shown.append)
    monkeypatch.setitem(sys.modules, "IPython", notebook)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr("webbrowser.open", opened.append)
    run.show()
    assert shown == [run] and opened == []
    # What the cell shows is the page, as a frame that runs its scripts and nothing of the notebook's.
    frame = re.fullmatch(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts" [^>]*></iframe>', run._repr_html_())
    assert frame and html.unescape(frame[1]) == run.page.read_text(encoding="utf-8")
    setattr(notebook, "get_ipython", lambda: None)  # IPython is installed, but this is no notebook
    run.show()
    assert shown == [run] and opened == [run.page.resolve().as_uri()]


def test_dataframe(drawn: tuple[idr.Run, list[float]]) -> None:
    pytest.importorskip("pandas")
    table = drawn[0].to_dataframe()
    assert table.index.name == "time" and np.array_equal(table["contact/force.z"], drawn[0].log["contact/force"][:, 2])


@pytest.mark.skipif("IMPEDRAW_PROGRAM" not in os.environ, reason="without the source tree's program")
def test_the_command_line_draws_the_same(drawn: tuple[idr.Run, list[float]], line: pathlib.Path, tmp_path: pathlib.Path) -> None:
    subprocess.run(
        [os.environ["IMPEDRAW_PROGRAM"], "draw", "--svg", line, "--out", tmp_path / "run",
         *[word for s in PLANE.items() for word in ("--set", f"{s[0]}={s[1]}")]],
        check=True, capture_output=True,
    )
    told = json.loads((tmp_path / "run/metrics.json").read_text())
    assert {k: told[k] for k in counted(drawn[0].metrics)} == counted(drawn[0].metrics)
    for name in ("/joint/torque", "/contact/force", "/tip/position"):
        np.testing.assert_array_equal(drawn[0].log[name], idr.Log(tmp_path / "run/run.h5")[name])


def test_kept_scenes_and_no_log_change_no_bit(drawn: tuple[idr.Run, list[float]], line: pathlib.Path) -> None:
    """One runner over many settings, against a new one for each."""
    cases: list[dict[str, Any]] = [
        {}, {"control.normal_force": 3}, {}, {"seed": 7, "perception.noise.sigma_at_1m": 0.001},
        {"world.tip.friction": 0.1}, {"control.wrench": "realistic"}, {}, {"perception.enabled": False},
        {"path.draw_speed": 0.02, "seed": 8, "perception.noise.sigma_at_1m": 0.001}, {"seed": 9},
    ]
    kept = idr._impedraw.Runner()
    for case in cases:
        given = _runner.options({**PLANE, **case}, svg=line)
        a, b = kept.run(given), idr._impedraw.Runner().run(given)
        assert counted(a["metrics"]) == counted(b["metrics"]), case
        assert a["end"] == b["end"] and a["met"] == b["met"]
        if not case:
            assert counted(a["metrics"]) == counted(drawn[0].metrics)
    # {}, 3 N and the seed without noise share a scene.
    assert kept.scenes_reused == 4 and kept.scenes_built == 6


@pytest.mark.parametrize(
    "settings, message",
    [
        ({"control.normal_forc": 3}, "unknown key 'normal_forc' in control; did you mean 'normal_force'?"),
        ({"control.normal_force": 99}, "control.normal_force is 99 N, allowed is 0 to 50 N"),
        ({"control.normal_force": float("nan")}, "control.normal_force"),
        ({"control": {"normal_force": object()}}, "a setting is of type object"),
        ({"drawing.placement.scale": 90}, "drawing"),
    ],
)
def test_what_is_refused_writes_nothing(settings: Any, message: Any, line: pathlib.Path, tmp_path: pathlib.Path) -> None:
    with pytest.raises(ValueError) as fault:
        idr.draw(line, canvas=idr.Plane(), settings=settings, out=tmp_path / "run")
    assert message in str(fault.value) and "\n" not in str(fault.value)
    assert not (tmp_path / "run").exists()


def test_a_scene_is_kept_after_a_refusal(line: pathlib.Path) -> None:
    runner = idr._impedraw.Runner()
    runner.run(_runner.options(PLANE, svg=line))
    with pytest.raises(ValueError):
        runner.run(_runner.options({**PLANE, "drawing.placement.scale": 30}, svg=line))
    with pytest.raises(ValueError):  # named by a setting that does not make the scene
        runner.run(_runner.options({**PLANE, "control.null_stiffness": [1, 2]}, svg=line))
    runner.run(_runner.options(PLANE, svg=line))
    assert runner.scenes_built == 1 and runner.scenes_reused == 2


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"svg": None}, "svg is None"), ({"svg": 5}, "svg is of type int"), ({"svg": b"a.svg"}, "svg is of type bytes"),
        ({"svg": ""}, "svg is empty"), ({"svg": ["a.svg"]}, "svg is of type list"), ({"text": 5}, "text is of type int"),
        ({"text": ""}, "text is empty"), ({"shape": b"M"}, "shape is of type bytes"), ({"scenario": 1.5}, "scenario is of type float"),
        ({"scenario": ""}, "scenario is empty"), ({"canvas": "bowl"}, "canvas is of type str"), ({"settings": 5}, "settings is of type int"),
        ({"settings": [("control.normal_force", 3)]}, "settings is of type list"), ({"out": 5}, "out is of type int"),
        ({"keep_order": "yes"}, "keep_order is of type str"), ({"no_perception": None}, "no_perception is of type NoneType"),
        ({"skip_unreachable": 1}, "skip_unreachable is of type int"), ({"overwrite": 1}, "overwrite is of type int"),
        ({"progress": 5}, "progress is of type int"),
    ],
)  # fmt: skip
def test_a_wrong_type_is_one_line_and_no_drawing(
    arguments: dict[str, Any], message: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((TypeError, ValueError)) as fault:
        idr.draw(**arguments)
    assert message in str(fault.value) and "\n" not in str(fault.value)
    assert list(tmp_path.iterdir()) == []
    if set(arguments) & {"svg", "text", "shape", "scenario", "canvas", "settings"}:
        with pytest.raises((TypeError, ValueError), match=message):
            idr.plan(**arguments)


def test_results_are_replaced_on_request_alone(drawn: tuple[idr.Run, list[float]], line: pathlib.Path) -> None:
    with pytest.raises(ValueError, match="holds the results of a run; --overwrite"):
        idr.draw(line, canvas=idr.Plane(), out=drawn[0].folder)
    again = idr.draw(line, canvas=idr.Plane(), settings={"drawing.placement.scale": 1}, out=drawn[0].folder, overwrite=True)
    assert counted(again.metrics) == counted(drawn[0].metrics)


def test_the_pre_flight_tells_what_cannot_be_drawn(line: pathlib.Path) -> None:
    good = idr.plan(line, canvas=idr.Plane())
    assert good["not_drawable"] == []
    bad = idr.plan(line, canvas=idr.Plane(), settings={"drawing.placement.scale": 30})
    assert bad["not_drawable"] and "text" in bad["not_drawable"][0]


def test_ctrl_c_lifts_the_pen_and_keeps_the_log(tmp_path: pathlib.Path) -> None:
    code = (
        "import impedraw as idr, os, signal\n"
        "def seen(what, share):\n"
        "    if what == 'drawing' and share > 0.1: os.kill(os.getpid(), signal.SIGINT)\n"
        f"try: idr.draw(out={str(tmp_path / 'run')!r}, progress=seen)\n"
        "except KeyboardInterrupt as e: print('interrupt:', e)\n"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert "interrupt: interrupted at t =" in said.stdout and "the pen was lifted" in said.stdout, said
    log = idr.Log(tmp_path / "run/run.h5")
    left = idr.Run.open(tmp_path / "run")
    assert left.end == "interrupted" and left.cause.startswith("interrupted at t =") and left.incident is None
    assert len(log["time"]) > 100 and log["tip/position"][-1][2] > log["tip/position"][-300][2]


def test_an_error_of_the_callback_ends_the_run(line: pathlib.Path) -> None:
    def fail(what: Any, share: Any) -> None:
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        _runner.run(PLANE, svg=line, progress=fail)


def world() -> Any:
    arm = idr.ArmModel.standard()
    w = idr.World(arm.urdf, idr.Bowl().canvas())
    return arm, w


def test_world_falls_freely_and_holds() -> None:
    """With τ = g the arm at rest stays; without, it begins with M v̇ = −g."""
    arm, w = world()
    q = np.array([0, 0.3, 0, -1.6, 0, 1.2, 0])
    w.set_state(q)
    t = arm.compute(q, np.zeros(7))
    for _ in range(100):
        w.step(t.g)
    np.testing.assert_allclose(w.state.q, q, atol=1e-6)
    w.set_state(q)
    w.step(np.zeros(7))
    np.testing.assert_allclose(w.state.v, -1e-3 * np.linalg.solve(t.M, t.g), rtol=1e-6, atol=1e-9)
    assert w.state.time == pytest.approx(1e-3) and w.failure is None
    with pytest.raises(ValueError, match="tau is .*; valid is 7 entries"):
        w.step(np.zeros(6))
    with pytest.raises(ValueError, match="tau is .*; valid is finite"):
        w.step(np.full(7, np.nan))


def swing(seed: int) -> Any:
    arm, w = world()
    w.set_state(np.array([0, 0.3, 0, -1.6, 0, 1.2, 0]))
    rng = np.random.default_rng(seed)
    for _ in range(300):
        w.step(rng.normal(0, 3, 7))
    return w.state.q.copy()


def test_worlds_in_threads_are_as_alone() -> None:
    alone = [swing(seed) for seed in range(4)]
    together = [None] * 4

    def work(seed: int) -> None:
        together[seed] = swing(seed)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert all(b is not None and np.array_equal(a, b) for a, b in zip(alone, together))


def test_world_keeps_its_canvas_alive() -> None:
    import gc

    arm = idr.ArmModel.standard()
    w = idr.World(arm.urdf, idr.Plane().canvas())
    gc.collect()
    w.set_state(np.array([0, 0.3, 0, -1.6, 0, 1.2, 0]))
    w.step(np.zeros(7))
    assert w.touching_link == ""


def test_canvas_of_a_mesh() -> None:
    v = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    c = idr.Canvas.from_mesh(v, [[0, 1, 2], [1, 3, 2]])
    p = c.closest([0.5, 0.25, 0.1])
    np.testing.assert_allclose(p.p_W, [0.5, 0.25, 0], atol=1e-15)
    assert p.distance == pytest.approx(0.1) and list(p.n_W) == [0, 0, 1]
    with pytest.raises(ValueError, match="an index of a vertex, 0 to 3"):
        idr.Canvas.from_mesh(v, [[0, 1, 9]])
    with pytest.raises(ValueError, match="canvas.cap.radius"):
        idr.Bowl(radius=-1).canvas()


def test_import_pulls_neither_ray_nor_matplotlib() -> None:
    code = "import impedraw, sys; print([m for m in ('ray','matplotlib','h5py','pandas','gymnasium','mujoco') if m in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


@pytest.mark.skipif("IMPEDRAW_PROGRAM" in os.environ, reason="the source tree's package")
def test_a_wheel_brings_its_data() -> None:
    """Nothing is read from where it was built."""
    package = pathlib.Path(idr.__file__).parent
    assert idr._impedraw.data_folder() == package / "data"
    assert idr.ArmModel.standard().urdf.is_relative_to(package)
    assert (package / "data/scenarios/bowl-sine.yaml").is_file() and (package / "py.typed").is_file()
    written = idr.plan(text="Hi")  # with the fonts that it brings
    assert written["not_drawable"] == []


def test_nothing_leaks_at_exit() -> None:
    """nanobind counts its instances, types and functions when Python ends."""
    code = (
        "import impedraw as idr, numpy as np, copy, pickle\n"
        "arm = idr.ArmModel.standard(); t = arm.compute(np.zeros(7), np.zeros(7))\n"
        "c = idr.ImpedanceController(idr.ImpedanceSettings(), arm)\n"
        "view = c.step(t, idr.TipReference(n_WD=-t.X_WE.R[:, 2]), idr.SurfaceEstimate()).tau\n"
        "part = idr.ImpedanceSettings().contact; copy.deepcopy(part); pickle.dumps(part)\n"
        "w = idr.World(arm.urdf, idr.Plane().canvas()); state = w.state.q\n"
        "try: idr.ImpedanceSettings(normal_forc=3)\n"
        "except ValueError: pass\n"
        "del arm, t, c, view, part, w, state\n"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == said.stderr == ""


def test_many_steps_keep_memory() -> Any:
    """A reference lost in a step or in a result would show."""
    import resource

    arm = idr.ArmModel.standard()
    t = arm.compute(np.zeros(7), np.zeros(7))
    c = idr.ImpedanceController(idr.ImpedanceSettings(), arm)
    reference, surface, F = idr.TipReference(n_WD=-t.X_WE.R[:, 2]), idr.SurfaceEstimate(), [0.0] * 6

    def some() -> Any:
        for _ in range(20000):
            out = c.step(t, reference, surface, F)
            assert out.tau is not None and out.terms is not None and out.status.ok in (True, False)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = some()
    assert some() - before < 2000  # kB; an object a step would be 20,000
