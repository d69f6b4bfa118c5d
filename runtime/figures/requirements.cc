#include "runtime/figures/requirements.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "compiler/schema/series.h"
#include "compiler/schema/verdicts.h"
#include "runtime/figures/boundaries.h"
#include "runtime/figures/conclusions.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {

static_assert(Bootstrap::kLeastForInterval == plan::kLeastRepeats);

std::string_view AnswerName(Answer answer) {
  switch (answer) {
    case Answer::kNotRun:
      return "not run";
    case Answer::kCannotTell:
      return "cannot tell";
    case Answer::kNotMet:
      return "not met";
    case Answer::kMet:
      break;
  }
  return "met";
}

Answer JudgeRange(const Interval& range, plan::Comparison comparison, double limit) {
  using enum plan::Comparison;
  const auto [low, high] = range;
  if (!(low <= high) || std::isnan(limit)) return Answer::kCannotTell;
  // Whether it holds for all values of the range, and for some.
  bool all = false, some = false;
  switch (comparison) {
    case kEqual:
      all = low == limit && high == limit;
      some = low <= limit && limit <= high;
      break;
    case kNotEqual:
      all = limit < low || high < limit;
      some = low != limit || high != limit;
      break;
    case kLess:
    case kAtMost:
    case kGreater:
    case kAtLeast:
      all = plan::Holds(low, comparison, limit) && plan::Holds(high, comparison, limit);
      some = plan::Holds(low, comparison, limit) || plan::Holds(high, comparison, limit);
      break;
  }
  return all ? Answer::kMet : some ? Answer::kCannotTell : Answer::kNotMet;
}

Answer JudgeTime(const Interval& range, const std::optional<double>& at_least,
                 plan::Comparison comparison, double limit) {
  const Answer answer = JudgeRange(range, comparison, limit);
  const bool may_be_noise =
      answer == Answer::kNotMet && at_least && plan::Holds(*at_least, comparison, limit);
  return may_be_noise ? Answer::kCannotTell : answer;
}

std::optional<double> TimeAtLeast(const results::ResultFile& file, const MeasuredPoint& point,
                                  protocol::Phase phase, CycleStatistic statistic) {
  if (2 * CountNoisy(file, point.cells) < point.cells.size()) return std::nullopt;
  std::vector<double> fastest;
  for (const Cell& cell : point.cells) {
    const std::vector<double> repeat = file.ReadDuration(phase, cell);
    fastest.resize(std::max(fastest.size(), repeat.size()), kNone);
    for (std::size_t c = 0; c < repeat.size(); ++c) fastest[c] = std::fmin(fastest[c], repeat[c]);
  }
  return StatisticOf(std::move(fastest),
                     point.cells.size() > 1 ? statistic : CycleStatistic::kMedian);
}

namespace {

constexpr std::string_view kNotNoisyEnough = "noise alone may have made it as long";

std::size_t IndexOfStatistic(std::string_view name) {
  const auto* found = std::ranges::find(plan::kCycleStatistics, name);
  return static_cast<std::size_t>(found - std::begin(plan::kCycleStatistics));
}

double StatisticOfSeries(std::vector<double> values, std::string_view name) {
  if (values.empty()) return kNone;
  if (name == plan::kFinal) return values.back();
  return StatisticOf(std::move(values), static_cast<CycleStatistic>(IndexOfStatistic(name)));
}

protocol::Phase PhaseCalled(std::string_view name) {
  const auto* found = std::ranges::find(schema::kPhases, name);
  return static_cast<protocol::Phase>(found - std::begin(schema::kPhases));
}

/// Judges one requirement of a file at each of its points.
class Judge {
 public:
  Judge(const Model& model, const plan::Requirement& what)
      : model_(model), file_(model.file()), what_(what), figure_(what.figure) {
    if (figure_.kind != plan::FigureKind::kTime) return;
    const auto statistic = static_cast<CycleStatistic>(IndexOfStatistic(figure_.statistic));
    if (statistic == model.times().statistic()) {
      times_ = &model.times();
    } else if (statistic == CycleStatistic::kP99) {
      times_ = &model.slow().times();
    } else {
      own_times_.emplace(file_, statistic);
      times_ = &*own_times_;
    }
  }

