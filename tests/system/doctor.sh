#!/usr/bin/env bash
# Makes each trouble that `cairn doctor` knows, for real, in network namespaces of its own: no route, no multicast loopback, a
# clipped receive buffer, a port that is taken, firewalls, ttl 0 with an actor on another host, a key that is missing or
# readable by others, a full disk. Each must be named with its cure, and where the cure is a command, running it must help.
# Then `--peer` measures between two hosts what nftables was told to drop, within 1 %.
#   doctor.sh BIN_DIR [--probes N, default 10000] [--host-sysctl]
# net.core.rmem_max belongs to the whole machine, so that a shim caps the buffer in its place; --host-sysctl lowers the real
# one for a moment. Needs root, network namespaces and nft. Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
shift
probes=10000
host_sysctl=0
while (($# > 0)); do
  case "$1" in
    --probes)
      probes=$2
      shift
      ;;
    --host-sysctl) host_sysctl=1 ;;
    *)
      echo "doctor.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift
done
source_dir=$(realpath "$(dirname "$0")/../..")
experiment=$source_dir/deploy/experiments/car_maze.textproto
shim=$bin/../lib/libcairn_receive_buffer_shim.so
work=$(mktemp -d)
name=cdoc$$
pids=()
rmem=
cleanup() {
  [[ -n $rmem ]] && sysctl -q -w "net.core.rmem_max=$rmem"
  for pid in "${pids[@]}"; do kill -KILL "$pid" 2> /dev/null; done
  wait 2> /dev/null
  for host in a b s; do ip netns del "$name-$host" 2> /dev/null; done
  mountpoint -q "$work/disk" && umount "$work/disk"
  rm -rf "$work"
}
trap cleanup EXIT
trap "exit 1" INT TERM
on() { # host, command …
  local host=$name-$1
  shift
  ip netns exec "$host" "$@"
}

command -v nft > /dev/null || { echo "doctor.sh: nft is not installed"; exit 77; }
((EUID == 0)) || { echo "doctor.sh: needs root"; exit 77; }
ip netns add "$name-a" 2> /dev/null || { echo "doctor.sh: no network namespaces here"; exit 77; }
mkdir "$work/here"
cd "$work/here" || exit 1

# Host a as new: a cable to host b, loopback up, the route of this argument ("v": by the cable, "lo", "": none).
fresh() {
  for host in a b; do
    ip netns del "$name-$host" 2> /dev/null
    ip netns add "$name-$host"
    on $host ip link set lo up
  done
  ip link add v netns "$name-a" type veth peer name v netns "$name-b"
  on a ip addr add 10.98.0.1/24 dev v
  on b ip addr add 10.98.0.2/24 dev v
  for host in a b; do on $host ip link set v up; done
  on b ip route add 224.0.0.0/4 dev v
  [[ -z $1 ]] || on a ip route add 224.0.0.0/4 dev "$1"
}

doctor() { on a "$bin/cairn" doctor "$@" > "$work/out" 2>&1; }

# What was made, the exit status to see, a regular expression that a line must match; then the arguments of doctor.
expect() {
  local what=$1 status=$2 pattern=$3 seen
  shift 3
  doctor "$@"
  seen=$?
  check "$what" "$([[ $seen == "$status" ]] && grep -Eq -- "$pattern" "$work/out"; echo $?)" \
    "exit $seen, $(grep -E -- "$pattern" "$work/out" || sed -n '/^\(fail\|warn\|cairn\)/p' "$work/out" | head -n 3)"
}

# Runs the cure that the last doctor named on its line `$1` on host a, as it stands, up to a remark in parentheses.
cure() { on a bash -c "sudo() { \"\$@\"; }; $(grep -E "^(fail|warn) $1:" "$work/out" | sed 's/.*; cure: //; s/ (.*//')"; }

fresh lo
expect "nothing is wrong" 0 "0 failures"
expect "an experiment of one host" 0 "^ok +ttl: 0" "$experiment"

