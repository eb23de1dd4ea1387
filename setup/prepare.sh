# Sourced by ./impedraw and ./check. `prepare TARGET` installs missing dependencies and builds TARGET if a source is newer.
# Requires $root (the repository) and `set -euo pipefail`.
# Optional: $preset, one of CMakePresets.json (default: release); $package_lists, lists of Debian packages (default:
# apt-packages.txt); IMPEDRAW_VENV, a venv in place of .venv.
# Messages go to stderr, details to build/install.log and build/build.log. Once everything is installed, no network is needed,
# and a call with nothing to do starts no compiler, pip or apt.

venv=${IMPEDRAW_VENV:-$root/.venv}
preset=${preset:-release}
out=$root/build/$preset
package_lists=("${package_lists[@]:-$root/apt-packages.txt}")
log=$root/build/install.log
[[ -t 2 ]] && terminal=1 || terminal=

count() { echo "$1 $2$( (( $1 == 1 )) || echo s)"; }  # 3 wheels, 1 wheel

say() { printf '%s%s\n' "${terminal:+$'\r\e[K'}" "impedraw: $*" >&2; }

# Progress. On a terminal the line is redrawn; elsewhere a new line is printed at most every half minute.
step_shown=
step() {
  if [[ $terminal ]]; then printf '\r\e[K%s' "impedraw: $*" >&2
  elif [[ -z $step_shown ]] || (( SECONDS - step_shown >= 30 )); then step_shown=$SECONDS; printf '%s\n' "impedraw: $*" >&2
  fi
}

# fail MESSAGE ADVICE [nolog]: prints the message, 20 lines of the log (from its first error, else the last ones) and the advice.
fail() {
  say "$1"
  if [[ ${3-} != nolog && -s $log ]]; then
    local first
    first=$(grep -m1 -nE '^(CMake Error|FAILED:|E: |ERROR:|error:)' "$log" | cut -d: -f1) || true
    echo "--- from $log" >&2
    if [[ $first ]]; then sed -n "$first,$((first + 19))p" "$log" >&2; else tail -n 20 "$log" >&2; fi
    echo "---" >&2
  fi
  [[ -z ${2-} ]] || printf '%s\n' "impedraw: $2" >&2
  exit 1
}

prepare() {
  is_ready "$1" && return
  if ! can_write; then
    # Whoever runs it here can neither install nor build; what is built runs as it is.
    [[ -x $venv/bin/python ]] && is_built "$1" && return
    fail "$1 is not built, and $root/build cannot be written" "build it once as the owner of $root, or copy it" nolog
  fi
  trap 'say "interrupted; the same command goes on from here"; exit 130' INT
  exec 9>"$root/build/.lock"
  flock -n 9 || { say "waiting for another impedraw that is installing or building"; flock 9; }
  # 9>&-: child processes must not inherit the lock, or the daemon of a compiler wrapper would hold it for ever.
  if ! is_ready "$1"; then
    { has_packages || install_packages
      has_wheels || { start_cargo; finish_wheels; }
      begin_arm_meshes
      is_built "$1" || build "$1"; } 9>&-
  fi
  exec 9>&-
  trap - INT
}

# Only the Debian packages, for modes that build nothing.
prepare_packages() {
  mkdir -p "$root/build"
  has_packages || install_packages
}

can_write() { mkdir -p "$root/build" 2>/dev/null && [[ -w $root/build ]]; }
is_ready() { has_packages && has_wheels && is_built "$1"; }

# --- Debian's packages ---------------------------------------------------------------------------------------------

