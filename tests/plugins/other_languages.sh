#!/bin/bash
# The examples in C and Rust, built by the commands in their sources against an installed cdb, and verified by it.
# A language without a compiler is left out; status 77 if both are.
set -euo pipefail
cmake=$1 build=$2 source=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$cmake" --install "$build" --prefix "$folder/usr" >/dev/null
cp -r "$source/examples/my_detector" "$folder/mine"

tried=0
for language in c rust; do
  cd "$folder/mine/$language"
  # The command stands in the source, after its indent.
  command=$(sed -nE 's|^( \*\|//)   ((cc\|rustc) .*)|\2|p' my_detector.*)
  [ -n "$command" ]
  if ! command -v "${command%% *}" >/dev/null; then
    echo "skipped: $language needs ${command%% *} (./setup --cross)"
    continue
  fi
  bash -ec "${command//PREFIX/$folder/usr}"
  "$folder/usr/bin/cdb" verify compare.cdb | tee verified
  grep -q "sorted_in_$language .* exact" verified
  tried=$((tried + 1))
done
[ $tried -gt 0 ] || exit 77
