#include "runtime/figures/budget.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "runtime/figures/conclusions.h"

namespace cdb::figures {

std::string_view FitName(Fit fit) {
  return fit == Fit::kYes ? "yes" : fit == Fit::kNo ? "no" : "cannot tell";
}

std::vector<BudgetFigures> BudgetOf(const Model& model, double budget_ns, protocol::Phase phase) {
  std::vector<BudgetFigures> all;
  for (const MeasuredPoint& point : model.points()) {
    const std::vector<double>& cycles = model.times().Of(point, phase).cycles;
    BudgetFigures figures;
    figures.point = &point;
    figures.p99 = model.TimeOf(point, phase);
    figures.cycles = cycles.size();
    figures.above = static_cast<std::size_t>(
        std::ranges::count_if(cycles, [&](double ns) { return ns > budget_ns; }));
    if (model.times().HasIntervals()) figures.interval = model.times().IntervalOf(figures.p99);
    const Interval range =
        figures.interval.value_or(Interval{figures.p99.value, figures.p99.value});
    figures.fit = range.high <= budget_ns ? Fit::kYes
                  : range.low > budget_ns ? Fit::kNo
                                          : Fit::kUnclear;
    figures.worst = kNone;
    for (const Cell& cell : point.cells)
      for (const double ns : model.file().ReadDuration(phase, cell))
        figures.worst = std::fmax(figures.worst, ns);
    all.push_back(figures);
  }
  return all;
}

std::string BudgetAnswer(const Model& model, const std::vector<BudgetFigures>& figures) {
  std::vector<std::string> fitting, unclear;
  std::size_t timed = 0, unsound = 0;
  for (const BudgetFigures& of : figures) {
    if (!of.point->IsSound()) continue;
    ++timed;
    if (of.fit == Fit::kNo) continue;
    if (WorstEnding(model.file(), of.point->at).judgement.verdict > protocol::Verdict::kStable)
      ++unsound;
    (of.fit == Fit::kYes ? fitting : unclear)
        .push_back(PlaceText(model.file(), AllAxes(model.file()), of.point->at));
  }
  constexpr std::size_t kMostNamed = 6;
  const auto named = [&](const std::vector<std::string>& places) {
    if (places.empty() || places[0].empty()) return std::string();
    const std::size_t count = std::min(places.size(), kMostNamed);
    return fmt::format(
        ": {}{}",
        fmt::join(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count), "; "),
        places.size() > kMostNamed ? "; …" : "");
  };
  std::string answer =
      fmt::format("{} of {} configurations fit{}.", fitting.size(), timed, named(fitting));
  if (!unclear.empty())
    answer += fmt::format(" {} cannot be told{}.", unclear.size(), named(unclear));
  if (unsound > 0)
    answer += fmt::format(" Of these {}, {} not stable.", fitting.size() + unclear.size(),
                          unsound == 1 ? "one is" : fmt::format("{} are", unsound));
  return answer;
}

void ConcludeBudget(const Model& model, std::vector<Conclusion>& all) {
  const auto budget_ns = model.file().budget_ns();
  if (!budget_ns || !model.HasTimes() || model.points().empty()) return;
  const Model& slow = model.slow();
  const std::vector<BudgetFigures> figures = BudgetOf(slow, *budget_ns, protocol::Phase::kStep);
  const bool is_clear = slow.times().bootstrap().kind() == IntervalKind::kInterval &&
                        std::ranges::none_of(figures, [](const BudgetFigures& of) {
                          return of.point->IsSound() && of.fit == Fit::kUnclear;
                        });
  all.push_back({fmt::format("Which configurations stay within {} a step?", TimeText(*budget_ns)),
                 BudgetAnswer(slow, figures), "budget",
                 is_clear ? Certainty::kClear : Certainty::kUnknown});
}

}  // namespace cdb::figures
