#include "runtime/cli/plans/earlier_runs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/plan_changes.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/journal/merge_base.h"
#include "runtime/results/journal/run_writer.h"
#include "runtime/results/versions.h"
#include "runtime/sweep/cluster/submission.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/parts.h"

namespace cdb::plans {
namespace {

namespace fs = std::filesystem;

/// Facts of /provenance that are the same in runs of one cdb, Bullet and machine.
constexpr const char* kSame[] = {"cdb_version",    "commit",         "build_type", "compiler",
                                 "compiler_flags", "bullet_version", "host",       "cpu"};

/// Records that are copied in one commit.
constexpr std::size_t kAtOnce = 500;
constexpr std::size_t kMostBytesAtOnce = 64 << 20;

/// The plan of the unfinished sweep in the folder if it is another one; empty otherwise.
std::string FindOtherPlan(const fs::path& folder, const std::string& sha256) {
  for (const fs::path& file : journal::JournalsIn(folder)) try {
      const std::string plan = journal::Journal::OpenToRead(file).plan_sha256();
      if (!plan.empty() && plan != sha256) return plan;
    } catch (const journal::DamagedJournal&) {
    }
  return {};
}

/// Throws CommandError if another cdb, or jobs of `cdb submit`, may be at work in the folder.
void RequireAlone(FolderLock& lock, const fs::path& folder) {
  if (cluster::ReadSubmission(folder))
    throw options::CommandError(
        fmt::format("jobs of `cdb submit` may be at work in '{}', with another plan; nothing was "
                    "changed: name another result by -o, or discard their runs by --fresh",
                    folder.string()));
  if (!lock.TryLockAlone())
    throw options::CommandError(
        fmt::format("another cdb is at work in '{}', with another plan; nothing was changed: run "
                    "this one when it has ended, or name another result by -o",
                    folder.string()));
}

/// Calls `visit` for every run of a plan, with its scene.
void ForEachListed(const SizedPlan& sized, const std::function<void(const plan::Run&)>& visit) {
  if (sized.grid == nullptr) {
    for (const plan::Run& run : sized.plan.runs) visit(run);
    return;
  }
  const std::uint64_t parts = sized.plan.RunCount() / schedule::kPartRuns + 1;
  for (std::uint64_t part = 0; part < parts; ++part)
    for (const plan::Run& run : sized.ListPart(part, parts).runs) visit(run);
}

/// In what a run of this provenance differs from one that this process would make.
std::vector<std::string> UnlikeIn(const results::Provenance& made, const results::Provenance& now) {
  std::vector<std::string> unlike;
  const auto fact = [](const results::Provenance& facts, const char* name) {
    const auto found = facts.find(name);
    return found == facts.end() ? std::string() : found->second;
  };
  for (const char* name : kSame)
    if (fact(made, name) != fact(now, name)) unlike.emplace_back(name);
  return unlike;
}

/// Counts the finished runs of earlier results that are part of a plan.
class Counter {
 public:
  explicit Counter(const results::Provenance& now) : now_(now) {}

  /// True if the run is kept.
  bool Add(const results::Provenance& made) {
    const std::vector<std::string> unlike = UnlikeIn(made, now_);
    ++(unlike.empty() ? kept_ : others_);
    unlike_.insert(unlike.begin(), unlike.end());
    return unlike.empty();
  }
  EarlierRuns Counted(const plan::Plan& plan) const {
    EarlierRuns earlier;
    earlier.runs = plan.RunCount();
    earlier.is_searched = plan.ChoosesRuns();
    earlier.kept = kept_;
    earlier.others = others_;
    earlier.unlike = fmt::format("{}", fmt::join(unlike_, ", "));
    return earlier;
  }

