#include "runtime/cli/plans/sweep_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>

#include "runtime/cli/options/provenance.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/points.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/journal/merge.h"
#include "runtime/results/store.h"
#include "runtime/sweep/cluster/submission.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/terminal/console.h"

namespace cdb::plans {
namespace {

namespace fs = std::filesystem;

/// Empty where it cannot be read.
std::string PlanOf(const std::string& results) {
  try {
    return results::ResultFile(results, results::ProofOf::kStructure).plan_sha256();
  } catch (const files::StoreError&) {
    return {};
  }
}

}  // namespace

bool IsOfEarlierFormat(const results::ResultFile& file, const plan::Plan& plan) {
  std::optional<plan::Plan> there = figures::ReadPlan(file);
  if (!there || there->version == plan::kPlanVersion) return false;
  there->Renew();
  return there->Sha256() == plan.Sha256();
}

bool Exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

fs::path RunsFolderOf(const fs::path& out) {
  fs::path folder = out;
  if (out.extension() == ".h5") folder.replace_extension();
  return folder += ".runs";
}

bool IsThereAlready(const fs::path& out, const plan::Plan& plan, std::string_view hint) {
  std::error_code error;
  if (!fs::exists(out, error)) return false;
  const results::ResultFile file(out);
  if (file.plan_sha256() == plan.Sha256())
    return CountMissing(file, plan) == 0 && file.requirements() == plan.requirements;
  const bool is_earlier = IsOfEarlierFormat(file, plan);
  if (is_earlier && hint.empty() && CountMissing(file, plan) == 0) return true;
  throw options::CommandError(fmt::format(
      "'{}' has the results of {} and was not changed; name another file by -o, or use --fresh "
      "to overwrite it{}",
      out.string(),
      is_earlier ? "an earlier cdb, which named its runs differently, so that none can be added,"
                 : "another plan",
      is_earlier ? "" : hint));
}

void CheckIsOfPlan(const std::string& out, const plan::Plan& plan) {
  std::error_code error;
  if (!fs::exists(out, error)) return;
  const std::string sha256 = PlanOf(out);
  if (sha256 == plan.Sha256()) return;
  if (sha256.empty())
    throw options::CommandError(
        fmt::format("'{}' exists but is not a results file, or is damaged; it was not changed: "
                    "remove it, or name another file (-o)",
                    out));
  throw options::CommandError(fmt::format(
      "'{}' has the results of another plan and was not changed; name another file", out));
}

std::size_t CountMissing(const results::ResultFile& file, const plan::Plan& plan) {
  std::size_t missing = 0;
  plan.ForEachRun([&](const std::string&, const auto& at, std::uint64_t rep) {
    missing += file.ReadStatus({at, rep}) == results::Status::kMissing;
  });
  return missing;
}

std::size_t CountLeftOut(const results::ResultFile& file, const plan::Plan& plan) {
  std::size_t left_out = 0;
  plan.ForEachRun([&](const std::string&, const auto& at, std::uint64_t rep) {
    left_out += file.ReadStatus({at, rep}) == results::Status::kSkipped;
  });
  return left_out;
}

void MergeOnto(const plan::Plan& plan, const std::vector<fs::path>& places, const fs::path& out) {
  std::error_code error;
  journal::Merge(plan, options::CollectProvenance(), places, out,
                 fs::exists(out, error) ? out : fs::path(), searches::AnswersToStore);
}

void JudgeAnew(const plan::Plan& plan, const fs::path& out) {
  std::error_code error;
  if (!fs::exists(out, error)) return;
  const results::ResultFile file(out);
  if (file.plan_sha256() != plan.Sha256() || file.requirements() == plan.requirements) return;
  std::vector<fs::path> places;
  if (const fs::path folder = RunsFolderOf(out); fs::exists(folder, error))
    places.push_back(folder);
  MergeOnto(plan, places, out);
}

FolderLock::FolderLock(const fs::path& folder) : folder_(folder) {
  for (;;) {
    std::error_code error;
    fs::create_directories(folder, error);
    fd_ = plan::Descriptor(error ? -1 : open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd_.get() < 0)
      throw options::CommandError(
          fmt::format("cannot make the folder '{}' for the finished runs: {}; nothing was changed: "
                      "choose another "
                      "place by -o",
                      folder.string(), error ? error.message() : std::strerror(errno)));
    int locked = 0;
    while ((locked = flock(fd_.get(), LOCK_SH)) != 0 && errno == EINTR) {
    }
    // If the file system does not support locks, users must not start two runners on one result.
    is_known_ = locked == 0;
    if (plan::IsAt(fd_.get(), folder)) return;
    // The folder was removed by the runner that held it.
  }
}

FolderLock::~FolderLock() {
  if (TryLockAlone()) rmdir(folder_.c_str());
}

bool FolderLock::TryLockAlone() {
  if (flock(fd_.get(), LOCK_EX | LOCK_NB) == 0) return true;
  // NFS may grant a shared lock on a folder that is open for reading, but never an exclusive one.
  if (errno != EWOULDBLOCK && errno != EINTR) is_known_ = false;
  return false;
}

bool IsMadeAnew(const plan::Plan& plan, const fs::path& folder) {
  return journal::FindRequest(folder, journal::kFresh) == plan.Sha256();
}

bool HasRuns(const fs::path& folder) {
  schedule::RefuseEarlierShards(folder);
  try {
    return journal::CountRuns(folder) > 0;
  } catch (const journal::DamagedJournal&) {
    return true;
  }
}

void RemoveMergedRuns(const plan::Plan& plan, const fs::path& folder) {
  cluster::RemoveSubmission(folder);
  schedule::RemoveSweep(folder, plan.Sha256());
}

void RemoveMergedRuns(const plan::Plan& plan, const fs::path& folder, FolderLock& lock,
                      bool is_quiet) {
  if (lock.TryLockAlone()) return RemoveMergedRuns(plan, folder);
  if (!lock.is_known() && !is_quiet)
    terminal::Say(fmt::format(
        "'{}' is on a file system without locks, so that nobody can tell whether another cdb works "
        "there: its runs are merged, and its journals stay; remove the folder when no other is at "
        "work\n",
        folder.string()));
}

}  // namespace cdb::plans
