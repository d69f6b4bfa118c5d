// A results file as one JSON document, for `cdb show --json`, the page of `cdb report`, and
// notebook modules. `cdb doc document` describes it. All statistics are computed here; readers only
// display them.
#pragma once

#include <cstddef>
#include <string>

#include "runtime/store/store.h"

namespace cdb::document {

struct DocumentOptions {
  std::string file;           ///< the name of the results file, for display
  std::string baseline = {};  ///< the baseline of ratios; empty: as in show.h
  bool only_sound = false;    ///< leave out runs whose timings are voided by their verdict
  /// Include the times of each cycle, and distributions.
  bool for_page = false;
};

struct DocumentText {
  std::string json;           ///< UTF-8, without a newline
  std::size_t bad_cells = 0;  ///< as in ShowText
};

/// A document with more points is too large for a page.
inline constexpr std::size_t kMaxDocumentPoints = 100'000;

/// Throws StoreError, also for a detector that the file does not contain, and for more than
/// kMaxDocumentPoints points.
DocumentText ResultsDocument(const store::ResultFile& file, const DocumentOptions& options);

}  // namespace cdb::document
