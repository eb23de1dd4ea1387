#!/bin/bash
# ./impedraw docs: builds the documentation site, build/docs/html/index.html. Warnings are errors.
# Installs the packages of apt-packages-docs.txt, and docs/requirements.txt into build/docs-venv.
# Builds no C++. If the program is built and up to date, writes docs/command-line.md from its --help
# first; with --check, compares that page instead, as CI does.
set -euo pipefail
self=$(readlink -f "${BASH_SOURCE[0]}")
root=${self%/*/*}
. "$root/setup/prepare.sh"
cd "$root"

check=
case ${1-} in
  '') ;;
  --check) check=--check ;;
  *) say "docs: unknown argument '$1'; valid is --check: fail where docs/command-line.md is not the program's own help"
     exit 2 ;;
esac

site=$root/build/docs
docs_venv=$root/build/docs-venv
log=$root/build/docs.log
mkdir -p "$site/static"
: >"$log"

missing=()
while read -r name _; do
  [[ -z $name || $name == '#'* ]] && continue
  dpkg-query -W -f='${db:Status-Abbrev}' "$name" 2>/dev/null | grep -q '^.i' || missing+=("$name")
done <apt-packages-docs.txt
if (( ${#missing[@]} )); then
  as_root=()
  if (( EUID != 0 )); then as_root=(sudo); fi
  step "installing Debian packages for the documentation (${missing[*]})"
  { "${as_root[@]}" apt-get update &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
  } >>"$log" 2>&1 || fail "the documentation needs Debian packages that could not be installed" \
    "by hand: apt-get install --no-install-recommends ${missing[*]}"
fi

stamp=$(echo "$docs_venv"; cat docs/requirements.txt)
if [[ ! -r $docs_venv/.requirements || $(<"$docs_venv/.requirements") != "$stamp" ]]; then
  step "installing Python wheels for the documentation"
  rm -rf "$docs_venv"
  { /usr/bin/python3 -m venv "$docs_venv" &&
    "$docs_venv/bin/python" -m pip install --require-hashes --no-deps --only-binary :all: --no-input \
      --disable-pip-version-check -r docs/requirements.txt
  } >>"$log" 2>&1 || fail "the Python wheels for the documentation could not be installed" "the whole log: $log"
  echo "$stamp" >"$docs_venv/.requirements"
fi

if is_built impedraw; then
  "$docs_venv/bin/python" setup/command_line_page.py $check "$out/src/app/impedraw" docs/command-line.md || exit 1
else
  say "docs/command-line.md is left as it is: the program is not built"
fi
"$docs_venv/bin/python" setup/check_links.py || exit 1

rm -rf "$site"/{doxygen,doctrees,html,static/katex}
cp -rL /usr/share/javascript/katex "$site/static/katex"
rm -f "$site"/static/katex/fonts/*.ttf "$site"/static/katex/*.{js,mjs} && rm -rf "$site/static/katex/contrib"
step "reading the headers"
{ cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $site/doxygen"; } | doxygen - >>"$log" 2>&1 ||
  fail "Doxygen failed" "the whole log: $log"
sed -i '/^ *<includes /d' "$site"/doxygen/xml/*.xml  # links to file pages, which the site does not have
step "building the documentation"
IMPEDRAW_DOCS_BUILD=$site "$docs_venv/bin/python" -m sphinx -b html -n -W --keep-going -q \
  -d "$site/doctrees" docs "$site/html" 2>&1 | tee -a "$log" >&2 ||
  fail "the documentation has warnings, which count as errors" "the whole log: $log"
say "documentation: $site/html/index.html"
