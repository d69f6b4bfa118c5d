#include "runtime/compare/result.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/compare/document.h"

namespace cdb::compare {
namespace {

constexpr std::size_t kMostPlaces = 6;

class ResultText {
 public:
  ResultText(const Comparison& comparison, const CompareOptions& options)
      : of_(comparison), options_(options) {}

  std::vector<std::string> ChangedFacts() const {
    std::vector<std::string> lines;
    if (!of_.states.other.empty() || !of_.states.unsettled.empty()) AddStates(lines);
    for (const FactComparison& fact : of_.facts) AddFact(lines, fact);
    return lines;
  }

  std::vector<std::string> Results() const {
    std::vector<std::string> lines;
    AddTimes(lines);
    AddStates(lines);
    for (const FactComparison& fact : of_.facts) AddFact(lines, fact);
    AddUnchanged(lines);
    const std::vector<std::string> worse = WorseThings(of_, options_);
    lines.push_back(
        worse.empty()
            ? fmt::format("Nothing is significantly worse by more than {}", Margin())
            : fmt::format("WORSE by more than {}, exit status 4: {}", Margin(), PlacesText(worse)));
    return lines;
  }

 private:
  std::string Margin() const { return fmt::format("{:g} %", 100 * options_.margin); }
  std::string PlaceOf(std::size_t point) const {
    return of_.match.points[point].PlaceText(of_.match.axes);
  }

  void AddTimes(std::vector<std::string>& lines) const {
    const TimeComparison& times = of_.times;
    if (times.groups.empty()) {
      lines.push_back("Times: nothing to compare");
    } else {
      AddCommonShift(lines);
      AddVerdict(lines, ChangeVerdict::kSlower, "SLOWER");
      AddVerdict(lines, ChangeVerdict::kFaster, "FASTER");
      AddSame(lines);
      AddUnknown(lines);
      AddPointCounts(lines);
    }
    if (!times.left_out.empty()) {
      std::vector<std::string> places;
      for (const auto& [point, why] : times.left_out)
        places.push_back(fmt::format("{} ({})", PlaceOf(point), why));
      lines.push_back("Times not compared: " + PlacesText(places));
    }
  }

  /// Groups with the phases of that verdict: `grid broad, detect; sweep`, the latter in all phases.
  /// `bound` is raised to the largest bound of their distances from 1.
  std::vector<std::string> GroupsJudged(ChangeVerdict verdict, double& bound) const {
    std::vector<std::string> groups;
    for (const TimedGroup& group : of_.times.groups) {
      std::vector<std::string> phases;
      for (const TimeChange& change : group.phases) {
        const JudgedChange& judged = JudgementOf(change, options_);
        if (judged.verdict != verdict) continue;
        phases.push_back(PhaseName(change.phase));
        if (judged.tested.IsTested()) bound = std::fmax(bound, judged.tested.Bound());
      }
      if (phases.empty()) continue;
      groups.push_back(phases.size() == group.phases.size()
                           ? group.name
                           : fmt::format("{} {}", group.name, fmt::join(phases, ", ")));
    }
    return groups;
  }

  void AddSame(std::vector<std::string>& lines) const {
    double bound = 0;
    const std::vector<std::string> groups = GroupsJudged(ChangeVerdict::kSame, bound);
    if (!groups.empty())
      lines.push_back(fmt::format("Same within {:.1f} %: {}", 100 * bound, PlacesText(groups)));
  }

  void AddUnknown(std::vector<std::string>& lines) const {
    double bound = 0;
    const std::vector<std::string> groups = GroupsJudged(ChangeVerdict::kCannotTell, bound);
    if (groups.empty()) return;
    const std::uint64_t least = std::min(of_.a->file.begun_repeats(), of_.b->file.begun_repeats());
    std::string why = fmt::format(
        "the noise is larger than {}: the ratio may be up to {:.0f} % from 1. Add repeats",
        Margin(), 100 * bound);
    if (bound == 0) why = "repeats are missing or void";
    if (!of_.times.has_intervals)
      why = fmt::format(
          "there {} {} repeat{}, but an interval needs {} in each file (facts below are exact)",
          least == 1 ? "is" : "are", least, least == 1 ? "" : "s",
          statistics::Bootstrap::kLeastForInterval);
    lines.push_back(fmt::format("Cannot tell, as {}: {}", why, PlacesText(groups)));
  }

  void AddCommonShift(std::vector<std::string>& lines) const {
    const TimeComparison& times = of_.times;
    if (!times.HasCommonShift()) return;
    const TestedChange& common = *times.common;
    const std::string phase = PhaseName(times.common_phase);
    std::string line = fmt::format(
        "EVERYTHING is {}: the median {} over all groups is {} ({}). The cause is the machine, or "
        "shared code",
        common.ratio > 1 ? "slower" : "faster", phase, PercentText(common.ratio),
        PercentRange(common.interval.low, common.interval.high));
    if (times.harness && times.harness->IsTested())
      line += fmt::format("; cdb's own overhead, which no detector changes, is {} ({})",
                          PercentText(times.harness->ratio),
                          PercentRange(times.harness->interval.low, times.harness->interval.high));
    lines.push_back(line);
    lines.push_back(options_.is_relative
                        ? "Below, each group relative to that median"
                        : "The column `relative` has each group over that median; --relative "
                          "judges by it");
  }

