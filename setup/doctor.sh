# Sourced by ./impedraw after setup/prepare.sh. `doctor` lists what is installed, what is missing, the
# disk space and how to remove everything. It installs and builds nothing.

disk() { if [[ -e $1 ]]; then du -shL "$1" 2>/dev/null | cut -f1; else echo -; fi; }

doctor() {
  local file name least why have missing=0 wheel one
  declare -A version=()
  while read -r name have; do version[$name]=$have; done < <(
    dpkg-query -W -f='${db:Status-Abbrev}\t${Package}\t${Version}\n' 2>/dev/null | awk -F'\t' '$1 ~ /^.i/ {print $2, $3}')

  echo "System     $(. /etc/os-release 2>/dev/null && echo "${PRETTY_NAME-unknown}") (made for Debian 12 and 13), $(nproc) cores"
  echo "Compilers  $(c++ --version 2>/dev/null | head -n 1 || echo 'no C++ compiler')"
  echo "           $(cargo --version 2>/dev/null || echo 'no cargo')"
  echo "           $(cmake --version 2>/dev/null | head -n 1 || echo 'no cmake')"

  for file in apt-packages.txt apt-packages-film.txt apt-packages-tests.txt apt-packages-check.txt; do
    echo
    echo "Debian packages of $file"
    while read -r name least why; do
      [[ -z $name || $name == '#'* ]] && continue
      have=
      for one in ${name//|/ }; do have=${have:-${version[$one]-}}; done
      if [[ $have ]] && dpkg --compare-versions "$have" ge "$least"; then
        printf '  %-20s %s\n' "$name" "$have"
      elif [[ $name == *-web ]] && dpkg --compare-versions "$(cargo --version 2>/dev/null | awk '{print $2}')" ge "$least" 2>/dev/null; then
        printf '  %-20s not needed: cargo on PATH is new enough\n' "$name"
      elif [[ $name == nodejs ]] && dpkg --compare-versions "$(node --version 2>/dev/null | tr -d v)" ge 18 2>/dev/null; then
        printf '  %-20s not needed: node on PATH is new enough\n' "$name"
      else
        printf '  %-20s MISSING%s, needs %s: %s\n' "$name" "${have:+ (has $have)}" "$least" "$why"
        [[ $file != apt-packages.txt ]] || missing=$(( missing + 1 ))
      fi
    done <"$root/$file"
    [[ $file != apt-packages-film.txt ]] || echo "  (only ./impedraw film needs these)"
    [[ $file != apt-packages-tests.txt ]] || echo "  (only ./check needs these)"
    [[ $file != apt-packages-check.txt ]] || echo "  (only ./check --asan, --fuzz, --format and --tidy need these)"
  done

  echo
  echo "Python wheels in $venv"
  while IFS='= ' read -r name _ least _; do
    [[ -z $name || $name == '#'* ]] && continue
    wheel=$(compgen -G "$venv/lib/python3.*/site-packages/${name//-/_}-$least.dist-info" | head -n 1 || true)
    if [[ $wheel ]]; then
      printf '  %-20s %s\n' "$name" "$least"
    else
      printf '  %-20s MISSING, needs %s\n' "$name" "$least"
      missing=$(( missing + 1 ))
    fi
  done <"$root/requirements.txt"

  echo
  echo "Disk"
  for name in "$venv" "$root/build" "$root/runs" "$root/dist"; do printf '  %-6s %s\n' "$(disk "$name")" "$name"; done
  for name in sweep-venv camera-venv image-venv python-tests wheel-tools wheel-test; do
    [[ ! -d $root/build/$name ]] || printf '  %-6s of it %s\n' "$(disk "$root/build/$name")" "$root/build/$name"
  done

  echo
  if (( missing )); then
    echo "$missing missing: any other command, as in ./impedraw draw, installs them"
  else
    echo "Nothing is missing."
  fi
  echo "To remove all: delete the first four folders above. Nothing else was written, apart from the Debian"
  echo "packages (apt-get remove NAME; other software may use them) and cargo's downloads in ~/.cargo."
  (( missing == 0 ))
}
