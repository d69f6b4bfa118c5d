#include "runtime/sweep/schedule/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>

#include "compiler/analysis/pruning.h"
#include "compiler/analysis/reference.h"
#include "compiler/schema/components.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/text/check.h"
#include "runtime/results/journal/run_writer.h"
#include "runtime/sweep/process/worker.h"
#include "runtime/sweep/schedule/error_evaluator.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/order.h"

namespace cdb::schedule {
namespace {

constexpr double kTick = 1;  // s
/// Ticks without a finished cycle after which a warning names the plug-in at work.
constexpr int kPatience = 60;

/// One call of Execute.
class Execution {
 public:
  Execution(const plan::Plan& plan, const ExecuteOptions& options, process::Launcher& launcher,
            ProgressListener& listener)
      : plan_(plan),
        options_(options),
        launcher_(launcher),
        listener_(listener),
        slots_(std::max<std::size_t>(options.jobs, 1)) {}

  Summary Run() {
    const std::vector<const plan::Run*> measured = FindWanted();
    all_ = ReferencesOf(plan_, measured);
    all_.insert(all_.end(), measured.begin(), measured.end());
    // Before any file is removed.
    if (options_.start != SweepStart::kResume) CheckCanRun(all_);
    folder_.emplace(plan_, options_.folder, options_.start);
    std::vector<std::string> warnings;
    for (const plan::Run* run : all_) {
      const auto found = folder_->Find(*run, warnings);
      if (found && !IsRepeated(*run, *found)) {
        CountFound(*run, *found);
      } else {
        if (found) repeated_.insert(run);
        queue_.push_back(run);
      }
      for (const std::string& warning : std::exchange(warnings, {})) listener_.Warn(warning);
    }
    CheckCanRun(queue_);
    if (!options_.has_plan) {
      folder_->WritePlan(plan_);
      if (!options_.short_plan.empty()) folder_->WriteShortPlan(options_.short_plan);
    }
    const EndGuard guard{*this};
    listener_.Begin(plan_, queue_, summary_, slots_.size());
    Work();
    while (!IsStopped() && QueueOutdated(measured)) Work();
    CheckRunsAreThere();
    return summary_;
  }

 private:
  void CheckCanRun(const std::vector<const plan::Run*>& runs) const {
    CheckFits(plan_.benchmark, LeastDemand(runs, slots_.size()), options_.folder);
    CheckModels(plan_.benchmark, runs);
  }

  /// Ends workers and clears the progress bar, however Execute is left.
  struct EndGuard {
    Execution& execution;
    ~EndGuard() {
      execution.launcher_.StopAll();
      execution.listener_.End();
    }
  };

  /// The runs that must be in the folder at the end.
  std::vector<const plan::Run*> FindWanted() {
    std::vector<const plan::Run*> wanted;
    for (const plan::Run* run : OrderRuns(plan_, options_.shard)) {
      const auto elsewhere = options_.find_elsewhere ? options_.find_elsewhere(*run) : std::nullopt;
      if (!elsewhere) {
        wanted.push_back(run);
      } else if (elsewhere->outcome.status == results::Status::kDone) {
        omissions_.Note(*run, elsewhere->omitted, elsewhere->decisions);
      }
    }
    return wanted;
  }

  bool IsRepeated(const plan::Run& run, const journal::RunInfo& found) const {
    return options_.is_repeated && run.scene.role == plan::Role::kMeasured &&
           options_.is_repeated(found);
  }

  void Work() {
    while (FillSlots()) {
      std::optional<process::Ending> ending = launcher_.Wait(kTick);
      if (ending) {
        Keep(std::move(*ending));
      } else if (IsStopped()) {
        break;
      } else {
        WatchPlugins();
        WatchPiles();
        listener_.Tick();
      }
    }
    if (!IsStopped()) return;
    // These runs have a measurement already and were only to be measured again.
    for (Attempts& attempts : attempts_)
      if (attempts.quietest) Finish(std::move(*std::exchange(attempts, {}).quietest));
    summary_.signal = options_.stop->signal();
    summary_.left = queue_.size() - next_;
    for (const plan::Run* run : slots_) summary_.left += run != nullptr;
  }

