# Sourced by setup/wheel.sh. `prepare_embree` makes build/embree, an Embree of static libraries for the wheel: that of Debian's sources, for
# triangles alone, with code for SSE2 and AVX. Debian's own library is 44 MB. It takes some minutes, once.
prepare_embree() {
  local at=$root/build/embree work=$root/build/embree-build geometry off=()
  [[ ! -e $at/libembree3.a ]] || return 0
  rm -rf "$work"
  mkdir -p "$work" "$at"
  step "building Embree for the wheels (some minutes, once)"
  debian_lists deb-src "$(. /etc/os-release && echo "$VERSION_CODENAME")"
  (cd "$work" && "${debian_apt[@]}" source --download-only --tar-only embree && tar -xf embree_*.orig.tar.* --strip-components=1) >>"$log" 2>&1 9>&- ||
    fail "Debian's sources of Embree could not be fetched" "the whole log: $log"
  # A third of the time, for what no scene here has. Its builders have no code for AVX2 without AVX: the intersectors are AVX's, too.
  sed -i '/curve_intersector_virtual/d' "$work/kernels/CMakeLists.txt"
  for geometry in QUAD CURVE SUBDIVISION USER INSTANCE GRID POINT; do off+=("-DEMBREE_GEOMETRY_$geometry=OFF"); done
  { cmake -G Ninja -S "$work" -B "$work/build" -DCMAKE_BUILD_TYPE=Release -DEMBREE_STATIC_LIB=ON -DEMBREE_ISPC_SUPPORT=OFF -DEMBREE_TUTORIALS=OFF \
      -DEMBREE_TASKING_SYSTEM=INTERNAL -DEMBREE_MAX_ISA=NONE -DEMBREE_ISA_SSE42=OFF -DEMBREE_ISA_AVX2=OFF -DEMBREE_ISA_AVX512=OFF \
      -DEMBREE_FILTER_FUNCTION=OFF "${off[@]}" &&
    ninja -C "$work/build" -j "$(jobs)"; } >>"$log" 2>&1 || fail "Embree could not be built" "the whole log: $log"
  cp "$work"/build/*.a "$at"
  rm -rf "$work"
}

# abi3_headers: the header folders of a CPython from 3.12 on, by ';': the system's or pyenv's, else those of Debian 13.
abi3_headers() {
  local found
  for found in /usr/include/python3.1[2-9] "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.1[2-9]*/include/python3.1[2-9]; do
    [[ ! -e $found/Python.h ]] || { echo "$found"; return; }
  done
  local at=$root/build/python-headers
  if [[ ! -e $at/usr/include/python3.13/Python.h ]]; then
    mkdir -p "$at"
    debian_lists deb trixie
    (cd "$at" && "${debian_apt[@]}" download libpython3.13-dev && dpkg-deb -x libpython3.13-dev_*.deb .) >>"$log" 2>&1 ||
      fail "the headers of CPython 3.13 could not be fetched from Debian 13" "the whole log: $log"
  fi
  echo "$at/usr/include/python3.13;$at/usr/include"
}

# debian_lists KIND RELEASE: makes debian_apt an apt-get that knows that release alone, whatever the system's own lists are. Its signatures count.
debian_lists() {
  local at=$root/build/apt-$2
  mkdir -p "$at"/{sources,lists/partial,archives/partial}
  printf '%s\n' "Types: $1" "URIs: $(awk '/^URIs:/ {print $2; exit}' /etc/apt/sources.list.d/debian.sources 2>/dev/null || true)" "Suites: $2" \
    "Components: main" "Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg" >"$at/sources/release.sources"
  grep -q '^URIs: .' "$at/sources/release.sources" || sed -i 's|^URIs:.*|URIs: http://deb.debian.org/debian|' "$at/sources/release.sources"
  debian_apt=(apt-get -q -o Dir::Etc::sourcelist=/dev/null -o "Dir::Etc::sourceparts=$at/sources" -o "Dir::State::lists=$at/lists"
              -o "Dir::Cache=$at" -o APT::Sandbox::User=root)
  "${debian_apt[@]}" update >>"$log" 2>&1 || fail "Debian's list of packages could not be fetched" "the whole log: $log"
}
