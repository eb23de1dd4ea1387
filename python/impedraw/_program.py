"""The command ``impedraw`` of an installed package: the program's own command line, in this process."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import signal
import sys
from types import ModuleType

from . import _impedraw

_DATA = pathlib.Path(str(_impedraw.data_folder()))

# What the package does without, and what each needs of a source tree.
_IN_TREE = {
    "bench": "the benchmarks, which are compiled there",
    "deb": "the sources",
    "docs": "the pages' sources",
    "figures": "the pages' sources",
    "film": "its renderer, Node.js, Chromium and ffmpeg",
    "reach": "its specification and meshes",
    "robustness": "its specification and meshes",
    "wheel": "the sources",
}


def found(argument: str) -> str:
    """The argument, with the package's own file where it names one that is not here, as in
    ``artwork/koi.svg`` or ``--set=drawing.svg=artwork/koi.svg``."""
    before, equals, name = argument.rpartition("=")
    if not name or os.path.isabs(name) or os.path.exists(name) or not (_DATA / name).is_file():
        return argument
    return f"{before}{equals}{_DATA / name}"


# Commands in Python: the package and its extra, and the modules that it needs.
_EXTRAS = {
    "calibrate-camera": ("camera", ("cv2", "scipy")),
    "capture": ("camera", ("cv2", "scipy")),
    "image": ("image", ("PIL", "resvg_py", "scipy", "skimage")),
    "sweep": ("sweep", ("pyarrow", "ray", "optuna", "yaml")),
}


def _part(command: str, extra: str, modules: tuple[str, ...]) -> ModuleType:
    lacking = [n for n in modules if importlib.util.find_spec(n) is None]
    if lacking:
        print(f"impedraw: {command} needs {', '.join(lacking)}: pip install 'impedraw[{extra}]'", file=sys.stderr)
        sys.exit(2)
    return importlib.import_module(f"impedraw.{extra}.__main__")


def _in_python(command: str, arguments: list[str]) -> int:
    extra, modules = _EXTRAS[command]
    main = _part(command, extra, modules).main
    first = ["--root", str(_DATA), "--program", os.path.abspath(sys.argv[0])] if command == "sweep" else [command]
    return int(main([*first, *arguments]))


def _doctor() -> int:
    from importlib import metadata

    print(f"impedraw   {metadata.version('impedraw')} in {_DATA.parent}")
    print(f"Python     {sys.version.split()[0]}, {sys.executable}")
    print("Packages")
    missing = 0
    for need in metadata.requires("impedraw") or []:
        # As in "ray==2.60.0; extra == 'sweep'".
        wanted, _, condition = need.partition(";")
        name = wanted.partition("==")[0].partition(">=")[0].strip()
        extra = condition.partition("extra ==")[2].strip(" '\"")
        try:
            state = metadata.version(name)
            if "==" in wanted and state != wanted.partition("==")[2].strip():
                state += f", needs {wanted.partition('==')[2].strip()}"
                missing += not extra
        except metadata.PackageNotFoundError:
            state = f"not installed; only impedraw[{extra}] needs it" if extra else "MISSING"
            missing += not extra
        print(f"  {name:20s} {state}")
    print("Nothing is missing." if not missing else f"{missing} missing: pip install --force-reinstall impedraw")
    remover = {"dpkg": "apt purge"}.get((metadata.distribution("impedraw").read_text("INSTALLER") or "").strip(), "pip uninstall")
    print(f"To remove all: {remover} impedraw, and the folders runs/ that it wrote.")
    return int(missing > 0)


def main() -> int:
    first, *rest = [*sys.argv[1:], ""]
    if first in _IN_TREE:
        print(f"impedraw: {first} needs {_IN_TREE[first]}: clone the repository, and call ./impedraw {first} there",
              file=sys.stderr)
        return 2
    if first == "doctor":
        return _doctor()
    words = sys.argv[1:]
    given = [word if before == "--text" else found(word) for before, word in zip(["", *words], words)]
    if first in _EXTRAS:
        return _in_python(first, given[1:])
    if first in ("draw", "plan", "place") and (of := {word.partition("=")[0] for word in given} & {"--image", "--trace"}):
        given = _part(min(of), *_EXTRAS["image"]).as_strokes(given)
    # As for a program: the library has its own handlers while an arm moves.
    for name in (signal.SIGINT, signal.SIGPIPE):
        signal.signal(name, signal.SIG_DFL)
    return _impedraw.command_line([os.fsencode(word) for word in ("impedraw", *given)])
