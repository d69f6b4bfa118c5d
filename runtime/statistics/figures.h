// The cells of a results file by the status of their runs, and percentiles (`cdb show`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "runtime/measure/verdict.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// The value below which a fraction `p` of the sorted values lies, interpolated linearly; NaN if
/// there are none.
double Percentile(const std::vector<double>& sorted, double p);

/// Cells by the status of their runs.
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
  std::map<measure::Verdict, std::vector<Judged>> verdicts;  ///< of the sound ones
  std::size_t skipped = 0, missing = 0;

  std::size_t NotSkipped() const { return good.size() + bad.size() + missing; }
};
CellGroups GroupCells(const store::ResultFile& file);

}  // namespace cdb::statistics
