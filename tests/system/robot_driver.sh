#!/usr/bin/env bash
# Builds the driver of docs/robots.md as a user does, from the page and the installed message types, and lets `cairn drive` drive it
# to the goal of a small run: without any code of Cairn in it.
#   robot_driver.sh BIN_DIR
# Needs lcm-gen, a compiler and network namespaces. Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
source_dir=$(realpath "$(dirname "$0")/../..")
if [[ -z ${CAIRN_ROBOT_INSIDE-} ]]; then
  command -v lcm-gen > /dev/null || { echo "robot_driver.sh: no lcm-gen (Debian: liblcm-bin)"; exit 77; }
  space=(unshare --net --pid --fork --kill-child --mount-proc)
  ((EUID == 0)) || space+=(--user --map-root-user)
  "${space[@]}" true 2> /dev/null || { echo "robot_driver.sh: no namespaces here"; exit 77; }
  CAIRN_ROBOT_INSIDE=1 exec "${space[@]}" bash "$0" "$@"
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
ip link set lo up
ip route add 224.0.0.0/4 dev lo

cmake --install "$bin/.." --prefix "$work/cairn" > "$work/install.log" 2>&1
check "cmake --install" $? "$(find "$work/cairn/share/cairn/lcmtypes" -name '*.lcm' | wc -l) message types"
awk '/^```cpp/ { code = 1; next } /^```/ { code = 0 } code' "$source_dir/docs/robots.md" > "$work/driver.cc"
(cd "$work" && lcm-gen -x "$work"/cairn/share/cairn/lcmtypes/*.lcm && g++ -std=c++17 -Wall -I. driver.cc -llcm -o driver) > "$work/build.log" 2>&1
check "the driver of the page builds" $? "$(wc -l < "$work/driver.cc") lines"

# A maze without walls in it: this driver is blind.
"$bin/cairn" train "$source_dir/deploy/experiments/car_maze.textproto" --run-dir "$work/run" --quiet --actors 1 \
  --set vehicle.kind=PLANE_CAR --set 'world={kind: BOXES bounds {max {x: 2 y: 2}} start {max {x: 2 y: 2}} goal {min {x: 1.5 y: 1.5} max {x: 1.8 y: 1.8}}}' \
  --set total_env_steps=30000 --set learner.learning_starts=500 > "$work/train.log" 2>&1
check "the run" $? "success $(value success_rate "$work/run/summary.json")"
timeout 90 "$bin/cairn" drive "$work/run" > "$work/drive.log" 2>&1 &
drive=$!
timeout 90 "$work/driver" 0.4 0.4 2 > "$work/driver.log" 2>&1
check "the robot is told that it has arrived" $? "$(tail -n 1 "$work/driver.log")"
wait $drive
check "cairn drive" $? "$(tail -n 1 "$work/drive.log")"
((failed == 0)) || tail -n 20 "$work"/*.log >&2
checks_ended