  JudgedPoint At(const GridPoint& point, double limit) {
    JudgedPoint judged;
    judged.at = point.at;
    judged.limit = limit;
    switch (figure_.kind) {
      case plan::FigureKind::kVerdict:
        OfVerdict(point, judged);
        break;
      case plan::FigureKind::kTime:
        if (HasSoundTimes(point, judged)) OfTime(*point.measured, judged);
        break;
      case plan::FigureKind::kError:
        if (HasCycles(point, judged)) OfError(*point.measured, judged);
        break;
      case plan::FigureKind::kSeries:
        if (HasEnded(point, judged))
          OfFacts(*point.measured, judged, [&](const Cell& cell) {
            return file_.Has(figure_.name)
                       ? StatisticOfSeries(file_.ReadSeries(figure_.name, cell), figure_.statistic)
                       : kNone;
          });
        break;
      case plan::FigureKind::kScalar:
        OfScalar(point, judged);
        break;
    }
    return judged;
  }

 private:
  void OfVerdict(const GridPoint& point, JudgedPoint& judged) const {
    const protocol::Verdict verdict = point.ending.judgement.verdict;
    if (verdict == protocol::Verdict::kUnknown) {
      const bool is_done = point.ending.status == results::Status::kDone;
      judged.answer = is_done ? Answer::kCannotTell : Answer::kNotMet;
      judged.why = is_done ? "no verdict was recorded"
                           : fmt::format("the run {}", results::StatusName(point.ending.status));
      return;
    }
    judged.value = judged.low = judged.high = static_cast<double>(verdict);
    judged.answer = JudgeRange({judged.value, judged.value}, what_.comparison, judged.limit);
  }

  static bool CannotTell(JudgedPoint& judged, std::string why) {
    judged.answer = Answer::kCannotTell;
    judged.why = std::move(why);
    return false;
  }

  static bool HasCycles(const GridPoint& point, JudgedPoint& judged) {
    return point.measured != nullptr ||
           CannotTell(judged, fmt::format("the run {}", point.ending.Word()));
  }
  /// The times of void runs are of another motion.
  static bool HasSoundTimes(const GridPoint& point, JudgedPoint& judged) {
    if (!HasCycles(point, judged)) return false;
    return point.measured->IsSound() ||
           CannotTell(judged, fmt::format("the run is {}", point.measured->fault));
  }
  /// A run that broke off has not got the figure of the whole.
  static bool HasEnded(const GridPoint& point, JudgedPoint& judged) {
    if (!HasCycles(point, judged)) return false;
    return point.ending.status == results::Status::kDone ||
           CannotTell(judged, fmt::format("the run {}", point.ending.Word()));
  }

  /// Sets the interval of a measured figure; false if there is none.
  bool SetInterval(const CycleTimes& times, const Estimate& estimate, JudgedPoint& judged) const {
    judged.value = estimate.value;
    if (std::isnan(judged.value)) return CannotTell(judged, "no time was recorded");
    const bool is_interval = times.bootstrap().kind() == IntervalKind::kInterval;
    const Interval interval = is_interval ? times.IntervalOf(estimate) : Interval{kNone, kNone};
    if (!(interval.low <= interval.high)) {
      const std::size_t repeats = is_interval ? estimate.things : times.bootstrap().size();
      return CannotTell(judged, repeats == 1 ? "one repeat does not tell"
                                             : fmt::format("{} repeats do not tell", repeats));
    }
    judged.low = interval.low;
    judged.high = interval.high;
    return true;
  }

