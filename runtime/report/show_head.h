// The head of a summary (`cdb show`): the runs, and how far their figures can be trusted.
#pragma once

#include <string>
#include <vector>

#include "runtime/statistics/figures.h"
#include "runtime/statistics/findings.h"
#include "runtime/store/store.h"

namespace cdb::report {

struct HeadParts {
  const statistics::CellGroups& groups;
  const std::vector<statistics::DetectorFindings>& findings;
  const std::vector<std::string>& references;  ///< the failed reference runs
  bool only_sound;                             ///< void runs are in no table
  std::string harness;                         ///< one line
};

/// Throws StoreError.
std::string SummaryHead(const store::ResultFile& file, const HeadParts& parts);

}  // namespace cdb::report
