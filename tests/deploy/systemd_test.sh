#!/usr/bin/env bash
# Has systemd itself check the units of deploy/systemd, with the programs where the build has put them.
#   systemd_test.sh BIN_DIR
set -euo pipefail
command -v systemd-analyze > /dev/null || { echo "systemd_test.sh: no systemd-analyze"; exit 77; }
bin=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for unit in "$(dirname "$0")"/../../deploy/systemd/*.service; do
  sed "s#/opt/cairn/bin#$bin#" "$unit" > "$work/$(basename "$unit")"
done
# Warnings go to stderr with exit status 0.
said=$(systemd-analyze verify "$work"/*.service 2>&1) || { echo "$said"; exit 1; }
if grep -q "$work" <<< "$said"; then
  echo "$said"
  exit 1
fi
# Each variable that a unit uses is one of cairn.env's.
for variable in $(grep -oh '\${CAIRN_[A-Z_]*}' "$work"/*.service | tr -d '${}' | sort -u); do
  grep -q "^$variable=" "$(dirname "$0")/../../deploy/systemd/cairn.env" || { echo "cairn.env has no $variable"; exit 1; }
done
echo "$(ls "$work"/*.service | wc -l) units are sound"
