#!/bin/sh
# Lists the tests that the last ctest in a build folder skipped, and the options of ./setup that install what they need:
#   skipped.sh BUILD [OPTION…]
# Fails if one of the OPTIONs, which were given, is among them. A test that needs what an option installs says so where it
# skips something: "skipped: REASON (./setup --OPTION)".
build=$1
shift
awk -v given=" $* " '
  / Test: / { name = $3; ++count; next }
  match($0, /\(\.\/setup --[a-z-]+\)/) { note(substr($0, RSTART + 9, RLENGTH - 10)); next }
  /^skipped: / { note("no option") }
  function note(option) {
    skipped += !(name in is_noted)
    is_noted[name] = 1
    if (names[option] !~ " " name "( |$)") names[option] = names[option] " " name
  }
  END {
    if (skipped == 0) exit
    printf "%d of %d tests were skipped, whole or in part. What installs what they need:\n", skipped, count
    for (option in names) {
      line = sprintf("  %-14s", option)
      n = split(names[option], each, " ")
      for (i = 1; i <= n; ++i) {
        if (length(line) + length(each[i]) > 118) { print line; line = sprintf("%16s", "") }
        line = line " " each[i]
      }
      print line
      if (index(given, " " option " ")) lacking = lacking " " option
    }
    if (lacking != "") { print "error: given, yet tests lack what these install:" lacking; exit 1 }
  }' "$build/Testing/Temporary/LastTest.log"
