#include "runtime/figures/compare.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "compiler/analysis/trace.h"
#include "compiler/plan/clock.h"
#include "compiler/schema/metrics.h"
#include "runtime/figures/points.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

using Kind = FactComparison::Kind;

/// The assumed spread of the peak memory of a process if there are too few repeats to measure it.
constexpr double kSpreadOfFew = 0.05;

/// Empty for a run that failed before its last cycle.
std::set<std::string> StatesAt(const results::ResultFile& file, const Point& at) {
  std::set<std::string> states;
  for (const Cell& cell : CellsThatRan(file, at))
    if (std::string state = file.ReadText("state_hash", cell); !state.empty())
      states.insert(std::move(state));
  return states;
}

std::string EndingText(const Ending& ending) {
  const std::int64_t cycle = ending.judgement.first_bad_cycle;
  return cycle < 0 ? ending.Word() : fmt::format("{} from cycle {} on", ending.Word(), cycle);
}

FactComparison CompareVerdicts(const ComparedFile& a, const ComparedFile& b,
                               const PointMatch& match) {
  FactComparison fact = {Kind::kVerdict, "verdicts", 0, {}};
  for (std::size_t i = 0; i < match.points.size(); ++i) {
    const Ending of_a = WorstEnding(a.file, match.points[i].a),
                 of_b = WorstEnding(b.file, match.points[i].b);
    if (!of_a.IsKnown() || !of_b.IsKnown()) continue;
    ++fact.points;
    const std::int64_t cycle_a = of_a.judgement.first_bad_cycle,
                       cycle_b = of_b.judgement.first_bad_cycle;
    if (of_a.Rank() == of_b.Rank() && cycle_a == cycle_b) continue;
    const bool is_worse =
        of_a.Rank() != of_b.Rank() ? of_b.Rank() > of_a.Rank() : cycle_b < cycle_a;
    fact.changes.push_back({i, is_worse ? Direction::kWorse : Direction::kBetter, kNone, kNone,
                            EndingText(of_a), EndingText(of_b)});
  }
  return fact;
}

/// False if a repeat of the point ended early: it timed out or crashed.
bool IsWhole(const results::ResultFile& file, const MeasuredPoint& point) {
  return std::ranges::all_of(point.cells, [&](const Cell& cell) {
    return file.ReadStatus(cell) == results::Status::kDone;
  });
}

/// A value of a point, and how it is compared.
struct NumberFact {
  Kind kind;
  std::string name;
  std::string unit = {};
  bool less_is_better = true;
  bool varies = false;  ///< the value varies between repeats: a difference up to
                        ///< the floor is none
  double scale = 1;     ///< of the unit
  using ValueOf = std::function<double(const Model&, const MeasuredPoint&)>;
  ValueOf value = {};
  ValueOf floor = {};          ///< differences up to the floor are not significant
  bool of_whole_runs = false;  ///< no value for a run that ended early

  double ValueAt(const Model& model, const Point& at) const {
    const MeasuredPoint* point = model.Find(at);
    if (point == nullptr || (of_whole_runs && !IsWhole(model.file(), *point))) return kNone;
    return scale * value(model, *point);
  }
  double FloorAt(const Model& model, const Point& at) const {
    const MeasuredPoint* point = model.Find(at);
    return point == nullptr || !floor ? 0 : std::fmax(0, scale * floor(model, *point));
  }
};

std::string NumberText(double value, const std::string& unit) {
  if (std::isnan(value)) return "no value";
  const std::string number = value == std::round(value) && std::fabs(value) < 1e7
                                 ? fmt::format("{:.0f}", value)
                                 : fmt::format("{:#.4g}", value);
  return unit.empty() ? number : number + " " + unit;
}

FactComparison CompareNumbers(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
                              const NumberFact& of) {
  FactComparison fact = {of.kind, of.name, 0, {}};
  for (std::size_t i = 0; i < match.points.size(); ++i) {
    const auto& [at_a, at_b, place] = match.points[i];
    const double value_a = of.ValueAt(a.model, at_a), value_b = of.ValueAt(b.model, at_b);
    if (std::isnan(value_a) && std::isnan(value_b)) continue;
    // Verdicts say that a run ended early.
    if (of.of_whole_runs && (std::isnan(value_a) || std::isnan(value_b))) continue;
    ++fact.points;
    if (value_a == value_b) continue;
    const double floor = std::fmax(of.FloorAt(a.model, at_a), of.FloorAt(b.model, at_b));
    if (of.varies && std::fabs(value_b - value_a) <= floor) continue;
    Direction direction = Direction::kOther;
    // A missing value is the worst.
    const bool is_worse = std::isnan(value_b) || value_b > value_a;
    if (of.less_is_better && !(std::fabs(value_b - value_a) <= floor))
      direction = is_worse ? Direction::kWorse : Direction::kBetter;
    fact.changes.push_back({i, direction, value_a, value_b, NumberText(value_a, of.unit),
                            NumberText(value_b, of.unit)});
  }
  std::ranges::stable_sort(fact.changes, std::greater(), [](const FactChange& change) {
    return std::fabs(change.RelativeChange());
  });
  return fact;
}

