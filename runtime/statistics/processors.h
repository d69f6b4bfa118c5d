// Checks whether the runs of a results file were made on processors of one kind.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::statistics {

/// If `cells` were run on several kinds of processors (model names), a line for each kind, and
/// whether the detectors of one point were run on different kinds; empty if there is only one kind.
/// Cells without a run do not count. Throws StoreError.
std::string ProcessorText(const store::ResultFile& file,
                          const std::vector<store::ResultFile::Cell>& cells);

}  // namespace cdb::statistics
