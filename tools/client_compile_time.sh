#!/bin/sh
# Prints how long a client that includes axode/axode.hpp and calls inverse dynamics takes to compile: seconds,
# median of five, without and with Eigen's adaptors.
set -eu
cd "$(dirname "$0")/.."
compiler=${CXX:-g++}

median_of_five() {
  for _ in 1 2 3 4 5; do
    start=$(date +%s%N)
    "$compiler" -std=c++20 -O2 -I. -isystem /usr/include/eigen3 "$@" -c bench/client/client.cpp -o /dev/null
    echo $((($(date +%s%N) - start) / 1000000))
  done | sort -n | sed -n 3p
}

for extra in "" "-include axode/eigen.hpp"; do
  milliseconds=$(median_of_five $extra)
  printf 'client compile time, %s -O2%s: %d.%03d s\n' "$compiler" "${extra:+ with axode/eigen.hpp}" \
    $((milliseconds / 1000)) $((milliseconds % 1000))
done