  void OfTime(const MeasuredPoint& point, JudgedPoint& judged) {
    const protocol::Phase phase = PhaseCalled(figure_.name);
    if (!file_.Has("duration")) {
      CannotTell(judged, "no time was recorded");
      return;
    }
    const Estimate& estimate = times_->FigureOf(point, phase);
    if (!figure_.IsMeasured()) {  // the longest cycle that there was
      judged.value = judged.low = judged.high = estimate.value;
      judged.answer = JudgeRange({judged.low, judged.high}, what_.comparison, judged.limit);
      return;
    }
    if (!SetInterval(*times_, estimate, judged)) return;
    const Interval range = {judged.low, judged.high};
    judged.answer = JudgeTime(range, TimeAtLeast(file_, point, phase, times_->statistic()),
                              what_.comparison, judged.limit);
    if (judged.answer == Answer::kCannotTell &&
        JudgeRange(range, what_.comparison, judged.limit) == Answer::kNotMet)
      judged.why = kNotNoisyEnough;
  }

  void OfError(const MeasuredPoint& point, JudgedPoint& judged) const {
    judged.value = model_.ErrorOf(point, figure_.name);
    if (std::isnan(judged.value)) {
      CannotTell(judged, "it has no such error");
      return;
    }
    if (std::string fault = model_.ReferenceFaultOf(point); !fault.empty()) {
      CannotTell(judged, std::move(fault));
      return;
    }
    const double floor = model_.ErrorOf(point, figure_.name + "_floor");
    const double beside = std::isnan(floor) ? 0 : floor;
    judged.low = std::fmax(0, judged.value - beside);
    judged.high = judged.value + beside;
    judged.answer = JudgeRange({judged.low, judged.high}, what_.comparison, judged.limit);
    if (judged.answer == Answer::kCannotTell)
      judged.why = fmt::format("the reference itself is off by {}", terminal::ShortNumber(beside));
  }

  /// A figure that is a fact of each repeat.
  template <typename ValueOf>
  void OfFacts(const MeasuredPoint& point, JudgedPoint& judged, ValueOf value_of) const {
    std::vector<double> values;
    for (const Cell& cell : point.cells) values.push_back(value_of(cell));
    if (std::ranges::any_of(values, [](double value) { return std::isnan(value); })) {
      CannotTell(judged, "it has no value");
      return;
    }
    judged.low = std::ranges::min(values);
    judged.high = std::ranges::max(values);
    const auto wrong = std::ranges::find_if(
        values, [&](double value) { return !plan::Holds(value, what_.comparison, judged.limit); });
    judged.answer = wrong == values.end() ? Answer::kMet : Answer::kNotMet;
    judged.value = wrong == values.end() ? values.front() : *wrong;
  }

  void OfScalar(const GridPoint& point, JudgedPoint& judged) const {
    if (!HasEnded(point, judged)) return;
    const auto value_of = [&](const Cell& cell) {
      return file_.Has(figure_.name) ? file_.ReadReal(figure_.name, cell) : kNone;
    };
    if (!figure_.IsMeasured()) {
      OfFacts(*point.measured, judged, value_of);
      return;
    }
    std::vector<double> values;
    for (const Cell& cell : point.measured->cells) values.push_back(value_of(cell));
    const Bootstrap& bootstrap = model_.times().bootstrap();
    if (values.size() != bootstrap.size()) {
      judged.value = Mean(values);
      CannotTell(judged, "a repeat is missing or void");
      return;
    }
    if (SetInterval(model_.times(), bootstrap.MeanEstimate(values), judged))
      judged.answer = JudgeRange({judged.low, judged.high}, what_.comparison, judged.limit);
  }

  const Model& model_;
  const results::ResultFile& file_;
  const plan::Requirement& what_;
  const plan::Figure& figure_;
  std::optional<CycleTimes> own_times_;
  CycleTimes* times_ = nullptr;  ///< by the statistic of the figure; null unless it is a time
};

std::string QuantityText(const plan::Figure& figure, double value) {
  if (figure.kind == plan::FigureKind::kVerdict)
    return std::string(schema::kVerdicts[static_cast<std::size_t>(value)].name);
  const std::string_view unit = figure.Unit();
  if (unit == "ns") return TimeText(value);
  if (unit == "bytes") return fmt::format("{} MB", terminal::ShortNumber(value / 1e6));
  const bool is_whole = value == std::round(value) && std::fabs(value) < 1e6;
  return fmt::format("{}{}{}",
                     is_whole ? fmt::format("{:.0f}", value) : terminal::ShortNumber(value),
                     unit.empty() ? "" : " ", unit);
}

}  // namespace

