#!/usr/bin/env bash
# A run whose checkpoints cannot be written for a while, by a dying disk (EIO) and by a full one (ENOSPC): training goes
# on, the older checkpoint stays whole, the status says what is wrong, and when it works again a checkpoint is written.
#   checkpoint_faults.sh BIN_DIR
# The full disk needs root (a small tmpfs in a mount namespace of its own); without, that part is left out and said.
# Last line: "N passed, M failed".
set -uo pipefail

bin=$(realpath "$1")
source_dir=$(realpath "$(dirname "$0")/../..")
shim=$(realpath "$bin/../lib/libcairn_fault_shim.so")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0
failed=0

# A checkpoint every 5 ms: a run of one second, as fast machines make it, must get past every call that fails.
train() {
  local run_dir=$1
  shift
  "$bin/cairn" train "$source_dir/deploy/experiments/car_maze.textproto" --run-dir "$run_dir" --actors 1 \
    --set vehicle.kind=PLANE_CAR --set total_env_steps=60000 --set learner.learning_starts=500 \
    --set learner.train_freq=10 --set evaluation.interval_env_steps=20000 --set evaluation.max_steps=60 \
    --set evaluation.test_starts=10 --set learner.checkpoint_interval_s=0.005 "$@"
}

check() {
  local what=$1
  shift
  if "$@" > /dev/null; then
    passed=$((passed + 1))
  else
    echo "FAILED: $what" >&2
    tail -n 20 "$work"/*.log >&2
    failed=$((failed + 1))
  fi
}

weights() { grep -o '"weights_crc32c": *"[0-9a-f]*"' "$1/summary.json"; }
same_weights() { [[ -n $(weights "$1") && $(weights "$1") == "$(weights "$2")" ]]; }

train "$work/whole" > "$work/whole.log" 2>&1
check "an undisturbed run ends" test -s "$work/whole/summary.json"

# EIO from the 20th to the 32nd call of the checkpoint writer.
CAIRN_FAULT=eio:20:32 LD_PRELOAD=$shim train "$work/eio" > "$work/eio.log" 2>&1
check "EIO: the run ends as if nothing had happened" same_weights "$work/eio" "$work/whole"
check "EIO: it is said" grep -q "failed, the older ones stay: .*Input/output error" "$work/eio/log/learner.log"
check "EIO: later checkpoints are written" \
  grep -q "checkpoint at 60000 env steps: [0-9]* ms" "$work/eio/log/learner.log"
check "EIO: no temporary file is left" bash -c "! compgen -G '$work/eio/checkpoints/*.tmp'"

# A disk too small for the replay rows: nothing but checkpoints/ lies on it.
full_disk() {
  mkdir -p "$work/full/checkpoints"
  mount -t tmpfs -o size=1500k tmpfs "$work/full/checkpoints" || return 77
  rm -rf "$work/full.cfg"
  train "$work/full.run" > "$work/full.log" 2>&1 &
  local pid=$!
  # The run directory must be vacant at the start: the small disk slides under checkpoints/ once it is there.
  for ((i = 0; i < 200; i++)); do [[ -d $work/full.run/checkpoints ]] && break; read -rt 0.01 <> <(:) || true; done
  mount --move "$work/full/checkpoints" "$work/full.run/checkpoints" || { wait $pid; return 77; }
  wait $pid
  local status=$?
  ls -la "$work/full.run/checkpoints" >> "$work/full.log"
  ls "$work/full.run/checkpoints" | grep -q '\.tmp$' && return 2
  return $status
}
export -f full_disk train
export work bin source_dir
if ((EUID == 0)) && unshare --mount true 2> /dev/null; then
  unshare --mount --propagation private bash -c full_disk
  status=$?
  if ((status == 77)); then
    echo "no tmpfs here: the full disk is left out"
  else
    check "ENOSPC: the run ends and leaves no temporary file" test "$status" = 0
    check "ENOSPC: training was not touched" same_weights "$work/full.run" "$work/whole"
    check "ENOSPC: it is said in the log" grep -q "No space left on device" "$work/full.run/log/learner.log"
    check "ENOSPC: the status line says so" grep -q "! .*No space left on device" "$work/full.log"
  fi
else
  echo "not root, or no mount namespaces: the full disk is left out"
fi
echo "$passed passed, $failed failed"
((failed == 0))
