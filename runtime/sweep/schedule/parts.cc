#include "runtime/sweep/schedule/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include "dsl/text/check.h"
#include "runtime/sweep/process/worker.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/order.h"

namespace cdb::schedule {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t Summary::*kCounts[] = {&Summary::done, &Summary::failed, &Summary::crashed,
                                             &Summary::timed_out, &Summary::spoiled};

/// The marks of the parts of all shards of a plan, as requests in the journals of its folder.
class PartMarks {
 public:
  PartMarks(const plan::Plan& plan, const fs::path& folder, std::uint64_t shards,
            std::uint64_t part_runs)
      : plan_sha256_(plan.whole->sha256), shards_(shards), marks_(journal::FindRequests(folder)) {
    const std::uint64_t runs = plan.RunCount() / shards;
    parts_ = std::max<std::uint64_t>(1, (runs + part_runs - 1) / part_runs);
  }
  /// The number of parts of each shard.
  std::uint64_t parts() const { return parts_; }
  /// The summary of the runs of a part; nullopt if it is not marked, or is marked for another plan.
  /// `shard` from 1, `part` from 0.
  std::optional<Summary> Read(std::uint64_t shard, std::uint64_t part) const {
    const auto found = marks_.find(Name(shard, part));
    std::istringstream in(found == marks_.end() ? "" : found->second);
    std::string sha256;
    if (!(in >> sha256) || sha256 != plan_sha256_) return std::nullopt;
    Summary summary;
    for (const auto count : kCounts)
      if (!(in >> summary.*count)) return std::nullopt;
    summary.resumed = summary.ended();
    return summary;
  }
  void Write(std::uint64_t shard, std::uint64_t part, const Summary& summary,
             const fs::path& folder) const {
    std::string text = plan_sha256_;
    for (const auto count : kCounts) text += fmt::format(" {}", summary.*count);
    journal::Ask(folder, plan_sha256_, Name(shard, part), text);
  }
  /// The number of runs of all marked parts.
  std::uint64_t CountRuns() const {
    std::uint64_t runs = 0;
    for (std::uint64_t shard = 1; shard <= shards_; ++shard)
      for (std::uint64_t part = 0; part < parts_; ++part)
        if (const auto there = Read(shard, part)) runs += there->ended();
    return runs;
  }

 private:
  std::string Name(std::uint64_t shard, std::uint64_t part) const {
    return fmt::format("part {} of {}", (shard - 1) * parts_ + part + 1, shards_ * parts_);
  }

  const std::string plan_sha256_;
  const std::uint64_t shards_;
  const std::map<std::string, std::string> marks_;
  std::uint64_t parts_;
};

void Add(const Summary& part, Summary& all) {
  for (const auto count : kCounts) all.*count += part.*count;
  all.resumed += part.resumed;
  all.left += part.left;
  all.signal = part.signal;
}

}  // namespace

std::vector<std::uint64_t> FindUnmarkedShards(const plan::Plan& plan, const fs::path& folder,
                                              std::uint64_t shards, std::uint64_t part_runs) {
  CDB_CHECK(plan.whole != nullptr);
  const PartMarks marks(plan, folder, shards, part_runs);
  const bool are_all_there = marks.CountRuns() <= journal::CountRuns(folder);
  std::vector<std::uint64_t> unmarked;
  for (std::uint64_t shard = 1; shard <= shards; ++shard)
    for (std::uint64_t part = 0; part < marks.parts(); ++part)
      if (!are_all_there || !marks.Read(shard, part)) {
        unmarked.push_back(shard);
        break;
      }
  return unmarked;
}

Summary ExecuteParts(const plan::Plan& plan, const ListPart& list, const ExecuteOptions& options,
                     process::Launcher& launcher, ProgressListener& listener,
                     std::uint64_t part_runs) {
  CDB_CHECK(plan.whole != nullptr);
  const std::uint64_t shards = options.shard.count;
  CheckShard(options.shard);
  const PartMarks marks(plan, options.folder, shards, part_runs);
  const std::uint64_t parts = marks.parts(), shard = options.shard.index;
  std::uint64_t marked = 0;
  if (options.start == SweepStart::kResume)
    for (std::uint64_t part = 0; part < parts; ++part)
      if (const auto there = marks.Read(shard, part)) marked += there->ended();
  const std::uint64_t runs = plan.RunCount() / shards;
  Demand demand = LeastDemand(plan, std::max<std::size_t>(options.jobs, 1), shards);
  const double left = 1 - static_cast<double>(std::min(marked, runs)) /
                              static_cast<double>(std::max<std::uint64_t>(runs, 1));
  demand.time *= left;
  demand.disk *= left;
  // Where some are found elsewhere or not wanted yet, each part is held against what is free when
  // it begins: all that `repeats` allows may be many times what is run.
  if (!options.find_elsewhere) CheckFits(plan.benchmark, demand, options.folder);
  const bool heeds_marks = !options.is_repeated && !options.find_elsewhere && marked > 0 &&
                           journal::CountRuns(options.folder) >= marked;
  ExecuteOptions one = options;
  one.shard = {};
  Summary all;
  for (std::uint64_t part = 0; part < parts && all.signal == 0; ++part) {
    if (const auto there = heeds_marks ? marks.Read(shard, part) : std::nullopt) {
      Add(*there, all);
      continue;
    }
    listener.BeginPart(part, parts);
    const Summary summary =
        Execute(list((shard - 1) * parts + part, shards * parts), one, launcher, listener);
    one.start = SweepStart::kResume;
    Add(summary, all);
    // A mark means that the folder has every run of the part.
    if (summary.signal == 0 && summary.left == 0 && !options.find_elsewhere)
      marks.Write(shard, part, summary, options.folder);
  }
  return all;
}

Summary ExecuteParts(const plan::Plan& plan, const ListPart& list, const ExecuteOptions& options,
                     ProgressListener& listener) {
  process::ProcessLauncher launcher(process::FindWorkers(plan),
                                    std::max<std::size_t>(options.jobs, 1), options.stop);
  return ExecuteParts(plan, list, options, launcher, listener);
}

}  // namespace cdb::schedule
