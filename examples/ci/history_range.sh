#!/bin/sh
# Builds and measures each commit of a range, and prints the history: history_range.sh BENCH.cdb RANGE [FOLDER]
# Call it in the repository; RANGE is one of git, such as v1.0..main, and FOLDER (default: history) is kept. Of branches
# that were merged, the merge is measured. The newest commits come first, and commits with results are skipped, so stop
# it at any time, and call it again.
# Commits are checked out and built in one folder beside, FOLDER.tree, so that a build compiles what changed. Delete it
# with `git worktree remove --force FOLDER.tree`.
# BUILD: the command that builds a commit, in its folder (default: cmake, into build/).
# PLUGIN: the plug-in that this makes, such as build/libmy_detector.so; or PROGRAM: `cdb` itself, build/cdb.
# CDB: the program that prints the history, and measures a plug-in (default: cdb).
# RUN: options of `cdb run`, such as '--set clock=instructions --set repeats=1'. HISTORY: those of `cdb history`.
# Exit status: that of `cdb history`; or else 3 if a commit could not be built or a run failed in this call, which is
# named.
set -eu
bench=$1 range=$2 folder=${3:-history}
build=${BUILD:-cmake -S . -B build -DCMAKE_BUILD_TYPE=Release && cmake --build build}
tree=$folder.tree new=$folder.new log=$folder.log failed=0

mkdir -p "$folder"
test -e "$tree" || git worktree add -q --detach "$tree"
commits=$(git rev-list --first-parent --abbrev-commit --abbrev=12 "$range")
for commit in $commits; do
  if [ -e "$folder/$commit" ]; then continue; fi
  git -C "$tree" checkout -q --force --detach "$commit"
  if ! (cd "$tree" && eval "$build") >"$log" 2>&1 </dev/null; then
    echo "$commit is not built: $(tail -n 1 "$log")" >&2
    failed=3
    continue
  fi
  rm -rf "$new"
  status=0
  # shellcheck disable=SC2086 # RUN has several words
  if [ -n "${PLUGIN:-}" ]; then
    "${CDB:-cdb}" run "$bench" -q ${RUN:-} --plugin "$tree/$PLUGIN" -o "$new/" || status=$?
  else
    "$tree/${PROGRAM:-build/cdb}" run "$bench" -q ${RUN:-} -o "$new/" || status=$?
  fi
  case $status in
    0 | 5) ;;
    3) failed=3 && echo "$commit: a run failed; delete $folder/$commit to measure it again" >&2 ;;
    *) exit $status ;;
  esac
  mv "$new" "$folder/$commit"
done
# shellcheck disable=SC2086
"${CDB:-cdb}" history "$folder" --git . ${HISTORY:-}
exit $failed
