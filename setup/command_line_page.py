"""Writes docs/command-line.md from the --help of the program, of the sweeps and of the cameras' commands. Needs PyYAML.

usage: command_line_page.py [--check] PROGRAM PAGE

Writes PAGE; with --check compares instead, and fails where it differs.
"""

import contextlib
import io
import os
import pathlib
import re
import subprocess
import sys
import types
import unittest.mock

INTRODUCTION = """\
# Command line

<!-- Made by setup/command_line_page.py from each --help: ./impedraw docs writes it anew. -->

`./impedraw` installs and builds what is missing, then runs the program. `./impedraw docs` builds this
documentation. The other commands:
"""


def help_of(program, *command):
    text = subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


def page(program):
    whole = help_of(program)
    commands = re.findall(r"^  ([a-z][\w-]*) ", whole.split("Subcommands:")[1], re.MULTILINE)
    parts = [INTRODUCTION, f"```text\n{whole}\n```\n"]
    for command in commands:
        parts.append(f"## {command}\n\n```text\n{help_of(program, command)}\n```\n")
    for command, text in (*sweeps(), *cameras()):
        parts.append(f"## {command}\n\n```text\n{text}\n```\n")
    return "\n".join(parts)


def sweeps():
    """Name and help of each command that runs many drawings, without the package's compiled part."""
    os.environ["COLUMNS"] = "100"  # argparse wraps its text there
    package = types.ModuleType("impedraw")
    package.__path__ = [str(pathlib.Path(__file__).parents[1] / "python" / "impedraw")]
    sys.modules["impedraw"] = package
    from impedraw.sweep.__main__ import help_texts

    return help_texts().items()


def cameras():
    """The same of the commands of impedraw.camera, without OpenCV and what else they work with."""
    for name in ("cv2", "numpy", "scipy", "scipy.optimize", "scipy.spatial", "scipy.spatial.transform"):
        sys.modules.setdefault(name, unittest.mock.MagicMock())
    from impedraw.camera.__main__ import main as run

    for command in ("calibrate-camera", "capture", "capture import"):
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
            run([*command.split(), "--help"])
        yield command, "\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    program, path = arguments
    text = page(program)
    if "--check" not in sys.argv:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    elif open(path, encoding="utf-8").read() != text:
        sys.exit(f"impedraw: {path} is not what the program's --help says; write it anew: ./impedraw docs")


main()
