#!/bin/sh
# Installs what is missing, builds, and runs the benchmarks one after the other: the tests that are registered
# with CONFIGURATIONS bench. Arguments go to ctest: scripts/bench.sh -R frames
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh
ctest --test-dir build -C bench -L bench --verbose -j 1 "$@"