std::size_t JudgedRequirement::Count(Answer answer) const {
  return static_cast<std::size_t>(std::ranges::count(points, answer, &JudgedPoint::answer));
}

Answer JudgedRequirement::Whole() const {
  for (const Answer answer : {Answer::kNotMet, Answer::kCannotTell, Answer::kMet})
    if (Count(answer) > 0) return answer;
  return Answer::kNotRun;
}

std::vector<JudgedPoint> JudgePoints(const Model& model, const plan::Requirement& what) {
  Judge judge(model, what);
  std::vector<JudgedPoint> points;
  for (const GridPoint& point : model.grid()) points.push_back(judge.At(point, what.limit));
  return points;
}

std::vector<JudgedRequirement> JudgeRequirements(const Model& model) {
  std::vector<JudgedRequirement> all;
  for (const plan::Requirement& what : model.file().requirements())
    all.push_back({what, false, JudgePoints(model, what)});
  const auto budget = BudgetOfScenario(model.file());
  if (!budget || !model.HasTimes()) return all;
  JudgedRequirement judged = {{.text = fmt::format("budget {}", budget->Text()),
                               .figure = {plan::FigureKind::kTime, "step", "p99"},
                               .comparison = plan::Comparison::kAtMost,
                               .limit = budget->ns},
                              true,
                              {}};
  Judge judge(model, judged.what);
  for (const GridPoint& point : model.grid()) {
    const double limit = point.measured == nullptr || !budget->frame_s
                             ? budget->ns
                             : budget->OfStep(model.TimeStepOf(*point.measured));
    judged.points.push_back(judge.At(point, limit));
  }
  all.push_back(std::move(judged));
  return all;
}

std::size_t CountNotMet(const std::vector<JudgedRequirement>& all) {
  std::size_t count = 0;
  for (const JudgedRequirement& of : all) count += of.Count(Answer::kNotMet);
  return count;
}

std::string FigureText(const JudgedRequirement& of, const JudgedPoint& point,
                       std::string_view interval_name) {
  const plan::Figure& figure = of.what.figure;
  if (std::isnan(point.value)) return "-";
  std::string text = QuantityText(figure, point.value);
  if (!(point.low < point.high)) return text;
  const double scale = figure.Unit() == "ns"      ? terminal::TimeUnit::For(point.value).ns
                       : figure.Unit() == "bytes" ? 1e6
                                                  : 1;
  const std::string_view name = figure.IsMeasured()                       ? interval_name
                                : figure.kind == plan::FigureKind::kError ? "known to"
                                                                          : "repeats";
  return fmt::format("{} ({} {})", text, name,
                     IntervalText({point.low / scale, point.high / scale}));
}

std::string ReasonText(const JudgedRequirement& of, const JudgedPoint& point,
                       std::string_view interval_name) {
  const std::string figure = FigureText(of, point, interval_name);
  if (point.why.empty()) return figure;
  return std::isnan(point.value) ? point.why : fmt::format("{}: {}", figure, point.why);
}

results::StoredAnswers AnswersOf(const Model& model) {
  const results::ResultFile& file = model.file();
  const std::size_t requirements = file.requirements().size();
  std::map<Point, std::size_t> places;
  for (const Point& at : AllPoints(file)) places.emplace(at, places.size());
  const std::size_t values = places.size() * requirements;
  results::StoredAnswers stored = {
      std::vector<double>(values, 0), std::vector<double>(values, kNone),
      std::vector<double>(values, kNone), std::vector<double>(values, kNone)};
  const std::vector<JudgedRequirement> judged = JudgeRequirements(model);
  for (std::size_t r = 0; r < requirements; ++r)
    for (const JudgedPoint& point : judged[r].points) {
      const std::size_t place = places.at(point.at) * requirements + r;
      stored.answer[place] = static_cast<double>(point.answer);
      stored.value[place] = point.value;
      stored.low[place] = point.low;
      stored.high[place] = point.high;
    }
  return stored;
}

