#!/usr/bin/env bash
# Follows "From a laptop to a rack" of docs/operations.md word for word: each block of commands that is marked with
# <!-- run on HOST … --> runs on its hosts, which are three fresh network namespaces behind a switch, with directories of
# their own. Marks: "on" several hosts: one after the other; "at once": together; "in the background": goes on until the end,
# and "the run" is what is waited for. All commands must succeed, and the run must be learnt.
#   operations.sh BIN_DIR
# Three things stand in for what the namespaces lack: sudo runs its command, scp copies between the hosts' directories, and
# net.core.rmem_max, which belongs to the whole machine, is left alone where it is large enough (else the script is skipped).
# Needs root, namespaces, nft and openssl. Last line: "N passed, M failed".
set -uo pipefail
source "$(dirname "$0")/common.sh"

bin=$(realpath "$1")
source_dir=$(realpath "$(dirname "$0")/../..")
if [[ -z ${CAIRN_OPERATIONS_INSIDE-} ]]; then
  for tool in nft openssl; do command -v $tool > /dev/null || { echo "operations.sh: no $tool"; exit 77; }; done
  unshare --net --mount --pid --fork true 2> /dev/null || { echo "operations.sh: needs root and namespaces"; exit 77; }
  (($(sysctl -n net.core.rmem_max) >= 4194304)) || { echo "operations.sh: net.core.rmem_max is below 4194304"; exit 77; }
  # All processes end with the process namespace, all mounts and networks with theirs.
  CAIRN_OPERATIONS_INSIDE=1 exec unshare --net --mount --pid --fork --kill-child --mount-proc bash "$0" "$@"
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mount -t tmpfs tmpfs /opt
cmake --install "$bin/.." --prefix /opt/cairn > "$work/install.log" 2>&1 || { cat "$work/install.log"; exit 1; }
mount -t tmpfs tmpfs /run/netns 2> /dev/null || { mkdir -p /run/netns && mount -t tmpfs tmpfs /run/netns; }

ip link add name switch type bridge mcast_snooping 0
ip link set switch up
number=0
for host in hostA hostB hostC; do
  number=$((number + 1))
  ip netns add $host
  ip link add eth1 netns $host type veth peer name port$number
  ip link set port$number master switch up
  ip -n $host link set lo up
  ip -n $host address add 10.0.0.$number/24 dev eth1
  ip -n $host link set eth1 up
  mkdir -p "$work/$host"
done

cat > "$work/profile" << EOF
export PATH=/opt/cairn/bin:\$PATH
sudo() {
  if [[ "\$*" == "sysctl -w net.core.rmem_max="* ]]; then sysctl net.core.rmem_max; else "\$@"; fi
}
scp() {
  [[ \$1 == -p ]] && shift
  local to=\${!#}
  cp -p "\${@:1:\$#-1}" "$work/\${to%%:*}/\${to#*:}"
}
set -e
EOF
run_on() { # host, file with commands
  cd "$work/$1" && exec ip netns exec "$1" bash --noprofile --norc -c "source '$work/profile'; source '$2'"
}

# Splits the section into numbered files, with the marks beside them.
awk -v out="$work/block-" '
  /^## / { inside = /^## From a laptop to a rack/ }
  inside && /^<!-- run on .* -->$/ { mark = $0; sub(/^<!-- run on /, "", mark); sub(/ -->$/, "", mark); next }
  /^```/ { if (code) { code = 0; close(file) } else if (mark != "") {
      code = 1; file = sprintf("%s%02d", out, ++n); print mark > (file ".mark"); close(file ".mark"); mark = "" }; next }
  code { print > file }
' "$source_dir/docs/operations.md"
unmarked=$(awk '/^## / { inside = /^## From a laptop to a rack/ } /^<!-- run on/ { marked = 1; next }
  /^```/ { if (!code && inside && !marked) n++; code = !code; marked = 0 } END { print n + 0 }' "$source_dir/docs/operations.md")
check "every block of the section is marked" "$unmarked" "$(ls "$work"/block-??.mark | wc -l) marked, $unmarked not"

main=
for mark in "$work"/block-??.mark; do
  block=${mark%.mark}
  words=$(cat "$mark")
  hosts=$(grep -o 'host[A-Z]' <<< "$words")
  log=$block.log
  if [[ $words == *"in the background"* ]]; then
    (run_on "$hosts" "$block") > "$log" 2>&1 &
    [[ $words == *"the run"* ]] && main=$! && main_log=$log
    continue
  fi
  if [[ -n $main ]]; then # what comes behind "Start" wants the run to be over
    wait "$main"
    status=$?
    main=
    check "the run on three hosts" "$status" "$(tail -n 1 "$main_log")"
  fi
  status=0
  if [[ $words == *"at once"* ]]; then
    waited=()
    for host in $hosts; do
      (run_on "$host" "$block") > "$log.$host" 2>&1 &
      waited+=($!)
    done
    for pid in "${waited[@]}"; do wait "$pid" || status=$?; done
    cat "$log".host* > "$log"
  else
    for host in $hosts; do (run_on "$host" "$block") >> "$log" 2>&1 || status=$?; done
  fi
  check "$(echo $hosts): $(head -n 1 "$block" | cut -c1-70)" "$status" "exit $status, $(tail -n 1 "$log" | cut -c1-90)"
  ((status == 0)) || tail -n 20 "$log"
done
summary=$work/hostA/runs/big/summary.json
check "success" "$(awk "BEGIN { print !($(value success_rate "$summary") >= 0.95) }")" "$(value success_rate "$summary") of $(value trials "$summary")"
check "nothing lost" "$(($(value transitions_lost "$summary") != 0))" "$(value transitions_lost "$summary")"
((failed == 0)) || tail -n 5 "$work"/block-*.log >&2
checks_ended
