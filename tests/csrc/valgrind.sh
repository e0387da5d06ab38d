#!/bin/sh
# Runs the C tests under valgrind: tests/csrc/valgrind.sh [BUILD_FOLDER]
# Debug build without sanitizers; fails on any error or lost block.
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$here/build/valgrind}
cmake -S "$here" -B "$build" -DCMAKE_BUILD_TYPE=Debug -DBELTSIM_PYTHON=OFF \
  -DBELTSIM_TESTS=ON -DBELTSIM_WERROR=ON >/dev/null
cmake --build "$build" >/dev/null
for name in roots friction system memory faults core; do
  printf '%s: ' "$name"
  valgrind --quiet --error-exitcode=9 --leak-check=full \
    --errors-for-leak-kinds=definite,possible \
    "$build/tests/csrc/beltsim_test_$name" >/dev/null && echo clean
done
