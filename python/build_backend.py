"""What pip builds the source distribution with: scikit-build-core, after a look at where it is."""

import os
import pathlib
import platform
import sys

from scikit_build_core import build as scikit
from scikit_build_core.build import build_sdist, build_wheel, get_requires_for_build_sdist, prepare_metadata_for_build_wheel  # noqa: F401


def get_requires_for_build_wheel(config_settings=None):
    here = f"{platform.python_implementation()} {platform.python_version()} on {platform.system()}, {platform.machine()}"
    tried = platform.python_implementation() == "CPython" and (platform.system(), platform.machine()) == ("Linux", "x86_64")
    if sys.version_info < (3, 11) or not (tried or "IMPEDRAW_ANY_PLATFORM" in os.environ):
        raise SystemExit(f"impedraw supports CPython 3.11 and later on Linux, x86-64, and this is {here}")
    import tomllib

    of = tomllib.loads((pathlib.Path(__file__).resolve().parent.parent / "pyproject.toml").read_text())
    # The extension is compiled with the headers of the wheels that it is loaded with.
    return [*scikit.get_requires_for_build_wheel(config_settings), *of["project"]["dependencies"], *of["tool"]["impedraw"]["build"]]
