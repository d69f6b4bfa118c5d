#include "runtime/cli/plans/sweep_estimate.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/content_cache.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/protocol/recording.h"
#include "runtime/protocol/series.h"
#include "runtime/results/journal/run_writer.h"
#include "runtime/results/store.h"
#include "runtime/sweep/process/worker.h"

namespace cdb::plans {
namespace {

/// Runs with different scenes, spread over the grid by the golden ratio, which does not resonate
/// with the stride of any axis.
std::vector<plan::Run> SpreadRuns(const grid::Grid& grid) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kMostTries = 100'000;  // needed if `skip` leaves few
  const grid::AxisSet all = grid::AllAxes(grid.head.axes.size());
  const grid::Subgrid whole(all, grid.extents());
  grid::Cursor cursor(grid);
  std::vector<plan::Run> runs;
  const std::size_t most = std::min<std::uint64_t>(kSampledRuns, grid.point_count);
  for (int i = 0; i < kMostTries && runs.size() < most; ++i) {
    const double part = std::fmod(0.5 + kGolden * i, 1.0);
    grid::Point place(all.size(), 0);
    whole.MoveTo(static_cast<std::uint64_t>(part * static_cast<double>(whole.size())), place);
    if (!cursor.MoveTo(place)) continue;
    if (std::ranges::find(runs, place, &plan::Run::at) != runs.end()) continue;
    runs.push_back({{}, place, 0, cursor.MakeScene(), {}, {}});
  }
  return runs;
}

/// The number of different piles of all runs: the product of those along each axis. Exact if the
/// axes are independent of one another.
std::uint64_t CountPiles(const grid::Grid& grid, const std::vector<plan::Run>& samples) {
  constexpr std::size_t kMostValues = 1000;  // of an axis; beyond it, all values are taken to
                                             // differ
  if (samples.empty() ||
      std::ranges::none_of(samples, [](const plan::Run& run) { return yaml::HasPile(run.scene); }))
    return 0;
  if (library::CacheFolder().empty()) return grid.run_count();
  grid::Cursor cursor(grid);
  double piles = 1;
  const std::vector<std::size_t> extents = grid.extents();
  for (std::size_t axis = 0; axis < extents.size(); ++axis) {
    std::set<std::string> texts;
    grid::Point place = samples[0].at;
    for (std::size_t i = 0; i < std::min(extents[axis], kMostValues); ++i) {
      place[axis] = i;
      if (cursor.MoveTo(place)) texts.insert(yaml::PileText(cursor.MakeScene()));
    }
    const bool all_differ = texts.size() == kMostValues;
    piles *=
        static_cast<double>(all_differ ? extents[axis] : std::max<std::size_t>(texts.size(), 1));
  }
  return static_cast<std::uint64_t>(std::min(piles, static_cast<double>(grid.point_count)));
}

double SeriesBytes(const plan::Scene& scene) {
  double bytes = 0;
  for (const protocol::Series& series : protocol::AllSeries())
    if (protocol::IsRecordedBy(series, scene))
      bytes +=
          static_cast<double>(series.ItemBytes() * series.ValueCount(protocol::ExtentsOf(scene)));
  return bytes;
}

/// A copy of the run, shortened and timed, without a reference run.
plan::Run Shortened(const plan::Run& run) {
  plan::Run sample = run;
  plan::WorldSettings& world = sample.scene.world;
  world.Set("cycles", std::min<std::uint64_t>(world.Count("cycles"), kSampledCycles));
  world.Set("warmup", std::uint64_t{0});
  world.Set("accuracy.metrics", schema::WordList{"none"});
  schema::WordList record = world.Words("record");
  if (std::ranges::find(record, "timing") == record.end()) record.emplace_back("timing");
  std::ranges::sort(record);
  world.Set("record", record);
  sample.id = plan::RunId(sample.scene, 0);
  return sample;
}

/// Time of a step over the cycles that ran, s.
double StepSeconds(const process::Ending& ending, const plan::Scene& scene) {
  const auto durations = ending.recording->Reals("duration");
  const std::uint64_t cycles = scene.world.Count("cycles");
  double nanoseconds = 0;
  // The times are stored as a row of cycles for each phase.
  const std::size_t row = protocol::IndexOf(protocol::Phase::kStep) * cycles;
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) nanoseconds += durations[row + cycle];
  return nanoseconds * 1e-9 / static_cast<double>(cycles);
}