  /// One warning per run: a hanging run would otherwise block the sweep silently.
  void WatchPlugins() {
    for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
      const plan::Run* run = slots_[slot];
      if (run == nullptr || run->scene.plugins.empty() ||
          run->scene.world.WordOr("timeout") != "none")
        continue;
      const process::Pulse pulse = launcher_.PulseOf(slot);
      Stall& stall = stalls_[slot];
      const bool is_stuck = !pulse.plugin_call.empty() && pulse.cycles == stall.cycles;
      stall.cycles = pulse.cycles;
      stall.ticks = is_stuck ? stall.ticks + 1 : 0;
      if (!is_stuck || stall.ticks < kPatience || std::exchange(stall.is_reported, true)) continue;
      listener_.Warn(fmt::format(
          "{}: no cycle has ended for {:g} s, and the run is in {}; `timeout {:g}` in the scenario "
          "would end it",
          Describe(plan_, *run), kPatience * kTick, pulse.plugin_call, 2 * kPatience * kTick));
    }
  }

  void WatchPiles() {
    for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
      const plan::Run* run = slots_[slot];
      if (run == nullptr || !yaml::HasPile(run->scene)) continue;
      std::string settling = launcher_.PulseOf(slot).settling;
      if (settling == settling_[slot]) continue;
      settling_[slot] = std::move(settling);
      listener_.RunSettles(*run, settling_[slot]);
    }
  }

  bool IsStopped() const { return options_.stop != nullptr && options_.stop->requested(); }

