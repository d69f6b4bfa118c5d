#include "runtime/sweep/schedule/folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/files/local_disk.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/sweep/process/launcher.h"

namespace cdb::schedule {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBrokenEnding = ".broken";
/// A journal that another machine writes is opened anew to see how it has grown.
constexpr std::chrono::seconds kLookAgain{1};

/// `0123456789abcdef.h5`, or the same set aside as broken.
bool IsShardName(std::string_view name) {
  constexpr std::size_t kIdDigits = 16;
  return (name.ends_with(".h5") || name.ends_with(".h5.broken")) &&
         name.find_first_not_of("0123456789abcdef") == kIdDigits && name[kIdDigits] == '.';
}

bool IsBrokenJournal(std::string_view name) {
  return name.find(std::string(journal::kEnding) + std::string(kBrokenEnding)) != name.npos;
}

[[noreturn]] void FailStore(std::string_view doing, const fs::path& file, int error) {
  throw files::StoreError(fmt::format("cannot {} {}: {}", doing, file.string(),
                                      std::generic_category().message(error)));
}

void RemoveFile(const fs::path& file) {
  if (unlink(file.c_str()) != 0 && errno != ENOENT) FailStore("remove", file, errno);
}

template <typename Visit>
void ForEachName(const fs::path& folder, Visit visit) {
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error))
    visit(entry->path().filename().string());
  if (error) FailStore("read the folder", folder, error.value());
}

/// Removes plans, and what earlier versions and damage have left.
void RemoveOtherFiles(const fs::path& folder) {
  ForEachName(folder, [&](const std::string& name) {
    if (name == kPlanName || name == kShortPlanName || IsShardName(name) || IsBrokenJournal(name))
      RemoveFile(folder / name);
  });
}

}  // namespace

void RefuseEarlierShards(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return;
  ForEachName(folder, [&](const std::string& name) {
    if (!IsShardName(name)) return;
    throw process::ScheduleError(fmt::format(
        "{} was written by an earlier version of cdb, which kept each finished run in a file; it "
        "was left as it is: end the sweep with that version, or start over with --fresh",
        (folder / name).string()));
  });
}

void RemoveSweep(const fs::path& folder, const std::string& plan_sha256) {
  for (const fs::path& file : journal::JournalsIn(folder)) try {
      const auto journal = journal::Journal::OpenToRead(file);
      if (!journal.plan_sha256().empty() && journal.plan_sha256() != plan_sha256) return;
    } catch (const journal::DamagedJournal&) {
    }
  journal::RemoveJournals(folder);
  for (const char* name : {kPlanName, kShortPlanName}) RemoveFile(folder / name);
  ForEachName(folder, [&](const std::string& name) {
    if (IsBrokenJournal(name)) RemoveFile(folder / name);
  });
  std::error_code ignored;
  fs::remove(folder, ignored);
}

SweepFolder::SweepFolder(const plan::Plan& plan, fs::path folder, SweepStart start)
    : folder_([&] {
        std::error_code error;
        fs::create_directories(folder, error);
        if (error) FailStore("make the folder", folder, error.value());
        return std::move(folder);
      }()),
      plan_sha256_(plan.Sha256()),
      own_path_(journal::OwnJournal(folder_)),
      is_local_(files::IsOnLocalDisk(folder_)) {
  if (start == SweepStart::kResume) RefuseOthers();
  files::RemoveStaleTemporaries(folder_);
  if (start != SweepStart::kResume) StartOver(start == SweepStart::kFreshForResult);
}

void SweepFolder::StartOver(bool is_newer) {
  const std::string asked = is_newer ? journal::kFresh : "";
  RemoveOtherFiles(folder_);
  std::error_code error;
  if (fs::exists(own_path_, error)) try {
      own_.emplace(journal::Journal::OpenToWrite(folder_, plan_sha256_));
      own_->Restart(plan_sha256_, asked);
      for (const fs::path& file : journal::JournalsIn(folder_))
        if (file != own_path_) RemoveFile(file);
      return;
    } catch (const files::StoreError&) {
      own_.reset();  // it cannot be read
    }
  journal::RemoveJournals(folder_);
  if (!is_newer) return;
  own_.emplace(journal::Journal::OpenToWrite(folder_, plan_sha256_));
  own_->Restart(plan_sha256_, asked);
}

void SweepFolder::RefuseOthers() {
  RefuseEarlierShards(folder_);
  for (const fs::path& file : journal::JournalsIn(folder_)) {
    std::string plan;
    try {
      plan = journal::Journal::OpenToRead(file).plan_sha256();
    } catch (const journal::DamagedJournal&) {
      continue;  // set aside when a run is looked for
    }
    if (plan.empty() || plan == plan_sha256_) continue;
    throw process::ScheduleError(fmt::format(
        "{} is of another plan; two plans are never mixed in one folder. Name another result "
        "by -o, or discard the runs in {} by --fresh",
        file.string(), folder_.string()));
  }
}

