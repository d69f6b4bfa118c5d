// The cells of a results file by how their runs ended, and percentiles (`cdb show`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "runtime/measure/verdict.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

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

}  // namespace cdb::statistics
