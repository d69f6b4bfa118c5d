// The folder of shards: which runs of a plan it contains, and what must not be in it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/files/temporary_file.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"

namespace cdb::schedule {

/// The plan by the texts that it is compiled from (compiler/yaml/short_plan.h), in the folder
/// beside a plan.yaml that lists its runs: for readers in a hurry.
inline constexpr const char* kShortPlanName = "plan.short.yaml";
/// Holds what is run again (`cdb run --retry`) until that has ended, in the folder.
inline constexpr const char* kRetryMarkName = "retry";
/// The mark of a part that has ended (runtime/schedule/parts.h), in the folder.
std::string PartMarkName(std::uint64_t part, std::uint64_t count);
/// The id in the name of a shard; empty for other names.
std::string RunIdOfShard(std::string_view name);
/// Files in the folder that are called like shards; 0 where there is no folder. Throws StoreError.
std::uint64_t CountShards(const std::filesystem::path& folder);
/// Removes the shards of one plan, its plan and marks of parts, and then the folder if it is empty.
/// To be called where all shards in it are of that plan. Throws StoreError.
void RemoveWholePlan(const std::filesystem::path& folder);

/// One folder of shards of one plan. Nothing is held open. Not for several threads.
class ShardFolder {
 public:
  /// Makes the folder, removes temporaries that killed processes of this machine left, and forgets
  /// its shards where `fresh`. Throws StoreError; ScheduleError where it holds a shard of a run
  /// that is not in the plan, and then nothing was changed.
  ShardFolder(const plan::Plan& plan, std::filesystem::path folder, bool fresh);

  /// What the shard of a run says, if it has a whole one. A broken one is set aside as
  /// `<name>.broken` and reported in `warnings`. Throws ScheduleError for a shard of another plan,
  /// StoreError for one that cannot be read.
  std::optional<shards::ShardInfo> Find(const plan::Run& run,
                                        std::vector<std::string>& warnings) const;

  /// Where the shard of a run is, or would be.
  std::filesystem::path ShardOf(const plan::Run& run) const;
  /// A file is there.
  bool Has(const plan::Run& run) const;

  /// Makes `plan.yaml` say this plan, in one step. To be called once no shard was refused. Throws
  /// StoreError.
  void WritePlan(const plan::Plan& plan) const;
  /// Of the plan in plan.yaml. Throws StoreError.
  void WriteShortPlan(const std::string& text) const;

  const std::filesystem::path& path() const { return folder_; }

 private:
  void RefuseOthers(const plan::Plan& plan) const;
  void RefuseOtherWhole() const;

  std::filesystem::path folder_;
  std::string plan_sha256_;
};

}  // namespace cdb::schedule
