#!/bin/sh
# Compares two builds of a plug-in, or of cdb itself: gate.sh BENCH.cdb BEFORE AFTER [REPEATS]
# BEFORE and AFTER are plug-ins (.so) or programs `cdb`; REPEATS is the `repeats` of the benchmark (default: 9).
# Exit status: that of `cdb compare`, 4 if something is worse; or else 3 if a run of either build failed.
# Writes before.h5, after.h5, gate.md and gate.html. Limits and options: COMPARE='--fail-above 5% --allow missing'.
set -eu
bench=$1 before=$2 after=$3 repeats=${4:-9}

failed=0
run() { # NAME BUILD K: the K-th repeats of the benchmark. Failed runs are part of the comparison.
  case $2 in
    *.so) cdb run "$bench" -q --plugin "$2" --shard "$3/$repeats" -o "$1.h5" ;;
    *) "$2" run "$bench" -q --shard "$3/$repeats" -o "$1.h5" ;;
  esac || { failed=$?; [ $failed -eq 3 ]; }
}

# The two builds take turns, so that a change of the machine affects both.
rm -rf before.h5 after.h5 before.runs after.runs
for k in $(seq "$repeats"); do
  run before "$before" "$k"
  run after "$after" "$k"
done
for name in before after; do cdb merge -o $name.h5 $name.runs || [ $? -eq 3 ]; done

# Both times the same comparison: as Markdown for a comment, as a page with figures and for the exit status.
# shellcheck disable=SC2086 # COMPARE has several words
cdb compare before.h5 after.h5 ${COMPARE:-} --markdown >gate.md || true
# shellcheck disable=SC2086
cdb compare before.h5 after.h5 ${COMPARE:-} --page -o gate.html
exit $failed
