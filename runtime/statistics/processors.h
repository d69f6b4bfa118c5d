// Whether the runs of a results file were made on processors of one kind.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::statistics {

/// A line for each kind of processor (its model name) that `cells` were run on, where there are
/// several, and whether detectors of one point were; empty where there is one kind. Cells without a
/// run do not count. Throws StoreError.
std::string ProcessorText(const store::ResultFile& file,
                          const std::vector<store::ResultFile::Cell>& cells);

}  // namespace cdb::statistics
