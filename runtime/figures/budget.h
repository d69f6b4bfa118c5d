// Which configurations stay within a time per cycle (`budget` of a scenario, `cdb show --budget`).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/model.h"

namespace cdb::figures {

/// Whether the 99th percentile is within the budget; kUnclear if its interval holds the budget.
enum class Fit { kYes, kNo, kUnclear };
/// `yes`, `no`, `cannot tell`.
std::string_view FitName(Fit fit);

/// A point against the budget. Times in ns.
struct BudgetFigures {
  const MeasuredPoint* point = nullptr;
  std::size_t above = 0, cycles = 0;  ///< cycles above the budget, of all
  Estimate p99;                       ///< of the times of the cycles
  std::optional<Interval> interval;   ///< of p99; none with one repeat
  double worst = 0;                   ///< the longest cycle of any repeat, disturbances included
  Fit fit = Fit::kNo;
};

/// A figure for each point of `model`, whose statistic is kP99, in grid order. Throws StoreError.
std::vector<BudgetFigures> BudgetOf(const Model& model, double budget_ns, protocol::Phase phase);

/// How many sound points fit, and which: whole sentences.
std::string BudgetAnswer(const Model& model, const std::vector<BudgetFigures>& figures);

}  // namespace cdb::figures
