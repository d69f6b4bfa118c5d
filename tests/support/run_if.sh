#!/bin/sh
# Runs a test where what it needs is installed:  run_if.sh OPTION PROBE COMMAND…
# Elsewhere it is skipped (77), and says which option of ./setup installs what it needs: PROBE fails there. If the working
# directory has a package.json, its packages are installed into it.
option=$1 probe=$2
shift 2
skip() {
  echo "skipped: $1 (./setup $option)"
  exit 77
}
sh -c "$probe" > /dev/null 2>&1 || skip "this fails here: $probe"
[ ! -e package.json ] || [ -e node_modules/.package-lock.json ] ||
  npm ci --ignore-scripts --no-audit --no-fund --loglevel=error || skip 'npm cannot install the packages'
exec "$@"
