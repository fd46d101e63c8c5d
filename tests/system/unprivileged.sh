#!/usr/bin/env bash
# Quickstart's commands behind the build, as a user without rights on a host without any network, where not even loopback is
# up: `cairn doctor`, `plan`, `train` and `eval` must work.
#   unprivileged.sh BIN_DIR [--steps N, default 250000] [--success S, default 0.97]
# Root takes the rights of nobody; others do without a change of user. Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
steps=250000
least=0.97
for ((i = 2; i < $#; i += 2)); do
  value=$((i + 1))
  case "${!i}" in
    --steps) steps=${!value} ;;
    --success) least=${!value} ;;
    *)
      echo "unprivileged.sh: unknown argument '${!i}'" >&2
      exit 2
      ;;
  esac
done
experiment=$(realpath "$(dirname "$0")/../..")/deploy/experiments/car_maze.textproto
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

nobody=()
bare=(unshare --user --map-root-user --net)
if ((EUID == 0)); then
  nobody=(setpriv --reuid=65534 --regid=65534 --clear-groups)
  bare=(unshare --net)
  chown 65534:65534 "$work"
fi
"${bare[@]}" "${nobody[@]}" unshare --user --net true 2> /dev/null ||
  { echo "unprivileged.sh: this kernel refuses network namespaces to users"; exit 77; }
"${bare[@]}" "${nobody[@]}" test -x "$bin/cairn" || { echo "unprivileged.sh: nobody may not run $bin/cairn"; exit 77; }
alone() { (cd "$work" && HOME=/nonexistent "${bare[@]}" "${nobody[@]}" "$@"); }

alone bash -c 'ip route get 239.255.76.67; ip -4 address' > "$work/network" 2>&1
check "there is no network" "$(grep -q unreachable "$work/network" && ! grep -q inet "$work/network"; echo $?)" "$(head -n 1 "$work/network")"
alone "$bin/cairn" doctor "$experiment" > "$work/doctor" 2>&1
check "doctor" $? "$(grep '^warn route' "$work/doctor")"
alone "$bin/cairn" plan "$experiment" --svg roadmap.svg > "$work/plan" 2>&1
check "plan" $? "$(tail -n 1 "$work/plan")"
alone "$bin/cairn" train "$experiment" --run-dir run --quiet --set "total_env_steps=$steps" > "$work/train" 2>&1
check "train" $? "$(tail -n 1 "$work/train")"
check "success" "$(awk "BEGIN { print !($(value success_rate "$work/run/summary.json") >= $least) }")" \
  "$(value success_rate "$work/run/summary.json"), lost $(value transitions_lost "$work/run/summary.json")"
alone "$bin/cairn" eval run --trials 20 --svg paths.svg > "$work/eval" 2>&1
check "eval" $? "$(tail -n 1 "$work/eval")"
checks_ended