/// The sum over the cycles that have a value; NaN if none has.
double SumOf(const Model& model, const MeasuredPoint& point, const char* series) {
  double sum = kNone;
  for (const double value : model.file().ReadSeries(series, point.cells[0]))
    if (value >= 0) sum = (std::isnan(sum) ? 0 : sum) + value;
  return sum;
}

/// The spread of the memory `name` between repeats, at least kNegligible of the largest; more for
/// the peak memory of few repeats, which show little of the spread.
double MemorySpread(const Model& model, const MeasuredPoint& point, const std::string& name) {
  double smallest = kNone;
  std::size_t repeats = 0;
  for (const Cell& cell : point.cells) {
    MeasuredPoint one = point;
    one.cells = {cell};
    if (const double bytes = model.MemoryOf(one, name); std::isfinite(bytes)) {
      smallest = std::fmin(smallest, bytes);
      ++repeats;
    }
  }
  if (repeats == 0) return 0;
  const double largest = model.MemoryOf(point, name);
  const bool is_unsure = name == "peak_rss" && repeats < Bootstrap::kLeastForInterval;
  return std::fmax(largest - smallest, (is_unsure ? kSpreadOfFew : kNegligible) * largest);
}

std::vector<NumberFact> AllFacts() {
  std::vector<NumberFact> facts;
  for (const schema::ErrorInfo& error : schema::Errors()) {
    const auto read = [](const std::string& name) {
      return [name](const Model& model, const MeasuredPoint& point) {
        return model.ErrorOf(point, name);
      };
    };
    const std::string name(error.name);
    facts.push_back({.kind = Kind::kError,
                     .name = "accuracy/" + name,
                     .unit = std::string(error.unit),
                     .value = read(name),
                     .floor = read(name + "_floor")});
  }
  for (const char* series : {"missed_pairs", "missed_contacts", "phantom_pairs", "duplicate_pairs",
                             "pairs", "contacts"}) {
    const bool is_missed = std::string_view(series).starts_with("missed");
    facts.push_back(
        {.kind = is_missed ? Kind::kPairs : Kind::kCount,
         .name = series,
         .less_is_better = is_missed,
         .value = [series](const Model& model,
                           const MeasuredPoint& point) { return SumOf(model, point, series); },
         .of_whole_runs = true});
  }
  for (const std::string name : {"heap", "peak_rss"})
    facts.push_back(
        {.kind = Kind::kMemory,
         .name = name,
         .unit = "MB",
         .varies = true,
         .scale = 1e-6,
         .value = [name](const Model& model,
                         const MeasuredPoint& point) { return model.MemoryOf(point, name); },
         .floor = [name](const Model& model,
                         const MeasuredPoint& point) { return MemorySpread(model, point, name); },
         .of_whole_runs = true});
  return facts;
}

/// The title of a fact in the output.
std::string TitleOf(const NumberFact& fact) {
  std::string title =
      fact.kind == Kind::kError ? fact.name.substr(std::string("accuracy/").size()) : fact.name;
  std::ranges::replace(title, '_', ' ');
  if (fact.name == "phantom_pairs") return "false positive pairs";
  if (fact.name == "peak_rss") return "peak memory";
  if (fact.name == "heap") return "heap memory";
  return fact.kind == Kind::kError ? title + " error" : title;
}

}  // namespace

double FactChange::RelativeChange() const {
  if (!std::isfinite(a) || !std::isfinite(b) || a == 0)
    return std::numeric_limits<double>::infinity();
  return (b - a) / std::fabs(a);
}

std::size_t FactComparison::Count(Direction direction) const {
  return static_cast<std::size_t>(std::ranges::count(changes, direction, &FactChange::direction));
}

