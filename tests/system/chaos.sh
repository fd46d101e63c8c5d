#!/usr/bin/env bash
# Trains with many actors while every two seconds one of them is killed, stopped for three seconds or told to end, and once
# the learner and once the planner is killed. The run must end as successful, with every transition in replay exactly once
# (compared by content), with no more rolled back than one checkpoint interval, every victim back within ten seconds, and
# no process left over.
#   chaos.sh BIN_DIR [--seconds N, default 300] [--actors N, default 8] [--schedule ASYNC|LOCKSTEP] [--seed S]
# Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
shift
seconds=300
actors=8
schedule=ASYNC
RANDOM=1
while (($# > 0)); do
  case "$1" in
    --seconds) seconds=$2 ;;
    --actors) actors=$2 ;;
    --schedule) schedule=$2 ;;
    --seed) RANDOM=$2 ;;
    *)
      echo "chaos.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift 2
done
source_dir=$(realpath "$(dirname "$0")/../..")
work=$(mktemp -d)
launcher=
cleanup() {
  if [[ -n $launcher ]]; then kill -KILL "$launcher" 2> /dev/null; fi
  rm -rf "$work"
}
trap cleanup EXIT
trap "exit 1" INT TERM

interval=5 # seconds between checkpoints
patience=10
train=("$bin/cairn" train "$source_dir/deploy/experiments/car_maze_async.textproto" --actors "$actors"
  --max-restarts 100000 --set "schedule=$schedule" --set "learner.checkpoint_interval_s=$interval"
  --set evaluation.interval_env_steps=20000)
made() { cat "$work"/audit/"$1"* 2> /dev/null | wc -c; }
children() { pgrep -P "$launcher" -f "$1"; }

"${train[@]}" --run-dir "$work/calibration" --set total_env_steps=30000 --quiet > "$work/calibration.log" 2>&1 ||
  { cat "$work/calibration.log" >&2; echo "0 passed, 1 failed"; exit 1; }
rate=$(value env_steps_per_s "$work/calibration/summary.json" | cut -d. -f1)
total=$((rate * seconds))
echo "$actors actors, $schedule, $rate env steps/s undisturbed: $total env steps"

mkdir "$work/audit"
CAIRN_AUDIT_DIR=$work/audit "${train[@]}" --run-dir "$work/run" --set "total_env_steps=$total" > "$work/run.log" 2>&1 &
launcher=$!
declare -A since=() mark=() resume=() # of victims that are not back: when, bytes made until then, when to go on
events=0
slowest=0
late=""
start=$(now)

begin() { # name of its audit files
  since[$1]=$(now)
  mark[$1]=$(made "$1")
}

look_after() {
  local name t
  for name in "${!resume[@]}"; do
    t=$(now)
    ((t < ${resume[$name]%% *})) && continue
    kill -CONT "${resume[$name]##* }" 2> /dev/null
    unset "resume[$name]"
    begin "$name"
  done
  for name in "${!since[@]}"; do
    t=$(($(now) - ${since[$name]}))
    if (($(made "$name") > ${mark[$name]})); then
      ((t > slowest)) && slowest=$t
      unset "since[$name]"
    elif ((t > patience * 1000)); then
      late+=" $name"
      unset "since[$name]"
    fi
  done
}

disturb() {
  local id=$((RANDOM % actors)) name pid
  name=$(printf 'actor-%04d' "$id")
  [[ -n ${since[$name]:-} || -n ${resume[$name]:-} ]] && return
  pid=$(children "cairn-actor .*--actor-id $id( |\$)") || return
  events=$((events + 1))
  case $((RANDOM % 3)) in
    0) kill -KILL "$pid" && begin "$name" ;;
    1) kill -STOP "$pid" && resume[$name]="$(($(now) + 3000)) $pid" ;;
    2) kill -TERM "$pid" && begin "$name" ;;
  esac
}

learner_killed=0
planner_killed=0
next=$((start + 5000)) # let everybody join first
while kill -0 "$launcher" 2> /dev/null; do
  sleep 0.1 # the pace of the disturbances, not a wait for something
  look_after
  elapsed=$(($(now) - start))
  if ((elapsed > seconds * 1000 && ${#resume[@]} == 0)); then break; fi
  if ((learner_killed == 0 && elapsed > seconds * 400)); then
    learner_killed=1
    before=$(tail -n 1 "$work/run/checkpoints/progress" | cut -d' ' -f1)
    kill -KILL "$(children cairn-learner)" && begin learner-02
  fi
  if ((planner_killed == 0 && elapsed > seconds * 600)); then
    planner_killed=1
    kill -KILL "$(children cairn-planner)"
  fi
  if (($(now) >= next)); then
    next=$((next + 2000))
    disturb
  fi
done
wait "$launcher"
status=$?
children_left=$(pgrep -f -- "--run-dir $work/run( |\$)" | wc -l)
launcher=
summary=$work/run/summary.json
log=$work/run/log/learner.log

check "the run ends" "$status" "exit $status; $(tail -n 1 "$work/run.log")"
success=$(value success_rate "$summary")
check "as successful" "$(awk "BEGIN { print !($success >= 0.9) }")" "success $success"
check "disturbances" "$((events < seconds / 4))" "$events"
check "nothing lost or doubled, as the learner counts" \
  "$(($(value transitions_lost "$summary") != 0 || $(value transitions_duplicate "$summary") != 0))" \
  "lost $(value transitions_lost "$summary"), duplicate $(value transitions_duplicate "$summary")"
check "every victim back within $patience s" "$([[ -z $late ]]; echo $?)" "slowest $slowest ms${late:+, late:$late}"
check "the planner came back" "$([[ $(grep -c 'serving roadmap' "$work/run/log/planner.log") == 2 ]]; echo $?)" \
  "$(grep -c 'serving roadmap' "$work/run/log/planner.log") times ready to serve"
resumed=$(grep -o 'resumed at [0-9]*' "$log" | cut -d' ' -f3)
check "rolled back at most one interval" "$((before - ${resumed:-0} > rate * interval * 3 / 2))" \
  "learner killed after $before, went on at ${resumed:-0}; transitions_rolled_back $(value transitions_rolled_back "$summary")"
check "no process left" "$children_left" "$children_left left"

# Replay holds the first learner's transitions up to the checkpoint, then the second one's.
head -n "${resumed:-0}" "$work/audit/learner-01.audit" > "$work/replay"
cat "$work/audit/learner-02.audit" >> "$work/replay"
sort "$work/replay" > "$work/replay.sorted"
sort "$work"/audit/actor-*.audit > "$work/made.sorted"
lines=$(wc -l < "$work/replay.sorted")
check "replay has every transition of the run" "$((lines != total))" "$lines of $total"
doubled=$(cut -d' ' -f1-3 "$work/replay.sorted" | sort | uniq -d | wc -l)
check "none twice, by content" "$doubled" "$doubled doubled"
foreign=$(comm -23 "$work/replay.sorted" <(uniq "$work/made.sorted") | wc -l)
check "none that no actor made, by content" "$foreign" "$foreign foreign"
# Steps of an episode without a hole: what is missing in the middle was lost on the way.
holes=$(awk '{ key = $1 " " $2; if (!(key in last) || $3 > last[key]) last[key] = $3; count[key]++ }
  END { holes = 0; for (key in last) if (count[key] != last[key] + 1) holes++; print holes }' "$work/replay.sorted")
check "no episode with a hole, by content" "$holes" "$holes episodes"

((failed == 0)) || tail -n 30 "$work/run.log" "$log" >&2
checks_ended
