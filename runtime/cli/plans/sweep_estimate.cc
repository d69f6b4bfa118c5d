#include "runtime/cli/plans/sweep_estimate.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <string>

#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/plan/clock.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/content_cache.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/searches/searches.h"
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

/// A copy of the run, of `cycles` at most and timed, without a reference run.
plan::Run Shortened(const plan::Run& run, std::uint64_t cycles) {
  plan::Run sample = run;
  plan::WorldSettings& world = sample.scene.world;
  world.Set("cycles", std::min<std::uint64_t>(world.Count("cycles"), cycles));
  world.Set("warmup", std::uint64_t{0});
  world.Set("accuracy.metrics", schema::WordList{"none"});
  schema::WordList record = world.Words("record");
  if (std::ranges::find(record, "timing") == record.end()) record.emplace_back("timing");
  std::ranges::sort(record);
  world.Set("record", record);
  sample.id = plan::RunId(sample.scene, 0);
  return sample;
}

/// The cycles of a sampled run. Times in s.
struct CycleSample {
  std::uint64_t count = 0;
  double seconds = 0, last_step = 0;  ///< of all cycles; the mean of the last quarter
  /// The last quarter had more pairs and contacts than the one before, or there was no contact yet.
  bool is_growing = false;
};

CycleSample CyclesOf(const process::Ending& ending, const plan::Scene& scene) {
  constexpr double kGrowth = 1.05;  // more pairs and contacts than that are growth
  CycleSample sample;
  sample.count = scene.world.Count("cycles");
  const std::uint64_t quarter = std::max<std::uint64_t>(1, sample.count / 4);
  // The times are stored as a row of cycles for each phase.
  const auto steps =
      ending.recording->Reals("duration")
          .subspan(protocol::IndexOf(protocol::Phase::kStep) * sample.count, sample.count);
  sample.seconds = 1e-9 * std::accumulate(steps.begin(), steps.end(), 0.0);
  const auto last = steps.last(quarter);
  sample.last_step =
      1e-9 * std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(quarter);
  if (sample.count < 2 * quarter) return sample;
  double late = 0, before = 0;
  const auto contacts = ending.recording->Ints("contacts");
  for (const auto& counts : {ending.recording->Ints("pairs"), contacts}) {
    if (counts.empty()) continue;
    const auto middle = counts.end() - static_cast<std::ptrdiff_t>(quarter);
    before = std::accumulate(middle - static_cast<std::ptrdiff_t>(quarter), middle, before);
    late = std::accumulate(middle, counts.end(), late);
  }
  sample.is_growing =
      late > kGrowth * before || (!contacts.empty() && std::ranges::max(contacts) == 0);
  return sample;
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

namespace {

/// Executes a run; nullopt if it was stopped.
std::optional<process::Ending> Execute(process::ProcessLauncher& launcher, const plan::Run& run,
                                       const process::StopFlag& stop) {
  launcher.Start(0, run, "");
  std::optional<process::Ending> ending;
  while (!ending && !stop.requested()) ending = launcher.Wait(1);
  return ending;
}

}  // namespace

SweepEstimate EstimateSweep(const grid::Grid& grid, const process::StopFlag& stop) {
  constexpr double kMostSeconds = 1;    // of a longer sample, as far as a shorter one predicts it
  constexpr std::uint64_t kLonger = 4;  // times the cycles of the shorter one
  SweepEstimate estimate;
  estimate.runs = searches::ExpectedRuns(grid.head, grid.run_count());
  estimate.runs_text = searches::RunsText(grid.head, grid.run_count());
  estimate.points = grid.point_count;
  plan::Plan plan = grid.head;
  std::vector<plan::Run> whole = SpreadRuns(grid);
  if (!whole.empty() && plan::CountsInstructions(whole[0].scene))
    throw options::CommandError(fmt::format(
        "--estimate: the runs of '{}' have `clock instructions`, and take 50 to 200 times as long "
        "as "
        "others, depending on their code: estimate them with --set clock=time, and multiply",
        plan.benchmark));
  for (const plan::Run& run : whole) plan.runs.push_back(Shortened(run, kSampledCycles));
  estimate.piles = CountPiles(grid, whole);
  std::set<std::string> settled;  // ids of settled piles
  TrialJournal journal(plan);
  process::ProcessLauncher launcher(process::FindWorkers(plan), 1, &stop);
  for (std::size_t i = 0; i < whole.size() && !stop.requested(); ++i) {
    const plan::Scene& scene = whole[i].scene;
    estimate.has_references = estimate.has_references || analysis::NeedsReference(scene);
    auto ending = Execute(launcher, plan.runs[i], stop);
    if (!ending) break;
    if (ending->result.status != results::Status::kDone) {
      estimate.failures.push_back(
          fmt::format("{}: {}", plan::Describe(plan, plan.runs[i]), ending->result.message));
      continue;
    }
    CycleSample sample = CyclesOf(*ending, plan.runs[i].scene);
    const double settling = ending->recording->header().settling.seconds.load();
    const double rest = std::max(0.0, ending->wall_s - settling - sample.seconds);
    if (yaml::HasPile(scene)) settled.insert(yaml::PileText(scene));
    const auto writing = journal.TimeOf(plan.runs[i], ending->result);
    estimate.has_journal = estimate.has_journal && writing;
    const std::uint64_t cycles = scene.world.Count("cycles");
    // The first cycles, such as those of a fall, are not like the later ones.
    while (sample.count < cycles && !stop.requested() &&
           sample.last_step * static_cast<double>(kLonger * sample.count) < kMostSeconds) {
      const plan::Run longer = Shortened(whole[i], kLonger * sample.count);
      const auto more = Execute(launcher, longer, stop);
      if (!more || more->result.status != results::Status::kDone) break;
      sample = CyclesOf(*more, longer.scene);
    }
    if (stop.requested()) break;
    estimate.cycles = std::max(estimate.cycles, sample.count);
    const auto left = static_cast<double>(cycles + scene.world.Count("warmup") - sample.count);
    estimate.samples.push_back(
        {rest + sample.seconds + sample.last_step * left + writing.value_or(0), settling,
         SeriesBytes(scene), sample.count < cycles && sample.is_growing});
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
  std::string text = fmt::format("{}: {}\n", benchmark, estimate.runs_text);
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
  const auto growing =
      static_cast<std::size_t>(std::ranges::count_if(estimate.samples, &SampledRun::is_growing));
  // An interval would be about the sampled points only, not about their later cycles.
  const bool has_interval = growing == 0 && time.low < time.high;
  text +=
      fmt::format("  time    {}{}{}, with {} at a time\n", growing > 0 ? "at least " : "",
                  Duration(time.mean * share + settling),
                  has_interval ? fmt::format(" ({} .. {})", Duration(time.low * share + settling),
                                             Duration(time.high * share + settling))
                               : "",
                  jobs == 1 ? "one run" : fmt::format("{} runs", jobs));
  if (growing > 0)
    text += fmt::format(
        "          At the end of {} of {} samples, pairs and contacts were still increasing, or "
        "there were none yet:\n          later cycles may take longer.\n",
        growing, estimate.samples.size());
  text += PilesText(estimate);
  const bool has_sizes = size.low < size.high;
  text += fmt::format(
      "  result  {}{} before compression\n", protocol::BytesText(size.mean * runs),
      has_sizes
          ? fmt::format(" ({} .. {})", protocol::BytesText(size.low * runs),
                        std::isinf(size.high) ? "unknown" : protocol::BytesText(size.high * runs))
          : "");
  text += fmt::format(
      "  Sampled: {} of {} points{}, for up to {} cycles each; one run takes {} .. {}.\n",
      estimate.samples.size(), estimate.points,
      estimate.samples.size() < estimate.points ? ", spread over the grid" : "", estimate.cycles,
      Duration(*std::ranges::min_element(seconds)), Duration(*std::ranges::max_element(seconds)));
  if (has_interval || has_sizes)
    text += "  In brackets: the mean plus and minus two standard errors of the sample.\n";
  text += "  Not known: how the time of a cycle changes after these; what other programs disturb";
  if (!estimate.has_journal)
    text += ";\n  how long writing the results takes, as nothing can be written to this folder";
  text += estimate.has_references ? "; the reference runs, which\n  come on top.\n" : ".\n";
  return text;
}

}  // namespace cdb::plans
