#!/bin/sh
set -eu
cmake -S . -B build/conda -G Ninja $CMAKE_ARGS -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON \
  -DAXODE_TESTS=OFF -DAXODE_EXAMPLES=OFF -DAXODE_VIEWER=OFF
cmake --build build/conda --parallel "$CPU_COUNT"
cmake --install build/conda --prefix "$PREFIX"
