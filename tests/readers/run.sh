#!/bin/sh
# Runs a reader's test where the reader is installed:  run.sh NAME PROBE COMMAND…
# Elsewhere it is skipped (77), or fails where CDB_REQUIRE_READERS=1.
name=$1 probe=$2
shift 2
if ! sh -c "$probe" > /dev/null 2>&1; then
  echo "$name is not installed"
  [ "${CDB_REQUIRE_READERS:-0}" = 1 ] && exit 1
  exit 77
fi
exec "$@"