// Budgets.

std::string_view FitName(Fit fit) {
  return fit == Fit::kYes ? "yes" : fit == Fit::kNo ? "no" : "cannot tell";
}

namespace {

/// ` Along quantity: fits up to 100, does not fit from 200.`, or, if no axis of numbers matters,
/// the fitting configurations; empty if none fits or all do.
std::string WhereText(const results::ResultFile& file, const std::map<Point, std::string>& states,
                      const BoundaryWords& words) {
  if (std::string text = BoundaryText(file, states, words); !text.empty()) return text;
  std::vector<std::string> fitting;
  for (const auto& [at, state] : states)
    if (state == words.good) fitting.push_back(PlaceText(file, AllAxes(file), at));
  constexpr std::size_t kMostNamed = 6;
  if (fitting.empty() || fitting.size() == states.size() || fitting.size() > kMostNamed) return {};
  return fmt::format(" Fitting: {}.", fmt::join(fitting, "; "));
}

Fit FitOf(const BudgetFigures& of) {
  const Interval range = of.interval.value_or(Interval{of.p99.value, of.p99.value});
  switch (JudgeTime(range, of.at_least, plan::Comparison::kAtMost, of.budget_ns)) {
    case Answer::kMet:
      return Fit::kYes;
    case Answer::kNotMet:
      return Fit::kNo;
    case Answer::kCannotTell:
    case Answer::kNotRun:
      break;
  }
  return Fit::kUnclear;
}

/// `No: the 99th percentile is 112 ms (95 % interval 110 .. 115).`
std::string AnswerOfOne(const CycleTimes& times, const BudgetFigures& of) {
  if (!of.point->IsSound()) return fmt::format("Cannot tell: the run is {}.", of.point->fault);
  const terminal::TimeUnit unit = terminal::TimeUnit::For(of.p99.value);
  return fmt::format(
      "{}: the 99th percentile is {}{}{}.",
      of.fit == Fit::kYes  ? "Yes"
      : of.fit == Fit::kNo ? "No"
      : of.MayBeNoise()    ? "Cannot tell, as the machine was noisy"
                           : "Cannot tell",
      TimeText(of.p99.value), IntervalNote(times, of.p99, 1 / unit.ns),
      of.at_least ? fmt::format(", at least {} without disturbances", TimeText(*of.at_least)) : "");
}

}  // namespace

std::vector<BudgetFigures> BudgetOf(const Model& model, const Budget& budget,
                                    protocol::Phase phase) {
  std::vector<BudgetFigures> all;
  for (const MeasuredPoint& point : model.points()) {
    const std::vector<double>& cycles = model.times().Of(point, phase).cycles;
    BudgetFigures figures;
    figures.point = &point;
    figures.budget_ns = budget.frame_s ? budget.OfStep(model.TimeStepOf(point)) : budget.ns;
    figures.p99 = model.TimeOf(point, phase);
    figures.cycles = cycles.size();
    figures.above = static_cast<std::size_t>(
        std::ranges::count_if(cycles, [&](double ns) { return ns > figures.budget_ns; }));
    if (model.times().HasIntervals()) figures.interval = model.times().IntervalOf(figures.p99);
    std::vector<std::vector<double>> repeats;
    for (const Cell& cell : point.cells) repeats.push_back(model.file().ReadDuration(phase, cell));
    figures.worst = kNone;
    for (const std::vector<double>& repeat : repeats)
      figures.worst = std::fmax(figures.worst, Largest(repeat));
    figures.at_least = TimeAtLeast(model.file(), point, phase, CycleStatistic::kP99);
    figures.fit = FitOf(figures);
    all.push_back(figures);
  }
  return all;
}

