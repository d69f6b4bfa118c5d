#!/bin/bash
# examples/my_detector as a user builds it: outside the source tree, against an installed cdb, and run by it.
set -euo pipefail
cmake=$1 build=$2 source=$3 compiler=$4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$cmake" --install "$build" --prefix "$folder/usr" >/dev/null
cp -r "$source/examples/my_detector" "$folder/mine"
cd "$folder/mine"
"$cmake" -S . -B build -DCMAKE_PREFIX_PATH="$folder/usr" -DCMAKE_CXX_COMPILER="$compiler" >/dev/null
"$cmake" --build build >/dev/null

"$folder/usr/bin/cdb" run compare.cdb
# Exit status 3 if the pairs of a cycle are not exact.
"$folder/usr/bin/cdb" verify compare.cdb | tee verified
grep -q sorted_along_x verified
