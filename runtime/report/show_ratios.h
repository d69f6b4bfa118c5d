// Detectors of a comparison against the first of them, for `cdb show`.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::report {

/// Median detect and step times over those of the first detector, at every point of the other axes,
/// and their geometric mean. Only `cells` count. Empty where the file sweeps no detectors or holds
/// no timings. Throws StoreError.
std::string ShowRatios(const store::ResultFile& file,
                       const std::vector<store::ResultFile::Cell>& cells);

}  // namespace cdb::report
