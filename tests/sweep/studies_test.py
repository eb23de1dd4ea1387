"""The studies have the same cells as the engines in C++, name by name and setting by setting."""

import os
import re
import shlex
import subprocess

import pytest
import yaml

from conftest import ROOT, needs_program
from impedraw.sweep import load_spec
from impedraw.sweep.settings import plain, text_of


def cells_of(command):
    """name → (scenario, svg, settings) of what `impedraw robustness --list` prints."""
    text = subprocess.run([os.environ["IMPEDRAW"], *command, "--list"], cwd=ROOT, check=True,
                          capture_output=True, text=True).stdout
    cells = {}
    for name, line in re.findall(r"^(\S.*)\n    (.*)$", text, re.M):
        words = shlex.split(line)[2:]
        settings, svg, scenario = {}, None, None
        while words:
            word = words.pop(0)
            if word == "--set":
                key, value = words.pop(0).split("=", 1)
                settings[key] = value
            elif word == "--svg":
                svg = words.pop(0)
            else:
                scenario = word
        cells[name] = (scenario, svg, {k: value_of(v) for k, v in settings.items()})
    return cells


def value_of(text):
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    if isinstance(value, str):
        try:
            value = float(value)  # 1e+05 is a text for PyYAML
        except ValueError:
            return text
    return plain(value)


@needs_program
@pytest.mark.parametrize(("name", "command"), [
    ("robustness", ["robustness"]), ("reach", ["reach"]),
    ("surfaces", ["robustness", "--part", "surfaces"])])
def test_the_cells_are_those_of_the_command(name, command, settings):
    spec = load_spec(ROOT / f"studies/{name}.yaml", ROOT, settings)
    mine = {c.name: (c.draw["scenario"], c.draw.get("svg"),
                     {k: value_of(text_of(v)) for k, v in c.settings.items()})
            for c in spec.cases()}
    theirs = cells_of(command)
    assert mine.keys() == theirs.keys()
    for cell in theirs:
        assert mine[cell] == theirs[cell], cell
