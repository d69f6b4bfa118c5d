// The statistic of run times that all tables of `cdb show` use.
//
// A run is repeatable to the last bit, so cycle c does the same work in every repeat, and
// differences between repeats are disturbances. The time of a cycle is the median over the repeats,
// which a stall in one repeat does not affect. (The minimum would also hide differences that are
// not disturbances, such as a processor that changes its frequency.) The time of a point is the
// mean over its cycles, which is proportional to its total work: the time of a simulated second is
// this mean divided by the time step. With one repeat, it is the mean of that run.
//
// Intervals are over repeats (bootstrap.h): whole runs are drawn, which keeps the correlation
// between the cycles of a run, and the statistic is computed from each draw. A draw may contain one
// repeat several times, and a stall in it would then outvote the others. Stalls are therefore
// winsorised first (Singh 1998, Breakdown theory for bootstrap quantiles, The Annals of Statistics
// 26): with m the time of a cycle, times are limited to m (1 - d) .. m (1 + d), where d is the 95th
// percentile of |t - m| / m over all cycles and repeats, or 5 * 1.4826 times its median if that is
// larger. Up to 5 % of the times may therefore be stalls; if there are more, d is that of a stall,
// and the interval is as wide as the disturbance. For synthetic runs (5 repeats of 60 cycles, 2 %
// between runs and between cycles, stalls of 20 times a cycle; 300 cases each):
//   stalls in            0 %   1 %   5 %   10 %   20 % of the cycles
//   covers the truth in   94    95    89     72     67 % of the cases
//   width                  4     4     6    151    392 % of the time
//   without winsorising    4    57   190    326    555 %
// From 10 % on, the median over five repeats itself is disturbed: repeat on an idle machine.
//
// For a comparison of two files, the time of a cycle is that of its fastest repeat (`fastest_of`),
// because disturbances only add time (Chen and Revels 2016, Robust benchmarking in noisy
// environments). On a shared machine, whole runs are slow while a neighbour uses the same core: of
// 45 alternating runs of equal code, a quarter to four fifths took a third longer. Medians and
// quartiles are then those of fast or of slow runs by chance; for equal code they differed by up to
// 9 %, the fastest repeats by up to 1.3 %. The fastest of more repeats is faster, and the bootstrap
// underestimates the variance of an extreme value unless it is one of few (Bickel, Götze and van
// Zwet 1997, Resampling fewer than n observations, Statistica Sinica 7). The time is therefore the
// least of m = 2 sqrt(n) repeats, in the mean over all choices of m, where n is the number of
// repeats of the file that has fewer.
//
// Times in ns. Throws StoreError. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/points.h"
#include "runtime/protocol/series.h"
#include "runtime/results/store.h"

namespace cdb::figures {

/// The statistic over the cycles of a point, if it is not the mean.
enum class CycleStatistic {
  kMean,
  kMedian,
  kP5,
  kP95,
  kP99,
  kMin,
  kMax,    ///< of the times of the cycles, which are medians over the repeats
  kWorst,  ///< the longest cycle of any repeat, including disturbances
};
/// `mean`, `median`, … in the order of CycleStatistic.
std::span<const std::string_view> CycleStatisticNames();
/// The statistic of values; NaN if one of them is NaN, or if there are none.
double StatisticOf(std::vector<double> values, CycleStatistic statistic);

/// `step`.
std::string PhaseName(protocol::Phase phase);
std::vector<protocol::Phase> AllPhases();

struct PhaseTimes {
  std::vector<double> cycles;        ///< the time of each cycle
  Estimate mean;                     ///< over the cycles
  Estimate other;                    ///< another statistic over the cycles, if one is requested
  std::vector<double> repeat_means;  ///< over the cycles of each repeat; NaN if it has none
};
/// `repeats[r][c]`: cycle c in repeat r of `bootstrap`; empty for a repeat without values. A cycle
/// that some repeats did not reach is taken from the others. `fastest_of`: use the fastest of this
/// number of repeats, at least 1, instead of the median.
PhaseTimes TimesOver(const std::vector<std::vector<double>>& repeats, const Bootstrap& bootstrap,
                     CycleStatistic statistic = CycleStatistic::kMean,
                     std::optional<std::size_t> fastest_of = {});

/// The `fastest_of` for a comparison of files in which the file with fewer repeats has `repeats`.
std::size_t FastestOf(std::size_t repeats);

/// The times of a file's points; each is computed once.
class CycleTimes {
 public:
  explicit CycleTimes(const results::ResultFile& file,
                      CycleStatistic statistic = CycleStatistic::kMean,
                      std::optional<std::size_t> fastest_of = {})
      : file_(file),
        bootstrap_(file.begun_repeats()),
        statistic_(statistic),
        fastest_of_(fastest_of) {}

  const PhaseTimes& Of(const MeasuredPoint& point, protocol::Phase phase);
  /// The time of a point by the requested statistic.
  const Estimate& FigureOf(const MeasuredPoint& point, protocol::Phase phase);
  /// Any statistic over the cycles of a point, except kWorst.
  double StatisticOf(const MeasuredPoint& point, protocol::Phase phase, CycleStatistic statistic);
  CycleStatistic statistic() const { return statistic_; }
  /// `mean`, `median`.
  std::string_view StatisticName() const;
  /// For the head of a table: `Mean`, `95th percentile`.
  std::string_view StatisticHead() const;
  const Bootstrap& bootstrap() const { return bootstrap_; }
  bool HasIntervals() const { return bootstrap_.kind() != IntervalKind::kAbsent; }
  Interval IntervalOf(const Estimate& estimate) const { return bootstrap_.IntervalOf(estimate); }

  /// `95 % interval`, `range`; empty for one repeat.
  std::string IntervalName() const { return std::string(NameOf(bootstrap_.kind())); }
  // A sentence each. `pools`: a row has several cells.
  std::string StatisticNote(bool pools) const;  ///< the statistic and the values it is over
  std::string StatisticAndIntervalNote(bool pools) const;  ///< both
  /// How the interval was made, or why there is none. `lacks_repeats`: some row has fewer repeats.
  std::string IntervalNote(bool lacks_repeats = false) const;

 private:
  std::string Statistic(bool pools) const;

  using AllPhases = std::array<PhaseTimes, protocol::kPhaseCount>;

  const results::ResultFile& file_;
  const Bootstrap bootstrap_;
  const CycleStatistic statistic_;
  const std::optional<std::size_t> fastest_of_;
  std::map<Point, AllPhases> points_;
};

/// `a`, `a and b`, `a, b and c`.
std::string JoinWords(const std::vector<std::string>& words);
/// ` (95 % interval 0.98 .. 1.02)`, ` (range 0.98 .. 1.02)`; empty if there is none.
std::string IntervalNote(const CycleTimes& times, const Estimate& estimate, double scale = 1);
/// `1.23 ms`.
std::string TimeText(double ns);
/// All axes of a file except one.
std::vector<std::size_t> OtherAxes(const results::ResultFile& file, std::size_t axis);
/// `the number of objects`, `hz`: an axis in a sentence.
std::string AxisWords(const plan::Axis& axis);

}  // namespace cdb::figures