# A run of this very host is no stranger, also where loopback is all there is.
on s true 2> /dev/null || ip netns add "$name-s"
on s ip link set lo up
on s ip route add 224.0.0.0/4 dev lo
ip netns exec "$name-s" "$bin/cairn" actor "$experiment" --run-id 5eed > "$work/actor.log" 2>&1 &
actor=$!
pids+=("$actor")
for ((i = 0; i < 300; i++)); do
  on s grep -q ":1E14 " /proc/net/udp && break
  read -rt 0.1 <> <(:) || true
done
on s "$bin/cairn" doctor "$experiment" > "$work/out" 2>&1
check "an actor of this host" "$(grep -q '^ok *ttl: 0' "$work/out"; echo $?)" "$(grep ' ttl:' "$work/out")"
kill "$actor"
wait "$actor" 2> /dev/null

fresh ""
expect "no route, one host" 0 "^warn route: no way to 239.255.76.67.*cure: sudo ip route add 224.0.0.0/4 dev lo"
cure route
expect "its cure" 0 "^ok +route: 239.255.76.67 by lo"
remote=("$experiment" --set transport.ttl=1 --insecure)
expect "ttl 1 by the loopback" 1 "^fail route: .*by lo.*cure: sudo ip route replace 224.0.0.0/4 dev v$" "${remote[@]}"
cure route
expect "its cure" 0 "^ok +route: 239.255.76.67 by v" "${remote[@]}"
fresh ""
expect "no route, ttl 1" 1 "^fail route: no way.*cure: sudo ip route add 224.0.0.0/4 dev v$" "${remote[@]}"
cure route
expect "its cure" 0 "^ok +route" "${remote[@]}"
on a ip route replace prohibit 224.0.0.0/4
on a ip route del 224.0.0.0/4 dev v 2> /dev/null
expect "a route that forbids" 1 "^fail route: .*cure: sudo ip route replace" "${remote[@]}"
fresh v
on b ip link set v down
for ((i = 0; i < 100; i++)); do # the kernel takes note a moment later
  on a ip link show v | grep -q NO-CARRIER && break
  read -rt 0.1 <> <(:) || true
done
expect "no carrier" 1 "^fail route: .*no carrier" "${remote[@]}"

fresh v
on a ip link set lo down
expect "no loopback interface" 1 "^fail loopback: lo is down; cure: sudo ip link set lo up"
cure loopback
expect "its cure" 0 "^ok +loopback"
on a sysctl -q -w net.ipv4.igmp_max_memberships=0
expect "no multicast membership" 1 "^fail echo: .*cannot join the group.*cure: sudo sysctl -w net.ipv4.igmp_max_memberships"
cure echo
expect "its cure" 0 "^ok +echo"
firewall() { # hook, rule
  on a nft flush ruleset
  on a nft add table inet f
  on a nft add chain inet f c "{ type filter hook $1 priority 0; }"
  on a nft add rule inet f c "$2"
}
firewall input "ip daddr 224.0.0.0/4 drop"
expect "no loopback multicast" 1 "^fail echo: .*multicast is not looped back.*cure: .*ip daddr 224.0.0.0/4 accept"
on a nft insert rule inet f c ip daddr 224.0.0.0/4 accept
expect "its cure" 0 "^ok +echo"

firewall input "udp dport 7700-7703 drop"
expect "firewall on the way in" 1 "^fail echo: port 7700.*a firewall drops them; cure: .*udp dport 7700-7703 accept"
on a nft insert rule inet f c udp dport 7700-7703 accept
expect "its cure" 0 "^ok +echo"
firewall input "udp dport 7702 drop"
expect "firewall on one port" 1 "^fail echo: port 7702.*firewall"
firewall input "udp length > 20000 drop"
expect "firewall on large messages" 1 "^fail echo: .*large datagrams"
firewall output "udp dport 7700-7703 drop"
expect "firewall on the way out" 1 "^fail echo: .*a firewall forbids to send"
on a nft flush ruleset

LD_PRELOAD=$shim CAIRN_RMEM_MAX=212992 expect "receive buffer clipped by the shim" 0 \
  "^warn receive buffer: .*212992 of 4000000.*cure: sudo sysctl -w net.core.rmem_max=4194304"
