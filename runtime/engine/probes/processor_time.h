// What the machine did to this thread while its cycles ran: time off the processor, preemptions,
// page faults, time that other programs used and that other virtual machines stole.
#pragma once

#include "runtime/measure/run_scalars.h"

namespace cdb::probes {

/// Measures from its construction on. Source: clock_gettime(2), getrusage(2), proc_stat(5).
/// Threads: of the calling thread; stolen time and other programs are of all processors together.
class ProcessorTime {
 public:
  ProcessorTime() : begin_(Read()) {}
  /// Sets the scalars to what happened since; NaN where the system does not say.
  void Store(measure::RunScalars& scalars) const;

 private:
  struct Reading {
    double wall_ns = 0, cpu_ns = 0, preemptions = 0, faults = 0, stolen_ns = 0, busy_ns = 0,
           process_ns = 0;
  };
  static Reading Read();

  Reading begin_;
};

}  // namespace cdb::probes
