// A part of a results file, by values on its axes (`cdb show --select`).
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::statistics {

/// Each of `selections` is `axis=value`, `axis=a,b` or `axis=a..b` (axis_values.h). Throws
/// StoreError that names the axes of the file, or the values of the axis.
void SelectPart(store::ResultFile& file, const std::vector<std::string>& selections);

}  // namespace cdb::statistics