if ((host_sysctl)); then
  rmem=$(sysctl -n net.core.rmem_max)
  sysctl -q -w net.core.rmem_max=212992
  expect "receive buffer clipped by the kernel" 0 "^warn receive buffer: .*212992 of 4000000.*rmem_max = 212992"
  bash -c "sudo() { \"\$@\"; }; $(grep -E "^warn receive buffer:" "$work/out" | sed 's/.*; cure: //; s/ (.*//')" > /dev/null
  expect "its cure" 0 "^ok +receive buffer"
  sysctl -q -w "net.core.rmem_max=$rmem"
  rmem=
fi

on a sysctl -q -w net.ipv4.ipfrag_low_thresh=50000 net.ipv4.ipfrag_high_thresh=100000
expect "no pool for fragments" 0 "^warn fragments: .*cure: sudo sysctl -w net.ipv4.ipfrag_high_thresh"
cure fragments > /dev/null
expect "its cure" 0 "^ok +fragments"
on a ip link set v mtu 1400
expect "a small mtu" 0 "^warn fragments: .*cut in two.*cure: sudo ip link set dev v mtu 1500" "${remote[@]}"
on a ip link set v mtu 1500

# Holds a port until it is killed; says when it has it.
hold="import socket, sys
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind(('', int(sys.argv[1])))
print('held', flush=True)
sys.stdin.read()"
mkfifo "$work/held" "$work/hold"
exec 5<> "$work/hold"
ip netns exec "$name-a" python3 -c "$hold" 7701 < "$work/hold" 5>&- > "$work/held" &
holder=$!
pids+=("$holder")
read -r _ < "$work/held"
expect "port taken" 1 "^fail ports: 7700 to 7704 are taken by process $holder \(python3\); cure: .*transport.base_port=7705"
expect "its cure" 0 "^ok +ports: 7705" "$experiment" --set transport.base_port=7705
kill "$holder"
wait "$holder" 2> /dev/null

# An actor of host b that waits for a run of host a, which has ttl 0.
ip netns exec "$name-b" "$bin/cairn" actor "$experiment" --lcm-url "udpm://239.255.76.67:7700?ttl=1" --run-id 5eed \
  --insecure --actor-id 3 > "$work/actor.log" 2>&1 &
actor=$!
pids+=("$actor")
for ((i = 0; i < 300; i++)); do # it is there when it has bound its ports
  on b grep -q ":1E14 " /proc/net/udp && break
  read -rt 0.1 <> <(:) || true
done
expect "ttl 0, and an actor of another host" 1 "^fail ttl: 0: .*10.98.0.2 sends.*cure: --set transport.ttl=1" "$experiment"
expect "its cure" 0 "^ok +ttl: 1.*hears 10.98.0.2" "${remote[@]}"
kill "$actor"
wait "$actor" 2> /dev/null
expect "ttl 0, and a peer" 1 "^fail ttl: 0: .*peer.*cure: --set transport.ttl=1" "$experiment" --peer
on a "$bin/cairn" train "$experiment" --run-dir "$work/run" --quiet --actors 1 --set vehicle.kind=PLANE_CAR \
  --set total_env_steps=600 --set learner.learning_starts=500 --set evaluation.test_starts=5 \
  --set evaluation.max_steps=20 > "$work/train.log" 2>&1
expect "ttl 0, on the host of the run" 0 "^ok +ttl: 0" "$work/run"
on a unshare --uts bash -c "hostname elsewhere; exec '$bin/cairn' doctor '$work/run'" > "$work/out" 2>&1
check "ttl 0, on another host of the run" "$(grep -Eq '^fail ttl: 0: .*stay on .*this is elsewhere; cure: --set transport.ttl=1' "$work/out"; echo $?)" \
  "$(grep ' ttl:' "$work/out")"

cp "$experiment" "$work/here/maze.textproto"
keyed=(maze.textproto --set transport.ttl=1)
expect "no key beside the file" 0 "^warn key: .*no such file.*cure: copy the run's: scp -p" "${keyed[@]}"
expect "the named key is missing" 1 "^fail key: .*no such file.*cure: copy the run's: scp -p .*openssl rand -hex 32" \
  "${keyed[@]}" --key secret
