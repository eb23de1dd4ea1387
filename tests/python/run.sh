#!/bin/bash
# run.sh PACKAGE_FOLDER PROGRAM [PYTEST_ARGUMENTS…]: the tests of the Python package, in their own venv. Its wheels are those of
# requirements.txt; they are installed when they are missing, which needs the network this once.
set -euo pipefail
here=$(cd "$(dirname "$(readlink -f "$0")")" && pwd)
root=${here%/tests/python}
venv=$root/build/python-tests
stamp() { echo "$venv"; cat "$here/requirements.txt"; }
if [[ ! -r $venv/.requirements || $(<"$venv/.requirements") != "$(stamp)" ]]; then
  rm -rf "$venv"
  python=/usr/bin/python3
  [[ -x $python ]] || python=python3
  "$python" -m venv "$venv"
  "$venv/bin/python" -m pip install --require-hashes --no-deps --only-binary :all: --no-input --disable-pip-version-check -q -r "$here/requirements.txt"
  stamp >"$venv/.requirements"
fi
package=$1 program=$2
shift 2
export PYTHONPATH=$package IMPEDRAW_PROGRAM=$program PYTHONDONTWRITEBYTECODE=1
exec "$venv/bin/python" -m pytest -q -p no:cacheprovider --tb=short "$here" "$@"
