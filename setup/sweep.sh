# Sourced by ./impedraw after setup/prepare.sh. `prepare_sweep` installs the wheels of
# setup/sweep-requirements.txt into build/sweep-venv. `bash setup/sweep.sh` does the same for the tests.

if [[ "${BASH_SOURCE[0]}" == "$0" ]]; then
  set -euo pipefail
  self=$(readlink -f "${BASH_SOURCE[0]}")
  root=${self%/*/*}
  . "$root/setup/prepare.sh"
  prepare_sweep_at_end=1
fi

sweep_venv=$root/build/sweep-venv

sweep_stamp() { echo "$sweep_venv"; cat "$root/setup/sweep-requirements.txt"; }

prepare_sweep() {
  [[ -r $sweep_venv/.requirements && $(<"$sweep_venv/.requirements") == "$(sweep_stamp)" ]] && return
  local python=/usr/bin/python3 site
  [[ -x $python ]] || python=python3
  mkdir -p "$root/build"
  exec 8>"$root/build/.sweep-lock"
  flock 8
  if [[ ! -r $sweep_venv/.requirements || $(<"$sweep_venv/.requirements") != "$(sweep_stamp)" ]]; then
    log=$root/build/sweep-install.log
    : >"$log"
    step "installing Python wheels for sweeps (Ray, pyarrow, Optuna: 200 MB to fetch)"
    rm -rf "$sweep_venv"
    { "$python" -m venv "$sweep_venv" &&
      "$sweep_venv/bin/python" -m pip install --require-hashes --no-deps --only-binary :all: --no-input \
        --disable-pip-version-check -r "$root/setup/sweep-requirements.txt"
    } >>"$log" 2>&1 8>&- || fail "the Python wheels for sweeps could not be installed" "the whole log: $log"
    # Drivers and workers import impedraw.sweep from the tree, without the compiled package beside it.
    site=$("$sweep_venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    mkdir -p "$site/impedraw"
    ln -sfn "$root/python/impedraw/sweep" "$site/impedraw/sweep"
    sweep_stamp >"$sweep_venv/.requirements"
    say "installed $(grep -c '^[^#]' "$root/setup/sweep-requirements.txt") Python wheels for sweeps"
  fi
  exec 8>&-
}

[[ -z ${prepare_sweep_at_end-} ]] || prepare_sweep
