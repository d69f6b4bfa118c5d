#include "runtime/compare/compare.h"

#include <fmt/format.h>

namespace cdb::compare {

namespace {

/// Throws StoreError as MatchPoints does; for different benchmarks, the message begins with that.
PointMatch MatchBenchmarks(const ComparedFile& a, const ComparedFile& b,
                           const CompareOptions& options) {
  std::vector<statistics::AxisSelection> selections;
  for (const std::string& word : options.select)
    selections.push_back(statistics::ParseSelection(word));
  try {
    return MatchPoints(a, b, selections);
  } catch (const files::StoreError& error) {
    if (a.file.benchmark() == b.file.benchmark()) throw;
    throw files::StoreError(fmt::format("{} has the benchmark '{}', but {} has '{}': {}", a.name,
                                        a.file.benchmark(), b.name, b.file.benchmark(),
                                        error.what()));
  }
}

}  // namespace

Comparison Compare(const ComparedFile& a, const ComparedFile& b, const CompareOptions& options) {
  Comparison made = {&a, &b, MatchBenchmarks(a, b, options), {}, {}, {}, {}};
  made.setup = CompareSetups(a, b, made.match);
  made.states = CompareStates(a, b, made.match);
  made.facts = CompareFacts(a, b, made.match);
  made.times = CompareTimes(a, b, made.match, options.phase);
  if (options.is_relative && !made.times.common)
    throw files::StoreError(
        fmt::format("--relative needs {} detectors or more, whose median shows the common change; "
                    "{} and {} have {}",
                    TimeComparison::kLeastGroups, a.name, b.name, made.times.groups.size()));
  return made;
}

void JudgeAll(const std::vector<Comparison*>& comparisons, const CompareOptions& options) {
  std::vector<TimeComparison*> times;
  for (Comparison* comparison : comparisons) times.push_back(&comparison->times);
  JudgeTimes(times, options.margin);
}

const JudgedChange& JudgementOf(const TimeChange& change, const CompareOptions& options) {
  return options.is_relative ? change.relative : change.absolute;
}

std::vector<std::string> WorseThings(const Comparison& comparison, const CompareOptions& options) {
  std::vector<std::string> worse;
  const auto add = [&](const std::string& place, measure::Phase phase) {
    worse.push_back(fmt::format("{} {}", place, measure::PhaseNames()[measure::IndexOf(phase)]));
  };
  for (const FactComparison& fact : comparison.facts)
    if (fact.IsWorse(options.margin)) worse.push_back(fact.name);
  for (const TimedGroup& group : comparison.times.groups)
    for (const TimeChange& change : group.phases)
      if (JudgementOf(change, options).IsSlowerThan(options.margin)) add(group.name, change.phase);
  if (options.is_relative || comparison.times.points.size() == comparison.times.groups.size())
    return worse;
  for (const TimedPoint& point : comparison.times.points)
    for (const TimeChange& change : point.phases)
      if (change.absolute.IsSlowerThan(options.margin))
        add(comparison.match.points[point.point].PlaceText(comparison.match.axes), change.phase);
  return worse;
}

bool IsWorse(const Comparison& comparison, const CompareOptions& options) {
  return !WorseThings(comparison, options).empty();
}

}  // namespace cdb::compare
