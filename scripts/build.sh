#!/bin/sh
# Installs what is missing and builds everything into build/.
set -eu
cd "$(dirname "$0")/.."

scripts/install.sh
[ -f build/build.ninja ] || cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release
cmake --build build
