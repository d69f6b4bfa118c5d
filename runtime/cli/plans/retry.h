// The finished runs that `cdb run` and `cdb submit` run again, within their results file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"

namespace cdb::plans {

/// Selects runs by how they ended (`failed`, `crashed`, `timed_out`), by a disturbed machine
/// (`noisy`), or one run by its id.
class RetryChoice {
 public:
  RetryChoice() = default;
  /// Throws CommandError for an unknown word.
  explicit RetryChoice(const std::vector<std::string>& words);
  static RetryChoice Only(const std::string& run_id);

  bool is_empty() const { return words_.empty(); }
  /// `run_id`: the id of the run in that cell.
  bool Wants(const results::ResultFile& file, const results::ResultFile::Cell& cell,
             const std::string& run_id) const;
  bool Wants(const journal::RunInfo& run) const;

  /// `crashed,failed`: kept in the journal, so that a stopped retry can continue.
  std::string Text() const;
  static RetryChoice FromText(const std::string& text);
  const std::set<std::string>& Words() const { return words_; }
  RetryChoice With(const RetryChoice& other) const;

 private:
  std::set<std::string> words_;  ///< words and ids of runs
};

/// The choice of the unfinished retry of a sweep; empty if there is none.
RetryChoice FindStartedRetry(const std::filesystem::path& folder);

/// The runs of a results file that are not run again.
class KeptRuns {
 public:
  KeptRuns(const std::filesystem::path& out, RetryChoice retry);

  bool Has(const std::string& id, const std::vector<std::size_t>& at, std::uint64_t rep) const;
  std::size_t CountOthers(const plan::Plan& plan) const;
  /// Nullopt for a run that is to be run again.
  std::optional<journal::RunInfo> Find(const plan::Run& run) const;

 private:
  const results::ResultFile file_;
  const RetryChoice retry_;
  /// True for a retry of a search or a race, which goes on afterwards and chooses from the missing
  /// runs.
  const bool leaves_missing_;
};

/// Prepares the folder of a sweep for a new retry: removes journals whose runs the result already
/// contains. Returns an empty text, or the reason why there is nothing to run again. Throws
/// CommandError if the result lacks some of these runs, or another cdb is at work in the folder.
std::string PrepareRetry(const plan::Plan& plan, const std::filesystem::path& folder,
                         const std::filesystem::path& out, const RetryChoice& retry,
                         bool is_complete);

/// The number of runs that the retry in `folder` selects and that have not been run again yet; 0 if
/// there is no retry. Call it before they are merged into `out`.
std::size_t CountNotRunAgain(const plan::Plan& plan, const std::filesystem::path& folder,
                             const std::filesystem::path& out);

}  // namespace cdb::plans
