#!/bin/sh
# Builds the programs that contain a test with the preset
# dev, and runs all tests whose names begin with a text, e.g.
#   tools/test_one.sh Paper.Der1
#   tools/test_one.sh Laws/ForwardDynamics.UndoesInverseDynamics/body_double
set -e
cd "$(dirname "$0")/.."
jobs=${2:-$(nproc)}
suite=${1%%.*}     # of Laws/Suite.Name/fast_double what stands before the first dot,
suite=${suite##*/} # without the name of its parameters
folders=$(grep -rlE "^(TYPED_)?TEST(_F|_P)?\($suite," tests | cut -d / -f 2 | sort -u)
if [ -z "$1" ] || [ -z "$folders" ]; then
  echo "No test is named '$1': the names are Suite.Name of TEST(Suite, Name) in tests/" >&2
  exit 1
fi
cmake --preset dev > /dev/null
found=
for folder in $folders; do
  program="build/dev/tests/test_$folder"
  cmake --build --preset dev --parallel "$jobs" --target "test_$folder"
  if "$program" --gtest_list_tests | awk '/^[^ ]/ { suite = $0 } /^ / { print suite $1 }' | grep -qE "(^|/)$1"; then
    found=yes
    "$program" --gtest_filter="$1*:*/$1*"
  fi
done
if [ -z "$found" ]; then
  echo "No test of $(echo $folders) is named '$1': build/dev/tests/test_NAME --gtest_list_tests lists them" >&2
  exit 1
fi
