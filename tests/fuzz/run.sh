#!/usr/bin/env bash
# Builds the fuzzers with clang and runs each from its corpus.
#   run.sh [--seconds N, default 60] [--runs N: at least this many inputs for each instead] [--target NAME] [--keep]
# --keep adds what was found to the corpus, reduced to what reaches something of its own. Last line: "N passed, M failed, …".
set -uo pipefail
cd "$(dirname "$0")/../.."

limit=(-max_total_time=60)
only=
keep=0
while (($# > 0)); do
  case "$1" in
    --seconds) limit=("-max_total_time=$2") && shift ;;
    --runs) limit=("-runs=$2") && shift ;;
    --target) only=$2 && shift ;;
    --keep) keep=1 ;;
    *)
      echo "run.sh: unknown argument '$1'" >&2
      exit 2
      ;;
  esac
  shift
done
clang=$(command -v clang++-14 || command -v clang++) || { echo "run.sh: clang is not installed"; exit 77; }

build=build/fuzz
options=(-DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -gline-tables-only -DNDEBUG"
  -DCMAKE_CXX_COMPILER="$clang" -DCMAKE_C_COMPILER="${clang/++/}" -DCAIRN_FUZZ=ON -DCAIRN_BUILD_TESTS=OFF
  -DCAIRN_SANITIZE=address,undefined)
if command -v ccache > /dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake -S . -B "$build" -G Ninja "${options[@]}" > "$build.log" 2>&1 &&
  cmake --build "$build" --target fuzzers > "$build.log" 2>&1 || { tail -n 30 "$build.log" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$build/bin/fuzz-seeds" "$work/seeds"

fuzz() {
  local name=$1 corpus=tests/fuzz/corpus/$1
  mkdir -p "$work/found/$name" "$corpus" "$work/seeds/$name"
  local inputs=("$work/found/$name" "$corpus" "$work/seeds/$name")
  if [[ -d $work/seeds/$name-body ]]; then inputs+=("$work/seeds/$name-body"); fi
  if "$build/bin/fuzz-$name" "${limit[@]}" -max_len=4096 -timeout=10 -rss_limit_mb=2000 -print_final_stats=1 \
    -artifact_prefix="$build/crash-$name-" "${inputs[@]}" > "$work/$name.log" 2>&1; then
    echo ok > "$work/$name.result"
  fi
  if ((keep == 1)); then
    mkdir -p "$work/merged/$name"
    "$build/bin/fuzz-$name" -merge=1 -max_len=512 "$work/merged/$name" "${inputs[@]}" > /dev/null 2>&1
    rm -rf "$corpus"
    mkdir -p "$corpus"
    # The smallest hundred say enough for a start.
    find "$work/merged/$name" -type f -printf '%s %p\n' | sort -n | head -n 100 | cut -d' ' -f2 | xargs -r cp -t "$corpus"
  fi
}
export -f fuzz
names=$(basename -a "$build"/bin/fuzz-* | sed 's/^fuzz-//' | grep -v '^seeds$')
if [[ -n $only ]]; then names=$only; fi
jobs=0
for name in $names; do
  fuzz "$name" &
  if ((++jobs % $(nproc) == 0)); then wait; fi
done
wait

passed=0
failed=0
total=0
for name in $names; do
  inputs=$(grep -o 'number_of_executed_units: *[0-9]*' "$work/$name.log" | grep -o '[0-9]*$')
  total=$((total + ${inputs:-0}))
  if [[ -e $work/$name.result ]]; then
    passed=$((passed + 1))
    echo "ok      $name: ${inputs:-0} inputs"
  else
    failed=$((failed + 1))
    echo "FAILED  $name"
    tail -n 40 "$work/$name.log"
  fi
done
echo "$passed passed, $failed failed, $total inputs"
((failed == 0))
