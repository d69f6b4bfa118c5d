// Disturbances of the runs of a results file, for summaries.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::report {

/// One line: the number of noisy `cells`, and the cause for the one that was longest off the
/// processor. Empty if none was noisy, or the file does not say. Throws StoreError.
std::string NoiseText(const store::ResultFile& file,
                      const std::vector<store::ResultFile::Cell>& cells);

}  // namespace cdb::report