/// Opens journals that have appeared, and those that other machines have written since.
void SweepFolder::LookAgain() {
  if (own_) own_->RequireInPlace();
  const auto now = std::chrono::steady_clock::now();
  std::error_code error;
  const fs::file_time_type folder_time = fs::last_write_time(folder_, error);
  if (own_ && (is_local_ ? folder_time == listed_ : now - looked_ < kLookAgain)) return;
  listed_ = folder_time;
  looked_ = now;
  for (const fs::path& file : journal::JournalsIn(folder_)) {
    if (file == own_path_) {
      if (!own_) own_.emplace(journal::Journal::OpenToWrite(folder_, plan_sha256_));
      continue;
    }
    const fs::file_time_type changed = fs::last_write_time(file, error);
    const auto known = others_.find(file);
    if (known != others_.end()) {
      if (is_local_ || known->second.changed == changed || now - known->second.opened < kLookAgain)
        continue;
      others_.erase(known);
    }
    others_.insert({file, Other{journal::Journal::OpenToRead(file), changed, now}});
  }
}

template <typename Use>
auto SweepFolder::First(Warnings& warnings, Use use)
    -> decltype(use(std::declval<journal::Journal&>())) {
  constexpr int kMostDamaged = 100;
  for (int tries = 0;; ++tries) try {
      LookAgain();
      if (own_)
        if (auto value = use(*own_)) return value;
      for (auto& [path, other] : others_)
        if (auto value = use(other.journal)) return value;
      return {};
    } catch (const journal::DamagedJournal& damaged) {
      if (tries == kMostDamaged) throw;
      SetAside(damaged.path(), warnings);
    }
}

std::optional<journal::Record> SweepFolder::ReadFrom(journal::Journal& from,
                                                     const std::string& run_id,
                                                     Warnings& warnings) {
  try {
    return from.Read(run_id);
  } catch (const journal::DamagedRun& damaged) {
    // Without the advice to the user, which is followed here.
    const std::string why = damaged.what();
    warnings.push_back(
        fmt::format("{}; it is run again", why.substr(0, why.find("; it was left as it is"))));
    if (own_ && &from == &*own_) from.Forget(run_id);
    return std::nullopt;
  }
}

std::optional<journal::RunInfo> SweepFolder::Find(const plan::Run& run, Warnings& warnings) {
  return First(warnings, [&](journal::Journal& from) -> std::optional<journal::RunInfo> {
    const auto record = ReadFrom(from, run.id, warnings);
    if (!record) return std::nullopt;
    try {
      return journal::InfoOf(*record);
    } catch (const hdf5::Error&) {
      return std::nullopt;  // of another version of cdb
    }
  });
}

bool SweepFolder::Has(const plan::Run& run) {
  Warnings ignored;
  return First(ignored,
               [&](journal::Journal& from) {
                 return from.Has(run.id) ? std::optional(true) : std::nullopt;
               })
      .has_value();
}

journal::Record SweepFolder::Read(const std::string& run_id) {
  Warnings warnings;
  auto record =
      First(warnings, [&](journal::Journal& from) { return ReadFrom(from, run_id, warnings); });
  if (!record)
    throw files::StoreError(
        fmt::format("{}: has no intact record of the run {}{}", folder_.string(), run_id,
                    warnings.empty() ? std::string() : ": " + warnings.front()));
  return *std::move(record);
}

void SweepFolder::Write(const std::function<void(journal::Journal&)>& write, Warnings& warnings) {
  for (bool is_again = false;; is_again = true) try {
      if (!own_) own_.emplace(journal::Journal::OpenToWrite(folder_, plan_sha256_));
      return write(*own_);
    } catch (const journal::DamagedJournal& damaged) {
      if (is_again || damaged.path() != own_path_) throw;
      SetAside(own_path_, warnings);
    }
}

/// Keeps the runs that can be read from either end of the damaged file.
void SweepFolder::SetAside(const fs::path& damaged, Warnings& warnings) {
  own_.reset();
  others_.erase(damaged);
  listed_ = {};
  const fs::path broken = damaged.string() + std::string(kBrokenEnding);
  // Another runner may have set it aside already.
  if (rename(damaged.c_str(), broken.c_str()) != 0 && errno != ENOENT)
    FailStore("set aside", damaged, errno);
  rename((damaged.string() + "-wal").c_str(), (broken.string() + "-wal").c_str());
  unlink((damaged.string() + "-shm").c_str());
  own_.emplace(journal::Journal::OpenToWrite(folder_, plan_sha256_));
  std::size_t kept = 0;
  for (const bool reversed : {false, true}) try {
      auto from = journal::Journal::OpenToRead(broken);
      if (from.plan_sha256() != plan_sha256_) break;
      from.ForEachRun(
          [&](const journal::Journal::Row& row) {
            try {
              if (own_->Has(row.run_id)) return;
              const auto record = from.ReadRow(row.number);
              if (!record) return;
              own_->Write(*record);
              ++kept;
            } catch (const journal::DamagedRun&) {
            }
          },
          0, reversed);
    } catch (const journal::DamagedJournal&) {
    }
  warnings.push_back(
      fmt::format("{}: is damaged; it is now {}; {} of its runs could be read and "
                  "are kept, and others are run again",
                  damaged.string(), broken.filename().string(), kept));
}

void SweepFolder::WritePlan(const plan::Plan& plan) const {
  const std::string text = plan.whole ? plan.whole->short_text : yaml::ToYaml(plan);
  const fs::path file = folder_ / kPlanName;
  std::string why;
  if (plan::ReadInputFile(file, why) == text) return;
  std::error_code ignored;
  fs::remove(folder_ / kShortPlanName, ignored);
  files::WriteWhole(text, file);
}

void SweepFolder::WriteShortPlan(const std::string& text) const {
  files::WriteWhole(text, folder_ / kShortPlanName);
}

}  // namespace cdb::schedule