bool FactComparison::IsWorse(double margin) const {
  return std::ranges::any_of(changes, [&](const FactChange& change) {
    if (change.direction != Direction::kWorse) return false;
    return kind == Kind::kVerdict || kind == Kind::kPairs || change.RelativeChange() > margin;
  });
}

bool ComparedFile::IsOnTraces() const {
  return plan && std::ranges::all_of(plan->runs, [](const plan::Run& run) {
           return analysis::TraceOf(run.scene).has_value();
         });
}

bool ComparedFile::CountsInstructions() const { return plan && plan::CountsInstructions(*plan); }

bool FileComparison::HasExactPairs() const {
  return std::ranges::any_of(facts,
                             [](const FactComparison& fact) { return fact.kind == Kind::kPairs; });
}

bool FileComparison::HasOtherDetectors() const {
  return std::ranges::any_of(setup.parameters, [](const SetupDifference& difference) {
    return difference.name == "detector" || difference.name == "narrow_phase";
  });
}

std::vector<std::size_t> FileComparison::OtherPairs() const {
  std::set<std::size_t> points;
  if (states.of_pairs) points.insert(states.other.begin(), states.other.end());
  const std::set<std::size_t> moved(states.other.begin(), states.other.end());
  for (const FactComparison& fact : facts)
    if (fact.kind == Kind::kCount && fact.name == "pairs")
      for (const FactChange& change : fact.changes)
        if (states.of_pairs || !moved.contains(change.point)) points.insert(change.point);
  return {points.begin(), points.end()};
}

StateComparison CompareStates(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match) {
  StateComparison states;
  states.of_pairs = a.IsOnTraces();
  const bool has_both = a.file.Has("state_hash") && b.file.Has("state_hash");
  for (std::size_t i = 0; i < match.points.size(); ++i) {
    const auto of_a = has_both ? StatesAt(a.file, match.points[i].a) : std::set<std::string>();
    const auto of_b = has_both ? StatesAt(b.file, match.points[i].b) : std::set<std::string>();
    if (of_a.empty() || of_b.empty()) {
      ++states.unknown;
    } else if (of_a.size() > 1 || of_b.size() > 1) {
      states.unsettled.push_back(i);
    } else if (of_a == of_b) {
      ++states.same;
    } else {
      states.other.push_back(i);
    }
  }
  return states;
}

std::vector<FactComparison> CompareFacts(const ComparedFile& a, const ComparedFile& b,
                                         const PointMatch& match) {
  std::vector<FactComparison> compared = {CompareVerdicts(a, b, match)};
  for (const NumberFact& fact : AllFacts()) {
    if (!a.file.Has(fact.name) || !b.file.Has(fact.name)) continue;
    compared.push_back(CompareNumbers(a, b, match, fact));
    compared.back().name = TitleOf(fact);
  }
  std::erase_if(compared, [](const FactComparison& fact) { return fact.points == 0; });
  return compared;
}

// Times.

namespace {

using protocol::Phase;

/// The number of fastest repeats that count: see runtime/figures/times.h.
std::size_t FastestOf(const ComparedFile& a, const ComparedFile& b) {
  return figures::FastestOf(std::min(a.file.begun_repeats(), b.file.begun_repeats()));
}

CycleTimes TimesOf(const ComparedFile& of, const ComparedFile& other) {
  return CycleTimes(of.file, CycleStatistic::kMean, FastestOf(of, other));
}

/// On traces, a step is detection alone, and tests of its parts would be of the same numbers.
std::vector<Phase> PhasesOf(const ComparedFile& of) {
  return of.IsOnTraces() ? std::vector{Phase::kStep} : AllPhases();
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
        test_(times_a_.bootstrap(), times_b_.bootstrap(), NoiseOf(a)),
        phases_(phase ? std::vector{*phase} : PhasesOf(a)) {
    made_.has_intervals = test_.HasIntervals();
    made_.counts_instructions = a.CountsInstructions();
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

  static std::optional<double> NoiseOf(const ComparedFile& of) {
    return of.CountsInstructions() ? std::optional(kCountNoise) : std::nullopt;
  }

  /// The reason why the times of a point cannot be compared; empty if they can.
  std::string WhyNot(std::size_t i) const {
    if (a_.CountsInstructions() != b_.CountsInstructions())
      return "one of the files counts instructions, the other measures time: run both with the "
             "same "
             "clock";
    if (HasCounters(a_.file) != HasCounters(b_.file))
      return "one of the files records counters, whose reading is part of its times: run both with "
             "the same `record`";
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
