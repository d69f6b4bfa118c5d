// What disturbed the runs of a results file, for summaries.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::report {

/// One line: how many of `cells` were noisy, and the cause in the one that was longest off the
/// processor. Empty where none was, or the file does not say. Throws StoreError.
std::string NoiseText(const store::ResultFile& file,
                      const std::vector<store::ResultFile::Cell>& cells);

}  // namespace cdb::report
