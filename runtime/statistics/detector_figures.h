// The figures of a comparison of detectors (`cdb show`), before formatting: the cost of each, its
// growth, and the overhead of calling it.
//
// Times in ns, memory in bytes; NaN where the file has no value. Throws StoreError.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// Over all points of a row.
struct DetectorCosts {
  Estimate mean;                   ///< of detect
  double worst = 0;                ///< cycle of detect
  double pairs = 0;                ///< mean
  double missed = 0, phantom = 0;  ///< sums; NaN if pairs were not checked in any cycle
  double peak_rss = 0, heap = 0;   ///< maxima
};
DetectorCosts CostsOf(const store::ResultFile& file, const Row& row, CycleTimes& times);

/// p of detect ~ objects^p, by least squares over the logarithms of means.
struct DetectorGrowth {
  std::size_t axis;               ///< the axis that changes the number of objects
  std::vector<std::size_t> rows;  ///< the axes of the rows, without that one
  struct Exponent {
    double p;            ///< the mean of the exponents pooled in the row
    double least, most;  ///< range of the numbers of objects in the fit
  };
  std::map<Point, Exponent> exponents;   ///< by row
  bool is_mean = false;                  ///< some row pools several exponents
  bool is_matched = true;                ///< all rows are fitted over the same numbers of objects
  std::size_t dropped = 0;               ///< numbers of objects that some row lacks
  std::vector<std::string> unlike = {};  ///< components that some points omitted and others kept
};
/// Fitted over the sound points at each value of the axes other than the one that changes the
/// number of objects, and over the numbers of objects that all rows have, if there are at least
/// three. Nullopt if no axis with at least three numbers changes it, or several do.
std::optional<DetectorGrowth> GrowthByRow(const store::ResultFile& file,
                                          const std::vector<MeasuredPoint>& points,
                                          const std::vector<std::size_t>& rows, CycleTimes& times);

/// The slope of log y over log x by least squares; NaN if there are fewer than three different x,
/// or if a value is not positive.
double GrowthExponent(const std::vector<std::pair<double, double>>& points);

/// The overhead of calling a detector in a cycle, in relation to the fastest detector.
struct HarnessCost {
  struct Fastest {
    double time;           ///< the median over its points
    std::string detector;  ///< empty if the plan cannot be read
    bool is_only;
  };
  double median;
  std::optional<Fastest> fastest;  ///< nullopt if no detector has timings
};
/// Nullopt if no run states it.
std::optional<HarnessCost> HarnessCostOf(const store::ResultFile& file,
                                         const std::vector<MeasuredPoint>& points,
                                         CycleTimes& times);

}  // namespace cdb::statistics
