#!/bin/sh
# Builds the program that contains a test with the preset
# dev, and runs all tests whose names begin with a text, e.g.
#   tools/test_one.sh Paper.Der1
#   tools/test_one.sh Laws/InverseOfInverseDynamics
set -e
cd "$(dirname "$0")/.."
jobs=${2:-$(nproc)}
suite=${1%%.*}     # of Laws/Suite.Name/fast_double what stands before the first dot,
suite=${suite##*/} # without the name of its parameters
folder=$(grep -rlE "^(TYPED_)?TEST(_F|_P)?\($suite," tests | head -n 1 | cut -d / -f 2)
if [ -z "$1" ] || [ -z "$folder" ]; then
  echo "No test is named '$1': the names are Suite.Name of TEST(Suite, Name) in tests/" >&2
  exit 1
fi
cmake --preset dev > /dev/null
cmake --build --preset dev --parallel "$jobs" --target "test_$folder"
exec "build/dev/tests/test_$folder" --gtest_filter="$1*:*/$1*"
