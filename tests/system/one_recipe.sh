#!/usr/bin/env bash
# One recipe file, navigate.textproto, for robots and worlds of every size: the paper's car and a quadruped in the 2 m maze, a
# TurtleBot on a floor of 20 m, a quadrotor in the cube. Each must reach the goal from most of 200 test starts.
#   one_recipe.sh BIN_DIR [--seed S] [--steps N] [--success 0.95] [--only "car quadruped turtlebot quadrotor"]
# Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
shift
seed=1
steps=250000
success=0.95
only="car quadruped turtlebot quadrotor"
while (($# > 0)); do
  case "$1" in
    --seed) seed=$2 ;;
    --steps) steps=$2 ;;
    --success) success=$2 ;;
    --only) only=$2 ;;
    *)
      echo "one_recipe.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift 2
done
source_dir=$(realpath "$(dirname "$0")/../..")
recipe=$source_dir/deploy/experiments/navigate.textproto
robots=$source_dir/deploy/robots
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

train() {
  local name=$1
  shift
  [[ " $only " == *" $name "* ]] || return
  "$bin/cairn" train "$recipe" --run-dir "$work/$name" --seed "$seed" --quiet --set total_env_steps="$steps" "$@" \
    >"$work/$name.log" 2>&1
  local status=$? summary=$work/$name/summary.json
  if ((status != 0)); then
    check "$name" 1 "cairn train ended with $status: $(tail -n 3 "$work/$name.log")"
    return
  fi
  local rate
  rate=$(value success_rate "$summary")
  awk -v r="$rate" -v s="$success" 'BEGIN { exit !(r >= s) }'
  check "$name" $? "success $rate of $(value trials "$summary"), SPL $(value spl "$summary"), consumption \
$(value consumption_env_steps "$summary"), $(value wall_s "$summary") s"
}

goal=$(python3 "$source_dir/tests/system/rooms_map.py" "$work/floor" --seed "$seed")
train car --set world.kind=CAR_MAZE --robot "$robots/car.textproto"
train quadruped --set world.kind=CAR_MAZE --robot "$robots/quadruped.textproto"
train turtlebot --map "$work/floor.yaml" --robot "$robots/turtlebot3_burger.textproto" --goal "$goal"
train quadrotor --set world.kind=CUBE_MAZE --robot "$robots/crazyflie.textproto"
checks_ended
