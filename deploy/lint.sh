#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy says what for) over the sources, or over the files named. Takes 4-10 s a file, which is
# why it is no test. Needs `deploy/install_dependencies.sh --test` and a configured build.
#   deploy/lint.sh [BUILD_DIR=build/release] [FILE.cc …]
set -euo pipefail
cd "$(dirname "$0")/.."

build=build/release
if [[ -d ${1-} ]]; then
  build=$1
  shift
fi
if [[ ! -f $build/compile_commands.json ]]; then
  echo "lint.sh: no $build/compile_commands.json; configure first: cmake --preset release" >&2
  exit 1
fi

files=("$@")
if ((${#files[@]} == 0)); then
  mapfile -t files < <(find common actors learner planner deploy tests -name '*.cc' | sort)
fi
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy-14 -p "$build" --quiet
