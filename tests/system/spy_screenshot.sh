#!/usr/bin/env bash
# Opens `cairn spy` on a running training under a window system without a screen, an actor's telemetry decoded and the
# plug-in's plots of the run, and takes a picture. Fails when lcm-spy does not start, does not find all our types and the
# plug-in, opens no decoded view or draws no curves.
#   spy_screenshot.sh BIN_DIR OUTPUT.png [SECONDS for the curves to show something, default 10]
set -euo pipefail

bin=$(realpath "$1")
output=$2
source_dir=$(realpath "$(dirname "$0")/../..")
work=$(mktemp -d)
pids=()

# Ends our own processes, newest first, and waits for them.
finish() {
  for ((i = ${#pids[@]} - 1; i >= 0; i--)); do
    kill "${pids[i]}" 2> /dev/null && wait "${pids[i]}" 2> /dev/null || true
  done
  rm -rf "$work"
}
trap finish EXIT

fail() {
  echo "spy_screenshot.sh: $1" >&2
  tail -n 20 "$work"/*.log >&2 || true
  exit 1
}

# Waits up to 60 s for a command to succeed.
await() {
  local what=$1 end=$((SECONDS + 60))
  shift
  while ((SECONDS < end)); do
    "$@" > /dev/null 2>&1 && return
    sleep 0.2
  done
  fail "waited 60 s for $what"
}

for tool in Xvfb xdotool import; do
  command -v "$tool" > /dev/null || fail "no $tool; deploy/install_dependencies.sh --test installs it"
done

window() { xdotool search --onlyvisible --name "^$1\$" | head -n 1; }
has_window() { [[ -n $(window "$1") ]]; }

# Double-clicks down the table of channels (rows are 16 pixels high) until a window of this name opens; views of other
# channels are moved out of the way.
open_window() {
  for ((row = 0; row < 5; row++)); do
    xdotool mousemove --window "$spy_window" 80 $((28 + 16 * row)) click --repeat 2 --delay 60 1
    for ((i = 0; i < 10; i++)); do
      has_window "$1" && return
      sleep 0.1
    done
    for other in $(xdotool search --onlyvisible --name '^Cairn run$|^CAIRN_' || true); do
      xdotool windowmove "$other" 0 2000
    done
  done
  return 1
}

# Takes the picture; true when both curves of the plot of successes are on it, in their colours.
curves_drawn() {
  import -window root "$output"
  for color in '#1f77b4' '#d62728'; do
    local pixels
    pixels=$(convert "$output" -fill black +opaque "$color" -fill white -opaque "$color" -format '%[fx:mean*w*h]' info:)
    ((${pixels%.*} > 100)) || return 1
  done
}

Xvfb -displayfd 3 -screen 0 900x790x24 -nolisten tcp 3> "$work/display" 2> "$work/xvfb.log" &
pids+=($!)
await "Xvfb" test -s "$work/display"
DISPLAY=:$(< "$work/display")
export DISPLAY

"$bin/cairn" train "$source_dir/deploy/experiments/car_maze.textproto" --run-dir "$work/run" --actors 2 --quiet \
  --set total_env_steps=1000000 > "$work/train.log" 2>&1 &
pids+=($!)
await "the run" test -s "$work/run/run.json"

"$bin/cairn" spy "$work/run" --plane telemetry > "$work/spy.log" 2>&1 &
pids+=($!)
await "lcm-spy's window" has_window "LCM Spy"
spy_window=$(window "LCM Spy")
types=$(find "$source_dir/lcmtypes" -name '*.lcm' | wc -l)
await "lcm-spy to find our $types types" grep -q "Found $types LCM types" "$work/spy.log"
await "lcm-spy to find the plug-in" grep -q "RunPlugin" "$work/spy.log"

xdotool windowsize "$spy_window" 900 150
await "an actor's decoded view" open_window CAIRN_ACTOR_0000
xdotool windowmove "$(window CAIRN_ACTOR_0000)" 0 2000
await "the plug-in's plots" open_window "Cairn run"
xdotool windowmove "$(window "Cairn run")" 0 150 windowsize "$(window "Cairn run")" 900 640
xdotool windowraise "$spy_window" windowsize "$spy_window" 899 150 windowraise "$(window "Cairn run")"
sleep "${3-10}" # for a picture with something in it; what is judged is waited for
await "curves on the picture" curves_drawn
echo "wrote $output"