std::string BudgetText(double budget_ns) {
  const terminal::TimeUnit unit = terminal::TimeUnit::For(budget_ns);
  return fmt::format("{:.4g} {}", budget_ns / unit.ns, unit.name);
}

std::string BudgetAnswer(const Model& model, const std::vector<BudgetFigures>& figures) {
  if (figures.size() == 1) return AnswerOfOne(model.times(), figures[0]);
  const BoundaryWords words = {
      .good = "fits",
      .everywhere = {{"does not fit", "fits nowhere"}, {"cannot tell", "cannot tell anywhere"}},
      .most_lines = 4};
  std::map<Point, std::string> states;
  std::size_t fitting = 0, unclear = 0, noise = 0, unsound = 0;
  for (const BudgetFigures& of : figures) {
    if (!of.point->IsSound()) continue;
    states[of.point->at] = of.fit == Fit::kYes  ? words.good
                           : of.fit == Fit::kNo ? "does not fit"
                                                : "cannot tell";
    if (of.fit == Fit::kNo) continue;
    ++(of.fit == Fit::kYes ? fitting : unclear);
    noise += of.MayBeNoise() ? 1 : 0;
    if (WorstEnding(model.file(), of.point->at).judgement.verdict > protocol::Verdict::kStable)
      ++unsound;
  }
  std::string answer = fmt::format("{} of {} configurations fit", fitting, states.size());
  if (unclear > 0) answer += fmt::format(", {} cannot be told", unclear);
  if (noise > 0)
    answer += noise == unclear ? " (the machine was noisy)"
                               : fmt::format(" (the machine was noisy in {} of them)", noise);
  answer += "." + WhereText(model.file(), states, words);
  const std::size_t candidates = fitting + unclear;
  if (unsound == 0) return answer;
  if (candidates == 1) return answer + " It is not stable.";
  return answer + (unsound == candidates ? fmt::format(" None of these {} is stable.", candidates)
                                         : fmt::format(" {} of these {} {} not stable.", unsound,
                                                       candidates, unsound == 1 ? "is" : "are"));
}

double Budget::OfStep(double time_step) const {
  if (!frame_s) return ns;
  const double steps = std::round(*frame_s / time_step);
  return ns / (steps < 1 ? 1 : steps);
}

std::string Budget::Text() const {
  if (!frame_s) return BudgetText(ns) + " a step";
  const double rate = std::round(1 / *frame_s);
  return fmt::format("{} a frame of {}", BudgetText(ns),
                     rate > 1 && std::abs(*frame_s * rate - 1) < 1e-9
                         ? fmt::format("1/{:.0f} s", rate)
                         : fmt::format("{:.4g} s", *frame_s));
}

std::optional<Budget> BudgetOfScenario(const results::ResultFile& file) {
  const auto ns = file.budget_ns();
  return ns ? std::optional(Budget{*ns, file.frame_s()}) : std::nullopt;
}

void ConcludeBudget(const Model& model, std::vector<Conclusion>& all) {
  const auto budget = BudgetOfScenario(model.file());
  if (!budget || !model.HasTimes() || model.points().empty()) return;
  const Model& slow = model.slow();
  const std::vector<BudgetFigures> figures = BudgetOf(slow, *budget, protocol::Phase::kStep);
  const bool is_clear = slow.times().bootstrap().kind() == IntervalKind::kInterval &&
                        std::ranges::none_of(figures, [](const BudgetFigures& of) {
                          return of.point->IsSound() && of.fit == Fit::kUnclear;
                        });
  const bool is_one = figures.size() == 1;
  all.push_back({fmt::format("{} within {}?",
                             is_one ? "Does the simulation stay" : "Which configurations stay",
                             budget->Text()),
                 BudgetAnswer(slow, figures), "budget",
                 is_clear ? Certainty::kClear : Certainty::kUnknown});
}

}  // namespace cdb::figures
