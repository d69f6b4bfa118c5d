// The output of `cdb verify`: each detector's pairs and contacts compared with the exact ones.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::report {

struct VerifyText {
  std::string text;
  /// Every run succeeded and no detector misses anything. Contacts that Bullet misses do not count:
  /// it makes those of detectors without a narrow phase.
  bool is_good = false;
};

/// A row for each detector, of its pairs, and for each narrow phase, of its contacts: first the
/// faulty ones, otherwise in the file's order. Below: the first bad cycle of each, the command that
/// replays it, and `left_out`. `narrow_phases`: by the ids of the runs. The file holds runs with
/// `record pairs`. Throws StoreError.
VerifyText VerifyTable(const store::ResultFile& file,
                       const std::map<std::string, std::string>& narrow_phases,
                       const std::vector<std::string>& left_out);

}  // namespace cdb::report
