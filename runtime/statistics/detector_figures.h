// The numbers of a comparison of detectors (`cdb show`), before they are formatted: what each
// costs, how that grows, and what calling it costs beside its own work.
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

/// Of all points of a row.
struct DetectorCosts {
  Estimate mean;                   ///< of detect
  double worst = 0;                ///< cycle of detect
  double pairs = 0;                ///< mean
  double missed = 0, phantom = 0;  ///< sums; NaN where no cycle was refereed
  double peak_rss = 0, heap = 0;   ///< the most
};
DetectorCosts CostsOf(const store::ResultFile& file, const Row& row, CycleTimes& times);

/// p of detect ~ objects^p, by least squares over the logarithms of means.
struct DetectorGrowth {
  std::size_t axis;               ///< that changes the number of objects
  std::vector<std::size_t> rows;  ///< the axes of the rows, without it
  struct Exponent {
    double p;            ///< the mean of what is pooled in the row
    double least, most;  ///< objects that it was fitted over
  };
  std::map<Point, Exponent> exponents;   ///< by row
  bool is_mean = false;                  ///< a row pools several
  bool is_matched = true;                ///< all rows are of the same numbers of objects
  std::size_t dropped = 0;               ///< numbers of objects that some row has not got
  std::vector<std::string> unlike = {};  ///< components that some points ran without, others with
};
/// Fitted over the sound points at each value of the axes beside the one that changes the number of
/// objects; over the numbers of objects that all rows have, if they are three or more. Nullopt
/// where no axis of three numbers or more does, or several do.
std::optional<DetectorGrowth> GrowthByRow(const store::ResultFile& file,
                                          const std::vector<MeasuredPoint>& points,
                                          const std::vector<std::size_t>& rows, CycleTimes& times);

/// The slope of log y over log x by least squares; NaN for fewer than three different x, or where
/// one is not positive.
double GrowthExponent(const std::vector<std::pair<double, double>>& points);

/// What calling a detector costs in a cycle, beside the fastest detector.
struct HarnessCost {
  struct Fastest {
    double time;           ///< the median of its points
    std::string detector;  ///< empty where the plan cannot be read
    bool is_only;
  };
  double median;
  std::optional<Fastest> fastest;  ///< nullopt where no detector has timings
};
/// Nullopt where no run states it.
std::optional<HarnessCost> HarnessCostOf(const store::ResultFile& file,
                                         const std::vector<MeasuredPoint>& points,
                                         CycleTimes& times);

}  // namespace cdb::statistics
