#!/bin/bash
# ./impedraw wheel [--sdist] [--test]: builds the Python package's wheels into dist/, for CPython 3.11 and for all from 3.12 on; --sdist: its source
# distribution. --test: installs that into an empty venv (build/wheel-test, build/sdist-test) and runs the package's tests there, without the source
# tree, and the command with each CPython that is here; a source distribution compiles for some minutes. --sdist --configure: only unpacks it and lets
# CMake look at all that it needs.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
case "$*" in
  '' | --test) sdist='' ;;
  --sdist | '--sdist --test' | '--sdist --configure') sdist=1 ;;
  --help | -h) sed -n '2,5s/^# //p' "$0"; exit ;;
  *) echo "impedraw: wheel takes no arguments but --sdist and --test" >&2; exit 2 ;;
esac
for task; do :; done  # the last argument
. "$root/setup/prepare.sh"
# In a test, all is built, and another process may hold the build's lock.
if [[ -z ${IMPEDRAW_WHEEL_BUILT-} ]]; then
  if [[ $sdist ]]; then
    prepare impedraw_web
  else
    prepare impedraw_wheel_extension
    prepare impedraw_stub
  fi
fi

if [[ ! $sdist ]] && ! compgen -G '/usr/lib/*/libcairo.a' >/dev/null; then
  echo "impedraw: a wheel is made on Debian 12: it is linked from libcairo.a, which this system has not; --sdist works here, too" >&2
  exit 77  # ctest: skipped
fi

# A test links Debian's Embree, unless IMPEDRAW_LONG=1 or another call has made the wheels' own, which takes minutes.
own=$([[ -z ${IMPEDRAW_WHEEL_BUILT-} || ${IMPEDRAW_LONG-} || -e $root/build/embree/libembree3.a ]] && echo "$root/build/embree" || true)
if [[ ! $sdist ]]; then
  log=$root/build/wheel.log
  : >"$log"
  . "$root/setup/embree.sh"
  [[ ! $own ]] || prepare_embree
  step "building the wheels"
  { cmake -U '*_ARCHIVE' -DIMPEDRAW_EMBREE="$own" -DIMPEDRAW_ABI3_HEADERS="$(abi3_headers)" "$out" &&
    ninja -C "$out" -j "$(jobs)" impedraw_wheel_extension impedraw_wheel_extension_abi3 impedraw_stub; } >>"$log" 2>&1 || fail "the extensions could not be built" "the whole log: $log"
fi

# venv_of NAME LIST: build/NAME with the wheels of a list, unless it has them already.
venv_of() {
  local at=$root/build/$1 list=$2
  if [[ ! -r $at/.requirements || $(<"$at/.requirements") != "$at$(<"$list")" ]]; then
    rm -rf "$at"
    "$venv/bin/python" -c 'import sys, venv; venv.create(sys.argv[1], with_pip=True)' "$at"
    "$at/bin/python" -m pip install --require-hashes --no-deps --only-binary :all: --no-input --disable-pip-version-check -q -r "$list"
    echo "$at$(<"$list")" >"$at/.requirements"
  fi
}

# install_needs TABLE PYTHON: what pyproject.toml asks for in that table, by hash.
install_needs() {
  python3 "$root/setup/build_wheel.py" needs "$root" "$1" >"$root/build/$1-needs.txt"
  "$2" -m pip install --require-hashes --no-deps --only-binary :all: --no-input --disable-pip-version-check -q -r "$root/build/$1-needs.txt"
}

venv_of wheel-tools "$root/setup/wheel-requirements.txt"
mkdir -p "$root/build"
if [[ $sdist ]]; then made=(sdist "$root" "$root/dist"); else made=(wheel "$root" "$out" "$root/dist" "$root/build/wheel-tools/bin/python"); fi
if ! "$root/build/wheel-tools/bin/python" "$root/setup/build_wheel.py" "${made[@]}" >"$root/build/wheel.log" 2>&1; then
  tail -n 20 "$root/build/wheel.log" >&2
  exit 1
fi
sed -n 's/^made //p' "$root/build/wheel.log"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# The package's tests with the interpreter of a venv. Nothing of the source tree: neither its program, nor its package. Within ./check, where
# python_test has run all of them, only those that a package could fail.
run_tests() {
  local tests=(python)
  [[ -z ${IMPEDRAW_WHEEL_BUILT-} || ${IMPEDRAW_LONG-} ]] || tests=(python/test_run.py python/test_records.py python/test_examples.py)
  cp -r "$root/tests/python" "$root/python/examples" "$scratch"
  ( cd "$scratch" && env -u PYTHONPATH -u IMPEDRAW_PROGRAM "$1/bin/python" -m pytest -q -p no:cacheprovider --tb=short "${tests[@]}" )
}
case ${task-} in
  --test) ;;
  --configure)
    tar -xzf "$root"/dist/impedraw-*.tar.gz -C "$scratch" --strip-components=1
    cmake -S "$scratch" -B "$scratch/build/source" -G Ninja -DSKBUILD=ON -DPython_EXECUTABLE="$venv/bin/python" >"$root/build/wheel.log" ||
      { tail -n 20 "$root/build/wheel.log" >&2; exit 1; }
    echo "the source distribution is configured"
    exit ;;
  *) exit 0 ;;
esac

if [[ $sdist ]]; then
  rm -rf "$root/build/sdist-test"
  venv_of sdist-test "$root/tests/python/requirements.txt"
  # pyproject.toml's requirements cannot have hashes: what it asks for is installed from this tree's lists, and pip fetches nothing.
  install_needs build-system "$root/build/sdist-test/bin/python"
  install_needs project "$root/build/sdist-test/bin/python"
  CMAKE_BUILD_PARALLEL_LEVEL=$(jobs) "$root/build/sdist-test/bin/python" -m pip install --no-index --no-build-isolation --no-deps --no-input -q "$root"/dist/impedraw-*.tar.gz
  "$root/build/sdist-test/bin/python" -m pip check
  run_tests "$root/build/sdist-test"
  exit
fi
# Only what the wheel's metadata asks for, and the tests' own wheels.
venv_of wheel-test "$root/tests/python/requirements.txt"
install_needs project "$root/build/wheel-test/bin/python"
"$root/build/wheel-test/bin/python" -m pip install --no-index --no-input --disable-pip-version-check -q --force-reinstall --no-deps "$root"/dist/impedraw-*-cp311-*.whl
"$root/build/wheel-test/bin/python" -m pip check
run_tests "$root/build/wheel-test"
# The command, with each CPython that is here, as an ordinary user where root may become one.
python3 "$root/tests/wheel/wheel_command.py" "$out/src/app/impedraw" "$root"/dist/impedraw-*.whl
for wheel in "$root"/dist/impedraw-*.whl; do
  # Nothing of the network or of a screen is in it.
  if "$venv/bin/python" -m zipfile -l "$wheel" | grep -E 'libcurl|libssl|libcrypto|libX11|libxcb|libmujoco|libpinocchio'; then
    echo "impedraw: $wheel has libraries that it must not have" >&2
    exit 1
  fi
  size=$(stat -c %s "$wheel")
  limit=$([[ $own ]] && echo 20000000 || echo 30000000)  # Debian's own Embree is larger
  (( size <= limit )) || { echo "impedraw: $wheel has $size bytes, allowed are $limit" >&2; exit 1; }
done
