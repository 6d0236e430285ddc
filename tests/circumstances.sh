#!/usr/bin/env bash
# The tests where they are not usually run: no law may hold only in somebody's own folder, terminal, language or place.
# `make test-elsewhere` runs all of the circumstances below; names select some, and options of pytest follow a `--`:
#   tests/circumstances.sh private nohup -- -n 0 tests/procedures/run/test_steering.py
set -euo pipefail
cd "$(dirname "$0")/.."
all=(private spaces long nohup elsewhere)
chosen=()
while [ $# -gt 0 ] && [ "$1" != "--" ]; do
  [[ " ${all[*]} " == *" $1 "* ]] || { echo "no circumstance $1 (allowed: ${all[*]})" >&2; exit 2; }
  chosen+=("$1")
  shift
done
[ $# -gt 0 ] && shift
[ ${#chosen[@]} -gt 0 ] || chosen=("${all[@]}")
options=("$@")
[ ${#options[@]} -gt 0 ] || options=(-n auto --maxprocesses 4 --dist worksteal)
python=$PWD/.venv/bin/python
scratch=$(mktemp -d)
chmod 711 "$scratch"
busy=()
# Under `set -e` a kill of nobody would end the trap: with its status, and before the folder is removed.
trap 'kill "${busy[@]}" 2>/dev/null || true; rm -rf "$scratch"' EXIT

run() { # NAME, then what stands before pytest
  local name=$1
  shift
  echo "== $name" >&2
  "$@" "$python" -m pytest -q -p no:cacheprovider "${options[@]}" || failed+=("$name")
}

in_folder() { # a temporary folder of a mode and a name
  local mode=$1 folder=$scratch/$2
  mkdir -p "$folder"
  chmod "$mode" "$folder"
  echo "$folder"
}

failed=()
for circumstance in "${chosen[@]}"; do
  case $circumstance in
    # Nobody else may enter: as root, a server's own user cannot. In the C locale, and a narrow terminal.
    private) run private env TMPDIR="$(in_folder 700 p)" LC_ALL=C COLUMNS=40 ;;
    # Another time zone, whose offset is no whole hour, and a wide terminal.
    spaces) run spaces env TMPDIR="$(in_folder 755 'Prüfstand № 7, a b')" TZ=Asia/Kathmandu COLUMNS=200 ;;
    # Long enough that a line with a path wraps in any terminal; sockets in such a folder are refused by the system.
    long) run long env TMPDIR="$(in_folder 755 "$(printf 'd%.0s' {1..90})")" LC_ALL=de_DE.UTF-8 TZ=America/St_Johns ;;
    # What `nohup` and a shell's background ignore, children are born ignoring.
    nohup) run nohup env -u TMPDIR bash -c 'trap "" HUP INT QUIT; exec "$@" < /dev/null' nohup ;;
    # Another user than root, with no home to write to and all processors taken by somebody else.
    elsewhere)
      for _ in $(seq "$(nproc)"); do
        (while :; do :; done) &
        busy+=($!)
      done
      if [ "$(id -u)" -eq 0 ]; then
        other=(setpriv --reuid nobody --regid nogroup --clear-groups)
        "${other[@]}" env "$python" -c '' || { echo "another user cannot run $python: busy only" >&2; other=(); }
        run elsewhere "${other[@]}" env HOME=/nonexistent TMPDIR="$(in_folder 777 other)" PYTHONDONTWRITEBYTECODE=1
      else
        run elsewhere
      fi
      kill "${busy[@]}"
      busy=()
      ;;
  esac
done
if [ ${#failed[@]} -gt 0 ]; then
  echo "failed: ${failed[*]}" >&2
  exit 1
fi
