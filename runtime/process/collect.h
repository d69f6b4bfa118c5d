// Collects the result of a worker: how its process ended, and its recording.
#pragma once

#include <string>

#include "compiler/plan/plan.h"
#include "runtime/measure/recording.h"
#include "runtime/store/store.h"

namespace cdb::process {

/// How the process ended.
struct ProcessEnd {
  int wait_status = 0;        ///< as waitpid gives it
  bool is_timed_out = false;  ///< we killed it
  std::string last_lines;     ///< of its standard error; may be empty
};

/// Status, message, what was left out, cycles that ran, series (they point into `recording`) and
/// contacts. What a worker that did not end well wrote of a cycle that it did not finish is taken
/// back to "no value". `contacts_fd` is the file of ContactRecords. Throws std::system_error where
/// it cannot be read. The time and machine fields are the caller's.
store::RunResult Collect(const plan::Run& run, const ProcessEnd& end, measure::Recording& recording,
                         int contacts_fd);

}  // namespace cdb::process
