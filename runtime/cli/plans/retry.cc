#include "runtime/cli/plans/retry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <string_view>
#include <system_error>

#include "dsl/diagnostics.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/protocol/machine/noise.h"
#include "runtime/sweep/schedule/folder.h"

namespace cdb::plans {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kNoisy = "noisy";
constexpr std::string_view kWords[] = {"failed", "crashed", "timed_out", kNoisy};

/// Journals beside a complete result were left by a runner that was killed right after its merge.
void RemoveLeftovers(const plan::Plan& plan, const fs::path& folder, bool is_complete) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  FolderLock lock(folder);
  if (!lock.TryLockAlone())
    throw options::CommandError(
        fmt::format("another cdb is running in '{}'; retry when it has ended", folder.string()));
  if ((!is_complete || IsMadeAnew(plan, folder)) && HasRuns(folder))
    throw options::CommandError(fmt::format(
        "'{}' has finished runs that are not merged yet; run the command without --retry first",
        folder.string()));
  RemoveMergedRuns(plan, folder);
}

}  // namespace

RetryChoice::RetryChoice(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (std::ranges::find(kWords, word) == std::end(kWords))
      throw options::CommandError(
          fmt::format("--retry {}: {}", word,
                      options::Suggestion(word, {std::begin(kWords), std::end(kWords)},
                                          fmt::format("there are {}", fmt::join(kWords, ", ")))));
    words_.insert(word);
  }
}

RetryChoice RetryChoice::Only(const std::string& run_id) {
  RetryChoice choice;
  choice.words_ = {run_id};
  return choice;
}

bool RetryChoice::Wants(const results::ResultFile& file, const results::ResultFile::Cell& cell,
                        const std::string& run_id) const {
  if (words_.contains(run_id) ||
      words_.contains(std::string(results::StatusName(file.ReadStatus(cell)))))
    return true;
  return words_.contains(std::string(kNoisy)) && file.Has("noise") &&
         file.ReadReal("noise", cell) == static_cast<double>(machine::Noise::kNoisy);
}

bool RetryChoice::Wants(const journal::RunInfo& run) const {
  return words_.contains(run.run_id) ||
         words_.contains(std::string(results::StatusName(run.outcome.status))) ||
         (words_.contains(std::string(kNoisy)) && run.is_noisy);
}

std::string RetryChoice::Text() const { return fmt::format("{}", fmt::join(words_, ",")); }

RetryChoice RetryChoice::FromText(const std::string& text) {
  RetryChoice choice;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');)
    if (!word.empty()) choice.words_.insert(word);
  return choice;
}

RetryChoice RetryChoice::With(const RetryChoice& other) const {
  RetryChoice both = *this;
  both.words_.insert(other.words_.begin(), other.words_.end());
  return both;
}

RetryChoice FindStartedRetry(const fs::path& folder) {
  return RetryChoice::FromText(journal::FindRequest(folder, journal::kRetry));
}

KeptRuns::KeptRuns(const fs::path& out, RetryChoice retry)
    : file_(out),
      retry_(std::move(retry)),
      leaves_missing_(!retry_.is_empty() && plan::ChoosesRuns(file_.axes())) {}

bool KeptRuns::Has(const std::string& id, const std::vector<std::size_t>& at,
                   std::uint64_t rep) const {
  const results::ResultFile::Cell cell = {at, rep};
  if (file_.ReadStatus(cell) == results::Status::kMissing) return leaves_missing_;
  return !retry_.Wants(file_, cell, id);
}

std::size_t KeptRuns::CountOthers(const plan::Plan& plan) const {
  std::size_t others = 0;
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    others += !Has(id, at, rep);
  });
  return others;
}

std::optional<journal::RunInfo> KeptRuns::Find(const plan::Run& run) const {
  if (!Has(run.id, run.at, run.rep)) return std::nullopt;
  const results::ResultFile::Cell cell = {run.at, run.rep};
  journal::RunInfo info = {
      run.id, {file_.ReadStatus(cell), protocol::Verdict::kUnknown}, {}, {}, false};
  if (file_.Has("omitted")) info.omitted = file_.ReadText("omitted", cell);
  if (file_.Has("needs")) info.decisions = file_.ReadText("needs", cell);
  return info;
}

std::string PrepareRetry(const plan::Plan& plan, const fs::path& folder, const fs::path& out,
                         const RetryChoice& retry, bool is_complete) {
  RemoveLeftovers(plan, folder, is_complete);
  if (KeptRuns(out, retry).CountOthers(plan) > 0) return {};
  return fmt::format("no run of '{}' is {}; nothing to repeat\n", out.string(),
                     fmt::join(retry.Words(), " or "));
}

std::size_t CountNotRunAgain(const plan::Plan& plan, const fs::path& folder, const fs::path& out) {
  std::error_code error;
  const RetryChoice retry = FindStartedRetry(folder);
  if (retry.is_empty() || !fs::exists(out, error)) return 0;
  const KeptRuns kept(out, retry);
  const journal::Journals journals({folder});
  std::size_t missing = 0;
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    missing += !kept.Has(id, at, rep) && !journals.Has(id);
  });
  return missing;
}

}  // namespace cdb::plans
