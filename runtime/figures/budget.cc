#include "runtime/figures/budget.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "runtime/figures/boundaries.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/requirements.h"

namespace cdb::figures {

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
