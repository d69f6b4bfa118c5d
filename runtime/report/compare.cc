#include "runtime/report/compare.h"

#include <fmt/format.h>

#include <algorithm>

namespace cdb::report {

Comparison Compare(ComparedFile& a, ComparedFile& b, const CompareOptions& options) {
  Comparison made = {&a, &b, MatchPoints(a, b, ParseSelections(options.select)), {}, {}, {}, {}};
  made.setup = CompareSetups(a, b, made.match);
  made.states = CompareStates(a, b, made.match);
  made.facts = CompareFacts(a, b, made.match);
  made.times = CompareTimes(a, b, made.match, options.phase);
  if (options.is_relative && !made.times.common)
    throw store::StoreError(fmt::format(
        "--relative takes {} detectors or more, whose median shows what all have in common; {} and "
        "{} have {}",
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

bool IsWorse(const Comparison& comparison, const CompareOptions& options) {
  if (std::ranges::any_of(comparison.facts,
                          [&](const FactComparison& fact) { return fact.IsWorse(options.margin); }))
    return true;
  for (const TimedGroup& group : comparison.times.groups)
    for (const TimeChange& change : group.phases)
      if (JudgementOf(change, options).IsSlowerThan(options.margin)) return true;
  if (options.is_relative) return false;
  for (const TimedPoint& point : comparison.times.points)
    for (const TimeChange& change : point.phases)
      if (change.absolute.IsSlowerThan(options.margin)) return true;
  return false;
}

}  // namespace cdb::report
