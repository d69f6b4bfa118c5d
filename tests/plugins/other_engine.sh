#!/bin/bash
# examples/ode_worker: its bounces lose less energy with smaller time steps, and it names each feature that it does not
# support.
set -euo pipefail
build=$1 source=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cp "$build/cdb" cdb
cp "$build/cdb-worker-ode" cdb-worker-f64

./cdb run -q "$source/examples/ode_worker/bounce.cdb" -o ode.h5
# Rows, the fastest first: hz, times real time, ms per s, error.
./cdb show ode.h5 --error energy | awk '$1 ~ /^[0-9]+$/ && NF >= 6 { print $1, $4 }' | sort -n | tee errors
awk 'NR > 1 && !($2 < 0.6 * last) { exit 1 } { last = $2 } END { exit NR != 5 }' errors

sed 's/quantity     1/quantity     1\n    type         cone/' \
  "$source/examples/ode_worker/bounce.cdb" | sed '/accuracy {/,/}/d' >cone.cdb
if ./cdb run -q cone.cdb -o cone.h5 >output 2>&1; then cat output && exit 1; fi
./cdb show cone.h5 >shown && exit 1 # exit status 3: not every run ended well
grep -q 'the ODE worker knows balls and cuboids' shown
