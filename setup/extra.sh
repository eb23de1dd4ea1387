# Sourced by ./impedraw after setup/prepare.sh. `prepare_extra NAME` installs the wheels of
# setup/NAME-requirements.txt, sweep, camera, image, format or vpype, into build/NAME-venv, sets $extra to its Python and lets
# it import impedraw.NAME from the tree, where there is one. `bash setup/extra.sh NAME` does the same for the tests.

if [[ "${BASH_SOURCE[0]}" == "$0" ]]; then
  set -euo pipefail
  self=$(readlink -f "${BASH_SOURCE[0]}")
  root=${self%/*/*}
  . "$root/setup/prepare.sh"
  prepare_extra_at_end=$1
fi

declare -A extra_holds=([sweep]="sweeps (Ray, pyarrow, Optuna: 200 MB to fetch)" [camera]="cameras (OpenCV, SciPy, rosbags, RealSense's SDK: 120 MB to fetch)" [format]="the format (clang-format 14: 2 MB to fetch)"
  [vpype]="comparison with vpype (vpype, Shapely, SciPy: 60 MB to fetch)" [image]="pictures (SciPy, scikit-image, Pillow: 80 MB to fetch)")

prepare_extra() {
  local name=$1 folder=$root/build/$1-venv list=$root/setup/$1-requirements.txt python=/usr/bin/python3 site stamp
  stamp=$folder$'\n'$(<"$list")
  extra=$folder/bin/python
  [[ -r $folder/.requirements && $(<"$folder/.requirements") == "$stamp" ]] && return
  [[ -x $python ]] || python=python3
  mkdir -p "$root/build"
  exec 8>"$root/build/.$name-lock"
  flock 8
  if [[ ! -r $folder/.requirements || $(<"$folder/.requirements") != "$stamp" ]]; then
    log=$root/build/$name-install.log
    : >"$log"
    step "installing Python wheels for ${extra_holds[$name]}"
    rm -rf "$folder"
    { "$python" -m venv "$folder" &&
      "$extra" -m pip install --require-hashes --no-deps --only-binary :all: --no-input \
        --disable-pip-version-check -r "$list"
    } >>"$log" 2>&1 8>&- || fail "the Python wheels for ${extra_holds[$name]%% *} could not be installed" "the whole log: $log"
    # It imports impedraw.NAME from the tree, without the compiled package beside it.
    if [[ -d $root/python/impedraw/$name ]]; then
      site=$("$extra" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
      mkdir -p "$site/impedraw"
      ln -sfn "$root/python/impedraw/$name" "$site/impedraw/$name"
    fi
    echo "$stamp" >"$folder/.requirements"
    say "installed $(grep -c '^[^#]' "$list") Python wheels for ${extra_holds[$name]%% *}"
  fi
  exec 8>&-
}

[[ -z ${prepare_extra_at_end-} ]] || prepare_extra "$prepare_extra_at_end"
