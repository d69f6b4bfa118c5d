#include "compiler/analysis/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::analysis {
namespace {

/// Cycles, objects and other counts are int32 coordinates of the results.
constexpr std::uint64_t kMostCycles = 2147483647;

/// In a readable form: `1 / 15`, `3 / 50`, `0.0123`.
std::string SecondsText(double seconds, double timestep) {
  for (const double unit : {seconds, timestep}) {
    const double rate = std::round(1 / unit);
    if (rate >= 2 && std::fabs(rate * unit - 1) < 1e-9)
      return fmt::format("{:.0f} / {:.0f}", std::round(seconds * rate), rate);
  }
  return schema::FormatReal(seconds);
}

/// The interval nearest to `wanted` that both time steps divide.
std::string IntervalThatWouldDo(double wanted, double timestep, double other) {
  constexpr double kFar = 4096;
  const double near = std::max(1.0, std::round(wanted / timestep));
  for (double away = 0; away <= kFar; ++away)
    for (const double steps : {near + away, near - away})
      if (steps >= 1 && WholeSteps(steps * timestep, other))
        return fmt::format("use an interval of {} s, for example",
                           SecondsText(steps * timestep, timestep));
  return "choose a reference.timestep that divides the time step of the run";
}

/// `every 60` counts cycles: converts it to the number of cycles of the reference in the same time.
template <bool kGrouped>
bool StretchSchedules(plan::SettingsOf<kGrouped>& settings, double from_s, double to_s) {
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (parameter.grouped != kGrouped || !parameter.TakesCall("every")) continue;
    const schema::Call* call = schema::AsCall(settings.ValueOf(parameter));
    if (call == nullptr || call->name != "every") continue;
    const auto& cycles = std::get<schema::Number>(schema::ArgumentOf(*call, "cycles"));
    const auto stretched = WholeSteps(cycles.AsReal() * from_s, to_s);
    if (!stretched) return false;
    schema::Call longer = *call;
    const schema::ParametrisedWord& info = *schema::FindParametrisedWord(longer.name);
    for (std::size_t i = 0; i < info.arguments.size(); ++i)
      if (info.arguments[i].name == "cycles") longer.arguments[i] = *stretched;
    settings.SetValue(parameter, std::move(longer));
  }
  return true;
}

/// All schedules of a scene; false if one cannot be converted.
bool Stretch(plan::Scene& scene, double from_s, double to_s) {
  bool whole = StretchSchedules(scene.world, from_s, to_s);
  for (plan::Group& group : scene.groups)
    whole = StretchSchedules(group.settings, from_s, to_s) && whole;
  return whole;
}

}  // namespace

std::optional<std::uint64_t> WholeSteps(double span_s, double timestep_s) {
  constexpr double kTolerance = 1e-9;
  constexpr double kMost = 4294967296.0;
  const double steps = std::round(span_s / timestep_s);
  if (!(steps >= 1 && steps < kMost) ||
      !(std::fabs(span_s - steps * timestep_s) <= kTolerance * span_s))
    return std::nullopt;
  return static_cast<std::uint64_t>(steps);
}

AccuracyFault FindAccuracyFault(const plan::Scene& scene) {
  if (ErrorsOf(scene).empty()) return {};
  const plan::WorldSettings& world = scene.world;
  const double interval = world.Real("accuracy.interval"), timestep = world.Real("timestep");
  const bool needs_reference = NeedsReference(scene);
  const double reference = needs_reference ? world.Real("accuracy.reference.timestep") : timestep;
  for (const auto& [step, whose] : {std::pair{timestep, "the run"}, {reference, "the reference"}})
    if (!WholeSteps(interval, step))
      return {schema::WorldParameter("accuracy.interval").get(),
              fmt::format("an interval of {} s is not a whole number of time steps of {}, {} s",
                          SecondsText(interval, interval), whose, SecondsText(step, step)),
              IntervalThatWouldDo(interval, timestep, reference)};
  const std::uint64_t cycles = world.Count("warmup") + world.Count("cycles");
  const std::uint64_t samples = cycles / *WholeSteps(interval, timestep);
  if (samples == 0)
    return {schema::WorldParameter("accuracy.interval").get(),
            fmt::format("the run ends before its first sample: it lasts {} s and the interval is "
                        "{} s",
                        schema::FormatReal(static_cast<double>(cycles) * timestep),
                        SecondsText(interval, interval)),
            "take a shorter interval or more cycles"};
  if (!needs_reference) return {};
  // The check of a reference may have twice as many cycles.
  if (samples > kMostCycles / 2 / *WholeSteps(interval, reference))
    return {schema::WorldParameter("accuracy.reference.timestep").get(),
            fmt::format("the reference would have {:.3g} cycles",
                        static_cast<double>(samples) * interval / reference),
            fmt::format("it may have at most {}: take a longer time step", kMostCycles / 2)};
  plan::Scene stretched = scene;
  if (!Stretch(stretched, timestep, reference))
    return {schema::WorldParameter("accuracy.reference.timestep").get(),
            "a schedule changes at a time that is not a whole number of the reference's time steps",
            "take a reference.timestep that divides the time step of the run"};
  const std::uint64_t bodies = BodyCount(scene);
  const std::string_view detector_name = world.WordOr("accuracy.reference.detector");
  const auto detector = schema::FindDetector(detector_name, scene.plugins);
  CDB_CHECK(detector);
  if (!detector->Holds(bodies))
    return {schema::WorldParameter("accuracy.reference.detector").get(),
            fmt::format("'{}' handles at most {} bodies, walls included, but there are {}",
                        detector_name, detector->max_bodies, bodies),
            "use dbvt"};
  return {};
}