/// A temporary folder for a journal, where `cdb run` would write it by default.
class TrialJournal {
 public:
  explicit TrialJournal(const plan::Plan& plan)
      : writer_(plan, provenance_), plan_sha256_(plan.Sha256()) {
    std::error_code error;
    std::filesystem::create_directory(folder_, error);
  }
  ~TrialJournal() {
    journal_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TrialJournal(const TrialJournal&) = delete;
  TrialJournal& operator=(const TrialJournal&) = delete;

  /// Time to write the run, s; nullopt if the folder cannot be written to.
  std::optional<double> TimeOf(const plan::Run& run, const results::RunResult& result) {
    try {
      if (!journal_) journal_.emplace(journal::Journal::OpenToWrite(folder_, plan_sha256_));
      const auto begin = std::chrono::steady_clock::now();
      writer_.Write(run, result, *journal_);
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    } catch (const files::StoreError&) {
      return std::nullopt;
    }
  }

 private:
  const results::Provenance provenance_;
  journal::RunWriter writer_;
  const std::string plan_sha256_;
  std::optional<journal::Journal> journal_;
  const std::filesystem::path folder_ = fmt::format(".cdb-estimate-{}", getpid());
};

std::string Duration(double seconds) {
  if (std::isinf(seconds)) return "unknown";
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  if (seconds < 2 * 3600) return fmt::format("{:.3g} min", seconds / 60);
  if (seconds < 1e3 * 3600) return fmt::format("{:.3g} h", seconds / 3600);
  return fmt::format("{:.0f} h", seconds / 3600);
}

}  // namespace

MeanOfSample MeanOf(const std::vector<double>& values, std::uint64_t population) {
  const auto n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (const double value : values) sum += value;
  for (const double value : values) squares += (value - sum / n) * (value - sum / n);
  const double mean = sum / n;
  if (values.size() >= population) return {mean, mean, mean};
  if (values.size() < 2) return {mean, 0, std::numeric_limits<double>::infinity()};
  const double left = 1 - n / static_cast<double>(population);
  const double error = std::sqrt(squares / (n - 1) / n * left);
  return {mean, std::max(0.0, mean - 2 * error), mean + 2 * error};
}

SweepEstimate EstimateSweep(const grid::Grid& grid, const process::StopFlag& stop) {
  SweepEstimate estimate;
  estimate.runs = grid.run_count();
  estimate.points = grid.point_count;
  plan::Plan plan = grid.head;
  std::vector<plan::Run> whole = SpreadRuns(grid);
  for (const plan::Run& run : whole) plan.runs.push_back(Shortened(run));
  estimate.piles = CountPiles(grid, whole);
  std::set<std::string> settled;  // ids of settled piles
  TrialJournal journal(plan);
  process::ProcessLauncher launcher(process::FindWorkers(plan), 1, &stop);
  for (std::size_t i = 0; i < whole.size() && !stop.requested(); ++i) {
    const plan::Scene& scene = whole[i].scene;
    estimate.has_references = estimate.has_references || analysis::NeedsReference(scene);
    launcher.Start(0, plan.runs[i], "");
    std::optional<process::Ending> ending;
    while (!ending && !stop.requested()) ending = launcher.Wait(1);
    if (!ending) break;
    if (ending->result.status != results::Status::kDone) {
      estimate.failures.push_back(
          fmt::format("{}: {}", plan::Describe(plan, plan.runs[i]), ending->result.message));
      continue;
    }
    const std::uint64_t sampled = plan.runs[i].scene.world.Count("cycles");
    const double step = StepSeconds(*ending, plan.runs[i].scene);
    const double settling = ending->recording->header().settling.seconds.load();
    const double rest =
        std::max(0.0, ending->wall_s - settling - step * static_cast<double>(sampled));
    if (yaml::HasPile(scene)) settled.insert(yaml::PileText(scene));
    const auto cycles =
        static_cast<double>(scene.world.Count("cycles") + scene.world.Count("warmup"));
    estimate.cycles = std::max(estimate.cycles, sampled);
    const auto writing = journal.TimeOf(plan.runs[i], ending->result);
    estimate.has_journal = estimate.has_journal && writing;
    estimate.samples.push_back(
        {rest + step * cycles + writing.value_or(0), settling, SeriesBytes(scene)});
  }
  estimate.settled_piles = settled.size();
  return estimate;
}

