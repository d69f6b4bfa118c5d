// The simulated time of a cycle of each run.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "runtime/store/store.h"

namespace cdb::document {

/// Reads the plan once, if the file does not state the time step itself. Throws StoreError.
class TimeSteps {
 public:
  explicit TimeSteps(const store::ResultFile& file);
  /// In s; NaN if neither the file nor its plan states it.
  double Of(const store::ResultFile::Cell& cell) const;

 private:
  const store::ResultFile& file_;
  const bool is_stated_;
  std::map<std::string, double> by_run_;
};

}  // namespace cdb::document
