// The shards beside a results file: where they are, who works with them, and when they may go.
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

/// `out` is there and holds every run of the plan. Throws CommandError where it holds the results
/// of another plan, with `hint` at the end, StoreError where it is damaged.
bool IsThereAlready(const std::filesystem::path& out, const plan::Plan& plan,
                    std::string_view hint = {});

/// Throws CommandError where `out` is there and is not the results of the plan.
void CheckIsOfPlan(const std::string& out, const plan::Plan& plan);

std::size_t CountMissing(const store::ResultFile& file, const plan::Plan& plan);

/// Merges the shards into `out`, which keeps the runs that it has and that have no shard. Throws
/// StoreError; then `out` is as before.
void MergeOnto(const plan::Plan& plan, const std::vector<std::filesystem::path>& shards,
               const std::filesystem::path& out);

/// Says to other runners that somebody works in a folder of shards. Shared while runs are
/// executed; the last one out gets it for itself, and only then may shards be removed.
class FolderLock {
 public:
  /// Makes the folder where there is none. Throws CommandError.
  explicit FolderLock(const std::filesystem::path& folder);
  /// A folder that nothing came into goes again.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// False where another runner is at work, or the file system knows no locks.
  bool TakeForMyself();
  /// False where the file system knows no locks: then nobody can tell whether others are at work.
  bool is_known() const { return is_known_; }

 private:
  std::filesystem::path folder_;
  plan::Descriptor fd_;
  bool is_known_ = true;
};

/// Stands in a folder of shards while `--fresh` is at work for the plan with that hash: what is
/// there is newer than the result, and the next run goes on with it.
std::filesystem::path FreshMark(const std::filesystem::path& folder);
bool IsMadeAnew(const plan::Plan& plan, const std::filesystem::path& folder);

bool HasShards(const std::filesystem::path& folder);

/// Removes the shards that `Merge` has verified, and the files that belong to them. Throws
/// StoreError.
void RemoveShards(const plan::Plan& plan, const std::filesystem::path& folder);
/// The same where nobody else is at work, by a lock that is given up for it. Where others are, the
/// last one removes them; where the file system knows no locks, the shards stay, and it is said.
void RemoveMergedShards(const plan::Plan& plan, const std::filesystem::path& folder,
                        FolderLock& lock, bool is_quiet);

}  // namespace cdb::plans
