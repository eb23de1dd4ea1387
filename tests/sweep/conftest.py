"""Shared by the tests of sweeps.

IMPEDRAW names the program; without it, tests that draw are left out.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def settings():
    from impedraw.sweep.settings import Settings

    return Settings.read(ROOT / "docs/scenario.schema.json")


@pytest.fixture
def spec(tmp_path, settings):
    """spec(TEXT): the checked specification."""
    from impedraw.sweep import load_spec

    def load(text):
        file = tmp_path / "s.yaml"
        file.write_text(text, encoding="utf-8")
        return load_spec(file, ROOT, settings)

    return load


def command(file, out, *more, runner="noop", options=None):
    words = [sys.executable, "-P", "-m", "impedraw.sweep", "--root", str(ROOT), str(file), "--out",
             str(out), "--runner", runner, *more]
    if runner == "process":
        words += ["--program", os.environ["IMPEDRAW"]]
    return words + (["--noop-options", json.dumps(options)] if options else [])


def sweep(file, out, *more, **how):
    """Runs the command to its end."""
    return subprocess.run(command(file, out, *more, **how), capture_output=True, text=True,
                          timeout=240)


needs_program = pytest.mark.skipif("IMPEDRAW" not in os.environ, reason="IMPEDRAW is not set")
