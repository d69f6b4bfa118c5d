// The record of jobs submitted for a sweep: a request in its journal, by which the same command
// follows the jobs or continues after them.
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
  std::string array, merge;  ///< ids of the jobs; `merge` equals `array` until there is a merge job
};

/// Nullopt if there is none, or if it is damaged.
std::optional<Submission> ReadSubmission(const std::filesystem::path& folder);
/// Throws StoreError.
void WriteSubmission(const Submission& submission, const std::filesystem::path& folder);
/// Keeps other cdb processes from submitting to the same folder. Starting tasks ignore it.
class SubmissionLock {
 public:
  explicit SubmissionLock(const std::filesystem::path& folder);
  /// False while another cdb submits. True if the file system does not support locks.
  bool is_held() const { return is_held_; }

 private:
  plan::Descriptor file_;
  bool is_held_ = true;
};

/// Removes the lock and the logs of the jobs; the submission is removed with its journal.
void RemoveSubmission(const std::filesystem::path& folder);

}  // namespace cdb::cluster
