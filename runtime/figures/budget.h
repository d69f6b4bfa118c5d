// Which configurations stay within a time per cycle (`budget` of a scenario, `cdb show --budget`).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/model.h"

namespace cdb::figures {

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
