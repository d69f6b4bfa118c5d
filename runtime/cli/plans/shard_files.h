// The shards beside a results file: their folder, its lock, and their removal.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/descriptor.h"
#include "compiler/plan/plan.h"
#include "runtime/store/store.h"

namespace cdb::plans {

/// The shards of `out.h5` lie in `out.runs`, those of `out.v1` in `out.v1.runs`.
std::filesystem::path ShardFolderOf(const std::filesystem::path& out);

/// True if `out` exists and holds every run of the plan. Throws CommandError, with `hint` at the
/// end, if it holds the results of another plan, and StoreError if it is damaged.
bool IsThereAlready(const std::filesystem::path& out, const plan::Plan& plan,
                    std::string_view hint = {});

/// Throws CommandError if `out` exists and is not a results file of the plan.
void CheckIsOfPlan(const std::string& out, const plan::Plan& plan);

std::size_t CountMissing(const store::ResultFile& file, const plan::Plan& plan);

/// Merges the shards into `out`. Runs in `out` that have no shard are kept. Throws StoreError;
/// `out` is then unchanged.
void MergeOnto(const plan::Plan& plan, const std::vector<std::filesystem::path>& shards,
               const std::filesystem::path& out);

/// Tells other runners that a folder of shards is in use. Shared while runs are executed; the last
/// runner takes it exclusively, and only then may shards be removed.
class FolderLock {
 public:
  /// Creates the folder if it does not exist. Throws CommandError.
  explicit FolderLock(const std::filesystem::path& folder);
  /// Removes the folder if it is empty.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// False if another runner is at work, or the file system does not support locks.
  bool TakeForMyself();
  /// False if the file system does not support locks; it is then unknown whether others are at
  /// work.
  bool is_known() const { return is_known_; }

 private:
  std::filesystem::path folder_;
  plan::Descriptor fd_;
  bool is_known_ = true;
};

/// The mark in a folder of shards while `--fresh` is at work for the plan with the hash in it: the
/// shards are newer than the result, and the next run continues with them.
std::filesystem::path FreshMark(const std::filesystem::path& folder);
bool IsMadeAnew(const plan::Plan& plan, const std::filesystem::path& folder);

bool HasShards(const std::filesystem::path& folder);

/// Removes the shards that `Merge` has verified, and the files that belong to them. Throws
/// StoreError.
void RemoveShards(const plan::Plan& plan, const std::filesystem::path& folder);
/// Calls RemoveShards if no other runner is at work, and gives up the lock. If others are, the last
/// one removes the shards. If the file system does not support locks, the shards stay, and a
/// message says so.
void RemoveMergedShards(const plan::Plan& plan, const std::filesystem::path& folder,
                        FolderLock& lock, bool is_quiet);

}  // namespace cdb::plans
