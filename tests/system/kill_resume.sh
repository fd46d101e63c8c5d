#!/usr/bin/env bash
# Kills the learner with SIGKILL again and again, at random moments and at every file system call of its checkpoint writer,
# and resumes: every resume must work, roll back no more than one checkpoint interval and say how much, leave no temporary
# file, and end with the weights of a run that was never interrupted.
#   kill_resume.sh BIN_DIR [--trials N, default 20] [--seed S]
# Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
shift
trials=20
RANDOM=1
while (($# > 0)); do
  case "$1" in
    --trials) trials=$2 ;;
    --seed) RANDOM=$2 ;;
    *)
      echo "kill_resume.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift 2
done
source_dir=$(realpath "$(dirname "$0")/../..")
shim=$(realpath "$bin/../lib/libcairn_fault_shim.so")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
points=0 # file system calls at which a learner was killed
kills=0

# A small run with a checkpoint every 0.1 s.
steps=12000
train() {
  local run_dir=$1
  shift
  "$bin/cairn" train "$source_dir/deploy/experiments/car_maze.textproto" --run-dir "$run_dir" --quiet --actors 1 --max-restarts 0 \
    --set vehicle.kind=PLANE_CAR --set total_env_steps=$steps --set learner.learning_starts=500 \
    --set learner.train_freq=10 --set evaluation.interval_env_steps=4000 --set evaluation.max_steps=60 \
    --set evaluation.test_starts=10 --set lockstep.round_steps=10 --set learner.checkpoint_interval_s=0.1 "$@"
}


train "$work/whole" > "$work/whole.log" 2>&1 || { cat "$work/whole.log" >&2; echo "0 passed, 1 failed"; exit 1; }
expected=$(value weights_crc32c "$work/whole/summary.json")
started=$(now)
CAIRN_FAULT="count:$work/calls" LD_PRELOAD="$shim" train "$work/counted" > "$work/counted.log" 2>&1
duration=$(($(now) - started))
calls=$(sort -n "$work/calls" 2> /dev/null | tail -n 1)
calls=${calls:-0}
echo "an uninterrupted run: weights $expected, $duration ms, $calls file system calls of the checkpoint writer"

fail() {
  echo "trial $1: $2" >&2
  tail -n 5 "$work/run.log" "$work/run/log/learner.log" >&2 2> /dev/null
  failed=$((failed + 1))
}

# One trial: a run that is killed, resumed, killed again …, until it ends.
trial() {
  local number=$1 attempt status before rolled
  rm -rf "$work/run"
  for ((attempt = 0; attempt < 12; attempt++)); do
    local fault=""
    # Odd trials die at a file system call, even ones at a random moment; the last attempts are left alone.
    if ((attempt < 3 && number % 2 == 1 && calls > 0)); then 
      fault="kill:$((1 + points * 37 % calls))"
      points=$((points + 1))
    fi
    if [[ -e $work/run/experiment.textproto ]]; then
      if ! compgen -G "$work/run/checkpoints/checkpoint-*.ckpt" > /dev/null; then
        rm -rf "$work/run" # killed before the first checkpoint: begin anew
      fi
    fi
    before=0
    if [[ -e $work/run/checkpoints/progress ]]; then before=$(cut -d' ' -f1 < "$work/run/checkpoints/progress"); fi
    if [[ -e $work/run/experiment.textproto ]]; then
      CAIRN_FAULT=$fault LD_PRELOAD=$shim "$bin/cairn" train --resume "$work/run" --max-restarts 0 --quiet > "$work/run.log" 2>&1 &
    else
      CAIRN_FAULT=$fault LD_PRELOAD=$shim train "$work/run" > "$work/run.log" 2>&1 &
    fi
    local pid=$!
    if ((attempt < 3 && number % 2 == 0)); then
      local pause=$((RANDOM % (duration + 1)))
      # Waits for the end of the run or for the moment to kill, whichever comes first.
      timeout "$((pause / 1000)).$(printf '%03d' $((pause % 1000)))" tail --pid=$pid -f /dev/null
      pkill -KILL -f "cairn-learner .*--run-dir $work/run " 2> /dev/null
    fi
    wait $pid
    status=$?
    if [[ -e $work/run/log/learner.log ]]; then
      rolled=$(grep -o '[0-9]* transitions rolled back' "$work/run/log/learner.log" | tail -n 1 | cut -d' ' -f1)
      if [[ -n $rolled ]] && ((rolled > before)); then fail "$number" "rolled back $rolled of $before"; return; fi
    fi
    # A kill that comes after the summary has nothing left to interrupt.
    if [[ $(value completed "$work/run/summary.json" 2> /dev/null) == true ]]; then status=0; fi
    ((status == 0)) && break
    kills=$((kills + 1))
  done
  local summary=$work/run/summary.json
  if ((status != 0)); then fail "$number" "did not come to an end: exit $status"; return; fi
  if [[ $(value weights_crc32c "$summary") != "$expected" ]]; then
    fail "$number" "weights $(value weights_crc32c "$summary") instead of $expected"
  elif [[ $(value transitions_lost "$summary") != 0 ]]; then
    fail "$number" "transitions were lost"
  elif compgen -G "$work/run/checkpoints/*.tmp" > /dev/null; then
    fail "$number" "temporary files are left: $(ls "$work/run/checkpoints")"
  elif (($(ls "$work"/run/checkpoints/checkpoint-* | wc -l) > 2)); then
    fail "$number" "checkpoints pile up: $(ls "$work/run/checkpoints")"
  else
    passed=$((passed + 1))
  fi
}

for ((t = 1; t <= trials; t++)); do trial "$t"; done
echo "$kills learners killed, $points of them at a file system call"
checks_ended
