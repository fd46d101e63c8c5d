#!/usr/bin/env bash
# Three hosts on one machine: network namespaces behind a bridge, ttl 1, messages of at most 1400 bytes, keyed frames, and
# packets lost at random on every host's way in. Learner and planner on one, two actors on each of the others. Whatever the
# loss, replay must hold every transition exactly once (compared by content), the weights must be those of a run on one host,
# the car must learn its maze, and no more may be sent again than 1.3 times what was lost. Without loss the stream's goodput is held against plain LCM.
#   multihost.sh BIN_DIR [--loss "0 1 5", in percent] [--steps N, default 250000] [--success S, default 0.97]
#                [--vehicle KIND] [--goodput RUNS, default 5; 0: none]
# Needs root, network namespaces and nft. Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
shift
losses="0 1 5"
steps=250000
least=0.97
vehicle=WHEELED_CAR
goodput=5
while (($# > 0)); do
  case "$1" in
    --loss) losses=$2 ;;
    --steps) steps=$2 ;;
    --success) least=$2 ;;
    --vehicle) vehicle=$2 ;;
    --goodput) goodput=$2 ;;
    *)
      echo "multihost.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift 2
done
source_dir=$(realpath "$(dirname "$0")/../..")
work=$(mktemp -d)
name=cairn$$
pids=()
cleanup() {
  for pid in "${pids[@]}"; do kill -KILL "$pid" 2> /dev/null; done
  wait 2> /dev/null
  for i in 0 1 2; do
    ip netns pids "$name-$i" 2> /dev/null | xargs -r kill -KILL 2> /dev/null
    ip netns del "$name-$i" 2> /dev/null
  done
  ip netns del "$name-s" 2> /dev/null
  rm -rf "$work"
}
trap cleanup EXIT
trap "exit 1" INT TERM
on() { # host, command …
  local host=$name-$1
  shift
  ip netns exec "$host" "$@"
}

command -v nft > /dev/null || { echo "multihost.sh: nft is not installed"; exit 77; }
# The switch is a namespace of its own, so that nothing touches this machine's network.
ip netns add "$name-s" && ip netns exec "$name-s" ip link add name sw type bridge mcast_snooping 0 &&
  ip netns exec "$name-s" ip link set sw up || { echo "multihost.sh: no network namespaces here"; exit 77; }
for i in 0 1 2; do
  ip netns add "$name-$i"
  ip link add "v$i" netns "$name-$i" type veth peer name "p$i" netns "$name-s"
  ip netns exec "$name-s" ip link set "p$i" master sw up
  on $i ip link set lo up
  on $i ip link set "v$i" up
  on $i ip addr add "10.99.0.$((i + 1))/24" dev "v$i"
  on $i ip route add 224.0.0.0/4 dev "v$i"
done

lose() { # percent
  local i
  for i in 0 1 2; do
    on $i nft flush ruleset
    (($1 == 0)) && continue
    on $i nft add table netdev l
    on $i nft add chain netdev l i "{ type filter hook ingress device v$i priority 0; }"
    on $i nft add rule netdev l i ip protocol udp numgen random mod 1000 "<" $(($1 * 10)) counter drop
  done
}

# The file as the learner's host has it, copied to the others with the key.
file=$work/experiment.textproto
sed -e "s/kind: WHEELED_CAR.*/kind: $vehicle/" -e "s/^total_env_steps: .*/total_env_steps: $steps/" \
  "$source_dir/deploy/experiments/car_maze.textproto" > "$file"
on 0 "$bin/cairn" train "$file" --run-dir "$work/one" --quiet > "$work/one.log" 2>&1
expected=$(value weights_crc32c "$work/one/summary.json")

port=7800
run() { # percent
  local loss=$1 run_dir=$work/run$1 audit=$work/audit$1 id status
  mkdir -p "$run_dir" "$audit"
  port=$((port + 10))
  (umask 077 && od -An -N32 -tx1 /dev/urandom | tr -d ' \n' > "$work/key" && echo >> "$work/key")
  local common=("$file" --lcm-url "udpm://239.255.76.67:$port?ttl=1" --run-id "$RANDOM$RANDOM" --key "$work/key")
  lose "$loss"
  pids=()
  # Not by way of `on`: the process's own number is wanted.
  ip netns exec "$name-0" "$bin/cairn" planner "${common[@]}" > "$run_dir/planner.log" 2>&1 &
  pids+=($!)
  for id in 0 1 2 3; do
    CAIRN_AUDIT_DIR=$audit ip netns exec "$name-$((1 + id / 2))" "$bin/cairn" actor "${common[@]}" --actor-id "$id" \
      > "$run_dir/actor-$id.log" 2>&1 &
    pids+=($!)
  done
  CAIRN_AUDIT_DIR=$audit timeout 900 ip netns exec "$name-0" "$bin/cairn" learner "${common[@]}" --run-dir "$run_dir" \
    --actors 4 > "$run_dir/learner.log" 2>&1
  status=$?
  local summary=$run_dir/summary.json
  check "$loss %: the run ends" "$status" "exit $status, $(value wall_s "$summary") s"
  check "$loss %: success" "$(awk "BEGIN { print !($(value success_rate "$summary") >= $least) }")" \
    "$(value success_rate "$summary")"
  local weights
  weights=$(value weights_crc32c "$summary")
  check "$loss %: the weights of a run on one host" "$([[ -n $expected && $weights == "$expected" ]]; echo $?)" "$weights"
  local replay made
  replay=$(sort "$audit"/learner-*.audit | md5sum)
  made=$(sort "$audit"/actor-*.audit | md5sum)
  check "$loss %: replay is what the actors made, by content" "$([[ $replay == "$made" ]]; echo $?)" \
    "$(cat "$audit"/learner-*.audit | wc -l) transitions, $(sort "$audit"/learner-*.audit | uniq -d | wc -l) twice"
  local sent resent
  sent=$(value messages_sent "$summary")
  resent=$(value messages_resent "$summary")
  # Three standard deviations of what chance may lose beyond the rate, and one message.
  check "$loss %: resent" "$(awk "BEGIN { p = $loss / 100; m = 1.3 * p * $sent; print !($resent <= m + 3 * sqrt(m) + 1) }")" \
    "$resent of $sent ($(awk "BEGIN { printf \"%.2f\", 100 * $resent / $sent }") %)"
  kill "${pids[@]}" 2> /dev/null
  wait "${pids[@]}" 2> /dev/null
  pids=()
  local left
  left=$(for i in 0 1 2; do ip netns pids "$name-$i"; done | wc -l)
  check "$loss %: no process left" "$left" "$left"
}

for loss in $losses; do run "$loss"; done

if ((goodput > 0)); then
  lose 0
  ratios=$(for ((i = 0; i < goodput; i++)); do
    CAIRN_BENCH_HOSTS="$name-1 $name-2" on 0 "$bin/cairn-bench-ingest" --benchmark_filter=1400B 2> /dev/null |
      grep -o 'ratio_to_raw=[0-9.]*' | cut -d= -f2
  done | sort -n)
  median=$(echo "$ratios" | sed -n "$(((goodput + 1) / 2))p")
  check "goodput beside plain LCM" "$(awk "BEGIN { print !(${median:-0} >= 0.85) }")" "median ${median:-none} of $(echo $ratios)"
fi
checks_ended
