// Which finished runs `cdb run` runs again, in the file that has them.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::cli {

/// By how they ended (`failed`, `crashed`, `timed_out`), by a disturbed machine (`noisy`), or one
/// run by its id.
class RetryChoice {
 public:
  RetryChoice() = default;
  /// Throws CommandError for another word.
  explicit RetryChoice(const std::vector<std::string>& words);
  static RetryChoice Only(const std::string& run_id);

  bool is_empty() const { return words_.empty(); }
  /// Of a results file or a shard. `run_id`: of the run in that cell.
  bool Wants(const store::ResultFile& file, const store::ResultFile::Cell& cell,
             const std::string& run_id) const;

  /// `crashed,failed`: kept in the folder of shards, so that a retry that was stopped goes on.
  std::string Text() const;
  static RetryChoice FromText(const std::string& text);
  const std::set<std::string>& Words() const { return words_; }
  RetryChoice With(const RetryChoice& other) const;

 private:
  std::set<std::string> words_;  ///< and ids
};

}  // namespace cdb::cli
