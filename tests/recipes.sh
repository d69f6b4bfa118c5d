#!/bin/sh
# Runs the recipes of the README and the manual as a reader would: the `sh` blocks of a page one after the other in an empty
# folder, which has the checkout's `examples` and `build`, with cdb in PATH. A `cdb` block whose first line is a comment that
# names a file is written to it. Blocks of commands that need a cluster, other machines or hours are `console` instead.
# `./setup` itself is left to .ci/clean.
#
#   tests/recipes.sh BUILD [PAGE…]
set -eu
build=$(cd "$1" && pwd)
shift
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- README.md runtime/manual/*.md
PATH=$build:$PATH
export PATH

root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
checkout=$PWD
status=0
for page; do
  folder=$root/$(echo "${page%.md}" | tr / _)
  mkdir "$folder"
  # One script of a page: files are written and commands run in the order of the text.
  awk '
    /^```/ && language == "" {
      language = substr($0, 4)
      if (language == "") language = "text"
      lines = 0
      next
    }
    /^```/ {
      if (language == "sh") for (i = 1; i <= lines; i++) {
        sub(/^\.\/setup && /, "", block[i])
        print block[i]
      }
      if (language == "cdb" && block[1] ~ /^# [a-z_]+\.cdb$/) {
        print "cat >" substr(block[1], 3) " <<'\''END OF FILE'\''"
        for (i = 1; i <= lines; i++) print block[i]
        print "END OF FILE"
      }
      language = ""
      next
    }
    language != "" { block[++lines] = $0 }' "$page" >"$folder.sh"
  [ -s "$folder.sh" ] || continue
  cp -r "$checkout/examples" "$folder/"
  ln -s "$build" "$folder/build"
  if (cd "$folder" && sh -eux "$folder.sh") >"$folder.log" 2>&1 </dev/null; then
    printf 'passed  %s\n' "$page"
  else
    printf 'FAILED  %s\n' "$page"
    cat "$folder.log"
    status=1
  fi
done
exit $status