std::optional<Sampling> SamplingOf(const plan::Scene& scene) {
  if (scene.role == plan::Role::kMeasured && ErrorsOf(scene).empty()) return std::nullopt;
  const double interval = scene.world.Real("accuracy.interval");
  const auto cycles = WholeSteps(interval, scene.world.Real("timestep"));
  CDB_CHECK(cycles);
  const std::uint64_t all = scene.world.Count("warmup") + scene.world.Count("cycles");
  return Sampling{interval, *cycles, all / *cycles + 1};
}

bool NeedsReference(const plan::Scene& scene) {
  return scene.role == plan::Role::kMeasured &&
         scene.world.WordOr("accuracy.closed_form") == "none" &&
         std::ranges::any_of(ErrorsOf(scene),
                             [](const schema::ErrorInfo* error) { return error->needs_truth; });
}

plan::Scene ReferenceOf(const plan::Scene& scene) {
  const auto sampling = SamplingOf(scene);
  CDB_CHECK(sampling);
  plan::Scene reference = scene;
  reference.role = plan::Role::kReference;
  reference.DropQueries();
  const auto& world = scene.world;
  const double timestep = world.Real("accuracy.reference.timestep");
  const auto steps = WholeSteps(sampling->interval_s, timestep);
  CDB_CHECK(steps);
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (parameter.grouped) continue;
    if (parameter.IsIgnoredBy(schema::Parameter::kReference)) reference.world.EraseValue(parameter);
    if (parameter.of_reference.empty()) continue;
    const schema::Value& value = world.ValueOf(parameter);
    if (value != schema::Value(schema::Word{"same"}))
      reference.world.SetValue(*schema::FindParameter(parameter.of_reference, false), value);
  }
  // Up to the last sample of any run that uses this reference.
  reference.world.Set("cycles", (sampling->count - 1) * *steps);
  reference.world.Set("record", schema::WordList{"stability"});
  CDB_CHECK(Stretch(reference, world.Real("timestep"), timestep));
  reference.KeepUsedPlugins();
  return reference;
}

plan::Scene TwinOf(const plan::Scene& reference) {
  const double interval = reference.world.Real("accuracy.interval");
  const double timestep = reference.world.Real("timestep");
  const std::uint64_t cycles = reference.world.Count("cycles");
  const auto of_timestep = [&](double other,
                               std::uint64_t its_cycles) -> std::optional<plan::Scene> {
    plan::Scene scene = reference;
    if (!WholeSteps(interval, other) || !Stretch(scene, timestep, other)) return std::nullopt;
    scene.role = plan::Role::kTwin;
    scene.seeds.emplace("nudge", plan::StreamSeed(scene.world.Count("seed"), "nudge"));
    scene.world.Set("timestep", other);
    scene.world.Set("cycles", its_cycles);
    scene.world.Set("record", schema::WordList{});
    return scene;
  };
  auto twin = of_timestep(2 * timestep, cycles / 2);
  if (!twin) twin = of_timestep(timestep / 2, 2 * cycles);
  CDB_CHECK(twin);
  return *std::move(twin);
}

void AddReferences(plan::Plan& plan) {
  plan.references.clear();
  std::unordered_map<std::string, std::string> twins;  // by the reference's id
  const auto add = [&plan](plan::Scene scene) {
    plan::Run run;
    run.id = plan::RunId(scene, 0);
    run.scene = std::move(scene);
    plan.references.push_back(std::move(run));
    return plan.references.back().id;
  };
  for (plan::Run& run : plan.runs) {
    run.reference.clear();
    run.twin.clear();
    if (!NeedsReference(run.scene)) continue;
    const plan::Scene scene = ReferenceOf(run.scene);
    run.reference = plan::RunId(scene, 0);
    const auto [twin, is_new] = twins.try_emplace(run.reference);
    if (is_new) {
      add(scene);
      twin->second = add(TwinOf(scene));
    }
    run.twin = twin->second;
  }
}

namespace {

using schema::ErrorInfo;
using schema::WordList;

/// Most runs of most plans request no errors, and a plan can have many runs.
bool AsksForNone(const WordList& metrics) { return metrics.size() == 1 && metrics[0] == "none"; }

const WordList& MetricsOf(const plan::Scene& scene) {
  return scene.world.Words("accuracy.metrics");
}

template <typename Words>
std::vector<const ErrorInfo*> ErrorsNamed(const Words& words) {
  std::vector<const ErrorInfo*> errors;
  for (const ErrorInfo& error : schema::Errors())
    if (std::ranges::find(words, error.metric) != words.end()) errors.push_back(&error);
  return errors;
}

}  // namespace

std::vector<const ErrorInfo*> ErrorsOf(const plan::Scene& scene) {
  const WordList& metrics = MetricsOf(scene);
  return AsksForNone(metrics) ? std::vector<const ErrorInfo*>() : ErrorsNamed(metrics);
}

std::vector<const ErrorInfo*> ErrorsOf(const plan::Plan& plan) {
  std::set<std::string, std::less<>> words;
  for (const plan::Run& run : plan.Bounds())
    if (const WordList& metrics = MetricsOf(run.scene); !AsksForNone(metrics))
      words.insert(metrics.begin(), metrics.end());
  return ErrorsNamed(words);
}

std::uint64_t BodyCount(const plan::Scene& scene) {
  const std::string_view walls = scene.world.WordOr("world.walls");
  return scene.ObjectCount() + (walls == "all" ? kWallCount : walls == "floor" ? 1 : 0);
}

std::uint64_t MaxBodyCount(const plan::Plan& plan) {
  std::uint64_t most = 0;
  for (const plan::Run& run : plan.Bounds()) most = std::max(most, BodyCount(run.scene));
  return most;
}

}  // namespace cdb::analysis
