// Whether the points of a results file meet the requirements of its scenario (`require`, `budget`).
//
// A point meets `p99(step) < 4 ms` if the whole 95 % interval of the figure over the repeats
// (bootstrap.h) is below 4 ms; it does not if no part of it is; else nobody can tell. With fewer
// repeats than an interval needs, a measured figure cannot be judged. On a noisy machine, which
// only adds time, a time is too long only if a lower bound without disturbances is.
//
// At a true value on the limit, `met` is wrong in 3 % of the cases, as is `not met` for means,
// medians and 95th percentiles. The highest of a few noisy times is too high, so `not met` is wrong
// more often for the last cycles: of 40 cycles, for the 99th percentile in 17 % with 5 repeats and
// in 7 % with 9, and for the largest in 23 % and 10 % (made-up runs, 2 % between runs and between
// cycles, 3000 cases each).
//
// Other figures are facts of a run. They have to be right in every repeat, and an error is known as
// well as its floor says (`cdb doc accuracy`). Points are judged one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/requirement.h"
#include "runtime/figures/model.h"
#include "runtime/figures/times.h"
#include "runtime/results/store.h"

namespace cdb::figures {

/// `flag_values` of the array `requirements/answer`.
enum class Answer : std::int8_t { kNotRun, kCannotTell, kNotMet, kMet };
/// `met`, `not met`, `cannot tell`.
std::string_view AnswerName(Answer answer);

/// The answer on a figure that is somewhere in `range`.
Answer JudgeRange(const Interval& range, plan::Comparison comparison, double limit);
/// The same for a time. `at_least`: a lower bound without disturbances, if the machine was noisy;
/// as long as that is within the limit, disturbances may be all that is above it.
Answer JudgeTime(const Interval& range, const std::optional<double>& at_least,
                 plan::Comparison comparison, double limit);

/// A lower bound for a statistic of the times without disturbances, if half of the repeats or more
/// are noisy: that of the fastest repeat of each cycle; with one repeat, the median, since more
/// than one cycle in a hundred may be disturbed.
std::optional<double> TimeAtLeast(const results::ResultFile& file, const MeasuredPoint& point,
                                  protocol::Phase phase, CycleStatistic statistic);

/// A point against a requirement, in the unit of the figure; NaN where there is no value.
struct JudgedPoint {
  Point at;
  Answer answer = Answer::kCannotTell;
  double value = kNone, low = kNone, high = kNone;  ///< low, high: where it may be
  double limit = kNone;
  std::string why = {};  ///< that cannot be told, or is not met by a run without a figure
};

struct JudgedRequirement {
  plan::Requirement what;  ///< of a budget, the limit is that of each point
  bool is_budget = false;
  std::vector<JudgedPoint> points;  ///< those with a run, in grid order

  std::size_t Count(Answer answer) const;
  /// The first of `Answer::kNotMet`, `kCannotTell` and `kMet` that some point has.
  Answer Whole() const;
};

/// All of the file, the budget last. Throws StoreError.
std::vector<JudgedRequirement> JudgeRequirements(const Model& model);

/// Each point with a run against one condition, in grid order. Throws StoreError.
std::vector<JudgedPoint> JudgePoints(const Model& model, const plan::Requirement& what);

/// The number of points and requirements that are not met.
std::size_t CountNotMet(const std::vector<JudgedRequirement>& all);

/// `4.31 ms (95 % interval 4.20 .. 4.44)`, `tunnelled`, `3`: the figure of a point.
std::string FigureText(const JudgedRequirement& of, const JudgedPoint& point,
                       std::string_view interval_name);
/// The reason of the answer: `4.31 ms (…)`, or `one repeat does not tell (1.2 ms)`.
std::string ReasonText(const JudgedRequirement& of, const JudgedPoint& point,
                       std::string_view interval_name);

/// The answers as a results file stores them: for each point of the whole grid and each `require`.
results::StoredAnswers AnswersOf(const Model& model);

// Which configurations stay within a time per cycle (`budget` of a scenario, `cdb show --budget`).

/// Whether the 99th percentile is within the budget; kUnclear if its interval holds the budget, or
/// if it is above and `at_least` is not.
enum class Fit { kYes, kNo, kUnclear };
/// `yes`, `no`, `cannot tell`.
std::string_view FitName(Fit fit);

/// A time that a step may take, or all steps of a frame.
struct Budget {
  double ns = 0;
  std::optional<double> frame_s = {};  ///< none: of a step

  /// What a step of `time_step` seconds may take, ns: frames have a whole number of steps, at
  /// least one. NaN if `time_step` is.
  double OfStep(double time_step) const;
  /// `4 ms a step`, `4 ms a frame of 1/60 s`.
  std::string Text() const;
};
/// That of the scenario. Throws StoreError.
std::optional<Budget> BudgetOfScenario(const results::ResultFile& file);

/// A point against the budget. Times in ns.
struct BudgetFigures {
  const MeasuredPoint* point = nullptr;
  double budget_ns = 0;               ///< of a step
  std::size_t above = 0, cycles = 0;  ///< cycles above the budget, of all
  Estimate p99;                       ///< of the times of the cycles
  std::optional<Interval> interval;   ///< of p99; none with one repeat
  double worst = 0;                   ///< the longest cycle of any repeat, disturbances included
  /// If half of the repeats or more are noisy: a lower bound for p99 without disturbances, which
  /// only add time. It is the 99th percentile of the fastest repeat of each cycle; with one repeat,
  /// the median, since more than one cycle in a hundred may be disturbed.
  std::optional<double> at_least;
  Fit fit = Fit::kNo;

  /// True if disturbances may be all that is above the budget.
  bool MayBeNoise() const { return fit == Fit::kUnclear && at_least.has_value(); }
};

/// A figure for each point of `model`, whose statistic is kP99, in grid order. Throws StoreError.
std::vector<BudgetFigures> BudgetOf(const Model& model, const Budget& budget,
                                    protocol::Phase phase);

/// `4 ms`.
std::string BudgetText(double budget_ns);

/// How many sound points fit, and which: whole sentences.
std::string BudgetAnswer(const Model& model, const std::vector<BudgetFigures>& figures);

}  // namespace cdb::figures
