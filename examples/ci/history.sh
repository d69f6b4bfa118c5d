#!/bin/sh
# Adds the results of a commit to a folder and prints the history: history.sh BENCH.cdb COMMIT [FOLDER]
# FOLDER (default: history) is kept between jobs. Options: HISTORY='--fail-above 5% --since LABEL'.
# Exit status: that of `cdb history`, 4 if a figure became worse; or else that of `cdb run`, 3 if a run failed, 5 if a
# requirement is not met. CDB names the program (default: cdb).
set -eu
bench=$1 commit=$2 folder=${3:-history}

failed=0
"${CDB:-cdb}" run "$bench" -q -o "$folder/$commit/" || failed=$?
case $failed in 0 | 3 | 5) ;; *) exit $failed ;; esac
# shellcheck disable=SC2086 # HISTORY has several words
"${CDB:-cdb}" history "$folder" ${HISTORY:-}
exit $failed
