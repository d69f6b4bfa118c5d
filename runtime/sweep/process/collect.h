// Collects the result of a worker from its recording and the ending of its process.
#pragma once

#include <string>

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"
#include "runtime/results/store.h"

namespace cdb::process {

/// The ending of a process.
struct ProcessEnd {
  int wait_status = 0;        ///< as returned by waitpid
  bool is_timed_out = false;  ///< killed by the runner
  std::string last_lines;     ///< of its standard error; may be empty
};

/// Collects status, message, omissions, number of cycles, series (which point into `recording`) and
/// contacts. If a worker failed, the values of the cycle that it did not finish are reset to "no
/// value". `contacts_fd` is the file of ContactRecords. Throws std::system_error if it cannot be
/// read. The caller sets the fields for time and machine.
results::RunResult Collect(const plan::Run& run, const ProcessEnd& end,
                           protocol::Recording& recording, int contacts_fd);

}  // namespace cdb::process
