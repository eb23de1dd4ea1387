#!/bin/bash
# ./impedraw deb: builds three packages for this release of Debian into dist/. `impedraw` is the program with the libraries that Debian lacks
# (MuJoCo, Pinocchio); `libimpedraw0.1` and `libimpedraw-dev` are the C++ library: control, sensing, perception and planning.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
case "$*" in
  '') ;;
  --help | -h) sed -n '2,3s/^# //p' "$0"; exit ;;
  *) echo "impedraw: deb takes no arguments" >&2; exit 2 ;;
esac
package_lists=("$root/apt-packages.txt" "$root/apt-packages-deb.txt")
. "$root/setup/prepare.sh"
prepare impedraw_stub

number=$(sed -n 's/^project(impedraw VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
version=$number~deb$(. /etc/os-release && echo "${VERSION_ID:-$VERSION_CODENAME}")
soname=libimpedraw${number%.*}
architecture=$(dpkg --print-architecture)
folder=$(dpkg-architecture -qDEB_HOST_MULTIARCH)
stage=$(mktemp -d "$root/build/deb.XXXXXX")
trap 'rm -rf "$stage"' EXIT
log=$root/build/deb.log
: >"$log"

step "building the packages"
# Debian's shared libraries and its Python, whatever the wheels were made for.
{ cmake -DIMPEDRAW_EMBREE= -DIMPEDRAW_ABI3_HEADERS= -DHDF5_ARCHIVE=OFF -DCAIRO_ARCHIVE=OFF "$out" && ninja -C "$out" -j "$(jobs)" impedraw_wheel_extension &&
    cmake --install "$out" --component python --prefix "$stage/impedraw/usr/lib/impedraw"
  # Debian's own Eigen, which is what a program that uses the library has.
  cmake -G Ninja -S "$root" -B "$root/build/deb" -DIMPEDRAW_LIBRARY_ONLY=ON -DIMPEDRAW_COMPONENTS="control;sensing;perception;planning" \
    -DCMAKE_INSTALL_PREFIX=/usr -DCMAKE_INSTALL_LIBDIR="lib/$folder" -DEigen3_DIR=/usr/share/eigen3/cmake &&
    ninja -C "$root/build/deb" -j "$(jobs)" && DESTDIR=$stage/libimpedraw-dev cmake --install "$root/build/deb" --component library; } >>"$log" 2>&1 9>&- ||
  fail "the packages could not be built" "the whole log: $log"

# The program: the Python package in a folder of its own, with those libraries of other wheels that it loads, as they stand in a venv.
lib=$stage/impedraw/usr/lib/impedraw
site=$(cd "$venv/lib/python3/site-packages" && pwd -P)
rm -rf "$lib"/impedraw/data/{hershey-fonts,fonts}  # of hershey-fonts-data, and of what fontconfig needs
ln -s ../../../../share/hershey-fonts "$lib/impedraw/data/hershey-fonts"
LD_LIBRARY_PATH=$site/mujoco:$site/cmeel.prefix/lib ldd "$lib"/impedraw/_impedraw.*.so | awk '{print $3}' | grep "^$site/" | while read -r from; do
  install -Dm 644 -s "$from" "$lib/${from#"$site/"}"
  patchelf --set-rpath '$ORIGIN' "$lib/${from#"$site/"}"  # some name folders of the machine that built them
done
install -d "$lib/impedraw-$number.dist-info" "$stage/impedraw/usr/bin"
printf 'Metadata-Version: 2.1\nName: impedraw\nVersion: %s\n' "$number" >"$lib/impedraw-$number.dist-info/METADATA"
echo dpkg >"$lib/impedraw-$number.dist-info/INSTALLER"
cat >"$stage/impedraw/usr/bin/impedraw" <<'END'
#!/usr/bin/python3 -IB
import sys

sys.path.insert(0, "/usr/lib/impedraw")
from impedraw._program import main

sys.exit(main())
END
chmod 755 "$stage/impedraw/usr/bin/impedraw"
install -d "$stage/$soname/usr/lib/$folder"
mv "$stage/libimpedraw-dev/usr/lib/$folder"/libimpedraw.so.* "$stage/$soname/usr/lib/$folder"
strip --strip-unneeded "$stage/$soname/usr/lib/$folder/libimpedraw.so.$number"

# needs FILE…: the Debian packages of the libraries that files load.
needs() {
  mkdir -p "$stage/debian"
  printf 'Source: impedraw\n\nPackage: impedraw\nArchitecture: any\n' >"$stage/debian/control"
  (cd "$stage" && dpkg-shlibdeps -O --ignore-missing-info -l"$lib/mujoco" -l"$lib/cmeel.prefix/lib" "${@/#/-e}" 2>>"$log") | sed 's/^shlibs:Depends=//'
}

# pack NAME SECTION DEPENDS SUMMARY TEXT
pack() {
  local at=$stage/$1 doc=$stage/$1/usr/share/doc/$1
  rm -rf "$at/usr/share/doc" && install -d "$doc" "$at/DEBIAN"
  { printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n\nFiles: *\nCopyright: 2026 the impedraw authors\nLicense: Apache-2.0\n'
    printf ' On Debian systems, the text is in /usr/share/common-licenses/Apache-2.0.\n'
    [[ $1 != impedraw ]] || { printf 'Comment: The libraries of others in this package have licences of their own:\n .\n'; sed 's/^/ /; s/^ $/ ./' "$root/THIRD_PARTY.md"; }
  } >"$doc/copyright"
  printf 'impedraw (%s) unstable; urgency=medium\n\n  * Version %s: CHANGELOG.md in the source lists what is new.\n\n -- %s  %s\n' \
    "$version" "$number" "$maintainer" "$(git -C "$root" log -1 --format=%aD)" | gzip -9n >"$doc/changelog.gz"
  cat >"$at/DEBIAN/control" <<END
Package: $1
Source: impedraw
Version: $version
Architecture: $architecture
Maintainer: $maintainer
Section: $2
Priority: optional
Installed-Size: $(du -sk --apparent-size "$at/usr" | cut -f1)
Depends: $3
Description: $4
$(fold -sw 76 <<<"$5" | sed 's/ *$//; s/^/ /')
END
  (cd "$at" && find usr -type f -printf '%P\0' | sort -z | sed -z 's|^|usr/|' | xargs -0 md5sum >DEBIAN/md5sums)
  find "$at" -type d -exec chmod 755 {} +
  dpkg-deb --root-owner-group -Zxz --build "$at" "$root/dist" >>"$log"
}
# Debian's own variables; else who made the last commit.
maintainer=$(git -C "$root" log -1 --format='%an <%ae>')
[[ -z ${DEBEMAIL-} ]] || maintainer="${DEBFULLNAME:-impedraw} <$DEBEMAIL>"
mkdir -p "$root/dist"
rm -f "$root"/dist/*impedraw*.deb
printf 'libimpedraw %s %s (>= %s~)\n' "${soname#libimpedraw}" "$soname" "$number" | install -Dm 644 /dev/stdin "$stage/$soname/DEBIAN/shlibs"
printf 'activate-noawait ldconfig\n' >"$stage/$soname/DEBIAN/triggers"
printf '# A copy of minizip is compiled into the library of Assimp'"'"'s wheel, which Pinocchio loads.\nimpedraw: embedded-library *\n' |
  install -Dm 644 /dev/stdin "$stage/impedraw/usr/share/lintian/overrides/impedraw"
pack impedraw science "python3, python3-numpy, python3-h5py, hershey-fonts-data, $(needs "$lib"/impedraw/_impedraw.*.so "$lib"/*/*.so* "$lib"/*/lib/*.so*)" \
  "draws on unknown curved surfaces with a simulated robot arm" "A pen on a robot arm, held by operational-space impedance control, draws SVG files, text or strokes on surfaces that depth cameras have seen. It checks what can be drawn, draws, and reports line, force and tilt."
pack "$soname" libs "$(needs "$stage/$soname/usr/lib/$folder"/*.so.*)" \
  "operational-space impedance control of a pen (library)" "The shared library: control, sensing, perception and planning of impedraw."
pack libimpedraw-dev libdevel "$soname (= $version), libeigen3-dev, libfmt-dev" \
  "operational-space impedance control of a pen (development)" "Headers, static and shared library, CMake and pkg-config files of impedraw's control, sensing, perception and planning."
for made in "$root"/dist/*impedraw*.deb; do echo "$made $(du -h "$made" | cut -f1)"; done
