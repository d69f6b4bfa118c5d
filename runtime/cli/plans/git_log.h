// The order of results files by the commits of a repository (`cdb history --git`).
#pragma once

#include <string>
#include <vector>

#include "runtime/cli/plans/history_folder.h"
#include "runtime/figures/history/histories.h"

namespace cdb::plans {

/// The commits up to that which is checked out in the repository, as `git log` lists them, the
/// oldest first. Throws CommandError if git is missing, or fails.
std::vector<history::Commit> ReadCommits(const std::string& repository);

/// Gives each file the place of its commit: the last word of its name that is the beginning of the
/// hash of one of `commits`, with seven digits or more. Files of no such commit are left out, and
/// those of branches that were merged: they are not in one line with the others.
void PlaceByCommits(const std::vector<history::Commit>& commits, HistoryFolder& folder);

}  // namespace cdb::plans
