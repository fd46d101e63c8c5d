#!/usr/bin/env bash
# Every kind of vehicle under random commands: nothing that is not finite, no wall crossed (checked after each control step
# against every obstacle), no abort, memory flat.
#   random_commands.sh BIN_DIR [--steps N a kind, default 20000; the whole test is 1e7] [--kinds "KIND …"] [--seed S]
# Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
shift
steps=20000
seed=1
kinds="wheeled_car plane_car holonomic ackermann quadrotor quadruped"
while (($# > 0)); do
  case "$1" in
    --steps) steps=$2 ;;
    --kinds) kinds=$2 ;;
    --seed) seed=$2 ;;
    *)
      echo "random_commands.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift 2
done

for kind in $kinds; do
  seen=$("$bin/cairn-random-commands" "$kind" --steps "$steps" --seed "$seed" 2>&1)
  check "$kind" $? "$seen"
done
checks_ended
