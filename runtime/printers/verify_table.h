// The output of `cdb verify`: each detector's pairs and contacts compared with the exact ones.
#pragma once

#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::printers {

struct VerifyText {
  std::string text;
  bool is_good = false;  ///< nothing is missed, and every run succeeded
};

/// A row for each detector: first those that missed pairs, then those that missed contacts, then
/// those that failed, otherwise in the file's order. Below: the first bad cycle of each, the
/// command that replays it, and `left_out`. The file holds runs with `record pairs`. Throws
/// StoreError.
VerifyText VerifyTable(const store::ResultFile& file, const std::vector<std::string>& left_out);

}  // namespace cdb::printers
