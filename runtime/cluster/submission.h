// What was submitted for a folder of shards: a file beside them, so that the same command follows
// the jobs or goes on after them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "compiler/plan/descriptor.h"

namespace cdb::cluster {

struct Submission {
  std::string plan_sha256;
  std::uint64_t tasks = 1;   ///< parts of the plan
  std::string array, merge;  ///< ids of the jobs; `merge` is `array` until there is one
};

/// Nullopt where there is none, or a damaged one.
std::optional<Submission> ReadSubmission(const std::filesystem::path& shards);
/// Throws StoreError.
void WriteSubmission(const Submission& submission, const std::filesystem::path& shards);
/// Keeps other cdb from submitting to the same folder. Tasks that start meanwhile do not heed it.
class SubmissionLock {
 public:
  explicit SubmissionLock(const std::filesystem::path& shards);
  /// False while another cdb submits. True where the file system knows no locks.
  bool is_held() const { return is_held_; }

 private:
  plan::Descriptor file_;
  bool is_held_ = true;
};

/// With the logs of its jobs.
void RemoveSubmission(const std::filesystem::path& shards);

}  // namespace cdb::cluster