(umask 077; od -An -N32 -tx1 /dev/urandom | tr -d ' \n' > key; echo >> key)
expect "a sound key" 0 "^ok +key" "${keyed[@]}"
chmod 644 key
expect "a key that others may read" 1 "^fail key: .*mode 0644.*cure: chmod 600 .*/key$" "${keyed[@]}"
cure key
expect "its cure" 0 "^ok +key" "${keyed[@]}"
echo short > key
expect "a broken key" 1 "^fail key: .*6 bytes.*cure: copy the run's again" "${keyed[@]}"

mkdir "$work/disk"
if mount -t tmpfs -o size=4m tmpfs "$work/disk" 2> /dev/null; then
  expect "a small disk" 1 "^fail disk: .*cure: free [0-9]+ MB there, or take a --run-dir on another disk" \
    "$experiment" --run-dir "$work/disk/runs"
  head -c 8m /dev/zero > "$work/disk/full" 2> /dev/null
  expect "a full disk" 1 "^fail disk: cannot write to .*No space left on device.*cure: free" \
    "$experiment" --run-dir "$work/disk/runs"
  umount "$work/disk"
  expect "its cure" 0 "^ok +disk" "$experiment" --run-dir "$work/disk/runs"
else
  echo "no tmpfs here: the full disk is left out"
fi

json() { python3 -c "import json, sys; print(json.load(open(sys.argv[1]))['peer'][sys.argv[2]])" "$work/$1.json" "$2"; }
lose() { # host, per mille
  on "$1" nft flush ruleset
  on "$1" nft add table netdev l
  on "$1" nft add chain netdev l i "{ type filter hook ingress device v priority 0; }"
  on "$1" nft add rule netdev l i ip protocol udp numgen random mod 1000 "<" "$2" counter drop
}
# Both hosts at once, with what is to be lost on the way in of each, in per mille.
peers() {
  local host
  lose a "$1"
  lose b "$2"
  on b "$bin/cairn" doctor --peer --json --probes "$probes" > "$work/b.json" 2>&1 &
  on a "$bin/cairn" doctor --peer --json --probes "$probes" > "$work/a.json" 2>&1
  wait $!
  local -A told=([a]=$1 [b]=$2)
  for host in a b; do
    local other=$([[ $host == a ]] && echo b || echo a)
    check "--peer on $host, told to drop $1 and $2 per mille" \
      "$(python3 -c "print(int(not (abs($(json $host lost_from_peer) - ${told[$host]} / 1000) <= 0.01
        and abs($(json $host lost_to_peer) - ${told[$other]} / 1000) <= 0.01)))")" \
      "lost on the way in $(json $host lost_from_peer), out $(json $host lost_to_peer), round trip median $(json $host round_trip_median_us) us, 99 % $(json $host round_trip_p99_us) us"
  done
}
fresh v
peers 0 0
peers 50 10
peers 200 0
for host in a b; do on $host nft flush ruleset; done

on b "$bin/cairn" doctor --peer --probes 400 --timeout 20 > "$work/b.out" 2>&1 &
firewall input "iifname v udp dport 7702 drop"
expect "--peer, one port closed" 1 "^fail loss from peer: .*nothing arrives on port 7702 \(tables\).*cure: on this host.*7700-7703" \
  --peer --probes 400 --timeout 20
wait $!
check "--peer, as the other host sees it" "$(grep -q '^fail loss to peer: .*port 7702.*cure: on the peer' "$work/b.out"; echo $?)" \
  "$(grep 'loss to peer' "$work/b.out")"
on b "$bin/cairn" doctor --peer --probes 400 --timeout 4 > "$work/b.out" 2>&1 &
firewall input "iifname v drop"
expect "--peer, all closed on this host" 1 "^fail peer: nobody answers.*cure: run cairn doctor --peer on the other host" \
  --peer --probes 400 --timeout 3
wait $!
check "--peer, as the other host sees it" "$(grep -q '^fail peer: 10.98.0.1 is heard, but does not hear this host' "$work/b.out"; echo $?)" \
  "$(grep ' peer:' "$work/b.out")"
checks_ended
