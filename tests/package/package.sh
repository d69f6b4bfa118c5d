#!/bin/bash
# The Debian package as its users meet it: made, unpacked elsewhere, and its programs run there.
set -euo pipefail
cpack=$1 build=$2
for program in dpkg-shlibdeps file; do
  command -v "$program" >/dev/null || { echo "skipped: needs $program (./setup --test)"; exit 77; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$cpack" --config "$build/CPackConfig.cmake" -B "$folder" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
package=$(echo "$folder"/cdb_*.deb)
dpkg-deb --field "$package" Depends | grep libhdf5
dpkg-deb --extract "$package" "$folder/root"
share=$folder/root/usr/share
[ -s "$share/doc/cdb/copyright" ] && [ -s "$share/man/man1/cdb.1" ] && [ -x "$share/cdb/fetch-models" ]

[ ! -e "$build/cdb-import" ] || [ -x "$folder/root/usr/bin/cdb-import" ]

cd "$folder"
cdb=$folder/root/usr/bin/cdb
"$cdb" run -q "$share/doc/cdb/examples/first.cdb"
"$cdb" show first.h5
# Where libraries of third-party detectors are not installed, scenarios that need them are errors.
"$cdb" check "$share"/cdb/scenarios/*/*.cdb >checked 2>&1 || {
  "$cdb" list detectors | grep 'not in this build' >missing
  grep E0218 checked >missing
  ! grep 'error:' checked | grep -v E0218
}
# A model is there, or the message says how this copy gets it.
echo 'benchmark b { cycles 2; world.side 100; objects { quantity 5; type bunny; size 10 } }' >b.cdb
"$cdb" run b.cdb >said 2>&1 || grep "run: '$share/cdb/fetch-models' '$share/cdb/models' bunny" said || { cat said; exit 1; }
