#!/bin/sh
# Runs a test of the language server with the packages beside it:  run.sh NODE TEST ARGUMENT…
# Without npm it is skipped (77), or fails where CDB_REQUIRE_EDITORS=1.
set -eu
missing() {
  echo "$1"
  [ "${CDB_REQUIRE_EDITORS:-0}" = 1 ] && exit 1
  exit 77
}
command -v npm > /dev/null || missing 'npm is not installed'
cd "$(dirname "$2")"
[ -d node_modules/vscode-jsonrpc ] || npm ci --ignore-scripts --no-audit --no-fund --loglevel=error ||
  missing 'vscode-jsonrpc cannot be installed'
exec "$@"
