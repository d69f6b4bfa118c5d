// The folder of shards: the runs of a plan that it contains, and checks of its contents.
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

/// The plan in its short form, the texts that it is compiled from (compiler/yaml/short_plan.h). In
/// the folder beside a plan.yaml that lists its runs, because it is faster to read.
inline constexpr const char* kShortPlanName = "plan.short.yaml";
/// The file in the folder that holds the runs to run again (`cdb run --retry`) until they have
/// ended.
inline constexpr const char* kRetryMarkName = "retry";
/// The mark, in the folder, of a part that has ended (runtime/schedule/parts.h).
std::string PartMarkName(std::uint64_t part, std::uint64_t count);
/// The id in the name of a shard; empty for other names.
std::string RunIdOfShard(std::string_view name);
/// The number of files in the folder with names of shards; 0 if there is no folder. Throws
/// StoreError.
std::uint64_t CountShards(const std::filesystem::path& folder);
/// Removes the shards of one plan, its plan and the marks of parts, and then the folder if it is
/// empty. All shards in the folder must be of that plan. Throws StoreError.
void RemoveWholePlan(const std::filesystem::path& folder);

/// A folder of shards of one plan. Keeps no file open. Not thread-safe.
class ShardFolder {
 public:
  /// Creates the folder, removes temporaries left by killed processes of this machine, and removes
  /// its shards if `fresh`. Throws StoreError; ScheduleError if it holds a shard of a run that is
  /// not in the plan, and then nothing was changed.
  ShardFolder(const plan::Plan& plan, std::filesystem::path folder, bool fresh);

  /// The facts in the shard of a run, if it has an intact one. A broken shard is set aside as
  /// `<name>.broken` and reported in `warnings`. Throws ScheduleError for a shard of another plan,
  /// StoreError for one that cannot be read.
  std::optional<shards::ShardInfo> Find(const plan::Run& run,
                                        std::vector<std::string>& warnings) const;

  /// The path of the shard of a run, whether it exists or not.
  std::filesystem::path ShardOf(const plan::Run& run) const;
  /// True if the file exists.
  bool Has(const plan::Run& run) const;

  /// Writes this plan to `plan.yaml`, in one step. Call once no shard was refused. Throws
  /// StoreError.
  void WritePlan(const plan::Plan& plan) const;
  /// Writes the short form of the plan in plan.yaml. Throws StoreError.
  void WriteShortPlan(const std::string& text) const;

  const std::filesystem::path& path() const { return folder_; }

 private:
  void RefuseOthers(const plan::Plan& plan) const;
  void RefuseOtherWhole() const;

  std::filesystem::path folder_;
  std::string plan_sha256_;
};

}  // namespace cdb::schedule
