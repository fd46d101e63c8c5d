#!/usr/bin/env bash
# Fails when a source file is not as .clang-format wants it. Cure: format.sh ROOT --fix
set -euo pipefail
cd "$1"
mode=(--dry-run --Werror)
[[ ${2-} != --fix ]] || mode=(-i)
find common actors learner planner deploy tests \( -name '*.h' -o -name '*.cc' \) -print0 |
  xargs -0 -r -n 20 -P "$(nproc)" clang-format-14 "${mode[@]}"
