#!/usr/bin/env bash
# From a fresh clone to a trained car: installs, builds, draws the roadmap, trains the paper's maze, tests the policy.
#   deploy/quickstart.sh [arguments of `cairn train`, e.g. --seed 2 --actors 1]
# Each run gets a directory of its own, runs/quickstart-1, -2, …
set -euo pipefail
cd "$(dirname "$0")/.."

experiment=deploy/experiments/car_maze.textproto
cairn=build/release/bin/cairn

step() { printf '\n== %s\n' "$*"; }

# Prints one value of the run's summary.
summary() { grep -o "\"$1\": *[^,}]*" "$run_dir/summary.json" | head -n 1 | sed 's/^[^:]*: *//'; }

step "Installing packages"
deploy/install_dependencies.sh

step "Building (build/release)"
options=(-DCAIRN_BUILD_TESTS=OFF)
if command -v ccache > /dev/null; then
  options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
cmake --preset release "${options[@]}"
cmake --build --preset release

number=1
while [[ -e runs/quickstart-$number ]]; do number=$((number + 1)); done
run_dir=runs/quickstart-$number
mkdir -p "$run_dir"

step "Planning"
"$cairn" plan "$experiment" --svg "$run_dir/roadmap.svg"

step "Training (watch it from another terminal: $cairn spy $run_dir)"
"$cairn" train "$experiment" --run-dir "$run_dir" "$@"

step "Testing the policy"
"$cairn" eval "$run_dir" --svg "$run_dir/paths.svg"

step "Done"
if [[ $(summary consumption_env_steps) =~ ^[0-9]+$ ]]; then
  LC_ALL=C printf 'consumption:  %d env steps, %.1f s after launch\n' \
    "$(summary consumption_env_steps)" "$(summary consumption_wall_s)"
else
  echo "consumption:  never"
fi
echo "success rate: $(summary success_rate) of $(summary trials) test starts"
echo "roadmap:      $run_dir/roadmap.svg"
echo "paths:        $run_dir/paths.svg"