  /// `SLOWER: grid: detect +5.2 % (+4.6 .. +5.8 %), step …`.
  void AddVerdict(std::vector<std::string>& lines, ChangeVerdict verdict, const char* name) const {
    for (const TimedGroup& group : of_.times.groups) {
      std::string phases;
      for (const TimeChange& change : group.phases) {
        const JudgedChange& judged = JudgementOf(change, options_);
        if (judged.verdict == verdict)
          phases +=
              fmt::format("{}{} {} ({})", phases.empty() ? "" : ", ", PhaseName(change.phase),
                          PercentText(judged.tested.ratio),
                          PercentRange(judged.tested.interval.low, judged.tested.interval.high));
      }
      if (!phases.empty()) lines.push_back(fmt::format("{}: {}: {}", name, group.name, phases));
    }
  }

  /// Counts the points that changed in groups that did not.
  void AddPointCounts(std::vector<std::string>& lines) const {
    if (of_.times.points.size() == of_.times.groups.size()) return;
    std::size_t tests = 0, slower = 0, faster = 0;
    for (const TimedPoint& point : of_.times.points)
      for (const TimeChange& change : point.phases) {
        tests += change.absolute.tested.IsTested() ? 1 : 0;
        slower += change.absolute.verdict == ChangeVerdict::kSlower ? 1 : 0;
        faster += change.absolute.verdict == ChangeVerdict::kFaster ? 1 : 0;
      }
    if (tests > 0)
      lines.push_back(
          fmt::format("Single points: {} slower and {} faster, of {} tests (points times phases)",
                      slower, faster, tests));
  }

  void AddStates(std::vector<std::string>& lines) const {
    const StateComparison& states = of_.states;
    const std::size_t known = of_.match.points.size() - states.unknown;
    if (known == 0) return;
    if (states.same == known) {
      lines.push_back(
          fmt::format("{} at {} of {}{}",
                      states.of_pairs ? "Pairs: the same in the last cycle"
                                      : "Physics: the same last state to the last bit",
                      states.same, Counted(of_.match.points.size(), "point"),
                      states.unknown > 0 ? "; at the others, a run did not reach its end" : ""));
      return;
    }
    std::vector<std::string> other, unsettled;
    for (const std::size_t point : states.other) other.push_back(PlaceOf(point));
    for (const std::size_t point : states.unsettled) unsettled.push_back(PlaceOf(point));
    if (!other.empty())
      lines.push_back(fmt::format("{} at {} of {}, whose times are of {}: {}",
                                  states.of_pairs ? "PAIRS DIFFER: other pairs in the last cycle"
                                                  : "PHYSICS DIFFERS: another last state",
                                  other.size(), Counted(known, "point"),
                                  states.of_pairs ? "other pairs" : "another motion",
                                  PlacesText(other)));
    if (!unsettled.empty())
      lines.push_back(fmt::format("NOT REPEATABLE: repeats in one file end in different states: {}",
                                  PlacesText(unsettled)));
  }

  static const char* HeadOf(FactComparison::Kind kind, Direction direction) {
    const bool is_worse = direction == Direction::kWorse;
    switch (kind) {
      case FactComparison::Kind::kVerdict:
        return is_worse ? "LESS STABLE" : "MORE STABLE";
      case FactComparison::Kind::kError:
      case FactComparison::Kind::kPairs:
        return is_worse ? "LESS TRUE" : "MORE TRUE";
      default:
        return is_worse ? "MORE MEMORY" : "LESS MEMORY";
    }
  }

  void AddFact(std::vector<std::string>& lines, const FactComparison& fact) const {
    for (const Direction direction : {Direction::kWorse, Direction::kBetter}) {
      const std::size_t count = fact.Count(direction);
      if (count == 0) continue;
      const auto most = std::ranges::find(fact.changes, direction, &FactChange::direction);
      lines.push_back(fmt::format("{}: {} at {} of {}{}: {}: {}", HeadOf(fact.kind, direction),
                                  fact.name, count, Counted(fact.points, "point"),
                                  count > 1 ? ", the most" : "", PlaceOf(most->point),
                                  ChangeText(*most)));
    }
  }

  void AddUnchanged(std::vector<std::string>& lines) const {
    std::vector<std::string> names;
    for (const FactComparison& fact : of_.facts)
      if (fact.changes.empty()) names.push_back(fact.name);
    if (!names.empty()) lines.push_back(fmt::format("Unchanged: {}", fmt::join(names, ", ")));
  }

  const Comparison& of_;
  const CompareOptions options_;
};

}  // namespace

std::vector<std::string> ResultLines(const Comparison& comparison, const CompareOptions& options) {
  return ResultText(comparison, options).Results();
}

std::vector<std::string> FactLines(const Comparison& comparison) {
  return ResultText(comparison, {}).ChangedFacts();
}

std::string PhaseName(measure::Phase phase) {
  return std::string(measure::PhaseNames()[measure::IndexOf(phase)]);
}

/// `8 points`.
std::string Counted(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// The first of `places`, and the number of the others.
std::string PlacesText(const std::vector<std::string>& places) {
  const auto shown = static_cast<std::ptrdiff_t>(std::min(places.size(), kMostPlaces));
  std::string text = fmt::format("{}", fmt::join(places.begin(), places.begin() + shown, "; "));
  if (places.size() > kMostPlaces)
    text += fmt::format("; and {} more", places.size() - kMostPlaces);
  return text;
}

std::string ChangeText(const FactChange& change) {
  const double relative = change.RelativeChange();
  return fmt::format("{} -> {}{}", change.text_a, change.text_b,
                     std::isfinite(relative) ? fmt::format(" ({:+.3g} %)", 100 * relative) : "");
}

std::string VerdictText(const JudgedChange& change) {
  switch (change.verdict) {
    case ChangeVerdict::kFaster:
      return "faster";
    case ChangeVerdict::kSlower:
      return "SLOWER";
    case ChangeVerdict::kSame:
      return fmt::format("same within {:.1f} %", 100 * change.tested.Bound());
    case ChangeVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

}  // namespace cdb::compare
