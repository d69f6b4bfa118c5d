#!/bin/sh
# Runs an example of examples/read and holds what it prints against the medians that are known:
#   check_example.sh FOLDER COMMAND…
set -eu
folder=$1
shift
out=$(mktemp)
trap 'rm -f "$out"' EXIT
"$@" > "$out"
# Some print the coordinates, some the number of the cell; the fixture's cell 5 is skipped.
awk -F '\t' -v file="$folder/medians.tsv" '
  function number(x) { return x == x + 0 ? x + 0 : x }
  { if ((getline line < file) <= 0) { print "a line too many: " $0; exit bad = 1 }
    n = split(line, wanted, "\t")
    if (NF == n) { for (i = 1; i < n; ++i) if (number($i) != number(wanted[i])) bad = 1 }
    else if (NF == 2) { if ($1 != NR - 1 + (NR > 5)) bad = 1 }
    else bad = 1
    if ($NF + 0 != wanted[n] + 0) bad = 1
    if (bad) { print "found " $0 "; wanted " line; exit 1 } }
  END { if (!bad && (getline line < file) > 0) { print "missing: " line; bad = 1 }; exit bad }' "$out"