std::optional<double> SettlingTime(const SweepEstimate& estimate) {
  double sum = 0, count = 0;
  for (const SampledRun& sample : estimate.samples) {
    sum += sample.settling;
    count += sample.settling > 0 ? 1 : 0;
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

namespace {

/// About the piles that have yet to settle; empty if there are none.
std::string PilesText(const SweepEstimate& estimate) {
  if (estimate.piles == 0) return {};
  const std::uint64_t settled = std::min(estimate.piles, estimate.settled_piles);
  std::string text = fmt::format("  piles   {}, each settled once: {} {} settled by now",
                                 estimate.piles, settled, settled == 1 ? "is" : "are");
  if (settled == estimate.piles) return text + "\n";
  const std::uint64_t left = estimate.piles - settled;
  if (const auto time = SettlingTime(estimate))
    return text + fmt::format(", the other{} take{} {}, within the time above\n",
                              left == 1 ? "" : "s", left == 1 ? "s" : "",
                              Duration(*time * static_cast<double>(left)));
  return text + "; the time of the others is not known\n";
}

}  // namespace

std::string EstimateText(const SweepEstimate& estimate, const std::string& benchmark,
                         std::uint64_t jobs) {
  std::string text =
      fmt::format("{}: {} {}\n", benchmark, estimate.runs, estimate.runs == 1 ? "run" : "runs");
  for (const std::string& failure : estimate.failures)
    text += fmt::format("  a sampled run failed and was not counted: {}\n", failure);
  if (estimate.samples.empty())
    return text + "  no sampled run finished, so there is no estimate\n";
  std::vector<double> seconds, bytes;
  for (const SampledRun& sample : estimate.samples) {
    seconds.push_back(sample.seconds);
    bytes.push_back(sample.bytes);
  }
  const auto runs = static_cast<double>(estimate.runs);
  const MeanOfSample time = MeanOf(seconds, estimate.points), size = MeanOf(bytes, estimate.points);
  const double share = runs / static_cast<double>(jobs);
  const double settling =
      SettlingTime(estimate).value_or(0) *
      static_cast<double>(estimate.piles - std::min(estimate.piles, estimate.settled_piles)) /
      static_cast<double>(jobs);
  text += fmt::format("  time    {} ({} .. {}), with {} at a time\n",
                      Duration(time.mean * share + settling), Duration(time.low * share + settling),
                      Duration(time.high * share + settling),
                      jobs == 1 ? "one run" : fmt::format("{} runs", jobs));
  text += PilesText(estimate);
  text += fmt::format("  result  {} ({} .. {}) before compression\n",
                      protocol::BytesText(size.mean * runs), protocol::BytesText(size.low * runs),
                      std::isinf(size.high) ? "unknown" : protocol::BytesText(size.high * runs));
  text += fmt::format(
      "  Sampled: {} of {} points, spread over the grid, for {} cycles each; one run takes {} .. "
      "{}.\n"
      "  In brackets: the mean plus and minus two standard errors of the sample.\n",
      estimate.samples.size(), estimate.points, estimate.cycles,
      Duration(*std::ranges::min_element(seconds)), Duration(*std::ranges::max_element(seconds)));
  text += "  Not known: how the time of a cycle changes after these; what other programs disturb";
  if (!estimate.has_journal)
    text += ";\n  how long writing the results takes, as nothing can be written to this folder";
  text += estimate.has_references ? "; the reference runs, which\n  come on top.\n" : ".\n";
  return text;
}

}  // namespace cdb::plans
