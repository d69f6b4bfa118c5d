// What `cdb verify` prints: each detector's pairs and contacts against what there was to find.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::report {

struct VerifyText {
  std::string text;
  bool is_good = false;  ///< nothing is missed, and every run ended well
};

/// A row for each detector, those that missed pairs first, then contacts, then those that failed,
/// else in the file's order; below it the first bad cycle of each and what replays it, and
/// `left_out`. The file holds runs with `record pairs`. Throws StoreError.
VerifyText VerifyTable(const store::ResultFile& file, const std::vector<std::string>& left_out);

}  // namespace cdb::report
