#include "runtime/schedule/folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "runtime/process/launcher.h"
#include "runtime/store/files/safe_file.h"

namespace cdb::schedule {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlanName = "plan.yaml";
constexpr std::string_view kShardEnding = ".h5";
constexpr std::string_view kBrokenEnding = ".h5.broken";

/// `0123456789abcdef.h5` → the run's id. Other files are not our shards and are left alone.
std::string ShardRunId(std::string_view name, std::string_view ending) {
  constexpr std::size_t kIdDigits = 16;
  if (name.size() != kIdDigits + ending.size() || !name.ends_with(ending)) return {};
  const std::string id(name.substr(0, kIdDigits));
  return id.find_first_not_of("0123456789abcdef") == std::string::npos ? id : std::string();
}

[[noreturn]] void FailStore(std::string_view doing, const fs::path& file, int error) {
  throw files::StoreError(fmt::format("cannot {} {}: {}", doing, file.string(),
                                      std::generic_category().message(error)));
}

constexpr std::string_view kMarkBegin = "part-", kMarkEnding = ".done";

bool IsPartMark(std::string_view name) {
  return name.starts_with(kMarkBegin) && name.ends_with(kMarkEnding);
}

template <typename Visit>
void ForEachName(const fs::path& folder, Visit visit) {
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error))
    visit(entry->path().filename().string());
  if (error) FailStore("read the folder", folder, error.value());
}

/// The format of the plan in the folder, if an earlier cdb wrote it.
std::optional<int> EarlierFormat(const fs::path& folder) {
  std::string why;
  const auto text = plan::ReadInputFile(folder / kPlanName, why);
  const auto version = text ? yaml::FindPlanVersion(*text) : std::nullopt;
  return version && *version < plan::kPlanVersion ? version : std::nullopt;
}

[[noreturn]] void RefuseMixture(const fs::path& file) {
  if (const auto version = EarlierFormat(file.parent_path()))
    throw process::ScheduleError(fmt::format(
        "{} holds runs that an earlier cdb finished (plan format {}). This cdb names runs "
        "differently and cannot use them: finish the sweep with the earlier cdb, or name another "
        "result with -o, or start over with --fresh",
        file.parent_path().string(), *version));
  throw process::ScheduleError(fmt::format(
      "{} is {} another plan; two plans are never mixed in one folder. Name another result "
      "with -o, or forget what {} holds with --fresh",
      file.string(), file.filename() == kPlanName ? "of" : "a shard of",
      file.parent_path().string()));
}

/// Removes shards (including broken ones), plans and marks.
void RemoveFilesOfPlans(const fs::path& folder) {
  ForEachName(folder, [&](const std::string& name) {
    if (ShardRunId(name, kShardEnding).empty() && ShardRunId(name, kBrokenEnding).empty() &&
        name != kPlanName && name != kShortPlanName && name != kRetryMarkName && !IsPartMark(name))
      return;
    const fs::path file = folder / name;
    if (unlink(file.c_str()) != 0 && errno != ENOENT) FailStore("remove", file, errno);
  });
}

}  // namespace

std::string PartMarkName(std::uint64_t part, std::uint64_t count) {
  return fmt::format("{}{}-of-{}{}", kMarkBegin, part + 1, count, kMarkEnding);
}

std::string RunIdOfShard(std::string_view name) { return ShardRunId(name, kShardEnding); }

std::uint64_t CountShards(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) return 0;
  std::uint64_t count = 0;
  ForEachName(folder,
              [&](const std::string& name) { count += !ShardRunId(name, kShardEnding).empty(); });
  return count;
}

void RemoveWholePlan(const fs::path& folder) {
  RemoveFilesOfPlans(folder);
  std::error_code ignored;
  fs::remove(folder, ignored);
}

ShardFolder::ShardFolder(const plan::Plan& plan, fs::path folder, bool fresh)
    : folder_(std::move(folder)), plan_sha256_(plan.Sha256()) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) FailStore("make the folder", folder_, error.value());
  if (!fresh) RefuseOthers(plan);
  files::RemoveStaleTemporaries(folder_);
  if (fresh) RemoveFilesOfPlans(folder_);
}

/// Compares with the plan in the folder, because computing the ids of all runs would take long.
void ShardFolder::RefuseOtherWhole() const {
  const fs::path file = folder_ / kPlanName;
  std::string why;
  if (const auto text = plan::ReadInputFile(file, why)) {
    if (EarlierFormat(folder_)) RefuseMixture(file);
    const auto there = yaml::FindShortPlan(*text, file.string());
    if (!there || there->sha256 != plan_sha256_) RefuseMixture(file);
    return;
  }
  ForEachName(folder_, [&](const std::string& name) {
    if (!ShardRunId(name, kShardEnding).empty()) RefuseMixture(folder_ / name);
  });
}

void ShardFolder::RefuseOthers(const plan::Plan& plan) const {
  if (plan.whole) return RefuseOtherWhole();
  std::unordered_set<std::string_view> ids;
  for (const plan::Run& run : plan.runs) ids.insert(run.id);
  for (const plan::Run& run : plan.references) ids.insert(run.id);
  ForEachName(folder_, [&](const std::string& name) {
    const std::string id = ShardRunId(name, kShardEnding);
    if (!id.empty() && !ids.contains(id)) RefuseMixture(folder_ / name);
  });
}

void ShardFolder::WritePlan(const plan::Plan& plan) const {
  const std::string text = plan.whole ? plan.whole->short_text : yaml::ToYaml(plan);
  const fs::path file = folder_ / kPlanName;
  std::string why;
  if (plan::ReadInputFile(file, why) == text) return;
  std::error_code ignored;
  fs::remove(folder_ / kShortPlanName, ignored);
  files::WriteWhole(text, file);
}

void ShardFolder::WriteShortPlan(const std::string& text) const {
  files::WriteWhole(text, folder_ / kShortPlanName);
}

fs::path ShardFolder::ShardOf(const plan::Run& run) const {
  return folder_ / (run.id + std::string(kShardEnding));
}

bool ShardFolder::Has(const plan::Run& run) const {
  std::error_code error;
  return fs::is_regular_file(ShardOf(run), error);
}

std::optional<shards::ShardInfo> ShardFolder::Find(const plan::Run& run,
                                                   std::vector<std::string>& warnings) const {
  const fs::path shard = ShardOf(run);
  // A file that the system refuses to open is not broken: setting it aside would hide an intact
  // shard.
  const int fd = open(shard.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 && errno == ENOENT) return std::nullopt;
  if (fd < 0) FailStore("read", shard, errno);
  close(fd);

  std::string fault;
  try {
    const shards::ShardInfo info = shards::ReadShardInfo(shard);
    if (info.plan_sha256 != plan_sha256_) RefuseMixture(shard);
    if (info.run_id == run.id && info.outcome.status != store::Status::kMissing &&
        info.outcome.status != store::Status::kSkipped)
      return info;
    fault = shard.string() + ": is the shard of another run";
  } catch (const files::StoreError& error) {
    // Without the advice to the user, which is followed here.
    fault = error.what();
    fault = fault.substr(0, fault.find("; it was left as it is"));
  }
  const fs::path broken = shard.string() + ".broken";
  // Another runner may have set it aside already.
  if (rename(shard.c_str(), broken.c_str()) != 0 && errno != ENOENT)
    FailStore("set aside", shard, errno);
  warnings.push_back(
      fmt::format("{}; it is now {}, and its run is run again", fault, broken.filename().string()));
  return std::nullopt;
}

}  // namespace cdb::schedule
