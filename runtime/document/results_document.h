// A results file as one JSON document: for `cdb show --json`, the page of `cdb report`, and modules
// for notebooks. `cdb doc document` describes it. All statistics are made here; a reader draws.
#pragma once

#include <cstddef>
#include <string>

#include "runtime/store/store.h"

namespace cdb::document {

struct DocumentOptions {
  std::string file;           ///< the name of the results file, for people
  std::string baseline = {};  ///< the detector that ratios are to; empty: as in show.h
  bool only_sound = false;    ///< without runs whose timings a verdict voids
  /// With the times of each cycle, and with distributions.
  bool for_page = false;
};

struct DocumentText {
  std::string json;           ///< UTF-8, without a newline
  std::size_t bad_cells = 0;  ///< as in ShowText
};

/// More points make a document that no page opens.
inline constexpr std::size_t kMaxDocumentPoints = 100'000;

/// Throws StoreError, also for a detector that the file has not got, and for more points than
/// kMaxDocumentPoints.
DocumentText ResultsDocument(const store::ResultFile& file, const DocumentOptions& options);

}  // namespace cdb::document
