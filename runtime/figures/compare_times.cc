#include "runtime/figures/compare.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "runtime/figures/times.h"

namespace cdb::figures {
namespace {

using protocol::Phase;

/// The number of fastest repeats that count: see runtime/figures/times.h.
std::size_t FastestOf(const ComparedFile& a, const ComparedFile& b) {
  return figures::FastestOf(std::min(a.file.begun_repeats(), b.file.begun_repeats()));
}

CycleTimes TimesOf(const ComparedFile& of, const ComparedFile& other) {
  return CycleTimes(of.file, CycleStatistic::kMean, FastestOf(of, other));
}

class TimeComparer {
 public:
  TimeComparer(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
               std::optional<Phase> phase)
      : a_(a),
        b_(b),
        match_(match),
        times_a_(TimesOf(a, b)),
        times_b_(TimesOf(b, a)),
        test_(times_a_.bootstrap(), times_b_.bootstrap()),
        phases_(phase ? std::vector{*phase} : AllPhases()) {
    made_.has_intervals = test_.HasIntervals();
    made_.common_phase = phase.value_or(Phase::kStep);
  }

  TimeComparison Compare() {
    if (!a_.file.Has("duration") || !b_.file.Has("duration")) return std::move(made_);
    for (std::size_t i = 0; i < match_.points.size(); ++i) {
      if (std::string why = WhyNot(i); !why.empty()) {
        made_.left_out.emplace_back(i, std::move(why));
      } else {
        AddPoint(i);
      }
    }
    MakeGroups();
    MakeRelative();
    CompareHarness();
    return std::move(made_);
  }

 private:
  const MeasuredPoint* MeasuredA(std::size_t i) const { return a_.model.Find(match_.points[i].a); }
  const MeasuredPoint* MeasuredB(std::size_t i) const { return b_.model.Find(match_.points[i].b); }

  /// The reason why the times of a point cannot be compared; empty if they can.
  std::string WhyNot(std::size_t i) const {
    const MeasuredPoint *a = MeasuredA(i), *b = MeasuredB(i);
    for (const auto& [point, file] : {std::pair{a, &a_}, std::pair{b, &b_}}) {
      if (point == nullptr) return fmt::format("no timed cycle in {}", file->name);
      if (!point->IsSound()) return fmt::format("{} in {}", point->fault, file->name);
    }
    if (const auto unlike = a->UnlikeComponents(*b); !unlike.empty())
      return fmt::format(
          "one of the files omitted {}, so it did less work: run both with omit none",
          fmt::join(unlike, ", "));
    const std::uint64_t cycles_a = a_.file.ReadCycleCount(a->cells[0]),
                        cycles_b = b_.file.ReadCycleCount(b->cells[0]);
    if (cycles_a != cycles_b) return fmt::format("{} and {} cycles", cycles_a, cycles_b);
    return {};
  }

  void AddPoint(std::size_t i) {
    TimedPoint timed = {i, {}};
    for (const Phase phase : phases_) {
      const Estimate &a = times_a_.Of(*MeasuredA(i), phase).mean,
                     &b = times_b_.Of(*MeasuredB(i), phase).mean;
      // An omitted phase has no times.
      if (!(a.value > 0) || !(b.value > 0)) continue;
      const Change change = ChangeOf(a, b);
      timed.phases.push_back({phase, a.value, b.value, change, {test_.Of(change)}, {}});
    }
    if (!timed.phases.empty()) made_.points.push_back(std::move(timed));
  }

