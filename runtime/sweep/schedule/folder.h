// The folder of an unfinished sweep: its plan, and the journals of its finished runs.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/journal/journals.h"

namespace cdb::schedule {

/// The plan, in the folder of its journals.
inline constexpr const char* kPlanName = "plan.yaml";
/// The plan in its short form, the texts that it is compiled from (compiler/yaml/short_plan.h). In
/// the folder beside a plan.yaml that lists its runs, because it is faster to read.
inline constexpr const char* kShortPlanName = "plan.short.yaml";

/// Throws ScheduleError if the folder holds a shard, a file of one run, as versions of cdb before
/// journals left them.
void RefuseEarlierShards(const std::filesystem::path& folder);

/// Removes the journals of the sweep of a plan and its plan file, and then the folder if it is
/// empty. Removes nothing if a journal is of another plan. No process may be at work in it. Throws
/// StoreError.
void RemoveSweep(const std::filesystem::path& folder, const std::string& plan_sha256);

enum class SweepStart {
  kResume,
  kFresh,           ///< what the folder holds is removed
  kFreshForResult,  ///< and the new runs are newer than the result beside it (journal::kFresh)
};

/// The folder of a sweep of one plan. Writes into one journal, and reads those of other processes,
/// as they grow. Not thread-safe; not to be used after a fork.
class SweepFolder {
 public:
  /// Creates the folder, and removes temporaries left by killed processes of this machine. Throws
  /// StoreError; ScheduleError if it holds runs of another plan, and then nothing was changed.
  SweepFolder(const plan::Plan& plan, std::filesystem::path folder, SweepStart start);

  using Warnings = std::vector<std::string>;
  /// The facts of a run, if it has finished. A damaged record is removed, and a damaged journal set
  /// aside as `<name>.broken`, with a warning. Throws StoreError if a journal cannot be read.
  std::optional<journal::RunInfo> Find(const plan::Run& run, Warnings& warnings);
  bool Has(const plan::Run& run);
  /// Throws StoreError if it is not there.
  journal::Record Read(const std::string& run_id);

  /// Calls `write` with the journal of this process, which is created if there is none; once more,
  /// with a new one, if it is damaged.
  void Write(const std::function<void(journal::Journal&)>& write, Warnings& warnings);

  /// Writes this plan to `plan.yaml`, in one step. Call once the folder was not refused. Throws
  /// StoreError.
  void WritePlan(const plan::Plan& plan) const;
  /// Writes the short form of the plan in plan.yaml. Throws StoreError.
  void WriteShortPlan(const std::string& text) const;

  const std::filesystem::path& path() const { return folder_; }

 private:
  struct Other {
    journal::Journal journal;
    std::filesystem::file_time_type changed;
    std::chrono::steady_clock::time_point opened;
  };
  void StartOver(bool is_newer);
  void RefuseOthers();
  void LookAgain();
  std::optional<journal::Record> ReadFrom(journal::Journal& from, const std::string& run_id,
                                          Warnings& warnings);
  void SetAside(const std::filesystem::path& damaged, Warnings& warnings);
  /// Calls `use` for each journal until it returns a value. A damaged one is set aside.
  template <typename Use>
  auto First(Warnings& warnings, Use use) -> decltype(use(std::declval<journal::Journal&>()));

  const std::filesystem::path folder_;
  const std::string plan_sha256_;
  const std::filesystem::path own_path_;
  const bool is_local_;
  std::optional<journal::Journal> own_;
  std::map<std::filesystem::path, Other> others_;
  std::filesystem::file_time_type listed_;  ///< time of the folder when its journals were listed
  std::chrono::steady_clock::time_point looked_;
};

}  // namespace cdb::schedule
