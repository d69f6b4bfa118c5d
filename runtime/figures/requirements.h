// Whether the points of a results file meet the requirements of its scenario (`require`, `budget`).
//
// A point meets `p99(step) < 4 ms` if the whole 95 % interval of the figure over the repeats
// (bootstrap.h) is below 4 ms; it does not if no part of it is; else nobody can tell. With fewer
// repeats than an interval needs, a measured figure cannot be judged. At a true value on the limit,
// either answer is therefore wrong in at most about 3 % of the cases (2.5 % nominally). On a noisy
// machine, which only adds time, a time is too long only if a lower bound without disturbances is.
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

/// The number of points and requirements that are not met.
std::size_t CountNotMet(const std::vector<JudgedRequirement>& all);

/// `4.31 ms (95 % interval 4.20 .. 4.44)`, `tunnelled`, `3`: the figure of a point.
std::string FigureText(const JudgedRequirement& of, const JudgedPoint& point,
                       std::string_view interval_name);
/// The reason of the answer: `4.31 ms (…)`, or `one repeat does not tell (1.2 ms)`.
std::string ReasonText(const JudgedRequirement& of, const JudgedPoint& point,
                       std::string_view interval_name);

/// The answers as a results file stores them: for each point of the whole grid and each `require`.
results::StoredAnswers AnswersToStore(const std::filesystem::path& file);

}  // namespace cdb::figures
