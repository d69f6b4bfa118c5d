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

#include "runtime/report/figures.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Of all cycles that share a row.
struct DetectorCosts {
  double median = 0, worst = 0;    ///< of detect
  double pairs = 0;                ///< median
  double missed = 0, phantom = 0;  ///< sums; NaN where no cycle was refereed
  double peak_rss = 0, heap = 0;   ///< the most
};
/// By the point on the axes `rows`.
std::map<Point, DetectorCosts> DetectorCostsByRow(const store::ResultFile& file,
                                                  const std::vector<store::ResultFile::Cell>& cells,
                                                  const std::vector<std::size_t>& rows);

/// p of detect ~ objects^p, by least squares over the logarithms of medians.
struct DetectorGrowth {
  std::size_t axis;                   ///< that changes the number of objects
  std::vector<std::size_t> rows;      ///< the axes of the rows, without it
  std::map<Point, double> exponents;  ///< by row: the mean of what is pooled there
  bool is_mean;                       ///< a row pools several
};
/// Fitted at each point of the axes beside the one that changes the number of objects. Nullopt
/// where no axis of three numbers or more does, or several do.
std::optional<DetectorGrowth> GrowthByRow(const store::ResultFile& file,
                                          const std::vector<store::ResultFile::Cell>& cells,
                                          const std::vector<std::size_t>& rows);

/// The slope of log y over log x by least squares; NaN for fewer than three different x, or where
/// one is not positive.
double GrowthExponent(const std::vector<std::pair<double, double>>& points);

/// What calling a detector costs in a cycle, beside the fastest detector.
struct HarnessCost {
  struct Fastest {
    double median;         ///< of the medians of its runs
    std::string detector;  ///< empty where the plan cannot be read
    bool is_only;
  };
  double median;
  std::optional<Fastest> fastest;  ///< nullopt where no detector has timings
};
/// Nullopt where no run states it.
std::optional<HarnessCost> HarnessCostOf(const store::ResultFile& file,
                                         const std::vector<store::ResultFile::Cell>& cells);

}  // namespace cdb::report
