// Estimates the remaining time from the runs that have finished.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::schedule {

/// Predicts a run from the mean of similar ones (same detector, objects, cycles), or else by a
/// power law of the time of a cycle in the number of objects, fitted to the runs of its detector,
/// or else to all runs. Not thread-safe.
class TimeEstimate {
 public:
  explicit TimeEstimate(const std::vector<const plan::Run*>& to_do);

  /// `run` took `wall_s`. Pass none for a failed run, whose time predicts nothing.
  void Ended(const plan::Run& run, std::optional<double> wall_s);

  /// Seconds; none before any run has ended.
  std::optional<double> Predict(const plan::Run& run) const;
  /// The sum over all runs that have not ended.
  std::optional<double> Left() const;

 private:
  /// Runs that are alike.
  struct Kind {
    std::string detector;
    double objects, cycles;
    double timeout_s;
    auto operator<=>(const Kind&) const = default;
  };
  struct Times {
    std::size_t left = 0, ended = 0;
    double sum_s = 0;
  };
  /// Fit of log(seconds per cycle) over log(objects): least squares from running sums.
  struct Fit {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    void Add(double objects, double cycle_s);
    double CycleSeconds(double objects) const;
  };

  static Kind KindOf(const plan::Run& run);
  std::optional<double> Predict(const Kind& kind, const Times& times) const;

  std::map<Kind, Times> kinds_;
  std::map<std::string, Fit> fits_;
  Fit all_;
};

}  // namespace cdb::schedule