  /// False if nothing is running and nothing is left to start.
  bool FillSlots() {
    bool is_busy = false;
    for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
      if (slots_[slot] == nullptr && !IsStopped() && !MustWait()) {
        if (const plan::Run* run = NextRun()) {
          launcher_.Start(slot, *run, omissions_.KeptFor(*run));
          slots_[slot] = run;
          stalls_[slot] = {};
          settling_[slot].clear();
          listener_.RunStarted(*run);
        }
      }
      is_busy |= slots_[slot] != nullptr;
    }
    return is_busy;
  }

  /// References must be complete before the runs that are compared with them end, and no measured
  /// run should execute beside a reference.
  bool MustWait() const {
    const auto is_reference = [](const plan::Run* run) {
      return run != nullptr && run->scene.role != plan::Role::kMeasured;
    };
    return next_ < queue_.size() && !is_reference(queue_[next_]) &&
           std::ranges::any_of(slots_, is_reference);
  }

  /// Counts a run that ended before this call, or that another runner executed.
  void CountFound(const plan::Run& run, const journal::RunInfo& found) {
    summary_.Count(found.outcome);
    ++summary_.resumed;
    if (found.outcome.status == results::Status::kDone)
      omissions_.Note(run, found.omitted, found.decisions);
  }

  /// Queues runs that omitted a component that a run compared with them keeps: they are measured
  /// again with it. Their records stay until the new ones are written. False if there are none.
  bool QueueOutdated(const std::vector<const plan::Run*>& measured) {
    is_repeating_ = true;
    queue_.clear();
    next_ = 0;
    std::string missing;
    for (const plan::Run* run : measured) {
      const std::string names = omissions_.MissingIn(*run);
      if (names.empty()) continue;
      queue_.push_back(run);
      missing += names + ' ';
    }
    if (queue_.empty()) return false;
    std::string components;
    for (const schema::ComponentInfo& info : schema::Components())
      if (schema::ListsWord(missing, info.name))
        components.append(components.empty() ? "" : ", ").append(info.name);
    listener_.Repeat(plan_, queue_, components);
    return true;
  }

  const plan::Run* NextRun() {
    if (is_repeating_) return next_ < queue_.size() ? queue_[next_++] : nullptr;
    while (next_ < queue_.size()) {
      const plan::Run* run = queue_[next_++];
      if (repeated_.contains(run)) return run;
      std::vector<std::string> warnings;
      const auto found = folder_->Find(*run, warnings);
      for (const std::string& warning : warnings) listener_.Warn(warning);
      if (!found) return run;
      CountFound(*run, *found);
      listener_.RunFound(*run, found->outcome);
    }
    return nullptr;
  }

  void Keep(process::Ending ended) {
    CDB_CHECK(ended.slot < slots_.size() && slots_[ended.slot] != nullptr);
    const plan::Run& run = *slots_[ended.slot];
    Attempts& attempts = attempts_[ended.slot];
    ++attempts.count;
    const bool is_first = !attempts.quietest;
    if (is_first || ended.result.noise.IsQuieterThan(attempts.quietest->result.noise))
      attempts.quietest = std::move(ended);
    attempts.quietest->result.scalars.attempts = static_cast<double>(attempts.count);
    if (attempts.quietest->result.noise.noise == machine::Noise::kNoisy &&
        attempts.count <= options_.noisy_retries && !IsStopped()) {
      if (is_first && !is_repeating_) WriteSafely(run, *attempts.quietest);
      return launcher_.Start(attempts.quietest->slot, run, omissions_.KeptFor(run));
    }
    Finish(std::move(*std::exchange(attempts, {}).quietest));
  }

  void Finish(process::Ending ending) {
    const plan::Run& run = *slots_[ending.slot];
    if (ending.result.status == results::Status::kDone)
      omissions_.Note(run, ending.result.omitted, ending.result.decisions);
    if (is_repeating_ && ending.result.status != results::Status::kDone) return GiveUp(ending);
    WriteSafely(run, ending);
    slots_[ending.slot] = nullptr;
    if (!is_repeating_) summary_.Count(ending.result.outcome());
    listener_.RunEnded(run, ending.result, ending.wall_s);
  }

  /// The number of runs in the journals now; a journal may have been removed in the meantime.
  std::size_t CountSafe() {
    return static_cast<std::size_t>(
        std::ranges::count_if(all_, [this](const plan::Run* run) { return folder_->Has(*run); }));
  }
  std::string SafeText() {
    std::size_t safe = 0;
    try {
      safe = CountSafe();
    } catch (const files::StoreError&) {
    }
    return fmt::format("{} of {} runs are safe in {}; the same command {}", safe, all_.size(),
                       folder_->path().string(), safe > 0 ? "resumes" : "executes all of them");
  }

  /// A merge would take a run whose journal has been removed for one that was never started.
  void CheckRunsAreThere() {
    if (IsStopped() || CountSafe() == all_.size()) return;
    throw files::StoreError(fmt::format(
        "{}: finished runs were removed from it while others went; nothing was merged\n{}",
        folder_->path().string(), SafeText()));
  }

  /// Keeps the earlier result of a run that succeeded before.
  void GiveUp(const process::Ending& ending) {
    const plan::Run& run = *slots_[ending.slot];
    slots_[ending.slot] = nullptr;
    omissions_.Forget(run);
    listener_.RunEnded(run, ending.result, ending.wall_s);
    listener_.Warn(
        fmt::format("{}: could not be measured again with the parts that the runs that it is "
                    "compared with keep; its first times are kept, and are of less work",
                    Describe(plan_, run)));
  }

  void WriteSafely(const plan::Run& run, process::Ending& ending) {
    try {
      Write(run, ending);
    } catch (const files::StoreError& error) {
      throw files::StoreError(fmt::format("{}\n{}", error.what(), SafeText()));
    }
  }

  void Write(const plan::Run& run, process::Ending& ending) {
    const bool is_measured = run.scene.role == plan::Role::kMeasured;
    if (is_measured && analysis::SamplingOf(run.scene)) {
      ending.result.errors =
          error_evaluator_.ErrorsOf(run, ending.result.status, *ending.recording);
      const protocol::RunErrors& errors = ending.result.errors;
      if (!errors.message.empty() && ending.result.status == results::Status::kDone)
        listener_.Warn(
            fmt::format("{}: errors without a value: {}", Describe(plan_, run), errors.message));
    }
    if (!writer_) writer_.emplace(plan_, options_.provenance);
    std::vector<std::string> warnings;
    folder_->Write(
        [&](journal::Journal& journal) {
          if (is_measured)
            writer_->Write(run, ending.result, journal);
          else
            writer_->WriteReference(run, ending.result, ending.recording->SampleValues(), journal);
        },
        warnings);
    for (const std::string& warning : warnings) listener_.Warn(warning);
  }

  const plan::Plan& plan_;
  const ExecuteOptions& options_;
  process::Launcher& launcher_;
  ProgressListener& listener_;
  std::optional<journal::RunWriter>
      writer_;  ///< lists every cycle of a plan: not before it is known to fit
  ErrorEvaluator error_evaluator_{plan_, [this](const auto& id) { return folder_->Read(id); }};
  SharedOmissions omissions_;
  bool is_repeating_ = false;  // executes runs again that have already succeeded
  std::optional<SweepFolder> folder_;
  std::vector<const plan::Run*> all_;  // including references
  std::vector<const plan::Run*> queue_;
  std::unordered_set<const plan::Run*> repeated_;  // runs of queue_ that have finished before
  std::size_t next_ = 0;                           // index in queue_
  std::vector<const plan::Run*> slots_;            // the run in each slot, or null
  /// The measurements of the run in a slot.
  struct Attempts {
    std::size_t count = 0;
    std::optional<process::Ending> quietest;
  };
  std::vector<Attempts> attempts_ = std::vector<Attempts>(slots_.size());
  struct Stall {
    std::uint64_t cycles = 0;
    int ticks = 0;  // in one call of a plug-in without a new cycle
    bool is_reported = false;
  };
  std::vector<Stall> stalls_ = std::vector<Stall>(slots_.size());  // for each slot
  std::vector<std::string> settling_ = std::vector<std::string>(slots_.size());
  Summary summary_;
};

}  // namespace

