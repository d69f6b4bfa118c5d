#!/bin/sh
# Runs a test with the packages beside it:  run.sh PROBE COMMAND…
# Without a browser or npm it is skipped (77), or fails where CDB_REQUIRE_BROWSER=1.
probe=$1
shift
skip() {
  echo "$1"
  [ "${CDB_REQUIRE_BROWSER:-0}" = 1 ] && exit 1
  exit 77
}
sh -c "$probe" > /dev/null 2>&1 || skip "not installed: $probe"
test -d node_modules/puppeteer-core || npm ci --ignore-scripts --loglevel=error || skip "npm ci failed"
exec "$@"
