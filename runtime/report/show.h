// A results file as tables on a terminal (`cdb show`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::report {

struct ShowOptions {
  /// Axes that make the rows; everything else is pooled. Empty: all axes together where that is at
  /// most kMaxRows rows, else each axis by itself.
  std::vector<std::string> by;
};

inline constexpr std::size_t kMaxRows = 60;

struct ShowText {
  std::string text;
  std::size_t bad_cells = 0;  ///< failed, crashed, timed out, or with void timings; references too
};

/// Detectors that missed pairs, first; what runs did without, as far as it changes the figures;
/// median, 5th and 95th percentile of
/// every phase, pairs and contacts; what detectors cost, the ratio between them. Cells that did not
/// end well are in none of it, and said so. Throws StoreError, also for an axis that the file has
/// not got.
ShowText Show(const store::ResultFile& file, const ShowOptions& options = {});

}  // namespace cdb::report
