"""The examples run, and hold what they assert. Types of examples and tests: mypy --strict."""

import os
import pathlib
import subprocess
import sys
from typing import Any

import pytest

HERE = pathlib.Path(__file__).parent
EXAMPLES = next(p for p in (HERE.parent.parent / "python/examples", HERE.parent / "examples") if p.is_dir())


@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("*.py")), ids=lambda p: p.stem)
def test_example(example: Any, tmp_path: pathlib.Path) -> None:
    if example.stem.startswith("3_"):
        pytest.importorskip("mujoco")
    if example.stem.startswith("4_"):
        pytest.importorskip("ray")  # of the sweeps' venv, where sweep_example_test runs it
    ran = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout


def test_types_of_package_and_examples(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("mypy")
    import impedraw

    # An installed package is found by itself; mypy does not look at PYTHONPATH.
    package = pathlib.Path(impedraw.__file__).parent
    environment = dict(os.environ)
    if package.parent.name != "site-packages":
        environment["MYPYPATH"] = str(package.parent)
    # impedraw.sweep, impedraw.camera and impedraw.image have environments of their own; a wheel's data/ has scripts for other interpreters.
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--scripts-are-modules", "--exclude", "/(camera|image|sweep|data)/", "-p", "impedraw"],
        capture_output=True, text=True, cwd=tmp_path, env=environment, timeout=600,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--scripts-are-modules", *sorted(EXAMPLES.glob("*.py")), *sorted(pathlib.Path(__file__).parent.glob("*.py"))],
        capture_output=True, text=True, cwd=tmp_path, env=environment, timeout=600,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