  void MakeGroups() {
    std::map<std::string, std::map<Phase, std::vector<const TimeChange*>>> members;
    for (const TimedPoint& point : made_.points) {
      const std::string name =
          match_.group ? match_.points[point.point].place[*match_.group] : "all points";
      auto group = std::ranges::find(made_.groups, name, &TimedGroup::name);
      if (group == made_.groups.end()) group = made_.groups.insert(group, {name, 0, {}});
      ++group->points;
      for (const TimeChange& change : point.phases) members[name][change.phase].push_back(&change);
    }
    for (TimedGroup& group : made_.groups) {
      for (const auto& [phase, changes] : members[group.name]) {
        std::vector<Change> parts;
        std::vector<double> of_a, of_b;
        for (const TimeChange* change : changes) {
          parts.push_back(change->change);
          of_a.push_back(change->a_ns);
          of_b.push_back(change->b_ns);
        }
        const Change mean = GeometricMeanOf(parts);
        group.phases.push_back(
            {phase, GeometricMean(of_a), GeometricMean(of_b), mean, {test_.Of(mean)}, {}});
      }
    }
  }

  /// Divides each group's ratio by the median of all groups, for each phase.
  void MakeRelative() {
    for (const Phase phase : phases_) {
      std::vector<TimeChange*> of_groups;
      std::vector<Change> changes;
      for (TimedGroup& group : made_.groups)
        for (TimeChange& change : group.phases)
          if (change.phase == phase) {
            of_groups.push_back(&change);
            changes.push_back(change.change);
          }
      if (of_groups.size() < TimeComparison::kLeastGroups) continue;
      const Change median = MedianOf(changes);
      if (phase == made_.common_phase) made_.common = test_.Of(median);
      for (TimeChange* change : of_groups)
        change->relative.tested = test_.Of(RatioOf(change->change, median));
    }
  }

  /// Points take the place of cycles here: each repeat measures the overhead once at each point.
  Estimate HarnessOf(const ComparedFile& of, bool is_a) {
    std::vector<std::vector<double>> repeats(of.file.begun_repeats());
    for (const TimedPoint& point : made_.points)
      for (const results::ResultFile::Cell& cell :
           (is_a ? MeasuredA(point.point) : MeasuredB(point.point))->cells)
        repeats[cell.rep].push_back(of.file.ReadReal("harness", cell));
    return TimesOver(repeats, (is_a ? times_a_ : times_b_).bootstrap(), CycleStatistic::kMean,
                     FastestOf(a_, b_))
        .mean;
  }

  void CompareHarness() {
    if (made_.points.empty() || !a_.file.Has("harness") || !b_.file.Has("harness")) return;
    const TestedChange tested = test_.Of(ChangeOf(HarnessOf(a_, true), HarnessOf(b_, false)));
    if (std::isfinite(tested.ratio)) made_.harness = tested;
  }

  const ComparedFile &a_, &b_;
  const PointMatch& match_;
  CycleTimes times_a_, times_b_;
  const ChangeTest test_;
  const std::vector<Phase> phases_;
  TimeComparison made_;
};

/// Adjusts the p-values of one family of tests and judges them.
template <typename Adjust>
void JudgeFamily(const std::vector<JudgedChange*>& family, Adjust adjust, double margin) {
  std::vector<double> p;
  for (const JudgedChange* change : family) p.push_back(change->tested.p);
  const std::vector<double> adjusted = adjust(p);
  for (std::size_t i = 0; i < family.size(); ++i) {
    family[i]->adjusted_p = adjusted[i];
    family[i]->verdict = JudgeChange(family[i]->tested, adjusted[i], margin);
  }
}

}  // namespace

TimeComparison CompareTimes(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
                            std::optional<Phase> phase) {
  return TimeComparer(a, b, match, phase).Compare();
}

void JudgeTimes(const std::vector<TimeComparison*>& comparisons, double margin) {
  std::vector<JudgedChange*> groups, relative, points;
  for (TimeComparison* comparison : comparisons) {
    for (TimedGroup& group : comparison->groups)
      for (TimeChange& change : group.phases) {
        groups.push_back(&change.absolute);
        relative.push_back(&change.relative);
      }
    for (TimedPoint& point : comparison->points)
      for (TimeChange& change : point.phases) points.push_back(&change.absolute);
  }
  JudgeFamily(groups, HolmAdjusted, margin);
  JudgeFamily(relative, HolmAdjusted, margin);
  JudgeFamily(points, BenjaminiHochbergAdjusted, margin);
}

}  // namespace cdb::figures
