#!/usr/bin/env bash
# A Slurm cluster of three nodes on one machine, in namespaces of its own: deploy/slurm/cairn.sbatch trains over all three,
# loses an actor, is told that its time limit is near, queues again, goes on from its checkpoint and learns the maze. Then an
# array of two seeds.
#   slurm.sh BIN_DIR [--steps N, default 250000] [--success S, default 0.97]
# Needs root, namespaces, Slurm and munge (Debian's slurm-wlm and munge). Last line: "N passed, M failed".
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
      echo "slurm.sh: unknown argument '${!i}'" >&2
      exit 2
      ;;
  esac
done

if [[ -z ${CAIRN_SLURM_INSIDE-} ]]; then
  for tool in slurmctld slurmd sbatch munged; do
    PATH=$PATH:/usr/sbin command -v $tool > /dev/null || { echo "slurm.sh: no $tool (Debian: slurm-wlm, munge)"; exit 77; }
  done
  # Daemons end with the process namespace, whatever happens; nothing touches the machine's network.
  unshare --net --mount --pid --fork true 2> /dev/null || { echo "slurm.sh: needs root and namespaces"; exit 77; }
  CAIRN_SLURM_INSIDE=1 exec unshare --net --mount --pid --fork --kill-child --mount-proc bash "$0" "$@"
fi

