// The unfinished sweep beside a results file: its folder, the lock of it, and its removal.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/input_file.h"
#include "compiler/plan/plan.h"
#include "runtime/results/store.h"

namespace cdb::plans {

/// False also if that cannot be found out.
bool Exists(const std::filesystem::path& path);

/// The journals of `out.h5` lie in `out.runs`, those of `out.v1` in `out.v1.runs`.
std::filesystem::path RunsFolderOf(const std::filesystem::path& out);

/// True if the results are those of the plan in an earlier format, with other ids of runs.
bool IsOfEarlierFormat(const results::ResultFile& file, const plan::Plan& plan);

/// True if `out` exists and holds every run of the plan. Throws CommandError, with `hint` at the
/// end, if it holds the results of another plan, and StoreError if it is damaged.
bool IsThereAlready(const std::filesystem::path& out, const plan::Plan& plan,
                    std::string_view hint = {});

/// Throws CommandError if `out` exists and is not a results file of the plan.
void CheckIsOfPlan(const std::string& out, const plan::Plan& plan);

std::size_t CountMissing(const results::ResultFile& file, const plan::Plan& plan);
/// The runs of the plan that its searches did not need.
std::size_t CountLeftOut(const results::ResultFile& file, const plan::Plan& plan);

/// Merges the journals into `out`. Runs in `out` that no journal holds are kept. Throws StoreError;
/// `out` is then unchanged.
void MergeOnto(const plan::Plan& plan, const std::vector<std::filesystem::path>& places,
               const std::filesystem::path& out);
/// Judges the requirements of the plan if `out` was judged by others.
/// Throws StoreError.
void JudgeAnew(const plan::Plan& plan, const std::filesystem::path& out);

/// Tells other runners that the folder of a sweep is in use. Shared while runs are executed; the
/// last runner takes it exclusively, and only then may journals be removed.
class FolderLock {
 public:
  /// Creates the folder if it does not exist. Throws CommandError.
  explicit FolderLock(const std::filesystem::path& folder);
  /// Removes the folder if it is empty.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// False if another runner is at work, or the file system does not support locks.
  bool TryLockAlone();
  /// False if the file system does not support locks; it is then unknown whether others are at
  /// work.
  bool is_known() const { return is_known_; }

 private:
  std::filesystem::path folder_;
  plan::Descriptor fd_;
  bool is_known_ = true;
};

/// True while `--fresh` is at work in the folder for the plan: its runs are newer than the result,
/// and the next run continues with them.
bool IsMadeAnew(const plan::Plan& plan, const std::filesystem::path& folder);

/// True if a journal in the folder holds a run, or cannot be read. Throws ScheduleError for shards
/// of earlier versions.
bool HasRuns(const std::filesystem::path& folder);

/// Removes journals whose runs `Merge` has verified, and the files that belong to them. Throws
/// StoreError.
void RemoveMergedRuns(const plan::Plan& plan, const std::filesystem::path& folder);
/// The same if no other runner is at work, and gives up the lock. If others are, the last one
/// removes them. If the file system does not support locks, the journals stay, and a message says
/// so.
void RemoveMergedRuns(const plan::Plan& plan, const std::filesystem::path& folder, FolderLock& lock,
                      bool is_quiet);

}  // namespace cdb::plans
