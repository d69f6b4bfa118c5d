#include "runtime/schedule/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>

#include "compiler/plan/input_file.h"
#include "dsl/check.h"
#include "runtime/process/worker.h"
#include "runtime/schedule/folder.h"
#include "runtime/store/safe_file.h"

namespace cdb::schedule {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t Summary::*kCounts[] = {&Summary::done, &Summary::failed, &Summary::crashed,
                                             &Summary::timed_out, &Summary::spoiled};

/// How the runs of a part ended; nullopt where it is not marked, or for another plan.
std::optional<Summary> ReadMark(const fs::path& mark, const std::string& plan_sha256) {
  std::string why, sha256;
  std::istringstream in(plan::ReadInputFile(mark, why).value_or(""));
  if (!(in >> sha256) || sha256 != plan_sha256) return std::nullopt;
  Summary summary;
  for (const auto count : kCounts)
    if (!(in >> summary.*count)) return std::nullopt;
  summary.resumed = summary.ended();
  return summary;
}

void WriteMark(const Summary& summary, const fs::path& mark, const std::string& plan_sha256) {
  std::string text = plan_sha256;
  for (const auto count : kCounts) text += fmt::format(" {}", summary.*count);
  store::WriteWhole(text + "\n", mark);
}

void Add(const Summary& part, Summary& all) {
  for (const auto count : kCounts) all.*count += part.*count;
  all.resumed += part.resumed;
  all.left += part.left;
  all.signal = part.signal;
}

}  // namespace

Summary ExecuteParts(const plan::Plan& plan, const ListPart& list, const ExecuteOptions& options,
                     process::Launcher& launcher, ProgressListener& listener,
                     std::uint64_t part_runs) {
  CDB_CHECK(plan.whole != nullptr);
  const std::uint64_t shards = options.shard.count;
  CheckShard(options.shard);
  const std::uint64_t runs = plan.RunCount() / shards;
  const std::uint64_t parts = std::max<std::uint64_t>(1, (runs + part_runs - 1) / part_runs);
  const auto mark_of = [&](std::uint64_t part) {
    return options.folder / PartMarkName((options.shard.index - 1) * parts + part, shards * parts);
  };
  std::uint64_t marked = 0;
  if (!options.fresh)
    for (std::uint64_t part = 0; part < parts; ++part)
      if (const auto there = ReadMark(mark_of(part), plan.whole->sha256)) marked += there->ended();
  const bool heeds_marks = !options.is_repeated && !options.find_elsewhere && marked > 0 &&
                           CountShards(options.folder) >= marked;
  ExecuteOptions one = options;
  one.shard = {};
  Summary all;
  for (std::uint64_t part = 0; part < parts && all.signal == 0; ++part) {
    if (const auto there =
            heeds_marks ? ReadMark(mark_of(part), plan.whole->sha256) : std::nullopt) {
      Add(*there, all);
      continue;
    }
    listener.BeginPart(part, parts);
    const Summary summary = Execute(list((options.shard.index - 1) * parts + part, shards * parts),
                                    one, launcher, listener);
    one.fresh = false;
    Add(summary, all);
    if (summary.signal == 0 && summary.left == 0)
      WriteMark(summary, mark_of(part), plan.whole->sha256);
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
