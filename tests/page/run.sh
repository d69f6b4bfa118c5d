#!/bin/sh
# Runs a test of a page where a browser is installed:  run.sh NODE TEST
# Elsewhere it is skipped (77), or fails where CDB_REQUIRE_BROWSER=1. The folder of the test has its packages.
set -eu
missing() {
  echo "$1"
  [ "${CDB_REQUIRE_BROWSER:-0}" = 1 ] && exit 1
  exit 77
}
CHROMIUM=$(command -v chromium || command -v chromium-browser) || missing 'chromium is not installed (./setup --browser)'
export CHROMIUM
cd "$(dirname "$2")"
[ -d node_modules/puppeteer-core ] || npm ci --ignore-scripts --no-audit --no-fund --loglevel=error ||
  missing 'puppeteer-core cannot be installed'
exec "$@"
