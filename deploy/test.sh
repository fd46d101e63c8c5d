#!/usr/bin/env bash
# Installs the test packages, builds everything and runs all tests. ctest's summary is the last thing printed.
#   deploy/test.sh [ctest arguments, e.g. -R ReplayBuffer]
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install_dependencies.sh --test
options=(-DCAIRN_BUILD_TESTS=ON)
if command -v ccache > /dev/null; then
  options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
cmake --preset release "${options[@]}"
cmake --build --preset release
exec ctest --preset release -j "$(nproc)" "$@"
