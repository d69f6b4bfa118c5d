#!/bin/sh
# Runs each benchmark of a scenario and writes its requirements as JUnit XML, NAME.junit.xml, for
# `cdb doc requirements`. Usage: requirements.sh SCENARIO.cdb [FOLDER]. The exit status is that of
# `cdb run`: 5 if a requirement is not met. CDB names the program (default: cdb).
set -u
scenario=$1
folder=${2:-results}
"${CDB:-cdb}" run "$scenario" -o "$folder/"
status=$?
for file in "$folder"/*.h5; do
  test -e "$file" || continue
  "${CDB:-cdb}" show "$file" --junit >"${file%.h5}.junit.xml"
done
exit $status
