// THE statistic of run times, for every table of `cdb show`.
//
// A run is repeatable to the last bit, so that cycle c does the same work in every repeat, and
// differences between repeats are disturbances. The time of a cycle is the median over the repeats:
// a stall in one repeat does not count. (The minimum would also hide what is no disturbance, such
// as a processor that changes its frequency.) The time of a point is the mean over its cycles,
// which is its total work: what a simulated second takes follows by the time step. With one repeat
// it is the mean of that run.
//
// Intervals are of repeats (bootstrap.h): whole runs are drawn, so that the correlation between the
// cycles of a run is kept, and the statistic is computed anew from each draw. A draw may have one
// repeat several times, and a stall in it would then outvote the others. So stalls are winsorised
// first (Singh 1998, Breakdown theory for bootstrap quantiles, The Annals of Statistics 26): with m
// the time of a cycle, times count as at least m (1 - d) and at most m (1 + d), where d is the 95th
// percentile of |t - m| / m over all cycles and repeats, or 5 * 1.4826 times its median if that is
// more. So up to 5 % of the times may be stalls; if more are, d is that of a stall, and the
// interval is as wide as the disturbance. On made-up runs (5 repeats of 60 cycles, 2 % between runs
// and between cycles, stalls of 20 times a cycle; 300 cases each):
//   stalls in            0 %   1 %   5 %   10 %   20 % of the cycles
//   covers the truth in   94    95    89     72     67 % of the cases
//   width                  4     4     6    151    392 % of the time
//   without winsorising    4    57   190    326    555 %
// From 10 % on the median over five repeats is disturbed itself: repeat on an idle machine.
//
// For a comparison of two files the time of a cycle is that of its fastest repeat (`fastest_of`),
// as disturbances only add time (Chen and Revels 2016, Robust benchmarking in noisy environments).
// On a shared machine whole runs are slow while a neighbour has the same core: of 45 runs in turn
// of equal code, a quarter to four fifths took a third longer. Medians and quartiles lie among
// the fast runs or the slow ones by chance; those of equal code differed by up to 9 %, the
// fastest repeats by up to 1.3 %. The fastest of more repeats is faster, and the bootstrap
// underrates the variance of an extreme unless it is one of few (Bickel, Götze and van Zwet 1997,
// Resampling fewer than n observations, Statistica Sinica 7). So it is the least time of
// m = 2 sqrt(n) repeats, in the mean over all choices of m, with n the repeats of the file that has
// fewer.
//
// Times in ns. Throws StoreError. Not for several threads.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/measure/series.h"
#include "runtime/statistics/bootstrap.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// What the time of a point is over its cycles, where it is asked to be another than the mean.
enum class CycleStatistic {
  kMean,
  kMedian,
  kP5,
  kP95,
  kMin,
  kMax,    ///< of the times of the cycles, which are medians over the repeats
  kWorst,  ///< the longest cycle of any repeat, disturbances included
};
/// `mean`, `median`, … in the order of CycleStatistic.
std::span<const std::string_view> CycleStatisticNames();

struct PhaseTimes {
  std::vector<double> cycles;  ///< the time of each cycle
  Estimate mean;               ///< over the cycles
  Estimate other;              ///< another statistic over them, if one is asked for
};
/// `repeats[r][c]`: cycle c in repeat r of `bootstrap`; empty for a repeat without values. A cycle
/// that some repeats did not reach is of the others. `fastest_of`: takes the fastest of so many
/// repeats, at least 1, in place of the median.
PhaseTimes TimesOver(const std::vector<std::vector<double>>& repeats, const Bootstrap& bootstrap,
                     CycleStatistic statistic = CycleStatistic::kMean,
                     std::optional<std::size_t> fastest_of = {});

/// `fastest_of` for a comparison of files of which the one with fewer has `repeats`.
std::size_t FastestOf(std::size_t repeats);

/// The times of a file's points; each is computed once.
class CycleTimes {
 public:
  explicit CycleTimes(const store::ResultFile& file,
                      CycleStatistic statistic = CycleStatistic::kMean,
                      std::optional<std::size_t> fastest_of = {})
      : file_(file),
        bootstrap_(file.begun_repeats()),
        statistic_(statistic),
        fastest_of_(fastest_of) {}

  const PhaseTimes& Of(const MeasuredPoint& point, measure::Phase phase);
  /// The time of a point by the statistic that was asked for.
  const Estimate& FigureOf(const MeasuredPoint& point, measure::Phase phase);
  CycleStatistic statistic() const { return statistic_; }
  /// `mean`, `median`.
  std::string_view StatisticName() const;
  /// For the head of a table: `Mean`, `95th percentile`.
  std::string_view StatisticHead() const;
  const Bootstrap& bootstrap() const { return bootstrap_; }
  Interval IntervalOf(const Estimate& estimate) const { return bootstrap_.IntervalOf(estimate); }

  /// `95 % interval`, `range`; empty for one repeat.
  std::string IntervalName() const;
  // One line each for below a table; `pools`: a row has several cells.
  std::string StatisticLine(bool pools) const;             ///< which statistic over what
  std::string StatisticAndIntervalLine(bool pools) const;  ///< both, in one line
  /// How the interval was made, or why there is none. `lacks_repeats`: some row has fewer repeats.
  std::string IntervalLine(bool lacks_repeats = false) const;

 private:
  std::string Statistic(bool pools) const;

  using AllPhases = std::array<PhaseTimes, measure::kPhaseCount>;

  const store::ResultFile& file_;
  const Bootstrap bootstrap_;
  const CycleStatistic statistic_;
  const std::optional<std::size_t> fastest_of_;
  std::map<Point, AllPhases> points_;
};

}  // namespace cdb::statistics