# The stamp contains the state of dpkg's list, so that a removed package or another machine is noticed.
packages_stamp() { stat -c '%Y %s' /var/lib/dpkg/status 2>/dev/null || echo no dpkg; cat "${package_lists[@]}"; }
packages_file() { local more=${package_lists[1]-}; more=${more##*apt-packages}; echo "$root/build/.packages${more%.txt}"; }
has_packages() { [[ -r $(packages_file) && $(<"$(packages_file)") == "$(packages_stamp)" ]]; }

# in_release NAME LEAST: the release has that package in at least that version.
in_release() {
  local has
  has=$(apt-cache policy "$1" 2>/dev/null | awk '$1 == "Candidate:" {print $2}')
  [[ $has && $has != '(none)' ]] && dpkg --compare-versions "$has" ge "$2"
}

# Prints the packages of the lists that are missing or too old, one per line; of alternatives, the first that the release has.
missing_packages() {
  local name least why have cargo node one release
  release=$(. /etc/os-release 2>/dev/null && echo "${VERSION_ID-}")
  declare -A version=()
  while read -r name have; do version[$name]=$have; done < <(
    dpkg-query -W -f='${db:Status-Abbrev}\t${Package}\t${Version}\n' 2>/dev/null | awk -F'\t' '$1 ~ /^.i/ {print $2, $3}')
  cargo=$(cargo --version 2>/dev/null | awk '{print $2}') || true
  node=$(node --version 2>/dev/null) || true
  while read -r name least why; do
    [[ -z $name || $name == '#'* ]] && continue
    [[ $name == *-web && $cargo ]] && dpkg --compare-versions "$cargo" ge "$least" && continue
    [[ $name == nodejs && $node ]] && dpkg --compare-versions "${node#v}" ge 18 && continue
    for one in ${name//|/ }; do
      [[ ${version[$one]-} ]] && dpkg --compare-versions "${version[$one]}" ge "$least" && continue 2
    done
    for one in ${name//|/ }; do
      [[ $one != "$name" ]] && in_release "$one" "$least" && { echo "$one"; continue 2; }
    done
    # Without lists of apt: the first, but for Debian 12's Rust.
    [[ $one == *-web && ${release-} == 12 ]] || one=${name%%|*}
    echo "$one"
  done < <(cat "${package_lists[@]}")
}

install_packages() {
  rm -f "$out"/.built-*  # packages changed: let ninja check what to rebuild
  if ! command -v dpkg-query apt-get >/dev/null; then
    say "this is no Debian: install what apt-packages.txt lists by this system's own means; going on without"
    packages_stamp >"$(packages_file)"
    return
  fi
  local missing
  mapfile -t missing < <(missing_packages)
  if (( ${#missing[@]} )); then
    local as_root=() rust='' by_hand="apt-get install --no-install-recommends ${missing[*]}" all
    all="$(count ${#missing[@]} 'Debian package')"
    [[ " ${missing[*]} " == *-web\ * ]] && rust="; rustc-web and cargo-web stand in the release's security updates, any Rust from 1.85 on PATH does as well"
    if (( EUID != 0 )); then
      command -v sudo >/dev/null || fail "missing Debian packages, and neither root nor sudo to install them" "ask an administrator to run: $by_hand" nolog
      [[ -t 0 ]] || sudo -n true 2>/dev/null ||
        fail "missing Debian packages, and sudo would ask for a password" "run first: sudo $by_hand" nolog
      as_root=(sudo)
    fi
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
               apt-get -y -o Acquire::Retries=3 -o DPkg::Lock::Timeout=600 -o Dpkg::Use-Pty=0)
    : >"$log"
    step "installing $all (${missing[*]:0:4}${missing[4]:+ …})"
    "${as_root[@]}" dpkg --configure -a >>"$log" 2>&1 || true  # an earlier try may have been interrupted
    "${apt[@]}" update >>"$log" 2>&1 || say "apt-get update failed (see $log); trying with the lists at hand"
    mapfile -t missing < <(missing_packages)  # which alternatives the release has is known only now
    # Python first, so that pip works while the rest is unpacked, on one core.
    # --no-remove: rustc-web conflicts with Debian's rustc; only the user may remove that.
    local names
    for names in "$(grep -x python3-venv < <(printf '%s\n' "${missing[@]}"))" "${missing[*]}"; do
      [[ $names ]] || continue
      # apt closes the descriptor of its status for what it starts. As 1, it would leave the packages' scripts without a
      # standard output, and one that prints, as fontconfig's, would fail.
      "${as_root[@]}" sh -c 'log=$1; shift; exec "$@" 3>&1 >>"$log" 2>&1' sh "$log" \
        "${apt[@]:${#as_root[@]}}" install --no-install-recommends --no-remove -o APT::Status-Fd=3 $names |
        follow_apt "installing $all" || fail "$all could not be installed" "by hand: ${as_root[*]:+sudo }$by_hand$rust"
      has_wheels || begin_wheels
    done
    mapfile -t missing < <(missing_packages)
    (( ${#missing[@]} == 0 )) || fail "still missing or too old for impedraw: ${missing[*]}" "apt-packages.txt tells the least versions; impedraw is made for Debian 12 and 13"
    say "installed $all ($SECONDS s so far)"
  fi
  packages_stamp >"$(packages_file)"
}

follow_apt() {
  local line kind
  while IFS= read -r line; do
    IFS=: read -r kind _ share _ <<<"$line"
    case $kind in
      dlstatus) step "$1: fetching, ${share%%.*} %" ;;
      pmstatus) step "$1: unpacking, ${share%%.*} %" ;;
      *) printf '%s\n' "$line" >>"$log" ;;
    esac
  done
}

# --- Wheels --------------------------------------------------------------------------------------------------------

# A venv contains its own path, so the stamp does too.
wheels_stamp() { echo "$venv"; cat "$root/requirements.txt"; }
has_wheels() { [[ -x $venv/bin/python && -e $venv/lib/python3 && -r $venv/.requirements && $(<"$venv/.requirements") == "$(wheels_stamp)" ]]; }

install_wheels() {
  local python=/usr/bin/python3 wheels
  [[ -x $python ]] || python=python3
  wheels=$(grep -c '^[^#]' "$root/requirements.txt")
  : >"$log"
  step "installing $wheels Python wheels"
  local stamped=
  [[ -r $venv/.requirements ]] && stamped=$(head -n 1 "$venv/.requirements")
  if [[ -n $stamped && $stamped != "$venv" ]] || ! "$venv/bin/python" -m pip --version >/dev/null 2>&1; then
    rm -rf "$venv"
    "$python" -m venv "$venv" >>"$log" 2>&1 || fail "no Python environment could be made in $venv" "is python3-venv installed?"
  fi
  rm -f "$venv/.requirements"
  # --no-deps: the list names every wheel with its version and hash, so pip has nothing to resolve, and installs those files alone.
  "$venv/bin/python" -m pip install --require-hashes --no-deps --only-binary :all: --no-compile --no-input --disable-pip-version-check -r "$root/requirements.txt" 2>&1 |
    follow_pip "$wheels" || fail "the Python wheels could not be installed" "pip follows PIP_* of the environment, and needs the network this once"
  rm -f "$out/CMakeCache.txt" "$out"/.built-*
  # Scenarios and studies name files of these wheels, whichever Python the system has.
  ln -sfn "$("$venv/bin/python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')" "$venv/lib/python3"
  wheels_stamp >"$venv/.requirements"
  say "installed $wheels Python wheels ($SECONDS s so far)"
}

# Installs the wheels in the background, in silence.
wheels_process=
begin_wheels() {
  [[ -z $wheels_process ]] || return 0
  ( log=$root/build/wheels.log; trap - INT; install_wheels >/dev/null 2>&1 ) &
  wheels_process=$!
}

# A failure in the background is told by a second try.
finish_wheels() {
  if [[ $wheels_process ]]; then
    step "installing Python wheels"
    if wait "$wheels_process"; then
      say "installed $(count "$(grep -c '^[^#]' "$root/requirements.txt")" 'Python wheel') ($SECONDS s so far)"
      return
    fi
  fi
  install_wheels
}

# Begins the longest step of a build while pip waits for the network. Ninja's own call waits for this one and tells its errors.
start_cargo() {
  local target=$root/build/cargo
  [[ -e $target/release/libimpedraw_usvg.a ]] || ! command -v cargo >/dev/null ||
    (cd "$root/src/drawing/usvg" && CARGO_TARGET_DIR=$target exec cargo build --release --locked --quiet) >/dev/null 2>&1 &
}

follow_pip() {
  local line n=0
  while IFS= read -r line; do
    printf '%s\n' "$line" >>"$log"
    case $line in
      Collecting*|'Requirement already satisfied'*) step "installing Python wheels [$(( ++n ))/$1]" ;;
      Installing*) step "unpacking $1 Python wheels" ;;
    esac
  done
}

# --- Shapes of the arm ---------------------------------------------------------------------------------------------

# Fetches the meshes of the standard arm for the pages (0.9 MB, of a wheel of 103 MB that goes again), in the background and in
# silence: without them, pages draw the arm's simple shapes. Tried again when something is next installed or built.
begin_arm_meshes() {
  local to=$root/build/arm-meshes/iiwa14_pen surfaces=$root/build/surface-meshes
  [[ -d $to && -f $surfaces/sea_bed.obj ]] && return 0
  (
    trap - INT
    new=$(mktemp -d "$root/build/arm-meshes.XXXXXX") || exit
    trap 'rm -rf "$new"' EXIT
    "$venv/bin/python" -m pip download --no-deps --only-binary :all: --python-version 311 --implementation cp --abi cp311 \
      --platform manylinux2014_x86_64 --require-hashes --no-input --disable-pip-version-check --no-cache-dir -q \
      -r "$root/setup/arm-meshes.txt" -d "$new" &&
      "$venv/bin/python" - "$new" <<'PYTHON' && mkdir -p "$root/build/arm-meshes" && { [[ -d $to ]] || mv -T "$new/iiwa14_pen" "$to"; }
import pathlib, sys, zipfile
folder = pathlib.Path(sys.argv[1])
(folder / "iiwa14_pen").mkdir()
with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
    for link in range(8):
        content = wheel.read(f"pybullet_data/kuka_iiwa/meshes/link_{link}.obj")
        (folder / "iiwa14_pen" / f"link_{link}.obj").write_bytes(content)
    # Copyright and licence, as the description beside them states them.
    lines = wheel.read("pybullet_data/kuka_iiwa/model.urdf").decode().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("<!--LICENSE"))
    said = [line.removeprefix("<!--").removesuffix("-->").strip() for line in lines[first + 1 :] if line.startswith("<!--")]
    (folder / "iiwa14_pen" / "NOTICE").write_text("\n".join(said).strip() + "\n")
PYTHON
    # The same wheel has surfaces for ./impedraw robustness --part surfaces.
    "$venv/bin/python" "$root/setup/surface_meshes.py" "$new"/*.whl "$new/surfaces" && { rm -rf "$surfaces"; mv -T "$new/surfaces" "$surfaces"; }
  ) </dev/null >"$root/build/arm-meshes.log" 2>&1 &
}

# --- Build ---------------------------------------------------------------------------------------------------------

sources=("$root"/{CMakeLists.txt,CMakePresets.json,cmake,src,web,bench,examples,python})

# Compares the marker of the last good build with every source: 3 ms, where ninja takes 100 ms.
is_built() {
  local marker=$out/.built-$1 more=()
  [[ $1 == all ]] && more=("$root/tests")
  [[ -e $marker ]] || return
  [[ -z $(find "${sources[@]}" "${more[@]}" -newer "$marker" -print -quit 2>/dev/null) ]]
}

# Build jobs, limited by cores and memory: the largest unit takes up to 2.4 GB, most half of it.
jobs() {
  [[ ${CMAKE_BUILD_PARALLEL_LEVEL-} =~ ^[1-9][0-9]*$ ]] && { echo "$CMAKE_BUILD_PARALLEL_LEVEL"; return; }
  local cores fit limit
  cores=$(nproc)
  fit=$(awk '/^MemAvailable:/ {print int($2 / 2000000)}' /proc/meminfo)
  limit=$(cat /sys/fs/cgroup/memory.max 2>/dev/null || true)
  [[ $limit =~ ^[0-9]+$ ]] && (( limit / 2000000000 < fit )) && fit=$(( limit / 2000000000 ))
  (( fit < 1 )) && fit=1
  echo $(( cores < fit ? cores : fit ))
}

build() {
  log=$root/build/build.log
  local marker=$out/.built-$1
  mkdir -p "$out"
  : >"$log"
  touch "$marker.new"  # before the build, so that a file edited during the build counts as newer
  step_shown=
  if [[ ! -e $out/build.ninja || ! -e $out/CMakeCache.txt ]] || ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$out/CMakeCache.txt"; then
    step "configuring"
    rm -rf "$out/CMakeCache.txt" "$out/CMakeFiles"
    cmake -S "$root" --preset "$preset" >>"$log" 2>&1 || fail "the build could not be configured" "the whole log: $log"
  fi
  local start=$SECONDS
  NINJA_STATUS='[%f/%t] ' ninja -C "$out" -j "$(jobs)" "$1" 2>&1 | follow_ninja || fail "the build failed" "the whole log: $log"
  mv "$marker.new" "$marker"
  [[ $1 != all ]] || cp -p "$marker" "$out/.built-impedraw"
  if grep -q '^\[' "$log"; then say "built ($(( SECONDS - start )) s)"; fi
  [[ -z $terminal ]] || printf '\r\e[K' >&2
}

follow_ninja() {
  local line
  while IFS= read -r line; do
    printf '%s\n' "$line" >>"$log"
    if [[ $line =~ ^\[[0-9]+/[0-9]+\] ]]; then step "building ${BASH_REMATCH[0]}"; fi
  done
}