 private:
  const results::Provenance& now_;
  std::uint64_t kept_ = 0, others_ = 0;
  std::set<std::string> unlike_;
};

/// The ids that the runs of a plan have in an earlier one. `repeats` is part of an id, but the
/// first repeats of a point are the same runs however many follow.
class IdsBefore {
 public:
  /// `before`: null if the earlier plan cannot be read.
  IdsBefore(const SizedPlan* before, const plan::Plan& now) {
    if (before == nullptr || before->plan.repeats == now.repeats) return;
    is_by_key_ = true;
    ForEachListed(*before, [this](const plan::Run& run) { ids_.emplace(KeyOf(run), run.id); });
  }
  /// Empty if the earlier plan has no such run.
  std::string Of(const plan::Run& run) const {
    if (!is_by_key_) return run.id;
    const auto found = ids_.find(KeyOf(run));
    return found == ids_.end() ? std::string() : found->second;
  }

 private:
  static std::string KeyOf(const plan::Run& run) {
    plan::Scene scene = run.scene;
    scene.world.Set("repeats", std::uint64_t{1});
    return plan::RunId(scene, run.rep);
  }

  bool is_by_key_ = false;
  std::unordered_map<std::string, std::string> ids_;
};

/// A results file of any plan.
class EarlierResult {
 public:
  EarlierResult(const fs::path& path, const plan::Plan& now, const results::PlanFacts& facts) {
    const results::ResultFile file(path);
    try {
      before_ = ReadSizedPlan(file.ReadProvenance("plan_text"), path.string());
    } catch (const yaml::PlanError&) {        // of another version of cdb, whose
    } catch (const options::CommandError&) {  // runs have other ids
    }
    changes_ = before_ && before_->plan.version == now.version
                   ? DescribeChanges(before_->plan, now)
                   : "the results are of another version of cdb";
    const hdf5::File opened = hdf5::File::Open(path);
    // Nothing can be copied from earlier schemas.
    if (results::ReadVersion(opened, path.string()) != results::kSchemaVersion) return;
    ids_before_.emplace(before_ ? &*before_ : nullptr, now);
    base_.emplace(path, facts, journal::MergeBase::Of::kAnyPlan);
    const std::vector<std::string> ids = opened.OpenDataset("run/run_id").ReadText();
    for (std::size_t cell = 0; cell < ids.size(); ++cell)
      if (base_->Has(cell)) cells_.emplace(ids[cell], cell);
  }

  const std::string& changes() const { return changes_; }
  /// Nullopt if it does not have the run.
  std::optional<results::Provenance> FindProvenance(const plan::Run& run) const {
    if (!base_ || !cells_.contains(ids_before_->Of(run))) return std::nullopt;
    return base_->ProvenanceOf(ids_before_->Of(run));
  }
  journal::Record Copy(const plan::Run& run, journal::RunWriter& writer) const {
    const std::string id = ids_before_->Of(run);
    return writer.Copy(run, *base_, cells_.at(id), id);
  }

 private:
  std::optional<SizedPlan> before_;
  std::string changes_;
  std::optional<IdsBefore> ids_before_;
  std::optional<journal::MergeBase> base_;  ///< null: without runs that can be copied
  std::unordered_map<std::string, std::size_t> cells_;
};

/// Writes records into the journal of a sweep, many in one commit.
class Copies {
 public:
  explicit Copies(schedule::SweepFolder& folder) : folder_(folder) {}
  void Add(journal::Record record) {
    bytes_ += record.bytes.size();
    records_.push_back(std::move(record));
    if (records_.size() >= kAtOnce || bytes_ >= kMostBytesAtOnce) Write();
  }
  void Write() {
    if (records_.empty()) return;
    schedule::SweepFolder::Warnings ignored;
    folder_.Write([&](journal::Journal& journal) { journal.Write(records_); }, ignored);
    records_.clear();
    bytes_ = 0;
  }