source_dir=$(realpath "$(dirname "$0")/../..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
export PATH=$bin:$PATH:/usr/sbin
ip link set lo up
ip route add 224.0.0.0/4 dev lo
# Slurm looks addresses up as on a host that has another interface than loopback.
ip link add e0 type veth peer name e1
ip address add 10.97.0.1/24 dev e0
ip link set e0 up
ip link set e1 up
echo "127.0.0.1 localhost $(hostname) $(hostname -s)" > "$work/hosts"
mount --bind "$work/hosts" /etc/hosts

await() { # seconds, what, command …
  local patience=$1 what=$2 end=$((SECONDS + $1))
  shift 2
  until "$@" > /dev/null 2>&1; do
    if ((SECONDS >= end)); then
      echo "FAILED  waited $patience s for $what"
      tail -n 5 "$work"/*.log "$work"/*.out >&2 2> /dev/null
      exit 1
    fi
    sleep 0.2
  done
}

mkdir -p "$work/state" "$work/etc" "$work/run"
(umask 077; head -c 1024 /dev/urandom > "$work/munge.key")
munged --force --foreground --socket="$work/munge.sock" --key-file="$work/munge.key" --pid-file="$work/munge.pid" \
  --log-file="$work/munge.log" --seed-file="$work/munge.seed" > /dev/null 2>&1 &
await 10 munged test -S "$work/munge.sock"
cat > "$work/etc/slurm.conf" << EOF
ClusterName=cairn
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket=$work/munge.sock,cred_expire=5
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,sched_min_interval=1000
KillWait=10
NodeName=n[1-3] NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=[16001-16003] CPUs=2
PartitionName=lab Nodes=ALL Default=YES MaxTime=INFINITE State=UP
EOF
echo "CgroupPlugin=cgroup/v1" > "$work/etc/cgroup.conf"
export SLURM_CONF=$work/etc/slurm.conf
slurmctld -D > "$work/slurmctld.out" 2>&1 &
for node in n1 n2 n3; do slurmd -D -N $node > "$work/slurmd-$node.out" 2>&1 & done
all_idle() { [[ $(sinfo -h -o %D -t idle) == 3 ]]; }
await 60 "three idle nodes" all_idle
echo "Slurm $(sinfo --version | cut -d' ' -f2), three nodes"

small=(--set vehicle.kind=PLANE_CAR --set learner.learning_starts=500 --set evaluation.test_starts=5
  --set evaluation.max_steps=20)
submit() { sbatch --parsable --chdir="$work" --output="$work/%x-%A_%a.out" "$@"; }
state() { scontrol show job "$1" | grep -o 'JobState=[A-Z]*' | head -n 1; }
ended() { [[ $(state "$1") =~ COMPLETED|FAILED|TIMEOUT|CANCELLED|NODE_FAIL ]]; }
steps_done() { tail -n 1 "$work/big/checkpoints/progress" 2> /dev/null | cut -d' ' -f1; }
passed_steps() { (($(steps_done || echo 0) >= $1)); }
# Training stands still while something is waited for that a fast machine would otherwise not reach before the run's end.
learner() { pgrep -f "cairn-learner .*--run-dir $work/$1 "; }
hold() { kill -STOP "$(learner "$1")"; }
release() { kill -CONT "$(learner "$1")"; }
processes() { [[ $(pgrep -fc "$1") == "$2" ]]; }

experiment=$source_dir/deploy/experiments/car_maze.textproto
job=$(CAIRN_ACTORS=1 submit --nodes=3 --time=30 "$source_dir/deploy/slurm/cairn.sbatch" "$experiment" "$work/big" --actors 1 \
  --set "total_env_steps=$steps" --set learner.checkpoint_interval_s=2)
out=$work/cairn-${job}_4294967294.out
await 120 "a fifth of the run" passed_steps $((steps / 5))
hold big
await 60 "the other nodes' actors" processes 'cairn-actor .*--actor-id 100[01] ' 2
check "actors of all nodes take part" "$([[ $(pgrep -fc 'cairn-actor .*--actor-id 100[01] ') == 2 ]]; echo $?)" \
  "$(pgrep -fa 'cairn-actor ' | grep -o -- '--actor-id [0-9]*' | tr '\n' ' ')"
victim=$(pgrep -f 'cairn-actor .*--actor-id 1001 ')
kill -KILL "$victim"
await 60 "the actor that was killed" pgrep -f 'cairn-actor .*--actor-id 1001 --generation 1'
release big
before=$(steps_done)
await 300 "a third of the run" passed_steps $((steps / 3))
check "training goes on after an actor's death" 0 "killed at $before env steps, now $(steps_done)"
# What Slurm sends two minutes before the time limit.
scancel --signal=USR1 --batch "$job"
await 60 "the job to queue again" grep -q "queues again" "$out"
await 120 "the second start" bash -c "scontrol show job $job | grep -q 'JobState=RUNNING .*\|Restarts=1'"
await 600 "the end of the job" ended "$job"
summary=$work/big/summary.json
check "the job ends well" "$([[ $(state "$job") == JobState=COMPLETED ]]; echo $?)" "$(state "$job"), exit codes $(scontrol show job "$job" | grep -o 'ExitCode=[0-9:]*')"
check "it was queued again once" "$(scontrol show job "$job" | grep -q 'Restarts=1'; echo $?)" "$(scontrol show job "$job" | grep -o 'Restarts=[0-9]*')"
check "and went on from its checkpoint" "$(grep -q 'resumed at [1-9]' "$work/big/log/learner.log"; echo $?)" \
  "$(grep -o 'resumed at [0-9]*.*' "$work/big/log/learner.log" | head -n 1)"
check "success" "$(awk "BEGIN { print !($(value success_rate "$summary") >= $least) }")" "$(value success_rate "$summary") after $(value env_steps "$summary") env steps"
check "nothing lost" "$(($(value transitions_lost "$summary") != 0))" "$(value transitions_lost "$summary")"
await 60 "idle nodes" all_idle
left=$(pgrep -fc 'cairn-(actor|learner|planner) ')
check "no process left" "$left" "$left"

array=$(submit --array=1-2 --nodes=1 "$source_dir/deploy/slurm/cairn.sbatch" "$experiment" "$work/seeds" --actors 1 "${small[@]}" \
  --set total_env_steps=2000)
array_ended() { [[ -z $(squeue -h -j "$array") ]]; }
await 300 "the array" array_ended
for seed in 1 2; do
  check "seed $seed of the array" "$([[ $(value seed "$work/seeds/seed-$seed/summary.json") == "$seed" ]]; echo $?)" \
    "env_steps $(value env_steps "$work/seeds/seed-$seed/summary.json"), weights $(value weights_crc32c "$work/seeds/seed-$seed/summary.json")"
done
# Without multicast: the route is gone, and LCM's broker carries the messages.
if [[ -e /usr/share/java/lcm.jar ]] && command -v java > /dev/null; then
  ip route del 224.0.0.0/4 dev lo
  job=$(CAIRN_BROKER=7950 CAIRN_ACTORS=1 submit --nodes=2 "$source_dir/deploy/slurm/cairn.sbatch" "$experiment" "$work/broker" \
    --actors 1 "${small[@]}" --set total_env_steps=100000)
  out=$work/cairn-${job}_4294967294.out
  await 60 "its learner" learner broker
  hold broker
  await 60 "the second node's actor" processes "cairn-actor .*--actor-id 1000 " 1
  release broker
  await 300 "the job over a broker" ended "$job"
  check "without multicast, over a broker" "$([[ $(state "$job") == JobState=COMPLETED ]]; echo $?)" \
    "$(state "$job"), env_steps $(value env_steps "$work/broker/summary.json"), lost $(value transitions_lost "$work/broker/summary.json")"
  check "with an actor of the second node" \
    "$(grep -q 'actor 1000 joined' "$work/broker/log/learner.log"; echo $?)" \
    "$(grep -o 'actor 1000 joined[^,]*' "$work/broker/log/learner.log")"
fi
((failed == 0)) || tail -n 20 "$work"/*.out >&2
checks_ended