void Summary::Count(const results::Outcome& outcome) {
  switch (outcome.status) {
    case results::Status::kDone:
      ++done;
      spoiled += outcome.IsGood() ? 0 : 1;
      return;
    case results::Status::kFailed:
      ++failed;
      return;
    case results::Status::kCrashed:
      ++crashed;
      return;
    case results::Status::kTimedOut:
      ++timed_out;
      return;
    case results::Status::kMissing:
    case results::Status::kSkipped:
      break;
  }
  CDB_CHECK(!"a run that was executed has a status");
}

std::string Describe(const Summary& summary) {
  const std::size_t total = summary.ended() + summary.left;
  std::string text = fmt::format("{} run{}: {} done", total, total == 1 ? "" : "s", summary.done);
  const auto add = [&text](std::size_t count, std::string_view what) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  };
  add(summary.spoiled, "of them without valid timings");
  add(summary.failed, "failed");
  add(summary.crashed, "crashed");
  add(summary.timed_out, "timed out");
  add(summary.left, "not run");
  if (summary.resumed > 0) text += fmt::format(" ({} of them before)", summary.resumed);
  return text;
}

Summary Execute(const plan::Plan& plan, const ExecuteOptions& options, ProgressListener& listener) {
  process::ProcessLauncher launcher(process::FindWorkers(plan),
                                    std::max<std::size_t>(options.jobs, 1), options.stop);
  return Execute(plan, options, launcher, listener);
}

Summary Execute(const plan::Plan& plan, const ExecuteOptions& options, process::Launcher& launcher,
                ProgressListener& listener) {
  return Execution(plan, options, launcher, listener).Run();
}

namespace {

using schema::ComponentInfo;

std::uint32_t BitOf(const ComponentInfo& info) {
  return 1u << static_cast<unsigned>(info.component);
}

std::string NamesOf(std::uint32_t components) {
  std::string names;
  for (const ComponentInfo& info : schema::Components())
    if ((components & BitOf(info)) != 0) names.append(names.empty() ? "" : " ").append(info.name);
  return names;
}

/// A key that is the same for runs that are compared.
std::string GroupOf(const plan::Run& run) {
  plan::Scene scene = run.scene;
  scene.world.Set("detector", schema::Word{"simple"});
  scene.world.Set("narrow_phase", schema::Word{"bullet"});
  scene.world.Set("pair_order", schema::Word{"sorted"});
  scene.world.Set("threads", std::uint64_t{1});
  scene.world.Set("seed", std::uint64_t{0});
  for (auto& [stream, seed] : scene.seeds) seed = 0;
  scene.plugins.clear();
  return plan::RunId(scene, 0);
}

}  // namespace

void SharedOmissions::Note(const plan::Run& run, std::string_view omitted,
                           std::string_view decisions) {
  Components left_out = 0, kept = 0;
  for (const ComponentInfo& info : schema::Components()) {
    if (!info.IsVisible() ||
        analysis::RequestFor(run.scene, info.component) != analysis::PruningRequest::kAuto)
      continue;
    if (schema::ListsWord(omitted, info.name)) left_out |= BitOf(info);
    if (analysis::SaysKept(decisions, info.component)) kept |= BitOf(info);
  }
  omitted_[run.id] = left_out;
  if (kept != 0) kept_[GroupOf(run)] |= kept;
}

SharedOmissions::Components SharedOmissions::KeptInGroupOf(const plan::Run& run) const {
  if (kept_.empty()) return 0;
  const auto found = kept_.find(GroupOf(run));
  return found == kept_.end() ? 0 : found->second;
}

std::string SharedOmissions::KeptFor(const plan::Run& run) const {
  return NamesOf(KeptInGroupOf(run));
}

std::string SharedOmissions::MissingIn(const plan::Run& run) const {
  const auto found = omitted_.find(run.id);
  if (found == omitted_.end() || found->second == 0) return {};
  return NamesOf(found->second & KeptInGroupOf(run));
}

}  // namespace cdb::schedule