 private:
  schedule::SweepFolder& folder_;
  std::vector<journal::Record> records_;
  std::size_t bytes_ = 0;
};

/// Copies the runs of `out` that the plan has into the journal of its sweep.
EarlierRuns CopyRuns(const SizedPlan& sized, const fs::path& out,
                     const results::Provenance& provenance) {
  journal::RunWriter writer(sized.plan, provenance);
  const EarlierResult earlier(out, sized.plan, writer.facts());
  schedule::SweepFolder folder(sized.plan, RunsFolderOf(out), schedule::SweepStart::kResume);
  Counter counter(provenance);
  Copies copies(folder);
  bool is_first = true;
  std::set<std::string> seen;  // a run may be at two points
  ForEachListed(sized, [&](const plan::Run& run) {
    const auto made = earlier.FindProvenance(run);
    if (!made || !counter.Add(*made)) return;
    if (!seen.insert(run.id).second || folder.Has(run)) return;
    // As when runs are executed: a journal never lacks its plan.
    if (std::exchange(is_first, false)) {
      folder.WritePlan(sized.plan);
      if (!sized.short_text.empty() && sized.grid == nullptr)
        folder.WriteShortPlan(sized.short_text);
    }
    copies.Add(earlier.Copy(run, writer));
  });
  copies.Write();
  EarlierRuns counted = counter.Counted(sized.plan);
  counted.changes = earlier.changes();
  return counted;
}

/// The plan of the unfinished sweep in `folder`, whose hash is `sha256`. Throws CommandError if it
/// is not there.
SizedPlan ReadOtherPlan(const fs::path& folder, const std::string& sha256) {
  const std::string file = FindPlanIn(folder);
  if (!file.empty()) {
    SizedPlan sized = ReadPlanFile(file, options::ReadText(file));
    if (sized.plan.Sha256() == sha256) return sized;
  }
  throw options::CommandError(
      fmt::format("'{}' has finished runs of another plan, and no plan.yaml to merge them with; "
                  "nothing was changed: name another result by -o, or discard these runs by "
                  "--fresh",
                  folder.string()));
}

/// True if the sweep in the folder has a run that `out` lacks.
bool HasRunsBeside(const fs::path& out, const fs::path& folder) {
  const hdf5::File file = hdf5::File::Open(out);
  if (results::ReadVersion(file, out.string()) != results::kSchemaVersion) return true;
  const std::vector<std::string> ids = file.OpenDataset("run/run_id").ReadText();
  const std::vector<double> status = file.OpenDataset("status").Read();
  std::set<std::string> copied;
  for (std::size_t cell = 0; cell < ids.size(); ++cell)  // missing runs have an id too
    if (status[cell] != static_cast<double>(results::Status::kMissing) &&
        status[cell] != static_cast<double>(results::Status::kSkipped))
      copied.insert(ids[cell]);
  bool has_own = false;
  for (const fs::path& each : journal::JournalsIn(folder))
    journal::Journal::OpenToRead(each).ForEachRun(
        [&](const journal::Journal::Row& row) { has_own |= !copied.contains(row.run_id); });
  return has_own;
}

/// Turns the unfinished sweep of another plan, of that hash, into results at `out`. Those that are
/// there are first set aside, unless all that the sweep has was copied from them.
void MergeOtherSweep(const fs::path& out, const fs::path& folder, const std::string& sha256) {
  if (sha256.empty()) return;
  schedule::RefuseEarlierShards(folder);
  if (journal::CountRuns(folder) > 0) {
    const SizedPlan other = ReadOtherPlan(folder, sha256);
    const bool is_anew = IsMadeAnew(other.plan, folder);
    const bool replaces =
        Exists(out) && (is_anew || results::ResultFile(out).plan_sha256() != sha256);
    if (!replaces || is_anew || HasRunsBeside(out, folder)) {
      if (replaces) files::SetAside(out);
      MergeOnto(other.plan, {folder}, out);
    }
  }
  schedule::RemoveSweep(folder, sha256);
}

/// True if `out` holds results, and they are not of the plan.
bool HoldsOtherPlan(const fs::path& out, const plan::Plan& plan) {
  if (!Exists(out)) return false;
  const results::ResultFile file(out);
  return file.plan_sha256() != plan.Sha256() &&
         !(IsOfEarlierFormat(file, plan) && CountMissing(file, plan) == 0);
}

}  // namespace

std::string Describe(const EarlierRuns& earlier, const std::string& benchmark, bool is_planned) {
  const std::uint64_t new_runs = earlier.runs - earlier.kept;
  const std::string others = earlier.is_searched
                                 ? "and its search chooses among the others"
                                 : fmt::format("{} {} new", new_runs, new_runs == 1 ? "is" : "are");
  std::string text = fmt::format("{}: {}; ", benchmark, earlier.changes);
  if (earlier.kept == earlier.runs)
    text +=
        earlier.runs == 1 ? "its run is kept" : fmt::format("all {} runs are kept", earlier.runs);
  else if (earlier.kept == 0)
    text += "no finished run is part of it, " + others;
  else
    text += fmt::format("{} of {} runs are kept, {}", earlier.kept, earlier.runs, others);
  if (earlier.others > 0)
    text +=
        fmt::format(" ({} of them run again, as the {} differs)", earlier.others, earlier.unlike);
  if (!earlier.aside.empty())
    text += fmt::format("; the earlier results {} '{}'",
                        is_planned ? "would be renamed to" : "are now", earlier.aside.string());
  return text;
}

std::optional<EarlierRuns> FindEarlierRuns(
    const SizedPlan& sized, const fs::path& out, const results::Provenance& provenance,
    const std::function<void(const std::string&)>& visit_kept) {
  const plan::Plan& plan = sized.plan;
  const fs::path folder = RunsFolderOf(out);
  const std::string other = FindOtherPlan(folder, plan.Sha256());
  const bool has_other_result = HoldsOtherPlan(out, plan);
  if ((other.empty() && !has_other_result) || IsMadeAnew(plan, folder)) return std::nullopt;
  Counter counter(provenance);
  std::optional<EarlierResult> result;
  std::optional<SizedPlan> before;
  std::optional<journal::Journals> journals;
  const results::PlanFacts facts(plan);
  if (has_other_result) result.emplace(out, plan, facts);
  if (!other.empty()) {
    before = ReadOtherPlan(folder, other);
    journals.emplace(std::vector{folder});
  }
  const IdsBefore ids(before ? &*before : nullptr, plan);
  ForEachListed(sized, [&](const plan::Run& run) {
    const auto record = journals ? journals->Find(ids.Of(run)) : std::nullopt;
    const auto made = record   ? std::optional(record->about->provenance)
                      : result ? result->FindProvenance(run)
                               : std::nullopt;
    if (made && counter.Add(*made)) visit_kept(run.id);
  });
  EarlierRuns earlier = counter.Counted(plan);
  earlier.changes = before ? DescribeChanges(before->plan, plan) : result->changes();
  earlier.aside = files::NameAside(out);
  return earlier;
}

std::optional<EarlierRuns> KeepEarlierRuns(const SizedPlan& sized, const fs::path& out,
                                           const results::Provenance& provenance) {
  const plan::Plan& plan = sized.plan;
  const fs::path folder = RunsFolderOf(out);
  if (IsMadeAnew(plan, folder)) return std::nullopt;
  if (!FindOtherPlan(folder, plan.Sha256()).empty()) {
    FolderLock lock(folder);
    RequireAlone(lock, folder);
    MergeOtherSweep(out, folder, FindOtherPlan(folder, plan.Sha256()));
  }
  if (!HoldsOtherPlan(out, plan)) return std::nullopt;
  FolderLock lock(folder);
  RequireAlone(lock, folder);
  if (!HoldsOtherPlan(out, plan)) return std::nullopt;  // another cdb was faster
  EarlierRuns earlier = CopyRuns(sized, out, provenance);
  earlier.aside = files::SetAside(out);
  return earlier;
}

}  // namespace cdb::plans
