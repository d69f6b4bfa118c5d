// The numbers of a summary (`cdb show`), before they are formatted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "runtime/measure/series.h"
#include "runtime/measure/verdict.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// The value below which a part `p` of the sorted values lies, between two of them in proportion;
/// NaN for none.
double Percentile(const std::vector<double>& sorted, double p);

/// Cells by how their runs ended.
struct CellGroups {
  struct Bad {
    store::ResultFile::Cell cell;
    std::string why;
  };
  struct Judged {
    store::ResultFile::Cell cell;
    std::int64_t first_bad_cycle;
  };
  std::vector<store::ResultFile::Cell> good;
  std::vector<Bad> bad;                                      ///< failed, or with void timings
  std::map<measure::Verdict, std::vector<Judged>> verdicts;  ///< of the good ones
  std::size_t skipped = 0, missing = 0;

  std::size_t NotSkipped() const { return good.size() + bad.size() + missing; }
};
CellGroups GroupCells(const store::ResultFile& file);

/// Values on some of the axes of a file.
using Point = std::vector<std::size_t>;

/// The values of all cycles of several cells, sorted; empty where the file has none.
struct Pool {
  std::array<std::vector<double>, measure::kPhaseCount> phases;
  std::vector<double> pairs, contacts;
};
/// The cells that share a point on the axes `by`, together.
std::map<Point, Pool> PoolCells(const store::ResultFile& file,
                                const std::vector<store::ResultFile::Cell>& cells,
                                const std::vector<std::size_t>& by);

/// A point of the other axes, and the repeat: what detectors are compared at.
using ComparedPoint = std::pair<Point, std::uint64_t>;

/// Medians of one phase by detector, in the order of their axis; NaN for cells that do not count.
using DetectorMedians = std::map<ComparedPoint, std::vector<double>>;
DetectorMedians MediansByDetector(const store::ResultFile& file,
                                  const std::vector<store::ResultFile::Cell>& cells,
                                  std::size_t detector_axis, measure::Phase phase);

/// Points at which some detectors ran without a component and others with it.
struct UnlikeOmissions {
  std::size_t unlike_points = 0, points = 0;
  std::vector<std::string> components;
};
/// None for a file that does not hold what runs left out.
UnlikeOmissions FindUnlikeOmissions(const store::ResultFile& file,
                                    const std::vector<store::ResultFile::Cell>& cells,
                                    std::size_t detector_axis);

/// e to the mean of the logarithms; NaN for none.
double GeometricMean(const std::vector<double>& values);

}  // namespace cdb::report
