// The facts of a plan that its layout needs, and the tables of what is known of each run.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "compiler/plan/clock.h"
#include "compiler/schema/metrics.h"
#include "runtime/protocol/samples.h"
#include "runtime/protocol/series.h"
#include "runtime/results/layout.h"

namespace cdb::results {
namespace {

using hdf5::Type;

std::string VerdictNames() {
  std::string names;
  for (const protocol::VerdictInfo& info : protocol::Verdicts())
    names.append(names.empty() ? "" : " ").append(info.name);
  return names;
}

std::string StatusNames() { return fmt::format("{}", fmt::join(kStatusNames, " ")); }

/// The count that was measured as a real number; -1 if it was not measured.
double CountOrNone(double value) {
  return std::isnan(value) ? -1 : std::min(value, double{std::numeric_limits<std::int32_t>::max()});
}

/// Adds the scalars that the worker measures.
std::vector<RunNumber> WithScalars(std::vector<RunNumber> numbers) {
  for (const schema::RunScalarInfo& info : schema::kRunScalars)
    numbers.push_back({std::string(kRunGroup) + std::string(info.name),
                       info.is_count ? Type::kInt32 : Type::kFloat64, std::string(info.unit),
                       std::string(info.doc), info.is_count ? -1 : kNaN,
                       [&info](const RunResult& r) {
                         const double value = r.scalars.*info.value;
                         return info.is_count ? CountOrNone(value) : value;
                       }});
  return numbers;
}

/// Gives the scalars that are read from the clock its unit.
void CountInstructions(std::vector<RunNumber>& numbers) {
  for (const schema::RunScalarInfo& info : schema::kRunScalars) {
    if (!info.by_clock) continue;
    const std::string name = std::string(kRunGroup) + std::string(info.name);
    RunNumber& number = *std::ranges::find(numbers, name, &RunNumber::name);
    number.unit.clear();
    number.doc = fmt::format("{} {}", kInstructions, info.doc);
  }
}

/// The values of a series of counts that are not the fill value; empty if it was not recorded.
std::vector<std::int32_t> CountsOf(const RunResult& result, std::string_view name) {
  std::vector<std::int32_t> counts;
  for (const auto& [series, bytes] : result.series) {
    if (series->name != name) continue;
    counts.resize(bytes.size() / sizeof(std::int32_t));
    std::memcpy(counts.data(), bytes.data(), bytes.size());
  }
  std::erase_if(counts, [](std::int32_t count) { return count < 0; });
  return counts;
}

/// The questions that the scene leaves open, and those that the run did.
std::string UncheckedOf(const plan::Scene& scene, const RunResult& result) {
  std::string text = UncheckedText(analysis::CoverageOf(scene));
  const auto add = [&](std::string_view question) {
    text.append(text.empty() ? "" : "; ").append(question);
  };
  if (const auto counts = CountsOf(result, "unfollowed");
      std::ranges::any_of(counts, [](std::int32_t count) { return count > 0; }))
    add("passing: some pairs of objects could not be followed");
  if (const auto counts = CountsOf(result, "unjudged_impacts");
      !counts.empty() && counts.back() > 0 &&
      analysis::IsChecked(analysis::Question::kImpacts, scene))
    add("impacts: some impacts could not be judged");
  return text;
}

double ErrorOf(const RunResult& result, const std::string& name) {
  const auto found = result.errors.values.find(name);
  return found == result.errors.values.end() || found->second.size() != 1 ? kNaN : found->second[0];
}

/// Adds the arrays of /accuracy for the errors that some run requests.
void AddErrors(const plan::Plan& plan, PlanFacts& facts) {
  using plan::Run;
  using R = const RunResult&;
  const auto add_as = [&](const std::string& name, const std::string& value, std::string_view unit,
                          std::string doc) {
    facts.numbers.push_back({std::string(kAccuracyGroup) + name, Type::kFloat64, std::string(unit),
                             std::move(doc), kNaN,
                             [value](const RunResult& r) { return ErrorOf(r, value); }});
  };
  const auto add = [&](const std::string& name, std::string_view unit, std::string doc) {
    add_as(name, name, unit, std::move(doc));
  };
  bool needs_truth = false;
  for (const schema::ErrorInfo* error : analysis::ErrorsOf(plan)) {
    const std::string name(error->name);
    add(name, error->unit, std::string(error->doc));
    needs_truth = needs_truth || error->needs_truth;
    if (error->needs_truth)
      add(name + "_floor", error->unit,
          "the same between the reference and its twin: a smaller error is not "
          "significant");
    facts.error_series.push_back({error->series, "", protocol::SeriesType::kFloat64,
                                  protocol::SeriesShape::kSample, error->unit, error->doc});
  }
  if (needs_truth)
    add("horizon", "s",
        "simulated time up to which the trajectories of the reference stay predictable");
  // If an axis is named `timestep`, this group has that dimension.
  add_as("step_size", "timestep", "s", "simulated time of a cycle");
  facts.texts.push_back({std::string(kAccuracyGroup) + "truth",
                         "ground truth of the errors: a closed form, or the id of a reference",
                         [](const Run&, R r) { return r.errors.truth; }});
  facts.texts.push_back({std::string(kAccuracyGroup) + "message",
                         "why some error of the run has no value",
                         [](const Run&, R r) { return r.errors.message; }});
}

/// Checked before the first run, because the results could not be stored.
void CheckAxisNames(const plan::Plan& plan) {
  for (const plan::Axis& axis : plan.axes)
    if (const auto clash = schema::FindNameClash(axis.name, analysis::ErrorsOf(plan)))
      throw files::StoreError(
          fmt::format("{}: the axis '{}' has the name of {}; nothing was written: give the axis "
                      "another name in "
                      "{} and plan again",
                      plan.benchmark, axis.name, *clash,
                      plan.source.empty() ? "the scenario" : "'" + plan.source + "'"));
}

std::uint64_t MaxQueries(const plan::Plan& plan) {
  std::uint64_t most = 0;
  for (const plan::Run& run : plan.Bounds()) most = std::max(most, run.scene.QueryCount());
  return most;
}

std::uint64_t MaxNodes(const plan::Plan& plan) {
  std::uint64_t most = 0;
  for (const plan::Run& run : plan.Bounds()) most = std::max(most, analysis::NodeCount(run.scene));
  return most;
}

}  // namespace

PlanFacts::PlanFacts(const plan::Plan& plan)
    : sha256(plan.Sha256()),
      cycles(std::max<std::uint64_t>(1, plan.MaxCycles())),
      bodies(std::max<std::uint64_t>(1, plan.MaxObjects())),
      box_bodies(std::max<std::uint64_t>(1, analysis::MaxBodyCount(plan))),
      queries(std::max<std::uint64_t>(1, MaxQueries(plan))),
      nodes(std::max<std::uint64_t>(1, MaxNodes(plan))),
      poses(plan.Records("poses") || plan.Records("vertices")),
      boxes(plan.Records("boxes")),
      contacts(plan.Records("contacts")),
      answers(plan.Records("queries")) {
  CheckAxisNames(plan);
  for (const plan::Axis& axis : plan.axes) integer_axes.push_back(axis.IsInteger());
  series = protocol::RecordedSeries(plan);
  numbers = RunNumbers();
  counts_instructions = plan::CountsInstructions(plan);
  if (counts_instructions) CountInstructions(numbers);
  texts = RunTexts();
  for (const plan::Run& run : plan.Bounds()) {
    if (const auto sampling = analysis::SamplingOf(run.scene)) {
      samples = std::max(samples, sampling->count);
      interval_s = sampling->interval_s;
      const std::uint64_t objects = protocol::SampleShapeOf(run.scene)->objects;
      sampled_bodies = std::max({sampled_bodies, bodies, objects});
    }
  }
  if (samples > 0) AddErrors(plan, *this);
}

bool IsRunFact(std::string_view name) {
  const std::string path = std::string(kRunGroup) + std::string(name);
  return std::ranges::find(RunNumbers(), path, &RunNumber::name) != RunNumbers().end() ||
         std::ranges::find(RunTexts(), path, &RunText::name) != RunTexts().end();
}

const std::vector<ReferenceArray>& ReferenceArrays() {
  static const std::vector<ReferenceArray> kArrays = {
      {"role",
       Type::kText,
       {"reference"},
       "",
       "reference, or twin: the run with another time step that shows how far it can be trusted"},
      {"status", Type::kInt8, {"reference"}, "", "how the run ended", StatusNames},
      {"message", Type::kText, {"reference"}, "", "why it did not end well, or is not sound"},
      {"verdict",
       Type::kText,
       {"reference"},
       "",
       "how a reference ended as physics: cdb doc verdicts"},
      {"state_hash",
       Type::kText,
       {"reference"},
       "",
       "hash of every body's state after the last cycle"},
      {"host", Type::kText, {"reference"}, "", "the machine that it ran on"},
      {"run_text", Type::kText, {"reference"}, "", "all that decides the run, as YAML"},
      {"states",
       Type::kFloat64,
       {"reference", "sample", "body", "state"},
       "",
       "state of every object at every sample"},
      {"observables",
       Type::kFloat64,
       {"reference", "sample", "observable"},
       "",
       "sums and extremes over all objects at every sample"},
  };
  return kArrays;
}

const std::vector<RunNumber>& RunNumbers() {
  using R = const RunResult&;
  static const std::vector<RunNumber> kNumbers = WithScalars({
      {"status", Type::kInt8, "", "how the run ended", 0,
       [](R r) { return static_cast<double>(r.status); }, StatusNames},
      {"verdict", Type::kInt8, "", "how the run ended as physics: cdb doc verdicts", 0,
       [](R r) { return static_cast<double>(r.judgement.verdict); }, VerdictNames},
      {"first_bad_cycle", Type::kInt32, "",
       "first recorded cycle at which the verdict applies; -1: none", -1,
       [](R r) { return static_cast<double>(r.judgement.first_bad_cycle); }},
      {"bad_objects", Type::kInt32, "",
       "number of objects, or pairs of them, to which the verdict applies; -1: it applies to none",
       -1, [](R r) { return static_cast<double>(r.judgement.bad_objects); }},
      {"n_cycles", Type::kInt32, "", "number of cycles that ran; -1: there is no run", -1,
       [](R r) { return static_cast<double>(r.n_cycles); }},
      {"run/started", Type::kFloat64, "seconds since 1970-01-01 00:00:00", "when the run began",
       kNaN, [](R r) { return r.started_s; }},
      {"run/load_average", Type::kFloat64, "",
       "the machine's one-minute load average when the run began", kNaN,
       [](R r) { return r.load; }},
      {"run/noise", Type::kInt8, "", "whether the run had the machine to itself: cdb doc noise", 0,
       [](R r) { return static_cast<double>(r.noise.noise); },
       [] { return fmt::format("{}", fmt::join(machine::NoiseNames(), " ")); }},
  });
  return kNumbers;
}

const std::vector<RunText>& RunTexts() {
  using plan::Run;
  using R = const RunResult&;
  static const std::vector<RunText> kTexts = {
      {"run/state_hash",
       "hash of every body's position, orientation and velocities after the last cycle",
       [](const Run&, R r) { return r.state_hash; }},
      {"run/run_id", "hash of all that decides the run's result; its name in the journal",
       [](const Run& run, R) { return run.id; }},
      {"run/host", "the machine that the run ran on", [](const Run&, R r) { return r.host; }},
      {"run/message", "why the run did not end well, or the first pair that its detector missed",
       [](const Run&, R r) { return r.message; }},
      {"run/criterion", "the series that shows why the verdict is not stable",
       [](const Run&, R r) { return r.judgement.criterion; }},
      {"run/noise_cause", "what disturbed a noisy run",
       [](const Run&, R r) { return r.noise.why; }},
      {"run/omitted", "parts of the engine that the run omitted, separated by spaces",
       [](const Run&, R r) { return r.omitted; }},
      {"run/needs", "decision about each part of the engine and its reason, one line each",
       [](const Run&, R r) { return r.decisions; }},
      {"run/checked", "questions that the verdict answers: cdb doc verdicts",
       [](const Run& run, R) { return CheckedText(analysis::CoverageOf(run.scene)); }},
      {"run/unchecked", "questions that the verdict leaves open, each with the reason",
       [](const Run& run, R r) { return UncheckedOf(run.scene, r); }},
  };
  return kTexts;
}

}  // namespace cdb::results
