"""Writes the stub of the extension: nanobind's, with what mypy --strict asks for besides.

python_stub.py PACKAGE_FOLDER OUTPUT
"""

import pathlib
import re
import subprocess
import sys

package, output = sys.argv[1:3]
subprocess.run([sys.executable, "-m", "nanobind.stubgen", "-q", "-i", package, "-m", "_impedraw", "-o", output], check=True)
text = pathlib.Path(output).read_text(encoding="utf-8")
text = re.sub(r"\bos\.PathLike(?!\[)", "os.PathLike[str]", text)
text = re.sub(r"\bdict(?=[,:])", "dict[str, typing.Any]", text)
text = re.sub(r"-> tuple:", "-> tuple[typing.Any, ...]:", text)
text = re.sub(r"\blist(?=[,:)])", "list[typing.Any]", text)
text = re.sub(r"^( +__hash__\b.*)$", r"\1  # type: ignore[assignment]", text, flags=re.M)
text = re.sub(r"(def plan\(.*\)) -> object:", r"\1 -> dict[str, typing.Any]:", text)
text = re.sub(r"^TORQUE_TERMS: tuple\b", "TORQUE_TERMS: tuple[str, ...]", text, flags=re.M)
if not re.search(r"^import typing$", text, flags=re.M):
    text = "import typing\n" + text
pathlib.Path(output).write_text(text, encoding="utf-8")
