#!/bin/bash
# ./impedraw wheel [--test]: builds the Python package's wheel into dist/. --test: installs it into an empty venv
# (build/wheel-test) and runs the package's tests there, without the source tree.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
case "${1-} $#" in
  ' 0' | '--test 1') ;;
  '--help 1' | '-h 1') sed -n '2,3s/^# //p' "$0"; exit ;;
  *) echo "impedraw: wheel takes no argument but --test" >&2; exit 2 ;;
esac
. "$root/setup/prepare.sh"
# In a test, all is built, and another process may hold the build's lock.
if [[ -z ${IMPEDRAW_WHEEL_BUILT-} ]]; then
  prepare impedraw_wheel_extension
  prepare impedraw_stub
fi

# venv_of NAME LIST PIP_ARGUMENTS…: build/NAME with the wheels of a list, unless it has them already.
venv_of() {
  local at=$root/build/$1 list=$2
  shift 2
  if [[ ! -r $at/.requirements || $(<"$at/.requirements") != "$at$(<"$list")" ]]; then
    rm -rf "$at"
    "$venv/bin/python" -c 'import sys, venv; venv.create(sys.argv[1], with_pip=True)' "$at"
    "$at/bin/python" -m pip install --only-binary :all: --no-input --disable-pip-version-check -q "$@" -r "$list"
    echo "$at$(<"$list")" >"$at/.requirements"
  fi
}

venv_of wheel-tools "$root/setup/wheel-requirements.txt"
mkdir -p "$root/build"
if ! "$venv/bin/python" "$root/setup/build_wheel.py" "$root" "$out" "$root/dist" "$root/build/wheel-tools/bin/python" >"$root/build/wheel.log" 2>&1; then
  tail -n 20 "$root/build/wheel.log" >&2
  exit 1
fi
tail -n 1 "$root/build/wheel.log"
[[ ${1-} == --test ]] || exit 0

# Only what the wheel's metadata asks for, and the tests' own wheels.
venv_of wheel-test "$root/tests/python/requirements.txt" --no-deps
"$root/build/wheel-test/bin/python" -m pip install --only-binary :all: --no-input --disable-pip-version-check -q --force-reinstall --no-deps "$root"/dist/impedraw-*.whl
"$root/build/wheel-test/bin/python" -m pip install --only-binary :all: --no-input --disable-pip-version-check -q "$root"/dist/impedraw-*.whl
"$root/build/wheel-test/bin/python" -m pip check
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp -r "$root/tests/python" "$root/python/examples" "$scratch"
cd "$scratch"
# Nothing of the source tree: neither its program, nor its package.
env -u PYTHONPATH -u IMPEDRAW_PROGRAM "$root/build/wheel-test/bin/python" -m pytest -q -p no:cacheprovider --tb=short python
# Nothing of the network or of a screen is in it.
if "$venv/bin/python" -m zipfile -l "$root"/dist/impedraw-*.whl | grep -E 'libcurl|libssl|libcrypto|libX11|libxcb|libmujoco|libpinocchio'; then
  echo "impedraw: the wheel has libraries that it must not have" >&2
  exit 1
fi
size=$(stat -c %s "$root"/dist/impedraw-*.whl)
(( size <= 30000000 )) || { echo "impedraw: the wheel has $size bytes, allowed are 30,000,000" >&2; exit 1; }
